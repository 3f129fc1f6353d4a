#include "cli/ranks.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "cli/commands.h"

#ifdef TANDEM_MPI
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace tandem::cli::ranks {

namespace {

int from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  const int value = text != nullptr ? std::atoi(text) : 0;
  return value > 0 ? value : otherwise;
}

/// Processes that mpirun (Open MPI's) started; 1: it did not.
int started() { return from_environment("OMPI_COMM_WORLD_SIZE", 1); }

}  // namespace

int on_this_machine() {
  return started() > 1 ? from_environment("OMPI_COMM_WORLD_LOCAL_SIZE", 1) : 1;
}

#ifdef TANDEM_MPI

namespace {

/// Without mpirun MPI is never started.
struct World {
  int count = 1, own = 0;
  bool may_end = true;

  World() {
    if (started() == 1) return;
    int granted = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &granted);
    if (granted < MPI_THREAD_SERIALIZED) {
      MPI_Finalize();
      throw Failed(
          "this MPI lets only one thread of a process call it; give --jobs 1, or use one "
          "with MPI_THREAD_SERIALIZED");
    }
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    MPI_Comm_rank(MPI_COMM_WORLD, &own);
  }
  ~World() {
    if (count == 1) return;
    if (may_end)
      MPI_Finalize();
    else
      MPI_Abort(MPI_COMM_WORLD, 1);
  }
};

World& world() {
  static World one;
  return one;
}

}  // namespace

int count() { return world().count; }
int own() { return world().own; }
void may_end(bool may) { world().may_end = may; }

void broadcast(std::vector<double>& values) {
  if (count() == 1) return;
  unsigned long long size = values.size();
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, MPI_COMM_WORLD);
  values.resize(size);
  constexpr std::size_t kAtOnce = 1u << 27;  // MPI counts with int
  for (std::size_t at = 0; at < values.size(); at += kAtOnce)
    MPI_Bcast(values.data() + at, static_cast<int>(std::min(kAtOnce, values.size() - at)),
              MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

void send(const std::vector<double>& message) {
  if (message.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw Failed("a row of the sweep is too long for MPI");
  MPI_Send(message.data(), static_cast<int>(message.size()), MPI_DOUBLE, 0, 0, MPI_COMM_WORLD);
}

bool receive(std::vector<double>& message, bool wait) {
  MPI_Status status;
  int there = 1;
  if (wait)
    MPI_Probe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &status);
  else
    MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return false;
  int size = 0;
  MPI_Get_count(&status, MPI_DOUBLE, &size);
  message.resize(static_cast<std::size_t>(size));
  MPI_Recv(message.data(), size, MPI_DOUBLE, status.MPI_SOURCE, 0, MPI_COMM_WORLD, &status);
  return true;
}

#else

int count() {
  if (started() > 1)
    throw Failed(
        "mpirun started several of these, but this program was built without MPI: "
        "configure with -DTANDEM_MPI=ON, or start it once, without mpirun");
  return 1;
}
int own() { return 0; }
void may_end(bool /*may*/) {}
void broadcast(std::vector<double>& /*values*/) {}
void send(const std::vector<double>& /*message*/) {}
bool receive(std::vector<double>& /*message*/, bool /*wait*/) { return false; }

#endif

}  // namespace tandem::cli::ranks
