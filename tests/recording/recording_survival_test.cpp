// What is left of a recording when its program is killed or its disk is full: child processes
// really record, and are really killed or limited.

#include <atomic>
#include <chrono>
#include <cstring>
#include <new>
#include <signal.h>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "recording/recording_reader.h"
#include "recording/recording_writer.h"
#include "tests/recording/recorded_examples.h"
#include "tests/recording/scratch_folder.h"

namespace tandem::recording {
namespace {

using core::PacketRecord;
using core::TickRecord;
using namespace std::chrono_literals;
using test::example;
using test::is_example;
using test::ScratchFolder;

/// Memory that parent and child both see.
struct Shared {
  std::atomic<std::uint64_t> handed_over{0};  ///< ticks given to the recording
  std::atomic<std::uint64_t> safe{0};         ///< ticks it said are safe
  std::atomic<std::uint64_t> lost{0};
  char failure[400] = {};
};

class SharedMemory {
 public:
  SharedMemory()
      : memory_(mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                     -1, 0)),
        shared_(new (memory_) Shared) {}
  ~SharedMemory() { munmap(memory_, sizeof(Shared)); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  Shared* operator->() const { return shared_; }

 private:
  void* memory_;
  Shared* shared_;
};

constexpr auto kTick = 977us;

/// Records ticks and packets at their real rates until `stop` says so.
template <typename Stop>
void record_in_real_time(RecordingWriter& writer, const RecordColumns& columns,
                         const SharedMemory& shared, Stop&& stop) {
  auto due = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0; !stop(); ++i) {
    writer.record(example<TickRecord>(i, columns));
    if (i % 8 == 0) writer.record(example<PacketRecord>(i, columns));
    shared->handed_over = i + 1;
    std::this_thread::sleep_until(due += kTick);
  }
}

TEST(RecordingSurvival, SigkillLosesAtMostTheLastSecond) {
  const auto columns = test::planar_columns();
  // Killed at different moments between two flushes, and before the first.
  for (const auto after : {200ms, 1130ms, 1610ms}) {
    const ScratchFolder folder;
    const std::string file = folder / "killed.h5";
    const SharedMemory shared;
    const pid_t child = fork();
    if (child == 0) {
      RecordingWriter writer(file, test::some_header(), columns);
      record_in_real_time(writer, columns, shared, [] { return false; });
      _exit(1);
    }
    std::this_thread::sleep_for(after);
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));

    RecordingReader reader(file);
    EXPECT_FALSE(reader.complete());
    EXPECT_EQ(reader.header().scene_hash, "0123456789abcdef");
    const std::uint64_t handed_over = shared->handed_over;
    EXPECT_GE(reader.tick_count() + 1024, handed_over) << "more than a second was lost";
    EXPECT_GE(reader.packet_count() + 128, handed_over / 8);
    const auto ticks = reader.ticks(0, reader.tick_count());
    ASSERT_EQ(ticks.size(), reader.tick_count());
    for (std::uint64_t i = 0; i < ticks.size(); ++i) ASSERT_TRUE(is_example(ticks[i], i, columns));
    const auto packets = reader.packets(0, reader.packet_count());
    for (std::uint64_t i = 0; i < packets.size(); ++i) {
      ASSERT_TRUE(is_example(packets[i], 8 * i, columns));
    }
  }
}

// The file may not grow beyond a limit, which is what a full disk looks like to the program.
TEST(RecordingSurvival, AFullDiskStopsTheRecordingNotTheSessionAndNothingFlushedIsLost) {
  const auto columns = test::planar_columns();
  const ScratchFolder folder;
  const std::string file = folder / "full.h5";
  const SharedMemory shared;
  const pid_t child = fork();
  if (child == 0) {
    const rlimit limit{400'000, 400'000};  // about 1.5 s of planar ticks
    setrlimit(RLIMIT_FSIZE, &limit);
    RecordingWriter writer(file, test::some_header(), columns);
    const auto end = std::chrono::steady_clock::now() + 3s;
    record_in_real_time(writer, columns, shared,
                        [&] { return std::chrono::steady_clock::now() > end; });
    writer.close();
    const RecordingStatus status = writer.status();
    shared->safe = status.ticks_safe;
    shared->lost = status.lost;
    std::strncpy(shared->failure, status.failure.c_str(), sizeof(shared->failure) - 1);
    exit(42);  // through the end of the program: HDF5 must not touch the file there either
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << "the session did not go on: signal " << WTERMSIG(status);
  ASSERT_EQ(WEXITSTATUS(status), 42);

  const std::string failure = shared->failure;
  EXPECT_NE(failure.find(file), std::string::npos) << failure;
  EXPECT_NE(failure.find("File too large"), std::string::npos) << failure;
  EXPECT_NE(failure.find("the session goes on"), std::string::npos) << failure;
  EXPECT_GT(shared->safe, 300u);
  EXPECT_LT(shared->safe, shared->handed_over);

  RecordingReader reader(file);
  EXPECT_FALSE(reader.complete());
  EXPECT_GE(reader.tick_count(), shared->safe);
  const auto ticks = reader.ticks(0, reader.tick_count());
  for (std::uint64_t i = 0; i < ticks.size(); ++i) ASSERT_TRUE(is_example(ticks[i], i, columns));
  // Every record is either safe or counted as lost.
  const std::uint64_t handed_over = shared->handed_over;
  const std::uint64_t records = handed_over + (handed_over + 7) / 8;
  const std::uint64_t packets_safe = records - shared->lost - shared->safe;
  EXPECT_LE(packets_safe, reader.packet_count());
  EXPECT_GT(packets_safe, 0u);
}

}  // namespace
}  // namespace tandem::recording
