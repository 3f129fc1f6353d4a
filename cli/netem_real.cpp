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
  real->add_option("--at-once", request.at_once, "sessions that run at the same time")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  real->add_flag(
      "--host-clock", request.host_clock,
      "user-mode Linux has this machine's clock, stalls and all (default: one of its own "
      "that leaves out idle time and what this machine takes away)");
  real->add_flag("--check", request.check, "only say where netem is on this machine");
  real->add_flag("--clean", request.clean, "only remove what killed runs left behind");
}

bool do_chores(const RealRequest& request) {
  if (request.clean) look_for_leftovers(true);
  if (request.check) say_where_netem_is();
  return request.clean || request.check;
}

std::optional<int> run_elsewhere(const RealRequest& request) {
  (void)harness::Caretaker::instance();
  if (harness::inside_guest()) {
    harness::settle_inside_guest();
    return std::nullopt;
  }
  look_for_leftovers(false);
  const Place place = find_place();
  if (place.here) return std::nullopt;
  if (!place.guest.ready()) throw Failed(what_it_needs(place));
  fmt::print(stderr, "no netem here ({}): everything runs in user-mode Linux, {}\n",
             place.why_not_here, place.guest.program);
  return harness::run_in_guest(
      place.guest, own_command_line(),
      request.host_clock ? harness::GuestClock::kHost : harness::GuestClock::kOwn);
}

RealRun run_real(const harness::Sweep& sweep, const RealRequest& request,
                 std::vector<harness::DelayBoundary>& boundaries,
                 const std::function<bool(int, int, const std::string&)>& progress) {
  harness::Caretaker& caretaker = harness::Caretaker::instance();
  caretaker.listen();
  harness::RealOptions options;
  options.program.file = std::filesystem::read_symlink("/proc/self/exe").string();
  if (harness::inside_guest()) options.program.main = run_program;
  options.name = request.name.empty() ? harness::own_network_name() : request.name;
  options.folder = request.folder;
  options.at_once = request.at_once;
  options.most_nodes = 2 * request.at_once;
  const harness::RealProgress report = [&](int done, int all, const std::string& doing) {
    if (!progress(done, all, doing)) throw harness::Interrupted();
  };
  RealRun run;
  const harness::Sweep carried = as_carried(sweep, run.left_out);
  run.results =
      harness::run_real_sweep(request.quick ? thinned(carried) : carried, options, report);
  constexpr double kSeconds = 5.0;
  if (!boundaries.empty())
    harness::find_real_boundaries(boundaries, options, kSeconds, request.quick, report);
  caretaker.forget();
  return run;
}

std::string real_setting() {
  utsname kernel{};
  uname(&kernel);
  const std::string own = fmt::format("Linux {} ({})", kernel.release, kernel.version);
  return harness::inside_guest() ? fmt::format("user-mode {} on {}", own, harness::guest_host())
                                 : own;
}

}  // namespace tandem::cli
