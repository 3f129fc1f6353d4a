#include "devices/csv_table.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <zlib.h>

namespace tandem::devices {
namespace {

/// The whole file, unpacked if it is packed.
std::string read_text(const std::string& file) {
  errno = 0;
  gzFile opened = gzopen(file.c_str(), "rb");
  if (opened == nullptr) {
    throw std::runtime_error("\"" + file + "\" cannot be read: " + std::strerror(errno));
  }
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> closes(opened, gzclose);
  std::string text;
  std::array<char, 65536> block;
  int count = 0;
  while ((count = gzread(opened, block.data(), static_cast<unsigned>(block.size()))) > 0) {
    text.append(block.data(), static_cast<std::size_t>(count));
  }
  int error = Z_OK;
  const char* what = gzerror(opened, &error);
  if (count < 0 || error != Z_OK) {
    throw std::runtime_error(
        "\"" + file + "\" cannot be unpacked: " + (error == Z_ERRNO ? std::strerror(errno) : what));
  }
  return text;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\"";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

bool read_number(std::string_view text, double& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

char separator_of(std::string_view line) {
  char most = ',';
  for (const char candidate : {';', '\t'}) {
    if (std::count(line.begin(), line.end(), candidate) >
        std::count(line.begin(), line.end(), most)) {
      most = candidate;
    }
  }
  return most;
}

/// Where each wanted column is in a line.
std::vector<std::size_t> places_of(const std::vector<std::string>& wanted,
                                   const std::vector<std::string_view>& first_line, bool is_heading,
                                   const std::string& file) {
  std::vector<std::size_t> places;
  for (const std::string& name : wanted) {
    std::size_t number = 0;
    const auto found = std::find(first_line.begin(), first_line.end(), name);
    if (is_heading && found != first_line.end()) {
      places.push_back(static_cast<std::size_t>(found - first_line.begin()));
    } else if (name.starts_with('#') &&
               std::from_chars(name.data() + 1, name.data() + name.size(), number).ptr ==
                   name.data() + name.size() &&
               number >= 1 && number <= first_line.size()) {
      places.push_back(number - 1);
    } else {
      std::string there;
      if (is_heading) {
        for (const auto& cell : first_line) there += " \"" + std::string(cell) + "\"";
      } else {
        there = " no heading";
      }
      throw std::runtime_error("\"" + file + "\" has no column \"" + name + "\"; it has" + there +
                               ", and #1 to #" + std::to_string(first_line.size()));
    }
  }
  return places;
}

}  // namespace

std::vector<std::vector<double>> read_csv_columns(const std::string& file,
                                                  const std::vector<std::string>& columns) {
  const std::string text = read_text(file);
  std::vector<std::vector<double>> numbers(columns.size());
  std::vector<std::size_t> places;
  char separator = ',';
  bool first = true;
  std::size_t line_number = 0;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++line_number;
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (first) separator = separator_of(line);
    const auto cells = split(line, separator);
    double value = 0.0;
    if (first) {
      first = false;
      const bool is_heading = !std::all_of(cells.begin(), cells.end(), [&](std::string_view cell) {
        return cell.empty() || read_number(cell, value);
      });
      places = places_of(columns, cells, is_heading, file);
      if (is_heading) continue;
    }
    for (std::size_t c = 0; c < places.size(); ++c) {
      if (places[c] >= cells.size() || !read_number(cells[places[c]], value)) {
        throw std::runtime_error("\"" + file + "\", line " + std::to_string(line_number) +
                                 ", column \"" + columns[c] + "\": " +
                                 (places[c] >= cells.size()
                                      ? "the line ends before it"
                                      : "\"" + std::string(cells[places[c]]) + "\" is no number"));
      }
      numbers[c].push_back(value);
    }
  }
  if (first) throw std::runtime_error("\"" + file + "\" is empty");
  return numbers;
}

}  // namespace tandem::devices
