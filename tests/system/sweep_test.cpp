// Sweeps that are stopped half way and gone on with.

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/system/program.h"

namespace tandem::test {
namespace {

std::string bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

/// A header and one line a finished part.
std::ptrdiff_t lines_of(const std::string& file) {
  const std::string bytes = bytes_of(file);
  return std::count(bytes.begin(), bytes.end(), '\n');
}

/// 400 points with margins, 80 parts.
std::vector<std::string> sweep(const std::string& csv, const std::string& kept,
                               const std::string& jobs) {
  std::vector<std::string> a{"analyze", "sweep",
                             "--scene", "axis_distributed",
                             "--axis",  "coupler.ko1.stiffness,coupler.ko2.stiffness=100:2000:80",
                             "--axis",  "delay_packets=0,0.5,1,1.5,2",
                             "--csv",   scratch(csv),
                             "--jobs",  jobs};
  if (!kept.empty()) a.insert(a.end(), {"--resume", scratch(kept)});
  return a;
}

void wait_for_lines(const std::string& file, std::ptrdiff_t lines) {
  for (int i = 0; i < 5000 && lines_of(file) < lines; ++i) sleep_seconds(0.002);
}

TEST(Sweeps, StoppedAndKilledAndGoneOnWithGiveTheSameBytes) {
  Program whole(sweep("whole.csv", "", "1"));

  Program stopped(sweep("resumed.csv", "kept.sweep", "2"));
  wait_for_lines(scratch("kept.sweep"), 5);
  stopped.signal(SIGINT);
  EXPECT_EQ(stopped.wait(), 1) << stopped.output();
  EXPECT_NE(stopped.output().find("--resume"), std::string::npos) << stopped.output();
  EXPECT_TRUE(bytes_of(scratch("resumed.csv")).empty()) << "nothing half is written";
  const auto first = lines_of(scratch("kept.sweep"));
  EXPECT_GE(first, 5);

  Program killed(sweep("resumed.csv", "kept.sweep", "2"));
  wait_for_lines(scratch("kept.sweep"), first + 5);
  killed.signal(SIGKILL);
  EXPECT_EQ(killed.wait(), 128 + SIGKILL) << killed.output();
  const auto second = lines_of(scratch("kept.sweep"));
  EXPECT_GE(second, first + 5);
  EXPECT_LT(second, 81) << "it ended before it was killed: nothing was tried";
  // As if it had died within a line.
  std::ofstream(scratch("kept.sweep"), std::ios::app) << "points|79 0.";

  Program last(sweep("resumed.csv", "kept.sweep", "2"));
  EXPECT_EQ(last.wait(60.0), 0) << last.output();
  EXPECT_EQ(whole.wait(60.0), 0) << whole.output();
  EXPECT_FALSE(bytes_of(scratch("whole.csv")).empty());
  EXPECT_EQ(bytes_of(scratch("resumed.csv")), bytes_of(scratch("whole.csv")));
}

// What is kept belongs to one sweep: another one's settings are not mixed with it.
TEST(Sweeps, TheFileOfAnotherSweepIsRefusedAndStays) {
  std::vector<std::string> a = sweep("a.csv", "mine.sweep", "2");
  a[5] = "coupler.ko1.stiffness,coupler.ko2.stiffness=100:2000:4";
  EXPECT_EQ(Program(a).wait(), 0);
  const std::string before = bytes_of(scratch("mine.sweep"));
  a[5] = "coupler.ko1.stiffness,coupler.ko2.stiffness=100:2100:4";
  Program other(a);
  EXPECT_EQ(other.wait(), 1) << other.output();
  EXPECT_NE(other.output().find("other settings"), std::string::npos) << other.output();
  EXPECT_EQ(bytes_of(scratch("mine.sweep")), before);
}

// One process and three give the same bytes; --jobs does not matter.
TEST(Sweeps, UnderMpirunGiveTheSameBytes) {
#ifndef TANDEM_MPI
  GTEST_SKIP() << "built without -DTANDEM_MPI=ON";
#else
  Program alone(sweep("alone.csv", "", "1"));
  ASSERT_EQ(alone.wait(60.0), 0) << alone.output();
  const std::string three = scratch("three.csv");
  std::string command = "exec mpirun --allow-run-as-root --oversubscribe -np 3 " TANDEM_PROGRAM;
  for (const std::string& word : sweep("three.csv", "", "1")) command += " '" + word + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(bytes_of(three), bytes_of(scratch("alone.csv")));
#endif
}

}  // namespace
}  // namespace tandem::test
