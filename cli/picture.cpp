#include "cli/picture.h"

#include <cstdio>
#include <filesystem>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/options.h"
#include "cli/script_path.h"

namespace tandem::cli {

std::string to_csv(const analysis::Table& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.columns, ","));
  for (const auto& row : table.rows) text += fmt::format("{}\n", fmt::join(row, ","));
  return text;
}

std::string with_suffix(const std::string& file, const std::string& name) {
  const std::filesystem::path path(file);
  return (path.parent_path() / (path.stem().string() + "_" + name + path.extension().string()))
      .string();
}

namespace {

/// Writes the data beside nobody's feet, runs the script over it and clears up.
bool run_plot(const std::string& script, std::vector<std::string> arguments,
              const std::string& data, const std::string& text, const std::string& file) {
  write_text(data, text);
  arguments.push_back(data);
  arguments.push_back(file);
  const int status = run_script(script, arguments);
  std::filesystem::remove(data);
  if (status == 0) return true;
  std::fprintf(stderr,
               "no picture %s: drawing needs python3 with matplotlib (apt install "
               "python3-matplotlib)\n",
               file.c_str());
  return false;
}

std::string temporary(const char* suffix) {
  return (std::filesystem::temp_directory_path() / fmt::format("tandem-{}.{}", getpid(), suffix))
      .string();
}

}  // namespace

bool draw(const std::string& file, const std::string& kind, const analysis::Table& table) {
  return run_plot("plot_table.py", {kind}, temporary("csv"), to_csv(table), file);
}

bool draw_json(const std::string& file, const std::string& script,
               const nlohmann::ordered_json& results) {
  return run_plot(script, {}, temporary("json"), results.dump(), file);
}

std::string picture_file(const std::string& file) {
  const std::string type = std::filesystem::path(file).extension().string();
  if (type != ".png" && type != ".svg" && type != ".pdf")
    return file + ": a picture is a .png, .svg or .pdf file";
  return writable_file(file);
}

}  // namespace tandem::cli
