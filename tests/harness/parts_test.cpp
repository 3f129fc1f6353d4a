// A sweep in parts: what workers leave for who puts it together, how far they are, and the guests
// that they run in.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sched.h>
#include <set>
#include <type_traits>
#include <unistd.h>

#include <boost/pfr.hpp>
#include <gtest/gtest.h>

#include "harness/caretaker.h"
#include "harness/guest_sweep.h"
#include "harness/harness_error.h"
#include "harness/part_results.h"

namespace tandem::harness {
namespace {

namespace fs = std::filesystem;

/// Calls `leaf` with every number, truth and text of a structure, of as many copies of it as given.
template <typename Leaf, typename First, typename... More>
void for_leaves(Leaf&& leaf, First& first, More&... more) {
  using T = std::remove_const_t<First>;
  if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    leaf(first, more...);
  } else if constexpr (std::is_same_v<T, SweepPoint>) {
    leaf(first.name, more.name...);  // all that travels of it
  } else if constexpr (requires { first.at(0); }) {
    for (std::size_t i = 0; i < first.size(); ++i) for_leaves(leaf, first[i], more.at(i)...);
  } else {
    boost::pfr::for_each_field(first, [&](auto& field, [[maybe_unused]] auto index) {
      for_leaves(leaf, field, boost::pfr::get<index>(more)...);
    });
  }
}

/// Every field has a value of its own.
PartResults full_part() {
  PartResults part;
  part.points.resize(2);
  part.boundaries.resize(2);
  for (PartResults::Point& point : part.points) {
    point.result.seen.resize(2);
    point.result.measures.sites.resize(2);
  }
  int n = 0;
  for_leaves(
      [&n](auto& leaf) {
        using T = std::remove_reference_t<decltype(leaf)>;
        ++n;
        if constexpr (std::is_same_v<T, std::string>)
          leaf = "text " + std::to_string(n);
        else if constexpr (std::is_same_v<T, bool>)
          leaf = !leaf;
        else if constexpr (std::is_floating_point_v<T>)
          leaf = 1.0 / n;
        else
          leaf = static_cast<T>(n);
      },
      part);
  return part;
}

TEST(PartResultsTest, EveryFieldComesThroughAsItWas) {
  const PartResults part = full_part();
  const PartResults again = unpack(pack(part));
  ASSERT_EQ(again.points.size(), 2u);
  int leaves = 0;
  for_leaves(
      [&](const auto& there, const auto& back) {
        ++leaves;
        EXPECT_EQ(there, back) << "field " << leaves;
      },
      part, again);
  EXPECT_GT(leaves, 200);  // of two points with two links and two sites each
}

TEST(PartResultsTest, WhatIsNoNumberAndInfiniteStaysSo) {
  PartResults part = full_part();
  PointResult& result = part.points[0].result;
  result.largest_coupling = std::numeric_limits<double>::infinity();
  result.mean_age = -std::numeric_limits<double>::infinity();
  result.hold_drag = std::numeric_limits<double>::quiet_NaN();
  result.kick_missed = std::numeric_limits<double>::denorm_min();
  result.seen[1].sent = std::numeric_limits<long long>::min();
  const PointResult back = unpack(pack(part)).points[0].result;
  EXPECT_EQ(back.largest_coupling, std::numeric_limits<double>::infinity());
  EXPECT_EQ(back.mean_age, -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(back.hold_drag));
  EXPECT_EQ(back.kick_missed, std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(back.seen[1].sent, std::numeric_limits<long long>::min());
}

TEST(PartResultsTest, WhatIsNoWholePartIsRefused) {
  std::vector<std::uint8_t> bytes = pack(full_part());
  bytes.pop_back();
  EXPECT_THROW((void)unpack(bytes), HarnessError);
  EXPECT_THROW((void)unpack({}), HarnessError);
  EXPECT_THROW((void)unpack({0x80}), HarnessError);  // an empty list: no field at all
  EXPECT_THROW((void)read_part("/nowhere/part"), HarnessError);
  EXPECT_THROW(write_part("/nowhere/part", {}), HarnessError);
}

TEST(SweepPartTest, EveryPointIsInOnePart) {
  for (std::size_t count = 1; count <= 3; ++count)
    for (std::size_t point = 0; point < 7; ++point) {
      int in = 0;
      for (std::size_t i = 0; i < count; ++i) in += SweepPart{i, count}.has(point) ? 1 : 0;
      EXPECT_EQ(in, 1) << point << " of " << count;
    }
}

TEST(SweepPartTest, IsReadAsItIsWritten) {
  const auto part = SweepPart::parse(SweepPart{1, 3}.text());
  ASSERT_TRUE(part);
  EXPECT_EQ(part->index, 1u);
  EXPECT_EQ(part->count, 3u);
  for (const char* text : {"", "1", "/", "1/", "0/2", "3/2", "1/2x", "-1/2", "1 /2"})
    EXPECT_FALSE(SweepPart::parse(text)) << text;
}

Sweep three_points() {
  Sweep sweep;
  for (const char* name : {"a", "b", "c"}) {
    sweep.points.emplace_back().name = name;
    sweep.points.back().label = std::string("label of ") + name;
  }
  return sweep;
}

/// What a worker leaves of some of three_points().
PartResults part_with(const std::vector<std::size_t>& indices) {
  PartResults part;
  for (const std::size_t i : indices) {
    PartResults::Point& point = part.points.emplace_back();
    point.index = i;
    point.result.point.name = three_points().points.at(i).name;
    point.result.mean_age = static_cast<double>(i);
  }
  return part;
}

TEST(JoinTest, PointsComeInTheOrderOfTheSweep) {
  const auto joined = join_points(three_points(), {part_with({1}), part_with({0, 2})});
  ASSERT_EQ(joined.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(joined[i].mean_age, static_cast<double>(i));
  EXPECT_EQ(joined[1].point.label, "label of b");  // the sweep's own point
}

TEST(JoinTest, APointThatIsMissingOrThereTwiceOrOfAnotherNameIsNamed) {
  const auto problem = [](const std::vector<PartResults>& parts) -> std::string {
    try {
      (void)join_points(three_points(), parts);
    } catch (const HarnessError& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_NE(problem({part_with({0, 2})}).find("b"), std::string::npos);
  EXPECT_NE(problem({part_with({0, 1, 2}), part_with({1})}).find("b"), std::string::npos);
  PartResults other = part_with({0, 1, 2});
  other.points[1].result.point.name = "other";
  EXPECT_NE(problem({other}).find("other"), std::string::npos);
  other.points[1].index = 7;
  EXPECT_NE(problem({other}).find("other"), std::string::npos);
}

TEST(JoinTest, ABoundaryIsBetweenTheLongestStableAndTheShortestNotStableOfAll) {
  std::vector<DelayBoundary> boundaries(1);
  boundaries[0].scene = "box";
  boundaries[0].predicted = 0.004;
  PartResults first, second, third;
  first.boundaries = second.boundaries = third.boundaries = boundaries;
  first.boundaries[0].real_stable = 0.003;
  second.boundaries[0].real_stable = 0.002;
  second.boundaries[0].real_not_stable = 0.005;
  third.boundaries[0].real_not_stable = 0.006;
  third.boundaries[0].failure = "one did not run";
  join_boundaries(boundaries, {first, second, third});
  EXPECT_EQ(boundaries[0].real_stable, 0.003);
  EXPECT_EQ(boundaries[0].real_not_stable, 0.005);
  EXPECT_EQ(boundaries[0].predicted, 0.004);
  EXPECT_EQ(boundaries[0].failure, "one did not run");
  third.boundaries[0].scene = "another";
  EXPECT_THROW(join_boundaries(boundaries, {third}), HarnessError);
}

TEST(AddedProgressTest, IsTheSumOfAllWorkersAndNothingElseIsTakenForProgress) {
  AddedProgress added(2);
  const auto say = [&](std::size_t worker, std::string line) {
    line.pop_back();  // lines come without their end
    return added.take(worker, line);
  };
  EXPECT_TRUE(say(0, progress_line(1, 10, "a point: kick")));
  EXPECT_TRUE(say(1, progress_line(2, 20, "")));
  EXPECT_TRUE(say(0, progress_line(3, 11, "another one")));
  EXPECT_EQ(added.done(), 5);
  EXPECT_EQ(added.all(), 31);
  EXPECT_EQ(added.doing(), "another one");
  for (const char* line : {"progress", "progress of 1 kind", "progress 1 x", "", " progress 1 2 x"})
    EXPECT_FALSE(added.take(0, line)) << line;
}

/// Guests that run a shell's script in place of the program; $2 is the part, $4 the file for its
/// results.
class GuestSweepTest : public testing::Test {
 protected:
  void SetUp() override {
    kernel_ = find_guest_kernel();
    if (!kernel_.ready()) GTEST_SKIP() << kernel_.why_not;
    (void)Caretaker::instance();
    sweep_ = three_points();
  }
  std::vector<PartResults> run(const std::string& script) {
    return run_in_guests(
        kernel_, GuestClock::kHost, {"sh", "-c", script, "stand-in"}, sweep_,
        [this](int done, int all, const std::string&) { done_ = done, all_ = all; },
        [this](const std::string& line) {
          said_ += line + "\n";
          if (when_said_) when_said_();
        });
  }
  /// What it throws as it fails.
  std::string failure(const std::string& script) {
    try {
      (void)run(script);
    } catch (const HarnessError& e) {
      return e.what();
    }
    ADD_FAILURE() << "it did not fail";
    return {};
  }
  /// Folders of guests that this process has now.
  static std::vector<fs::path> folders() {
    std::vector<fs::path> found;
    const std::string mine = "tandem-guest-" + std::to_string(getpid()) + "-";
    for (const auto& entry : fs::directory_iterator(fs::temp_directory_path()))
      if (entry.path().filename().string().starts_with(mine)) found.push_back(entry.path());
    return found;
  }
  static pid_t process_of(const fs::path& folder) {
    pid_t pid = 0;
    std::ifstream(folder / "pid") >> pid;
    return pid;
  }

  GuestKernel kernel_;
  Sweep sweep_;
  int done_ = 0, all_ = 0;
  std::string said_;
  std::function<void()> when_said_;
};

TEST_F(GuestSweepTest, EachRunsItsPartOnAProcessorOfItsOwn) {
  const fs::path ready = fs::temp_directory_path() / ("tandem-parts-" + std::to_string(getpid()));
  fs::create_directories(ready);
  const std::size_t count = guests_for(sweep_);
  for (std::size_t i = 0; i < count; ++i) {
    PartResults part = part_with({i});
    part.setting = SweepPart{i, count}.text();
    write_part(ready / std::to_string(i + 1), part);
  }
  std::set<int> processors;
  when_said_ = [&] {
    for (const fs::path& folder : folders()) {
      cpu_set_t one;
      if (sched_getaffinity(process_of(folder), sizeof(one), &one) != 0) continue;
      EXPECT_EQ(CPU_COUNT(&one), 1);
      for (int c = 0; c < CPU_SETSIZE; ++c)
        if (CPU_ISSET(c, &one)) processors.insert(c);
    }
  };
  const std::vector<PartResults> parts =
      run("echo progress 1 2 half; echo to err >&2; sleep 1; echo progress 2 2 all; cp " +
          ready.string() + "/${2%/*} $4; printf unended");
  fs::remove_all(ready);
  ASSERT_EQ(parts.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = SweepPart{i, count}.text();
    EXPECT_EQ(parts[i].setting, name);
    EXPECT_NE(said_.find("guest " + name + ": to err\n"), std::string::npos) << said_;
    EXPECT_NE(said_.find("guest " + name + ": unended\n"), std::string::npos) << said_;
  }
  EXPECT_EQ(said_.find("half"), std::string::npos) << said_;
  EXPECT_EQ(processors.size(), count);
  EXPECT_EQ(done_, 2 * static_cast<int>(count));
  EXPECT_EQ(all_, 2 * static_cast<int>(count));
  EXPECT_TRUE(folders().empty());
}

TEST_F(GuestSweepTest, OneThatFailsEndsAllAndItsPointsAreNamed) {
  const std::string last = std::to_string(guests_for(sweep_));
  const std::string why =
      failure("case $2 in " + last + "/*) echo its words >&2; exit 3;; esac; sleep 100");
  EXPECT_NE(why.find("guest " + last + "/"), std::string::npos) << why;
  EXPECT_NE(why.find("status 3"), std::string::npos) << why;
  EXPECT_NE(why.find(last == "1" ? "its points: a, b, c" : "its points: b"), std::string::npos)
      << why;
  EXPECT_NE(said_.find("its words"), std::string::npos) << said_;
  EXPECT_TRUE(folders().empty());
}

TEST_F(GuestSweepTest, OneThatBreaksDownEndsAll) {
  std::vector<pid_t> guests;
  std::size_t heard = 0;
  when_said_ = [&] {
    if (++heard < guests_for(sweep_)) return;  // all are up
    for (const fs::path& folder : folders()) guests.push_back(process_of(folder));
    kill(guests.front(), SIGKILL);
    when_said_ = {};
  };
  const std::string why = failure("echo here; sleep 100");
  EXPECT_NE(why.find("broke down"), std::string::npos) << why;
  EXPECT_NE(why.find("its points: "), std::string::npos) << why;
  EXPECT_TRUE(folders().empty());
  EXPECT_EQ(guests.size(), guests_for(sweep_));
  for (const pid_t guest : guests) EXPECT_NE(kill(guest, 0), 0) << guest << " still runs";
}

}  // namespace
}  // namespace tandem::harness
