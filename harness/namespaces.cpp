#include "harness/namespaces.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "harness/caretaker.h"
#include "harness/child.h"
#include "harness/harness_error.h"

namespace tandem::harness {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "/run/netns";
constexpr const char* kPrefix = "tandem-";

[[nodiscard]] bool exists(const std::string& name) {
  std::error_code ignored;
  return fs::exists(fs::path(kFolder) / name, ignored);
}

/// Of a locally administered kind that no card has.
[[nodiscard]] std::string hardware_address(int site) {
  return fmt::format("02:54:41:4e:00:{:02x}", site + 1);
}

/// The process number in "tandem-123-bridge"; 0: not one of our names.
[[nodiscard]] pid_t owner_of(const std::string& name) {
  if (!name.starts_with(kPrefix)) return 0;
  const char* begin = name.data() + std::strlen(kPrefix);
  const char* end = name.data() + name.size();
  pid_t pid = 0;
  const auto [rest, error] = std::from_chars(begin, end, pid);
  // "-a-bridge", "-b-2": what sessions are named after it.
  const std::string_view site(rest, static_cast<std::size_t>(end - rest));
  const bool ours = site.size() > 3 && site[0] == '-' && site[1] >= 'a' && site[1] <= 'd' &&
                    site[2] == '-' &&
                    (site.substr(3) == "bridge" ||
                     site.find_first_not_of("0123456789", 3) == std::string_view::npos);
  return error == std::errc() && ours ? pid : 0;
}

/// Ends what runs in a namespace, found by its inode.
void end_programs_in(const std::string& name) {
  struct stat wanted {};
  if (stat((fs::path(kFolder) / name).c_str(), &wanted) != 0) return;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", error)) {
    const std::string number = entry.path().filename().string();
    if (number.empty() || std::isdigit(static_cast<unsigned char>(number[0])) == 0) continue;
    struct stat network {};
    if (stat((entry.path() / "ns" / "net").c_str(), &network) == 0 &&
        network.st_ino == wanted.st_ino && network.st_dev == wanted.st_dev)
      kill(std::stoi(number), SIGKILL);
  }
}

}  // namespace

std::string own_network_name() { return fmt::format("{}{}", kPrefix, getpid()); }

bool is_running_tandem(pid_t pid) {
  std::error_code error;
  const fs::path program = fs::read_symlink(fmt::format("/proc/{}/exe", pid), error);
  if (error == std::errc::permission_denied) return true;  // somebody else's: not ours to doubt
  return !error && program.filename().string().starts_with("tandem");
}

std::string problem_with_network_name(const std::string& name) {
  constexpr std::size_t kLongest = 40;
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (!name.empty() && name.size() <= kLongest && plain && name[0] != '-') return {};
  return fmt::format("name of the network is \"{}\"; allowed: 1 to {} letters, digits, - and _",
                     name, kLongest);
}

Namespaces::Namespaces(const std::string& name, int sites) : bridge_(name + "-bridge") {
  if (const std::string problem = problem_with_network_name(name); !problem.empty())
    throw HarnessError(problem);
  for (int i = 0; i < sites; ++i) sites_.push_back(fmt::format("{}-{}", name, i + 1));
  shapes_.resize(sites_.size());
  known_.assign(sites_.size(), true);
  // Also one that is no site of ours: who looks for this network by its name would find it.
  for (const std::string& one : namespaces_of(name))
    throw HarnessError(fmt::format(
        "there is a network namespace {} already, which this run did not make and leaves alone; "
        "see what runs in it with `ip netns pids {}`; choose another --name, or remove it",
        one, one));
  try {
    make();
  } catch (...) {
    remove();
    throw;
  }
}

Namespaces::~Namespaces() { remove(); }

std::string Namespaces::address_of(int site) const { return fmt::format("10.84.0.{}", site + 1); }

void Namespaces::make() {
  const auto add = [this](const std::string& name) {
    must_run({"ip", "netns", "add", name});
    Caretaker::instance().remove_namespace_at_end(name);
    made_.push_back(name);
  };
  add(bridge_);
  for (const std::string& site : sites_) add(site);
  std::string at_bridge =
      "link add br0 type bridge forward_delay 0 stp_state 0 mcast_snooping 0\n"
      "link set br0 addrgenmode none\n"
      "link set br0 up\n";
  for (int i = 0; i < count(); ++i)
    at_bridge += fmt::format(
        "link add port{0} address 02:54:41:4e:01:{0:02x} type veth peer name eth0 netns {1}\n"
        "link set port{0} addrgenmode none\n"
        "link set port{0} master br0 up\n",
        i + 1, sites_[i]);
  must_run({"ip", "-batch", "-"}, bridge_, at_bridge);
  for (int i = 0; i < count(); ++i) {
    std::string at_site = fmt::format(
        "link set lo up\n"
        "link set eth0 address {} addrgenmode none\n"
        "addr add {}/24 dev eth0\n"
        "link set eth0 up\n",
        hardware_address(i), address_of(i));
    for (int j = 0; j < count(); ++j)
      if (j != i)
        at_site += fmt::format("neigh replace {} lladdr {} dev eth0 nud permanent\n", address_of(j),
                               hardware_address(j));
    must_run({"ip", "-batch", "-"}, sites_[i], at_site);
  }
}

void Namespaces::remove() noexcept {
  remove_namespaces(made_);
  for (const std::string& name : made_) Caretaker::instance().namespace_is_removed(name);
  made_.clear();
}

void Namespaces::shape(int site, const std::vector<std::string>& netem_arguments) {
  const std::string& name = sites_.at(site);
  std::vector<std::string>& shape = shapes_[site];
  if (known_[site] && shape == netem_arguments) return;
  if (!shape.empty()) must_run({"tc", "qdisc", "del", "dev", "eth0", "root"}, name);
  shape.clear();
  known_[site] = true;
  if (netem_arguments.empty()) return;
  std::vector<std::string> words{"tc", "qdisc", "add", "dev", "eth0", "root", "netem"};
  words.insert(words.end(), netem_arguments.begin(), netem_arguments.end());
  must_run(words, name);
  shape = netem_arguments;
}

std::vector<std::string> left_namespaces() {
  std::vector<std::string> left;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder, error)) {
    const std::string name = entry.path().filename().string();
    const pid_t owner = owner_of(name);
    if (owner > 0 && owner != getpid() && !is_running_tandem(owner)) left.push_back(name);
  }
  std::sort(left.begin(), left.end());
  return left;
}

std::vector<std::string> namespaces_of(const std::string& name) {
  std::vector<std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder, error)) {
    const std::string one = entry.path().filename().string();
    if (!one.starts_with(name + "-")) continue;
    const std::string rest = one.substr(name.size() + 1);
    const bool number = !rest.empty() && rest.find_first_not_of("0123456789") == std::string::npos;
    if (rest == "bridge" || number) found.push_back(one);
  }
  return found;
}

void remove_namespaces(const std::vector<std::string>& names) noexcept {
  try {
    for (const std::string& name : names) {
      if (!exists(name)) continue;
      end_programs_in(name);
      (void)run_program({"ip", "netns", "del", name});
    }
  } catch (...) {
    // What could not be removed is found by the next run.
  }
}

KernelSupport try_netem() {
  if (geteuid() != 0) return {false, "not root"};
  const std::string tc = find_program("tc");
  constexpr int kNoNamespace = 99;  // tc itself ends with 1 or 2
  if (tc.empty()) return {false, "no program tc (Debian's package iproute2)"};
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNET) != 0) _exit(kNoNamespace);
    const int nowhere = open("/dev/null", O_RDWR);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    execl(tc.c_str(), "tc", "qdisc", "add", "dev", "lo", "root", "netem", "delay", "1ms",
          static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return {false, "cannot try it"};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {true, {}};
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoNamespace)
    return {false, "may not make a network namespace (container without CAP_SYS_ADMIN?)"};
  return {false, "this kernel has no netem (module sch_netem)"};
}

}  // namespace tandem::harness
