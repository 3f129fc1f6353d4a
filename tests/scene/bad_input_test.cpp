#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

#include <gtest/gtest.h>

#include "scene/find_scene.h"
#include "scene/nearest_name.h"
#include "tests/scene/scene_testing.h"

namespace tandem::scene {
namespace {

using testing::contains;
using testing::error_of;
using testing::error_of_named;

/// Folder of one test, gone at its end.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tandem_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const {
    const std::string path = path_ + "/" + name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(BadInput, EmptyFile) {
  const Folder folder;
  const std::string file = folder.file("nothing.scene", "");
  EXPECT_EQ(error_of_named(file, {}), file + ": is empty; a scene starts with: scene_version: 1");
}

TEST(BadInput, OnlyComments) {
  EXPECT_TRUE(contains(error_of("# nothing\n"), "t.scene: scene_version is missing"));
}

TEST(BadInput, DirectoryInsteadOfFile) {
  const Folder folder;
  EXPECT_TRUE(contains(error_of_named(folder.path(), {}), "is a directory; give a scene file"));
}

TEST(BadInput, NoSuchFileAndNoSuchName) {
  EXPECT_TRUE(
      contains(error_of_named("./none.scene", {}), "./none.scene: cannot be read: No such"));
  const std::string error = error_of_named("axis_distribute", {});
  EXPECT_TRUE(contains(error, "did you mean 'axis_distributed'?")) << error;
  EXPECT_TRUE(contains(error, "looked in")) << error;
  EXPECT_TRUE(contains(error_of_named("", {}), "no scene given"));
}

TEST(BadInput, FileThatMayNotBeRead) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
  const Folder folder;
  const std::string file = folder.file("secret.scene", "scene_version: 1");
  std::filesystem::permissions(file, std::filesystem::perms::none);
  EXPECT_TRUE(contains(error_of_named(file, {}), "cannot be read: Permission denied"));
}

TEST(BadInput, BinaryGarbageIsNotText) {
  EXPECT_TRUE(contains(error_of(std::string("scene\0version", 13)), "not a text file"));
  EXPECT_TRUE(contains(error_of("\x7f"
                                "ELF\x02\x01\x01"),
                       "not a text file (control character at byte 4)"));
}

TEST(BadInput, RandomBytesNeverCrashAndAreAlwaysRefused) {
  std::mt19937_64 random(1);
  const std::string letters = "abz019 .:{}<>\"'\\#-,;[]\n\xff\xc3";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    const std::size_t length = 1 + random() % 60;
    for (std::size_t k = 0; k < length; ++k) text += letters[random() % letters.size()];
    EXPECT_FALSE(error_of(text).empty()) << text;
  }
}

TEST(BadInput, MutatedScenesLoadOrAreRefusedButNeverCrash) {
  const std::string good = to_text(load_scene("box_central"));
  std::mt19937_64 random(2);
  int refused = 0;
  for (int i = 0; i < 500; ++i) {
    std::string text = good;
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0)
        text[at] = static_cast<char>(32 + random() % 90);
      else
        text.erase(at, random() % 40);
    }
    if (!error_of(text).empty()) ++refused;
  }
  EXPECT_GT(refused, 400);  // most mutations hit a name or the structure
}

TEST(BadInput, DeepNestingIsRefusedNotFollowed) {
  std::string text = "scene_version: 1 ";
  for (int i = 0; i < 100000; ++i) text += "x{";
  EXPECT_FALSE(error_of(text).empty());
}

TEST(BadInput, TooLargeFile) {
  const Folder folder;
  const std::string file = folder.file("big.scene", std::string((1 << 20) + 1, '#'));
  EXPECT_TRUE(contains(error_of_named(file, {}), "larger than 1 MiB"));
}

TEST(BadInput, AnotherVersionIsSaidAloneBecauseItsFieldsMayBeOthers) {
  EXPECT_EQ(error_of("\nscene_version: 2\nnew_thing: 3\n"),
            "t.scene:2: scene_version = 2: this program reads version 1");
}

TEST(BadInput, SyntaxErrorHasLineAndColumn) {
  const std::string error = error_of("scene_version: 1\nrates { local_hz: }\n");
  EXPECT_TRUE(contains(error, "t.scene:2:19: syntax: ")) << error;
}

TEST(BadInput, UnknownFieldsAreAllReportedWithTheNearestName) {
  const std::string error =
      error_of("scene_version: 1\nrates {\n  locl_hz: 1000\n}\nobjekt { name: 'x' }\n");
  EXPECT_TRUE(contains(error,
                       "t.scene:3:3: unknown field 'locl_hz' in Rates; did you mean "
                       "'local_hz'? known: local_hz, packet_hz, latency_ticks"))
      << error;
  EXPECT_TRUE(contains(error, "unknown field 'objekt' in Scene; did you mean 'object'?")) << error;
}

TEST(BadInput, UnknownValuesOfAnEnumListTheKnown) {
  const std::string error = error_of("scene_version: 1\nspace: PLAIN\n");
  EXPECT_TRUE(contains(error, "t.scene:2:")) << error;
  EXPECT_TRUE(contains(error,
                       "unknown value 'PLAIN' of space; did you mean 'PLANE'? known: "
                       "AXIS, PLANE, SPACE"))
      << error;
}

// Text format takes a number for an enum; one without a name reaches no law.
TEST(BadInput, ANumberThatNoEnumValueHasListsTheNames) {
  const std::string error = error_of("scene_version: 1\nspace: AXIS\nintegrator: 7\n");
  EXPECT_TRUE(contains(error, "integrator = 7")) << error;
  EXPECT_TRUE(contains(error, "ZERO_ORDER_HOLD")) << error;
  EXPECT_TRUE(
      contains(error_of("scene_version: 1\nspace: AXIS\nintegrator: -1\n"), "integrator = -1"));
}

TEST(BadInput, AFileThatEndsInsideAPartSaysSo) {
  const std::string error = error_of("scene_version: 1\nspace: AXIS\nrates { local_hz: 1000\n");
  EXPECT_TRUE(contains(error, "a } is missing")) << error;
}

// An edit is blamed for what it spoiled, not the line of the file that it changed.
TEST(BadInput, AnEditIsNamedForWhatItSpoils) {
  const auto said = [](const std::string& set) -> std::string {
    const std::vector<std::string> sets{set};
    try {
      (void)load_scene("box_distributed", sets);
    } catch (const SceneError& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_TRUE(contains(said("scene_version=2"), "--set scene_version=2"))
      << said("scene_version=2");
  EXPECT_TRUE(contains(said("wall.wall.normal.y=0"), "--set wall.wall.normal.y=0"))
      << said("wall.wall.normal.y=0");
}

TEST(BadInput, AFieldGivenTwiceIsRefused) {
  const std::string error = error_of("scene_version: 1\nspace: AXIS\nspace: PLANE\n");
  EXPECT_TRUE(contains(error, "t.scene:3:")) << error;
  EXPECT_TRUE(contains(error, "space")) << error;
}

TEST(BadInput, ProblemsPointAtTheirLine) {
  const std::string error = error_of(
      "scene_version: 1\narchitecture: SINGLE\nobject {\n  name: 'box'\n  mass: -1\n}\n"
      "coupler { name: 'k' object: 'box' user: '1' }\nuser { name: '1' finger { name: 'a' } }");
  EXPECT_EQ(error, "t.scene:5: object.box.mass = -1 kg: must be above 0 and at most 1000000 kg");
}

TEST(FindScene, LooksInTheFoldersOfTheEnvironmentFirst) {
  const Folder folder;
  std::string text = to_text(load_scene("axis_single", std::vector<std::string>{"name=mine"}));
  (void)folder.file("axis_single.scene", text);
  (void)folder.file("only_here.scene", text);
  ::setenv("TANDEM_SCENES", ("/nowhere:" + folder.path()).c_str(), 1);
  EXPECT_EQ(load_scene("axis_single").name, "mine");
  EXPECT_EQ(load_scene("only_here").name, "mine");
  const auto names = scene_names();
  EXPECT_NE(std::find(names.begin(), names.end(), "only_here"), names.end());
  ::unsetenv("TANDEM_SCENES");
  EXPECT_EQ(load_scene("axis_single").name, "axis_single");
}

TEST(NearestName, CountsEdits) {
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);  // the textbook's example
  EXPECT_EQ(edit_distance("Mass", "mass"), 0);
  EXPECT_EQ(suggestion("zzz", {"mass"}), "; known: mass");
  EXPECT_EQ(suggestion("mas", {"size", "mass"}), "; did you mean 'mass'? known: size, mass");
}

}  // namespace
}  // namespace tandem::scene
