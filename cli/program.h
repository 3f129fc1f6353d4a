#pragma once

namespace tandem::cli {

/// The whole program: does what its words ask for. Nodes of the network harness are forks that go
/// through it again. Exit status: 0 done, 1 a check failed or a run ended badly, 2 wrong scene or
/// arguments.
[[nodiscard]] int run_program(int argc, char** argv);

}  // namespace tandem::cli
