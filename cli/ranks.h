#pragma once

#include <vector>

/// One sweep as many processes under mpirun; alone without. Built with -DTANDEM_MPI=ON. Nothing
/// here may be called by two threads at once.
namespace tandem::cli::ranks {

/// How many processes there are, and which one this is; 0 is the root, which reads and writes
/// files. Throws Failed under an mpirun this program was not built for.
[[nodiscard]] int count();
[[nodiscard]] int own();
/// How many of them are on this machine.
[[nodiscard]] int on_this_machine();

/// What the root has, everywhere.
void broadcast(std::vector<double>& values);
/// To the root.
void send(const std::vector<double>& message);
/// At the root, from anyone; false: there was nothing and `wait` is false.
bool receive(std::vector<double>& message, bool wait);

/// Whether this process may end by itself; otherwise its end ends all, so that none waits for ever.
void may_end(bool may);

}  // namespace tandem::cli::ranks
