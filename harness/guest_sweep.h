#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/guest.h"
#include "harness/part_results.h"
#include "harness/real_sweep.h"

namespace tandem::harness {

/// What a worker writes on its standard output to say how far it is.
[[nodiscard]] std::string progress_line(int done, int all, const std::string& doing);

/// Adds up what several workers say.
class AddedProgress {
 public:
  explicit AddedProgress(std::size_t workers) : done_(workers, 0), all_(workers, 0) {}
  /// False: that is no progress line.
  bool take(std::size_t worker, const std::string& line);
  [[nodiscard]] int done() const;
  [[nodiscard]] int all() const;
  [[nodiscard]] const std::string& doing() const { return doing_; }  ///< of who spoke last

 private:
  std::vector<int> done_, all_;
  std::string doing_;
};

/// How many guests share a sweep: one a processor, at most two (a third would need a processor of
/// its own, and the processors of a machine are not always alone on their core), and no more than
/// there are points.
[[nodiscard]] std::size_t guests_for(const Sweep& sweep);

/// Runs a command line in guests_for(sweep) guests at a time, with `--part I/N --part-results FILE`
/// behind its words, and returns what they left in their FILEs. `progress` gets the sum of theirs;
/// what they say otherwise goes to `say`, a line at a time, with the guest it came from. When one
/// fails all are ended: HarnessError, with its points. Interrupted as soon as the caretaker was.
[[nodiscard]] std::vector<PartResults> run_in_guests(
    const GuestKernel& kernel, GuestClock clock, const std::vector<std::string>& words,
    const Sweep& sweep, const RealProgress& progress,
    const std::function<void(const std::string&)>& say);

}  // namespace tandem::harness
