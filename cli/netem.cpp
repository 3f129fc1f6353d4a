#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands.h"
#include "cli/netem_real.h"
#include "cli/netem_report.h"
#include "cli/options.h"
#include "cli/picture.h"
#include "harness/caretaker.h"
#include "harness/prediction.h"
#include "harness/virtual_run.h"
#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct NetemOptions {
  std::string sweep = "thesis";
  bool virtual_time = false, quick = false, list = false, no_search = false;
  double seconds = 0.0;
  std::uint64_t seed = 1;
  int threads = 0;
  std::string csv, report;
  std::string round_trips, one_way;
  std::vector<std::string> stamps;
  JsonOption json;
  RealRequest real;
};

volatile std::sig_atomic_t netem_interrupted = 0;

/// A line that fills, on a terminal; says how long it may still take.
class Progress {
 public:
  Progress(std::string name, std::string unit) : name_(std::move(name)), unit_(std::move(unit)) {
    terminal_ = isatty(STDERR_FILENO) == 1;
    before_ = std::signal(SIGINT, [](int) { netem_interrupted = 1; });
  }
  ~Progress() {
    std::signal(SIGINT, before_);
    if (shown_) std::fputc('\n', stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  bool operator()(int done, int all, const std::string& doing = {}) {
    if (terminal_) {
      shown_ = true;
      constexpr int kWidth = 30;
      const int full = all > 0 ? kWidth * std::min(done, all) / all : 0;
      const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
      fmt::print(stderr, "\r\033[K{:8} [{:#>{}}{:.>{}}] {}/{} {}, {:.0f} s  {:.40}", name_, "",
                 full, "", kWidth - full, done, all, unit_, spent, doing);
      std::fflush(stderr);
    }
    return netem_interrupted == 0;
  }
  /// A line of its own above it.
  void say(const std::string& line) const {
    fmt::print(stderr, "{}{}\n", terminal_ ? "\r\033[K" : "", line);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string name_, unit_;
  bool terminal_ = false, shown_ = false;
  Clock::time_point start_ = Clock::now();
  void (*before_)(int) = SIG_DFL;
};

/// The scenes of the thesis' chapter 8, whose boundary in delay is named: by analysis, and by
/// `search` in virtual time.
std::vector<harness::DelayBoundary> delay_boundaries(const harness::Sweep& sweep, bool quick,
                                                     bool search) {
  constexpr double kLongest = 0.1;
  std::vector<harness::DelayBoundary> out;
  if (sweep.name != "thesis" && sweep.name != "delay") return out;
  for (const char* name : {"box_central_table_8_1", "box_distributed"}) {
    const core::Scene scene = scene::load_scene(name);
    harness::DelayBoundary b;
    b.scene = name;
    b.predicted = harness::predicted_delay_boundary(scene, kLongest);
    if (search)
      b.in_virtual_time = harness::search_delay_boundary(scene, kLongest, quick ? 10.0 : 20.0);
    out.push_back(b);
  }
  return out;
}

harness::Sweep load(const NetemOptions& o, const std::string& name) {
  harness::SweepOptions options;
  options.quick = o.quick;
  options.seconds = o.seconds;
  std::string recorded;
  if (!o.round_trips.empty()) recorded = fmt::format("round_trips: \"{}\"", o.round_trips);
  if (!o.one_way.empty()) recorded = fmt::format("one_way: \"{}\"", o.one_way);
  if (!o.stamps.empty())
    recorded = fmt::format("sent: \"{}\" received: \"{}\"", o.stamps.at(0), o.stamps.at(1));
  return recorded.empty() ? harness::load_sweep(name, options)
                          : harness::recorded_sweep(recorded, options);
}

SweepRun run_one(const NetemOptions& o, const std::string& name) {
  SweepRun run;
  const auto start = std::chrono::steady_clock::now();
  run.sweep = load(o, name);
  run.seed = o.seed;
  run.real = !o.virtual_time;
  Progress line(name, o.virtual_time ? "points" : "sessions");
  run.boundaries = delay_boundaries(run.sweep, o.quick, true);
  try {
    if (o.virtual_time) {
      harness::VirtualOptions options;
      options.seed = o.seed;
      options.search = !o.no_search;
      options.threads = o.threads;
      options.seconds = o.seconds > 0.0 ? o.seconds : o.quick ? 10.0 : 20.0;
      run.results = harness::run_virtual_sweep(run.sweep, options,
                                               [&](int done, int all) { return line(done, all); });
    } else {
      RealRun real = run_real(
          run.sweep, o.real, run.boundaries,
          {[&](int done, int all, const std::string& doing) { return line(done, all, doing); },
           [&](const std::string& text) { line.say(text); }});
      run.results = std::move(real.results);
      run.left_out = std::move(real.left_out);
      run.setting = std::move(real.setting);
    }
  } catch (const std::runtime_error&) {
    if (netem_interrupted == 0 && !harness::Caretaker::interrupted()) throw;
    throw Failed("stopped; nothing of sweep " + run.sweep.name + " is written");
  }
  run.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}

void list_sweeps() {
  for (const std::string& name : harness::built_in_sweeps()) {
    const harness::Sweep sweep = harness::load_sweep(name);
    harness::SweepOptions quick;
    quick.quick = true;
    fmt::print("{:8} {} ({} points, {} with --quick)\n", name, sweep.title, sweep.points.size(),
               harness::load_sweep(name, quick).points.size());
  }
}

void run(NetemOptions& o) {
  o.real.quick = o.quick;
  if (o.list) return list_sweeps();
  if (!o.virtual_time) {
    if (do_chores(o.real)) return;
    if (o.sweep == "all")
      throw CLI::ValidationError("--sweep", "all sweeps at once only with --virtual");
    // Early: it forks, and turns signals into words.
    (void)harness::Caretaker::instance();
    if (o.real.is_worker()) {
      const harness::Sweep sweep = load(o, o.sweep);
      return run_real_part(sweep, o.real, delay_boundaries(sweep, o.quick, false));
    }
  }
  const bool recorded = !o.round_trips.empty() || !o.one_way.empty() || !o.stamps.empty();
  const std::vector<std::string> names = recorded           ? std::vector<std::string>{"recorded"}
                                         : o.sweep == "all" ? harness::built_in_sweeps()
                                                            : std::vector<std::string>{o.sweep};
  ordered_json all = ordered_json::object();
  std::size_t points = 0, disagreements = 0;
  // Said at the end: what can be written is not lost with what cannot.
  std::vector<std::string> failures;
  const auto attempt = [&](const auto& write) {
    try {
      write();
    } catch (const std::system_error& e) {
      failures.push_back(fmt::format("cannot print: {}", e.what()));
    } catch (const Failed& e) {
      failures.emplace_back(e.what());
    }
  };
  for (const std::string& name : names) {
    const SweepRun done = run_one(o, name);
    const ordered_json json = to_json(done);
    const auto file = [&](const std::string& given) {
      return names.size() == 1 ? given : with_suffix(given, name);
    };
    if (!o.json.to_stdout()) attempt([&] { fmt::print("{}", to_text(done)); });
    if (!o.csv.empty()) attempt([&] { write_text(file(o.csv), to_csv(done)); });
    if (!o.report.empty()) attempt([&] { write_report(file(o.report), json); });
    points += done.results.size();
    if (!done.results.empty() && std::all_of(done.results.begin(), done.results.end(),
                                             [](const auto& r) { return r.failed; }))
      failures.push_back(fmt::format("every point of sweep {} failed", name));
    disagreements += json["disagreements"].get<std::size_t>();
    if (names.size() == 1)
      all = json;
    else
      all["sweeps"][name] = json;
  }
  if (names.size() > 1) {
    all["points"] = points;
    all["disagreements"] = disagreements;
    if (!o.json.to_stdout())
      fmt::print("all sweeps: {} points, {} disagreements\n", points, disagreements);
  }
  o.json.write(all);
  if (!failures.empty()) throw Failed(fmt::format("{}", fmt::join(failures, "\n")));
}

}  // namespace

void add_netem(CLI::App& app) {
  auto o = std::make_shared<NetemOptions>();
  CLI::App* command = app.add_subcommand(
      "netem",
      "what a network does to hands on one box: a sweep of scenes over delay, jitter, loss and "
      "rate,\n"
      "on real sockets behind tc netem or in virtual time, beside what the analysis predicts");
  command
      ->add_option(
          "--sweep", o->sweep,
          "thesis, rate, delay, jitter, loss, users, conditions, all (with --virtual), or a "
          "sweep file")
      ->capture_default_str();
  auto* in_virtual_time =
      command->add_flag("--virtual", o->virtual_time, "in virtual time, from --seed");
  command->add_flag("--quick", o->quick, "a few points only");
  command->add_flag("--list", o->list, "the built-in sweeps");
  command
      ->add_option("--seconds", o->seconds,
                   "of each run for stability [s]; default: 20 in virtual time (10 with --quick), "
                   "the sweep's own on sockets")
      ->check(
          [](const std::string& text) {
            double x = 0.0;
            const bool fits = CLI::detail::lexical_cast(text, x) && x >= 2.0 && x <= 3600.0;
            return fits ? std::string() : text + " is no number of seconds from 2 to 3600";
          },
          "[2 - 3600]", "seconds");
  command->add_option("--seed", o->seed, "of the modelled network's fates")
      ->check(seed_number, "", "seed")
      ->needs(in_virtual_time)
      ->capture_default_str();
  command->add_option("--threads", o->threads, "threads in virtual time; 0: one a core")
      ->check(CLI::Range(0, 1024))
      ->needs(in_virtual_time);
  command->add_flag("--no-search", o->no_search, "leave out the largest stable couplings")
      ->needs(in_virtual_time);
  auto* trips = command
                    ->add_option("--round-trips", o->round_trips,
                                 "a recorded network instead of a sweep: a round trip [ms] a line")
                    ->check(CLI::ExistingFile);
  auto* one_way = command
                      ->add_option("--one-way", o->one_way,
                                   "the same: CSV of time_s,delay_s; an empty delay is a loss")
                      ->check(CLI::ExistingFile);
  auto* stamps = command
                     ->add_option("--stamps", o->stamps,
                                  "the same: two files of STAMP_NS,PACKET, sent and received")
                     ->expected(2)
                     ->check(CLI::ExistingFile);
  trips->excludes(one_way)->excludes(stamps);
  one_way->excludes(stamps);
  for (auto* own : {trips, one_way, stamps}) own->excludes(command->get_option("--sweep"));
  o->json.add(*command);
  command->add_option("--csv", o->csv, "one row a point")->check(writable_file, "", "writable");
  command->add_option("--report", o->report, "one self-contained page: FILE.html")
      ->check(writable_file, "", "writable");
  add_real_options(*command, o->real);
  command->callback([o] {
    try {
      run(*o);
    } catch (const harness::SweepError& e) {
      const char* given = !o->round_trips.empty() ? "--round-trips"
                          : !o->one_way.empty()   ? "--one-way"
                          : !o->stamps.empty()    ? "--stamps"
                                                  : "--sweep";
      throw CLI::ValidationError(given, e.what());
    }
  });
}

}  // namespace tandem::cli
