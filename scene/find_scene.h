#pragma once

#include <string>
#include <vector>

namespace tandem::scene {

/// Folders in which NAME.scene is looked up, in this order: those of $TANDEM_SCENES (separated by
/// ':'), the source tree's examples/scenes, the installed share/tandem/scenes, and
/// ../share/tandem/scenes seen from the running program. Not all need exist.
[[nodiscard]] std::vector<std::string> scene_folders();

/// Names of all scenes in those folders, in order of the alphabet, each once.
[[nodiscard]] std::vector<std::string> scene_names();

/// File of a scene given by name or file. With a '/' or a '.' in it it is a file; otherwise a name,
/// then a file of that name. Throws SceneError: no such scene (with the nearest name).
[[nodiscard]] std::string find_scene(const std::string& name_or_file);

/// Whole text of a scene file. Throws SceneError: cannot be read, a directory, not text, too large.
[[nodiscard]] std::string read_scene_file(const std::string& file);

}  // namespace tandem::scene
