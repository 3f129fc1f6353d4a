#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

namespace tandem::harness {

/// A small network on this machine: one network namespace a site, each with `eth0` on a cable
/// (veth) to a bridge in a namespace of its own. Nothing outside these namespaces is touched, no
/// packet leaves them. Addresses are 10.84.0.1 and up; neighbours are entered for good, so that no
/// address resolution meets the conditions of the link.
///
/// Names are NAME-bridge, NAME-1, NAME-2, ...; what has such a name already is refused and left
/// alone.
class Namespaces {
 public:
  /// Needs root (CAP_NET_ADMIN, CAP_SYS_ADMIN). Throws HarnessError, with nothing left behind.
  Namespaces(const std::string& name, int sites);
  ~Namespaces();
  Namespaces(const Namespaces&) = delete;
  Namespaces& operator=(const Namespaces&) = delete;

  [[nodiscard]] int count() const { return static_cast<int>(sites_.size()); }
  /// Of a site from 0 on.
  [[nodiscard]] const std::string& name_of(int site) const { return sites_.at(site); }
  [[nodiscard]] std::string address_of(int site) const;

  /// What happens to packets on a site's way out: arguments after `tc qdisc ... netem`; empty:
  /// nothing. Where that is what holds already it stays (in user-mode Linux every tc takes 0.1 s),
  /// else packets still on their way are dropped. Throws HarnessError with tc's words.
  void shape(int site, const std::vector<std::string>& netem_arguments);
  /// Somebody else changes what holds there from now on: the next `shape` does all anew.
  void forget_shape(int site) { known_.at(site) = false; }

 private:
  void make();
  void remove() noexcept;

  std::string bridge_;
  std::vector<std::string> sites_;
  std::vector<std::string> made_;
  std::vector<std::vector<std::string>> shapes_;  ///< netem's arguments, by site
  std::vector<bool> known_;                       ///< that these hold
};

/// The name of this process's networks: "tandem-<pid>".
[[nodiscard]] std::string own_network_name();

/// Whether a process with this number runs now and is this program; numbers are used again.
[[nodiscard]] bool is_running_tandem(pid_t pid);

/// What is wrong with a name for a network; empty: nothing.
[[nodiscard]] std::string problem_with_network_name(const std::string& name);

/// Namespaces named as ours whose program is gone: left by runs that were killed together with the
/// process that cleans up after them.
[[nodiscard]] std::vector<std::string> left_namespaces();

/// Those of the network NAME that exist now.
[[nodiscard]] std::vector<std::string> namespaces_of(const std::string& name);

/// Removes namespaces by name, with what still runs in them; what does not exist is passed over.
void remove_namespaces(const std::vector<std::string>& names) noexcept;

/// Whether netem works on this kernel, tried in a namespace without a name; else why not.
struct KernelSupport {
  bool netem = false;
  std::string why_not;
};
[[nodiscard]] KernelSupport try_netem();

}  // namespace tandem::harness
