#include "harness/guest.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sched.h>
#include <string_view>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "harness/caretaker.h"
#include "harness/child.h"
#include "harness/harness_error.h"
#include "harness/namespaces.h"

namespace tandem::harness {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInside = "TANDEM_GUEST_MODULES";  // set in the guest: its modules' folder
constexpr const char* kHost = "TANDEM_GUEST_HOST";
constexpr const char* kFolderName = "tandem-guest-";
constexpr int kPriority = 50;
constexpr const char* kHint =
    "install it as root with `apt-get install --no-install-recommends user-mode-linux`, or let "
    "`scripts/netem` do it";

[[nodiscard]] std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// Whether we may have a real-time priority; tried, and given back.
[[nodiscard]] bool may_be_first() {
  const sched_param wanted{.sched_priority = kPriority}, ordinary{};
  if (sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) return false;
  sched_setscheduler(0, SCHED_OTHER, &ordinary);
  return true;
}

[[nodiscard]] std::string describe_host(GuestClock clock) {
  utsname kernel{};
  uname(&kernel);
  const std::string granted = clock == GuestClock::kOwn
                                  ? "a clock of its own (without host stalls and idle time)"
                                  : fmt::format("the host's clock, SCHED_FIFO {} {}", kPriority,
                                                may_be_first() ? "granted" : "not granted");
  return fmt::format("Linux {} ({}), one processor, {}", kernel.release, kernel.version, granted);
}

/// Loaded into the guest's kernel for a clock of its own: beside this program where it was built,
/// in lib/tandem where it is installed. Empty: not found.
[[nodiscard]] std::string find_clock() {
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const fs::path& place : {folder, folder.parent_path() / TANDEM_INSTALLED_LIBRARIES})
    if (fs::path file = place / "tandem_guest_clock.so"; fs::exists(file, ignored)) return file;
  return {};
}

/// What the guest's first process runs. The command's exit status and end are left in files.
[[nodiscard]] std::string init_script(const GuestKernel& kernel, const std::string& folder,
                                      const std::vector<std::string>& words, GuestClock clock) {
  std::string command;
  for (const std::string& word : words) command += quoted(word) + " ";
  const char* home = std::getenv("HOME");
  std::string own;  // where a guest finds what its host has found
  for (const char* name : {"TANDEM_SCENES", "TANDEM_SWEEPS"})
    if (const char* value = std::getenv(name); value != nullptr)
      own += fmt::format(" {}={}", name, quoted(value));
  return fmt::format(
      "#!/bin/sh\n"
      "export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin\n"
      "export HOME={home} LANG=C.UTF-8 {inside}={modules} {host}={described}{own}\n"
      "cd {here}\n"
      "{command} >{folder}/out 2>{folder}/err </dev/null\n"
      "echo $? >{folder}/status.new && mv {folder}/status.new {folder}/status\n"
      "sync\n"
      "echo o >/proc/sysrq-trigger\n"
      "sleep 60\n",
      fmt::arg("home", quoted(home != nullptr ? home : "/root")), fmt::arg("inside", kInside),
      fmt::arg("modules", quoted(kernel.modules)), fmt::arg("host", kHost),
      fmt::arg("described", quoted(describe_host(clock))), fmt::arg("own", own),
      fmt::arg("here", quoted(fs::current_path().string())), fmt::arg("command", command),
      fmt::arg("folder", folder));
}

[[nodiscard]] std::optional<int> read_status(const std::string& file) {
  std::ifstream in(file);
  int status = 0;
  if (in >> status) return status;
  return std::nullopt;
}

[[nodiscard]] std::string last_lines(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  std::string text;
  constexpr std::size_t kShown = 6;
  for (std::size_t i = lines.size() > kShown ? lines.size() - kShown : 0; i < lines.size(); ++i)
    text += "  " + lines[i] + "\n";
  return text;
}

void pin_to(int processor) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(processor, &one);
  sched_setaffinity(0, sizeof(one), &one);
}

[[nodiscard]] pid_t boot(const GuestKernel& kernel, const std::string& folder,
                         const std::string& clock, int processor) {
  const std::string init = "init=" + folder + "/init";
  const std::string console = folder + "/console";
  const std::vector<std::string> words{kernel.program,
                                       "mem=768M",
                                       "rootfstype=hostfs",
                                       "rootflags=/",
                                       "rw",
                                       init,
                                       "con=null",
                                       "con0=null,fd:1",
                                       "quiet",
                                       "panic=-1",
                                       "umid=" + fs::path(folder).filename().string()};
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw HarnessError(std::string("cannot fork: ") + std::strerror(errno));
  if (pid > 0) {
    setpgid(pid, pid);
    return pid;
  }
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  pin_to(processor);
  // With a clock of its own it waits for nobody, and nobody need wait for it.
  const sched_param priority{.sched_priority = kPriority};
  if (clock.empty()) sched_setscheduler(0, SCHED_FIFO, &priority);
  if (!clock.empty()) setenv("LD_PRELOAD", clock.c_str(), 1);
  // Its process numbers file and sockets; its default is below HOME.
  setenv("HOME", folder.c_str(), 1);
  const int nowhere = open("/dev/null", O_RDONLY);
  const int out = open(console.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(nowhere, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
  execv(argv[0], argv.data());
  _exit(127);
}

/// What a module says it needs: "depends=ipv6,llc,stp" in its information.
[[nodiscard]] std::vector<std::string> needs_of(const fs::path& module) {
  std::ifstream in(module, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  constexpr std::string_view kKey{"\0depends=", 9};
  std::vector<std::string> needs;
  const std::size_t begin = content.find(kKey);
  if (begin == std::string::npos) return needs;
  const std::string list = content.c_str() + begin + kKey.size();
  for (std::size_t at = 0; at < list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    needs.push_back(list.substr(at, end - at));
    at = end + 1;
  }
  return needs;
}

/// The file of a module; names have - and _ alike.
[[nodiscard]] fs::path find_module(const std::string& folder, std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string stem = entry.path().stem().string();
    std::replace(stem.begin(), stem.end(), '-', '_');
    if (entry.path().extension() == ".ko" && stem == name) return entry.path();
  }
  return {};  // part of the kernel itself
}

void load_module(const std::string& folder, const std::string& name) {
  const fs::path module = find_module(folder, name);
  if (module.empty()) return;
  for (const std::string& need : needs_of(module)) load_module(folder, need);
  const int fd = open(module.c_str(), O_RDONLY | O_CLOEXEC);
  // No router is asked for, no address made up: nothing but our packets on the cables.
  const long result = syscall(SYS_finit_module, fd, name == "ipv6" ? "disable_ipv6=1" : "", 0);
  const int error = errno;
  close(fd);
  if (fd < 0 || (result != 0 && error != EEXIST))
    throw HarnessError("module " + module.string() + ": " + std::strerror(error));
}

/// netem hands packets on in the kernel's soft interrupts, which under load are a thread without
/// priority: behind a node that writes its recording they waited 0.2 s. Before the force loops
/// (80).
void deliver_packets_first() {
  constexpr int kFirst = 90;
  const sched_param first{.sched_priority = kFirst};
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", error)) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    std::string name;
    if (pid <= 0 || !std::getline(std::ifstream(entry.path() / "comm"), name)) continue;
    if (name.starts_with("ksoftirqd/") && sched_setscheduler(pid, SCHED_FIFO, &first) != 0)
      throw HarnessError(fmt::format("cannot give {} a priority: {}", name, std::strerror(errno)));
  }
}

}  // namespace

GuestKernel find_guest_kernel() {
  GuestKernel kernel;
  kernel.program = find_program("linux.uml");
  if (kernel.program.empty()) {
    kernel.why_not = std::string("Debian's package user-mode-linux is not installed; ") + kHint;
    return kernel;
  }
  const fs::path modules =
      fs::canonical(kernel.program).parent_path().parent_path() / "lib" / "uml" / "modules";
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(modules, error))
    if (fs::exists(entry.path() / "kernel" / "net" / "sched" / "sch_netem.ko"))
      kernel.modules = (entry.path() / "kernel").string();
  if (kernel.modules.empty())
    kernel.why_not = fmt::format("{} has no module sch_netem below {}; {}", kernel.program,
                                 modules.string(), kHint);
  return kernel;
}

bool inside_guest() { return std::getenv(kInside) != nullptr; }

std::string guest_host() {
  const char* host = std::getenv(kHost);
  return host != nullptr ? host : "";
}

void settle_inside_guest() {
  const auto mount_at = [](const char* type, const char* where) {
    if (mount(type, where, type, 0, nullptr) != 0 && errno != EBUSY)
      throw HarnessError(fmt::format("cannot mount {}: {}", where, std::strerror(errno)));
  };
  mount_at("proc", "/proc");
  mount_at("sysfs", "/sys");
  mount_at("tmpfs", "/run");
  fs::create_directories("/run/netns");
  const std::string modules = std::getenv(kInside);
  for (const char* module : {"bridge", "veth", "sch_netem"}) load_module(modules, module);
  must_run({"ip", "link", "set", "lo", "up"});
  deliver_packets_first();
}

std::vector<int> processors_for_guests() {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return {0};
  std::vector<int> processors;
  for (int c = CPU_SETSIZE - 1; c >= 0; --c)
    if (CPU_ISSET(c, &allowed)) processors.push_back(c);
  return processors;
}

std::vector<std::string> left_guests() {
  std::vector<std::string> left;
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(fs::temp_directory_path(error), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kFolderName)) continue;
    const int owner = std::atoi(name.c_str() + std::strlen(kFolderName));
    if (owner > 0 && owner != getpid() && !is_running_tandem(owner))
      left.push_back(entry.path().string());
  }
  std::sort(left.begin(), left.end());
  return left;
}

void remove_guests(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) {
    std::ifstream in(fs::path(folder) / "pid");
    pid_t pid = 0;
    std::error_code error;
    if (in >> pid && pid > 1 &&
        fs::read_symlink(fmt::format("/proc/{}/exe", pid), error).filename() == "linux.uml")
      kill(-pid, SIGKILL);
    fs::remove_all(folder, error);
  }
}

Guest::Guest(GuestKernel kernel, GuestClock clock, int processor)
    : kernel_(std::move(kernel)),
      clock_(clock),
      processor_(processor),
      folder_((fs::temp_directory_path() / fmt::format("{}{}-XXXXXX", kFolderName, getpid()))
                  .string()) {
  if (mkdtemp(folder_.data()) == nullptr)
    throw HarnessError("cannot make a folder for the guest, " + folder_ + ": " +
                       std::strerror(errno));
  Caretaker::instance().remove_folder_at_end(folder_);
}

Guest::~Guest() {
  end();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  Caretaker::instance().folder_is_removed(folder_);
}

void Guest::start(const std::vector<std::string>& words) {
  const std::string clock = clock_ == GuestClock::kOwn ? find_clock() : "";
  if (clock_ == GuestClock::kOwn && clock.empty())
    throw HarnessError(
        "tandem_guest_clock.so is neither beside this program nor installed with it; build or "
        "install the whole of Tandem, or add --host-clock");
  // The loader takes a list and splits it at blanks and colons: its own folder's name has none.
  const bool plain = std::all_of(folder_.begin(), folder_.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("/._-+~@", c) != nullptr;
  });
  if (!plain || folder_.starts_with("/run/"))  // the guest has a /run of its own
    throw HarnessError("user-mode Linux cannot start from folder " + folder_ +
                       ": below /run, or with other signs in its name than letters, digits and "
                       "/._-+~@; set TMPDIR to another one");
  const std::string own_clock = clock.empty() ? "" : folder_ + "/clock.so";
  if (std::error_code error; !clock.empty() && !fs::copy_file(clock, own_clock, error))
    throw HarnessError("cannot write " + own_clock + ": " + error.message());
  {
    std::ofstream init(folder_ + "/init");
    init << init_script(kernel_, folder_, words, clock_);
    if (!init.flush()) throw HarnessError("cannot write " + folder_ + "/init: disk full?");
  }
  fs::permissions(folder_ + "/init", fs::perms::owner_all);
  pid_ = boot(kernel_, folder_, own_clock, processor_);
  Caretaker::instance().kill_group_at_end(pid_);
  std::ofstream(folder_ + "/pid") << pid_ << "\n";
  started_ = std::chrono::steady_clock::now();
}

void Guest::end() {
  if (pid_ <= 0) return;
  kill(-pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  Caretaker::instance().group_has_ended(pid_);
  pid_ = -1;
}

bool Guest::look(Said& said) {
  if (status_) return false;
  // In this order: what ends well has said all before its status is there, and that before it goes.
  siginfo_t end_of_kernel{};
  waitid(P_PID, static_cast<id_t>(pid_), &end_of_kernel, WEXITED | WNOHANG | WNOWAIT);
  status_ = read_status(folder_ + "/status");
  out_.take(folder_ + "/out", said.out, status_.has_value());
  err_.take(folder_ + "/err", said.err, status_.has_value());
  if (status_) {
    end();  // it has nothing left to do: its files are ours, written through
    return false;
  }
  constexpr auto kBootTime = std::chrono::seconds(30);
  const bool came_up = fs::exists(folder_ + "/err");
  const bool late = !came_up && std::chrono::steady_clock::now() - started_ > kBootTime;
  if (end_of_kernel.si_pid == 0 && !late) return true;
  std::error_code unknown;
  constexpr std::uintmax_t kLeast = 65536;
  if (fs::space(folder_, unknown).available < kLeast && !unknown)
    throw HarnessError("user-mode Linux broke down: the disk of " + folder_ +
                       " is full; make room, or set TMPDIR to a folder on another disk");
  const std::string console = last_lines(folder_ + "/console");
  throw HarnessError(fmt::format("user-mode Linux ({}) {}; its last words:\n{}", kernel_.program,
                                 came_up ? "broke down"
                                 : late  ? "did not come up within 30 s"
                                         : "ended before it came up",
                                 console.empty() ? "  (none)\n" : console));
}

void Guest::Tail::take(const std::string& file, std::vector<std::string>& lines, bool ended) {
  std::ifstream in(file, std::ios::binary);
  if (!in || !in.seekg(done_)) return;
  char buffer[4096];
  while (in.read(buffer, sizeof(buffer)), in.gcount() > 0) {
    begun_.append(buffer, static_cast<std::size_t>(in.gcount()));
    done_ += in.gcount();
  }
  for (std::size_t at; (at = begun_.find('\n')) != std::string::npos; begun_.erase(0, at + 1))
    lines.push_back(begun_.substr(0, at));
  if (ended && !begun_.empty()) lines.push_back(std::exchange(begun_, {}));
}

}  // namespace tandem::harness
