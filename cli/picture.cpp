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

bool draw(const std::string& file, const std::string& kind, const analysis::Table& table) {
  const std::string data =
      (std::filesystem::temp_directory_path() / fmt::format("tandem-{}.csv", getpid())).string();
  write_text(data, to_csv(table));
  const int status = run_script("plot_table.py", {kind, data, file});
  std::filesystem::remove(data);
  if (status == 0) return true;
  std::fprintf(stderr,
               "no picture %s: drawing needs python3 with matplotlib (apt install "
               "python3-matplotlib)\n",
               file.c_str());
  return false;
}

}  // namespace tandem::cli
