#include "cli/sweep_session.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numeric>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/ranks.h"
#include "scene/scene_text.h"

namespace tandem::cli {

namespace {

using analysis::SweepRow;
using analysis::SweepWork;

volatile std::sig_atomic_t interrupted = 0;

/// What a process under mpirun says when it has no items left: it did all, or was stopped.
enum Through { kAll = -1, kStopped = -2 };

std::string duration(double seconds) {
  if (seconds < 90.0) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

std::uint64_t hash_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

}  // namespace

void SweepOptions::add(CLI::App& command) {
  command
      .add_option("--jobs,--threads", jobs, "threads; 0: one a core. Results do not depend on it")
      ->check(CLI::Range(0, 1024));
  command
      .add_option("--resume", resume,
                  "keep finished points in this file, and go on with those that are in it")
      ->check(writable_file, "", "writable");
}

/// How far a stage is, and how long it still takes, on a terminal.
struct SweepSession::Progress {
  using Clock = std::chrono::steady_clock;
  std::string stage;
  std::int64_t items = 0, done_before = 0, done = 0;
  bool told = isatty(STDERR_FILENO) == 1 && ranks::own() == 0;
  bool line_open = false;
  Clock::time_point start = Clock::now(), next = start + std::chrono::milliseconds(300);

  void one_more() {
    ++done;
    if (!told || Clock::now() < next) return;
    next = Clock::now() + std::chrono::milliseconds(200);
    const double spent = std::chrono::duration<double>(Clock::now() - start).count();
    const double left =
        spent / static_cast<double>(done - done_before) * static_cast<double>(items - done);
    fmt::print(stderr, "\r\033[K{}: {} of {}, {} left", stage, done, items, duration(left));
    std::fflush(stderr);
    line_open = true;
  }
  ~Progress() {
    if (line_open) fmt::print(stderr, "\r\033[K");
  }
};

SweepSession::SweepSession(const SweepOptions& options, const std::string& command,
                           nlohmann::ordered_json settings)
    : command_(command) {
  settings_["command"] = command;
  settings_["revision"] = revision_text();
  for (auto& [key, value] : settings.items()) settings_[key] = value;
  const int processes = ranks::count();
  ranks::may_end(processes == 1);
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  jobs_ = options.jobs > 0 ? options.jobs : std::max(1, cores / ranks::on_this_machine());
  if (!options.resume.empty() && tells())
    file_ = std::make_unique<SweepFile>(options.resume, settings_);
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one ends us at once
  sigaction(SIGINT, &action, &before_int_);
  sigaction(SIGTERM, &action, &before_term_);
}

SweepSession::~SweepSession() {
  sigaction(SIGINT, &before_int_, nullptr);
  sigaction(SIGTERM, &before_term_, nullptr);
}

bool SweepSession::tells() const { return ranks::own() == 0; }

std::vector<SweepRow> SweepSession::run(const std::string& stage, std::int64_t items,
                                        const std::function<SweepWork()>& make_work) {
  const int processes = ranks::count(), own = ranks::own();
  ranks::may_end(processes == 1);
  std::vector<SweepRow> rows(static_cast<std::size_t>(items));
  if (file_ != nullptr)
    for (const auto& [item, row] : file_->rows(stage))
      if (item < items) rows[static_cast<std::size_t>(item)] = row;
  if (file_ == nullptr) kept_.emplace_back(stage, decltype(kept_)::value_type::second_type{});

  const std::vector<std::int64_t> all = missing(rows);
  std::vector<std::int64_t> ours;
  for (std::size_t i = static_cast<std::size_t>(own); i < all.size();
       i += static_cast<std::size_t>(processes))
    ours.push_back(all[i]);

  Progress progress{.stage = stage, .items = items};
  progress.done = progress.done_before = items - static_cast<std::int64_t>(all.size());
  bool whole = true;
  int working = processes - 1;  // others, at the root
  const auto take = [&](std::int64_t item, SweepRow&& row) {
    keep(stage, item, row);
    rows[static_cast<std::size_t>(item)] = std::move(row);
    progress.one_more();
  };
  const auto receive = [&](bool wait) {
    std::vector<double> message;
    if (!ranks::receive(message, wait)) return false;
    const auto item = static_cast<std::int64_t>(message.front());
    if (item < 0) {
      --working;
      whole = whole && item == kAll;
    } else {
      take(item, SweepRow(message.begin() + 1, message.end()));
    }
    return true;
  };
  const auto finished = [&](std::int64_t item, SweepRow&& row) {
    if (own != 0) {
      row.insert(row.begin(), static_cast<double>(item));
      ranks::send(row);
      return;
    }
    take(item, std::move(row));
    while (working > 0 && receive(false)) {
    }
  };
  const bool ours_whole =
      analysis::do_items(ours, jobs_, make_work, finished, [] { return interrupted != 0; });
  if (own != 0) ranks::send({static_cast<double>(ours_whole ? kAll : kStopped)});
  whole = whole && ours_whole;
  while (own == 0 && working > 0) receive(true);

  // Everybody learns how it ended, and the next stage may need every row of this one.
  std::vector<double> ended{whole ? 1.0 : 0.0};
  ranks::broadcast(ended);
  if (ended.front() == 0.0) {
    ranks::may_end(true);
    stopped(progress.done, items, stage);
  }
  share(rows);
  ranks::may_end(true);
  return rows;
}

/// Items without a row, the same in every process.
std::vector<std::int64_t> SweepSession::missing(const std::vector<SweepRow>& rows) const {
  std::vector<double> list;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].empty()) list.push_back(static_cast<double>(i));
  ranks::broadcast(list);
  return {list.begin(), list.end()};
}

void SweepSession::share(std::vector<SweepRow>& rows) const {
  if (ranks::count() == 1) return;
  std::vector<double> flat;
  if (ranks::own() == 0)
    for (const SweepRow& row : rows) {
      flat.push_back(static_cast<double>(row.size()));
      flat.insert(flat.end(), row.begin(), row.end());
    }
  ranks::broadcast(flat);
  auto at = flat.begin();
  for (SweepRow& row : rows) {
    const auto size = static_cast<std::ptrdiff_t>(*at++);
    row.assign(at, at + size);
    at += size;
  }
}

void SweepSession::keep(const std::string& stage, std::int64_t item, const SweepRow& row) {
  if (file_ != nullptr)
    file_->append(stage, item, row);
  else
    kept_.back().second.emplace_back(item, row);
}

void SweepSession::stopped(std::int64_t done, std::int64_t items, const std::string& stage) {
  if (!tells()) throw Failed("");
  if (file_ == nullptr) {
    const std::string name =
        fmt::format("tandem-{}-{:08x}.sweep", command_, hash_of(settings_.dump()) & 0xffffffff);
    file_ = std::make_unique<SweepFile>(name, settings_);
    for (const auto& [of, rows] : kept_)
      for (const auto& [item, row] : rows) file_->append(of, item, row);
  }
  throw Failed(
      fmt::format("stopped: {} of {} parts of \"{}\" are done and kept in {}\n"
                  "to go on: the same command with --resume {}",
                  done, items, stage, file_->name(), file_->name()));
}

nlohmann::ordered_json scene_settings(const core::Scene& scene, double delay_packets) {
  return {{"scene", scene.name},
          {"scene_hash", fmt::format("{:016x}", hash_of(scene::to_text(scene)))},
          {"delay_packets", delay_packets}};
}

void refuse_too_large(double points, double bytes, const std::string& what) {
  std::ifstream meminfo("/proc/meminfo");
  double free = 0.0;
  std::string line;
  while (std::getline(meminfo, line))
    if (std::sscanf(line.c_str(), "MemAvailable: %lf", &free) == 1) break;
  free *= 1024.0;
  constexpr double kGiga = 1e9, kMost = 1e12;
  if (points <= kMost && (free == 0.0 || points * bytes < 0.8 * free)) return;
  throw Failed(
      fmt::format("{}: {:.6g} points would take {:.3g} GB of memory, {:.3g} GB are free; "
                  "take fewer points, or narrower ranges one after the other",
                  what, points, points * bytes / kGiga, free / kGiga));
}

}  // namespace tandem::cli
