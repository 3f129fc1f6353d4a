#include "cli/netem_real.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/utsname.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/program.h"
#include "harness/caretaker.h"
#include "harness/child.h"
#include "harness/guest.h"
#include "harness/guest_sweep.h"
#include "harness/harness_error.h"
#include "harness/namespaces.h"
#include "harness/real_sweep.h"

namespace tandem::cli {
namespace {

/// Where a sweep on sockets can run on this machine, and if it cannot, what it needs.
struct Place {
  bool here = false;
  harness::GuestKernel guest;  ///< ready: there
  std::string why_not_here;
};

Place find_place() {
  Place place;
  const harness::KernelSupport support = harness::try_netem();
  place.here = support.netem;
  place.why_not_here = support.why_not;
  if (!place.here) place.guest = harness::find_guest_kernel();
  return place;
}

std::string what_it_needs(const Place& place) {
  return fmt::format(
      "Real sockets behind netem need one of:\n"
      "  root on a kernel with netem (modules sch_netem, veth, bridge) and Debian's iproute2; "
      "here: {}\n"
      "  user-mode Linux, which needs no root; here: {}\n"
      "Or add --virtual: the same sweep in virtual time needs nothing.",
      place.why_not_here, place.guest.why_not);
}

void say_where_netem_is() {
  const Place place = find_place();
  if (place.here)
    fmt::print("netem: in this kernel\n");
  else if (place.guest.ready())
    fmt::print("netem: not here ({}); in user-mode Linux, {}\n", place.why_not_here,
               place.guest.program);
  else
    throw Failed(what_it_needs(place));
}

/// What killed runs left behind: named, and removed when asked for.
void look_for_leftovers(bool remove) {
  const auto namespaces = harness::left_namespaces();
  const auto guests = harness::left_guests();
  for (const std::string& name : namespaces)
    fmt::print(stderr, "left by a killed run: network namespace {}\n", name);
  for (const std::string& folder : guests)
    fmt::print(stderr, "left by a killed run: user-mode Linux in {}\n", folder);
  const std::size_t count = namespaces.size() + guests.size();
  if (!remove) {
    if (count > 0) fmt::print(stderr, "they are left alone; `tandem netem --clean` removes them\n");
    return;
  }
  if (count > 0 && !namespaces.empty() && geteuid() != 0)
    throw Failed("removing network namespaces needs root");
  harness::remove_namespaces(namespaces);
  harness::remove_guests(guests);
  const std::size_t still = harness::left_namespaces().size() + harness::left_guests().size();
  if (still > 0)
    throw Failed(fmt::format(
        "{} of these {} could not be removed: run it as who made them, or root", still, count));
  std::fputs(count > 0 ? "removed\n" : "nothing is left of killed runs\n", stderr);
}

std::vector<std::string> own_command_line() {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(in, word, '\0');) words.push_back(word);
  words.at(0) = std::filesystem::read_symlink("/proc/self/exe").string();
  return words;
}

/// A few of many points, on alternating values so that all kinds of session are among them.
harness::Sweep thinned(harness::Sweep sweep) {
  constexpr std::size_t kFew = 5;
  while (sweep.points.size() > kFew) {
    std::vector<harness::SweepPoint> half;
    for (std::size_t i = 0; i < sweep.points.size(); ++i)
      if (i % 2 == i / 2 % 2) half.push_back(std::move(sweep.points[i]));
    sweep.points = std::move(half);
  }
  return sweep;
}

/// Without the points of more users than one processor can run as nodes.
harness::Sweep as_carried(harness::Sweep sweep, std::vector<std::string>& left_out) {
  constexpr std::size_t kMostUsers = 4;
  std::vector<harness::SweepPoint> points;
  for (harness::SweepPoint& point : sweep.points)
    if (point.scene.users.size() <= kMostUsers)
      points.push_back(std::move(point));
    else
      left_out.push_back(fmt::format("{}: {} users; sockets on one machine carry {}", point.name,
                                     point.scene.users.size(), kMostUsers));
  if (points.empty() && !left_out.empty()) throw Failed(left_out.front());
  sweep.points = std::move(points);
  return sweep;
}

/// A point that is not run is in `left_out`.
harness::Sweep as_run(const harness::Sweep& sweep, const RealRequest& request,
                      std::vector<std::string>& left_out) {
  harness::Sweep carried = as_carried(sweep, left_out);
  return request.quick ? thinned(std::move(carried)) : carried;
}

std::string real_setting() {
  utsname kernel{};
  uname(&kernel);
  const std::string own = fmt::format("Linux {} ({})", kernel.release, kernel.version);
  return harness::inside_guest() ? fmt::format("user-mode {} on {}", own, harness::guest_host())
                                 : own;
}

/// Where netem is.
std::vector<harness::PointResult> run_here(const harness::Sweep& sweep, const RealRequest& request,
                                           const harness::SweepPart& part,
                                           std::vector<harness::DelayBoundary>& boundaries,
                                           const harness::RealProgress& progress) {
  harness::RealOptions options;
  options.program.file = std::filesystem::read_symlink("/proc/self/exe").string();
  if (harness::inside_guest()) options.program.main = run_program;
  options.name = request.name.empty() ? harness::own_network_name() : request.name;
  options.folder = request.folder;
  options.at_once = request.at_once;
  options.most_nodes = 2 * request.at_once;
  options.part = part;
  int before = 0, last = 0;
  const harness::RealProgress added = [&](int done, int all, const std::string& doing) {
    last = before + done;
    progress(last, before + all, doing);
  };
  std::vector<harness::PointResult> results = harness::run_real_sweep(sweep, options, added);
  before = last;
  constexpr double kSeconds = 5.0;
  if (!boundaries.empty())
    harness::find_real_boundaries(boundaries, options, kSeconds, request.quick, added);
  return results;
}

std::vector<harness::PointResult> run_there(const Place& place, harness::GuestClock clock,
                                            const harness::Sweep& sweep,
                                            std::vector<harness::DelayBoundary>& boundaries,
                                            const harness::RealProgress& progress,
                                            const RealListener& listener, std::string& setting) {
  const std::size_t count = harness::guests_for(sweep);
  listener.say(fmt::format("no netem here ({}): sessions run in user-mode Linux, {} guest{} of {}",
                           place.why_not_here, count, count == 1 ? "" : "s", place.guest.program));
  const std::vector<harness::PartResults> parts =
      harness::run_in_guests(place.guest, clock, own_command_line(), sweep, progress, listener.say);
  std::vector<harness::PointResult> results = harness::join_points(sweep, parts);
  harness::join_boundaries(boundaries, parts);
  setting = parts.front().setting;
  if (count > 1) setting = fmt::format("{} guests at a time, each {}", count, setting);
  return results;
}

}  // namespace

void add_real_options(CLI::App& command, RealRequest& request) {
  auto* real = command.add_option_group("real sockets");
  real->add_option("--folder", request.folder,
                   "scenes, recordings and reports of all nodes are kept here")
      ->capture_default_str();
  real->add_option("--name", request.name,
                   "of the network namespaces: NAME-a-bridge, NAME-a-1, ... (default: "
                   "tandem-<process number>)")
      ->check([](const std::string& name) { return harness::problem_with_network_name(name); });
  real->add_option("--at-once", request.at_once,
                   "sessions that run at the same time (on one processor, in user-mode Linux)")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  real->add_flag(
      "--host-clock", request.host_clock,
      "user-mode Linux has this machine's clock, stalls and all (default: one of its own "
      "that leaves out idle time and what this machine takes away)");
  for (auto& [name, value] : {std::pair<const char*, std::string&>{"--part", request.part},
                              {"--part-results", request.part_results}})
    command.add_option(name, value)->group("");
  real->add_flag("--check", request.check, "only say where netem is on this machine");
  real->add_flag("--clean", request.clean, "only remove what killed runs left behind");
  for (CLI::Option* option : real->get_options({}))
    option->excludes(command.get_option("--virtual"));
}

bool do_chores(const RealRequest& request) {
  if (request.clean) look_for_leftovers(true);
  if (request.check) say_where_netem_is();
  return request.clean || request.check;
}

RealRun run_real(const harness::Sweep& sweep, const RealRequest& request,
                 std::vector<harness::DelayBoundary>& boundaries, const RealListener& listener) {
  harness::Caretaker& caretaker = harness::Caretaker::instance();
  caretaker.listen();
  RealRun run;
  const harness::Sweep carried = as_run(sweep, request, run.left_out);
  look_for_leftovers(false);
  const Place place = find_place();
  if (!place.here && !place.guest.ready()) throw Failed(what_it_needs(place));
  const harness::RealProgress progress = [&](int done, int all, const std::string& doing) {
    if (!listener.progress(done, all, doing) || harness::Caretaker::interrupted())
      throw harness::Interrupted();
  };
  run.setting = real_setting();
  run.results = place.here ? run_here(carried, request, {}, boundaries, progress)
                           : run_there(place,
                                       request.host_clock ? harness::GuestClock::kHost
                                                          : harness::GuestClock::kOwn,
                                       carried, boundaries, progress, listener, run.setting);
  caretaker.forget();
  return run;
}

void run_real_part(const harness::Sweep& sweep, const RealRequest& request,
                   std::vector<harness::DelayBoundary> boundaries) {
  const auto part = harness::SweepPart::parse(request.part);
  if (!part || request.part_results.empty() || !harness::inside_guest())
    throw Failed(
        "--part I/N and --part-results FILE are how `tandem netem` speaks with itself in "
        "user-mode Linux");
  harness::Caretaker::instance().listen();
  harness::settle_inside_guest();
  std::vector<std::string> left_out;
  const harness::Sweep carried = as_run(sweep, request, left_out);
  const auto progress = [](int done, int all, const std::string& doing) {
    std::fputs(harness::progress_line(done, all, doing).c_str(), stdout);
    std::fflush(stdout);
  };
  std::vector<harness::PointResult> results =
      run_here(carried, request, *part, boundaries, progress);
  harness::PartResults found;
  found.setting = real_setting();
  found.boundaries = std::move(boundaries);
  for (std::size_t i = 0, k = 0; i < carried.points.size(); ++i)
    if (part->has(i)) found.points.push_back({i, std::move(results.at(k++))});
  harness::write_part(request.part_results, found);
}

}  // namespace tandem::cli
