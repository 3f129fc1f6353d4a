// `tandem analyze` as a program: sweeps that are stopped half way and gone on with, scenes of walls
// only, recorded networks.

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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

nlohmann::json result_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "analyze");
  arguments.insert(arguments.end(), {"--json", scratch("result.json")});
  Program p(arguments);
  EXPECT_EQ(p.wait(), 0) << p.output();
  return nlohmann::json::parse(bytes_of(scratch("result.json")), nullptr, false);
}

// A mass m on a held wall of K and B: (3.18) with an object that nothing moves, k < 2 B / T where
// B < 2 m / T = 204.8 N s/m. A passive wall needs b = K T / 2 + B of the device.
TEST(Walls, HaveBoundsAndAnExactAnswer) {
  const double T = 1.0 / 1024.0;
  const auto bounds = result_of({"bounds", "--scene", "wall_single"});
  ASSERT_EQ(bounds["couplers"].size(), 1u);
  EXPECT_EQ(bounds["couplers"][0]["field"], "wall.wall.stiffness");
  int seen = 0;
  for (const auto& row : bounds["couplers"][0]["bounds"]) {
    if (row["bound"] == "2 B / T") {
      EXPECT_NEAR(row["value"].get<double>(), 2.0 * 10.0 / T, 1e-9);
      EXPECT_NEAR(row["exact"].get<double>(), 2.0 * 10.0 / T, 20480.0 * 1e-6);
      ++seen;
    }
    if (row["bound"] == "Colgate-Schenkel, damping") {
      EXPECT_NEAR(row["value"].get<double>(), 1000.0 * T / 2.0 + 10.0, 1e-9);
      ++seen;
    }
  }
  EXPECT_EQ(seen, 2);
  // The hand's own 300 N/m hold it too: 1000 + 300 at rest.
  const auto point = result_of({"point", "--scene", "wall_single"});
  EXPECT_TRUE(point["stable"]);
  EXPECT_NEAR(point["felt"]["1"]["alone"]["stiffness_n_per_m"].get<double>(), 1300.0, 1e-6);
  EXPECT_TRUE(point["gains"].contains("wall.wall.stiffness"));
  // Far below the resonance, sqrt(1300 / 0.1) = 114 rad/s, X/F is 1 / 1300; the ideal has no hand.
  const auto response = result_of(
      {"admittance", "--scene", "wall_single", "--position", "--from", "0.01", "--count", "1"});
  EXPECT_NEAR(response["rows"][0]["magnitude"].get<double>(), 1.0 / 1300.0, 1e-6 / 1300.0);
  EXPECT_NEAR(response["rows"][0]["ideal_magnitude"].get<double>(), 1e-3, 1e-9);
}

TEST(RecordedNetworks, ADelayThatNewerPacketsOvertakeCountsAsLost) {
  std::ofstream file(scratch("delays.txt"));
  for (int i = 0; i < 200; ++i) file << (i == 100 ? 3000.0 : 8.0) << '\n';
  file.close();
  const auto found = result_of({"network", "--scene", "axis_distributed", "--trace",
                                scratch("delays.txt"), "--runs", "2", "--packets", "100"});
  EXPECT_EQ(found["recorded_overtaken"], 1);
  EXPECT_EQ(found["mean_square"]["independent_draws"], "from the recorded histogram");
  EXPECT_EQ(found["typical_run"]["verdict"], "stable");
}

TEST(RandomNetworks, AreRefusedWhereNoPacketsTravel) {
  Program refused({"analyze", "network", "--scene", "wall_single"});
  EXPECT_NE(refused.wait(), 0);
  EXPECT_NE(refused.output().find("wall_single is architecture: SINGLE"), std::string::npos)
      << refused.output();
}

}  // namespace
}  // namespace tandem::test
