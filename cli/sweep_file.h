#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "analysis/sweep.h"

namespace tandem::cli {

/// The finished items of a sweep in a text file that only grows: a first line with the settings
/// they belong to (JSON), then a line an item: stage, item, its numbers, a full stop. Each line is
/// one write to the system, so that a killed process loses none that was written; a last line that
/// is not whole is cut off.
class SweepFile {
 public:
  /// Opens or creates. Throws Failed: it was made with other settings (which), is damaged (where),
  /// is in use, or cannot be written.
  SweepFile(std::string file, const nlohmann::ordered_json& settings);
  ~SweepFile();
  SweepFile(const SweepFile&) = delete;
  SweepFile& operator=(const SweepFile&) = delete;

  void append(const std::string& stage, std::int64_t item, const analysis::SweepRow& row);
  /// What was in the file.
  [[nodiscard]] const std::map<std::int64_t, analysis::SweepRow>& rows(const std::string& stage) {
    return stages_[stage];
  }
  [[nodiscard]] const std::string& name() const { return file_; }

 private:
  void read(const nlohmann::ordered_json& settings);
  void take(const std::string& line, int number);
  void write(const std::string& line);

  std::string file_;
  int descriptor_ = -1;
  std::map<std::string, std::map<std::int64_t, analysis::SweepRow>> stages_;
};

}  // namespace tandem::cli
