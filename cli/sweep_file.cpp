#include "cli/sweep_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

/// What differs between the settings of a file and ours, for people; empty: nothing.
std::string difference(const ordered_json& theirs, const ordered_json& ours) {
  std::string text;
  const ordered_json a = theirs.flatten(), b = ours.flatten();
  const auto name = [](const std::string& pointer) {
    std::string path = pointer.substr(1);
    for (char& c : path)
      if (c == '/') c = '.';
    return path;
  };
  for (const auto& [key, value] : b.items())
    if (!a.contains(key))
      text += fmt::format("\n  {}: not in the file, here {}", name(key), value.dump());
    else if (a[key] != value)
      text +=
          fmt::format("\n  {}: {} in the file, here {}", name(key), a[key].dump(), value.dump());
  for (const auto& [key, value] : a.items())
    if (!b.contains(key))
      text += fmt::format("\n  {}: {} in the file, not here", name(key), value.dump());
  return text;
}

}  // namespace

SweepFile::SweepFile(std::string file, const ordered_json& settings) : file_(std::move(file)) {
  descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  const auto cannot = [&](const std::string& why) {
    if (descriptor_ >= 0) close(descriptor_);
    throw Failed("cannot keep the sweep in " + file_ + ": " + why);
  };
  if (descriptor_ < 0) cannot(std::strerror(errno));
  struct stat about {};
  if (fstat(descriptor_, &about) != 0 || !S_ISREG(about.st_mode)) cannot("it is not a plain file");
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) cannot("another sweep is using it");
  try {
    read(settings);
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

SweepFile::~SweepFile() { close(descriptor_); }

void SweepFile::read(const ordered_json& settings) {
  std::string text;
  char block[65536];
  for (;;) {
    const ssize_t n = ::read(descriptor_, block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw Failed("cannot read " + file_ + ": " + std::strerror(errno));
    if (n == 0) break;
    text.append(block, static_cast<std::size_t>(n));
  }
  // A header that was never finished is ours to write again; anything else is somebody's file.
  const std::string header = ordered_json{{"tandem_sweep", settings}}.dump() + "\n";
  std::size_t end = text.find('\n');
  if (end == std::string::npos && header.compare(0, text.size(), text) == 0) {
    if (ftruncate(descriptor_, 0) != 0)
      throw Failed("cannot write " + file_ + ": " + std::strerror(errno));
    lseek(descriptor_, 0, SEEK_SET);
    write(header);
    return;
  }
  const ordered_json first = ordered_json::parse(text.substr(0, end), nullptr, false);
  if (first.is_discarded() || !first.is_object() || !first.contains("tandem_sweep"))
    throw Failed(file_ + " is not the file of a sweep; give another name, it stays as it is");
  if (const std::string text_of = difference(first["tandem_sweep"], settings); !text_of.empty())
    throw Failed(file_ + " belongs to a sweep with other settings:" + text_of +
                 "\ngive another file, or the settings of this one");

  int number = 1;
  std::size_t at = end + 1;
  while ((end = text.find('\n', at)) != std::string::npos) {
    take(text.substr(at, end - at), ++number);
    at = end + 1;
  }
  if (ftruncate(descriptor_, static_cast<off_t>(at)) != 0)
    throw Failed("cannot write " + file_ + ": " + std::strerror(errno));
  lseek(descriptor_, static_cast<off_t>(at), SEEK_SET);
}

void SweepFile::take(const std::string& line, int number) {
  const auto damaged = [&] {
    throw Failed(
        fmt::format("{}: line {} is damaged; delete that line and its item is computed "
                    "again",
                    file_, number));
  };
  const std::size_t bar = line.find('|');
  if (bar == std::string::npos || line.size() < bar + 4 ||
      line.compare(line.size() - 2, 2, " .") != 0)
    damaged();
  const char* at = line.c_str() + bar + 1;
  const char* const last = line.c_str() + line.size() - 2;
  char* next = nullptr;
  const std::int64_t item = std::strtoll(at, &next, 10);
  if (next == at || item < 0) damaged();
  analysis::SweepRow row;
  for (at = next; at < last; at = next) {
    row.push_back(std::strtod(at, &next));
    if (next == at || next > last) damaged();
  }
  stages_[line.substr(0, bar)][item] = std::move(row);
}

void SweepFile::append(const std::string& stage, std::int64_t item, const analysis::SweepRow& row) {
  std::string line = fmt::format("{}|{}", stage, item);
  for (const double value : row) line += fmt::format(" {}", value);
  write(line + " .\n");
}

void SweepFile::write(const std::string& line) {
  std::size_t done = 0;
  while (done < line.size()) {
    const ssize_t n = ::write(descriptor_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      throw Failed("cannot write " + file_ + ": " + std::strerror(errno) +
                   "; what is in it stays good: go on with --resume " + file_);
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace tandem::cli
