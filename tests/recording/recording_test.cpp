#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "recording/export_csv.h"
#include "recording/hdf5_id.h"
#include "recording/recording_reader.h"
#include "recording/recording_writer.h"
#include "tests/recording/recorded_examples.h"
#include "tests/recording/scratch_folder.h"

namespace tandem::recording {
namespace {

using core::PacketRecord;
using core::TickRecord;
using test::example;
using test::is_example;
using test::ScratchFolder;

/// Records `count` ticks and half as many packets, no faster than they are written.
void record_examples(const std::string& file, const RecordColumns& columns, std::uint64_t count,
                     const RecordingHeader& header = test::some_header()) {
  RecordingWriter writer(file, header, columns);
  for (std::uint64_t i = 0; i < count; ++i) {
    while (!writer.record(example<TickRecord>(i, columns))) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (i % 2 == 0) {
      while (!writer.record(example<PacketRecord>(i, columns))) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
  }
  writer.close();
  EXPECT_EQ(writer.status().failure, "");
  EXPECT_EQ(writer.status().ticks_safe, count);
}

void expect_examples(RecordingReader& reader, std::uint64_t count) {
  ASSERT_EQ(reader.tick_count(), count);
  ASSERT_EQ(reader.packet_count(), (count + 1) / 2);
  const auto ticks = reader.ticks(0, count);
  const auto packets = reader.packets(0, count);
  ASSERT_EQ(ticks.size(), count);
  for (std::uint64_t i = 0; i < count; ++i) {
    ASSERT_TRUE(is_example(ticks[i], i, reader.columns())) << i;
  }
  for (std::uint64_t i = 0; i < packets.size(); ++i) {
    ASSERT_TRUE(is_example(packets[i], 2 * i, reader.columns())) << i;
  }
}

TEST(Recording, GivesBackTheSameBitsInEverySpace) {
  const ScratchFolder folder;
  const RecordColumns axis{.fingers = 1,
                           .hand_values = 1,
                           .users = 2,
                           .objects = 1,
                           .object_values = 2,
                           .contacts = false,
                           .packet_values = 4};
  const RecordColumns widest{.fingers = core::kMaxFingers,
                             .hand_values = 3,
                             .users = core::kMaxUsers,
                             .objects = core::kMaxObjects,
                             .object_values = core::kMaxObjectValues,
                             .contacts = true,
                             .packet_values = core::kMaxPacketValues};
  const RecordColumns server{.fingers = 0,
                             .hand_values = 0,
                             .users = 2,
                             .objects = 1,
                             .object_values = 6,
                             .contacts = true,
                             .packet_values = 8};
  for (const RecordColumns& columns : {axis, test::planar_columns(), widest, server}) {
    const std::string file = folder / "session.h5";
    record_examples(file, columns, 3000);
    RecordingReader reader(file);
    EXPECT_TRUE(reader.complete());
    expect_examples(reader, 3000);
  }
}

TEST(Recording, KeepsTheHeaderEvenWithAVeryLongScene) {
  const ScratchFolder folder;
  RecordingHeader header = test::some_header();
  while (header.scene_text.size() < 300'000) header.scene_text += header.scene_text;
  record_examples(folder / "long.h5", test::planar_columns(), 1, header);
  const RecordingReader reader(folder / "long.h5");
  EXPECT_EQ(reader.header().scene_text, header.scene_text);
  EXPECT_EQ(reader.header().scene_hash, "0123456789abcdef");
  EXPECT_EQ(reader.header().git_revision, "abc");
  EXPECT_EQ(reader.header().program_version, "0.1.0");
  EXPECT_EQ(reader.header().user, "1");
  EXPECT_EQ(reader.header().local_rate_hz, 1024.0);
  EXPECT_EQ(reader.header().start_ns, 123'456'789'012'345);
  EXPECT_GT(reader.header().start_wall_ns, 1'600'000'000'000'000'000);  // after 2020
  EXPECT_GT(reader.header().start_monotonic_ns, 0);
}

TEST(Recording, ASessionWithoutATickIsAValidFile) {
  const ScratchFolder folder;
  record_examples(folder / "empty.h5", test::planar_columns(), 0);
  RecordingReader reader(folder / "empty.h5");
  EXPECT_TRUE(reader.complete());
  EXPECT_EQ(reader.tick_count(), 0u);
  EXPECT_TRUE(reader.ticks(0, 100).empty());
}

TEST(Recording, ReadsAnyStretchAndNoFurtherThanTheEnd) {
  const ScratchFolder folder;
  const auto columns = test::planar_columns();
  record_examples(folder / "a.h5", columns, 700);
  RecordingReader reader(folder / "a.h5");
  const auto stretch = reader.ticks(690, 100);
  ASSERT_EQ(stretch.size(), 10u);
  for (std::uint64_t i = 0; i < 10; ++i) EXPECT_TRUE(is_example(stretch[i], 690 + i, columns));
  EXPECT_TRUE(reader.ticks(700, 1).empty());
  EXPECT_TRUE(reader.ticks(1'000'000, 5).empty());
}

TEST(Recording, StoresOnlyTheColumnsInUse) {
  const ScratchFolder folder;
  RecordColumns none{};
  none.hand_values = 0;
  TickRecord tick;
  tick.slot = 5;
  tick.hands[0].position = {1.0, 2.0, 3.0};
  {
    RecordingWriter writer(folder / "none.h5", test::some_header(), none);
    ASSERT_TRUE(writer.record(tick));
  }
  RecordingReader reader(folder / "none.h5");
  ASSERT_EQ(reader.tick_count(), 1u);
  EXPECT_EQ(reader.ticks(0, 1)[0].slot, 5);
  EXPECT_EQ(reader.ticks(0, 1)[0].hands[0].position, core::Vec3(0.0));
}

TEST(Recording, WhatDoesNotFitIntoTheRingIsCountedAndTheRestIsThere) {
  const ScratchFolder folder;
  const auto columns = test::planar_columns();
  constexpr std::uint64_t kBurst = 20'000;  // far more than the ring holds
  std::uint64_t taken = 0;
  RecordingWriter writer(folder / "burst.h5", test::some_header(), columns);
  const auto tick = example<TickRecord>(1, columns);
  for (std::uint64_t i = 0; i < kBurst; ++i) taken += writer.record(tick) ? 1 : 0;
  writer.close();
  EXPECT_LT(taken, kBurst);
  EXPECT_EQ(writer.status().lost, kBurst - taken);
  const RecordingReader reader(folder / "burst.h5");
  EXPECT_EQ(reader.tick_count(), taken);
  EXPECT_EQ(reader.records_lost(), static_cast<std::int64_t>(kBurst - taken));
}

TEST(Recording, AFileThatCannotBeMadeIsRefusedBeforeTheSessionWithItsName) {
  try {
    const RecordingWriter writer("/no/such/folder/a.h5", test::some_header(), {});
    FAIL() << "must throw";
  } catch (const RecordingError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("/no/such/folder/a.h5"), std::string::npos) << what;
    EXPECT_NE(what.find("No such file or directory"), std::string::npos) << what;
  }
}

TEST(Recording, ImpossibleColumnsAreRefusedWithTheirRange) {
  RecordColumns columns;
  columns.fingers = 5;
  try {
    check(columns);
    FAIL() << "must throw";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "recording: fingers is 5, must be within [0, 4]");
  }
}

TEST(RecordingReader, MissingForeignAndTornFilesAreRefusedWithTheReason) {
  const ScratchFolder folder;
  EXPECT_THROW(RecordingReader(folder / "missing.h5"), RecordingError);
  std::ofstream(folder / "text.h5") << "no HDF5";
  EXPECT_THROW(RecordingReader(folder / "text.h5"), RecordingError);
  record_examples(folder / "torn.h5", test::planar_columns(), 1000);
  std::filesystem::resize_file(folder / "torn.h5", 3000);
  EXPECT_THROW(RecordingReader(folder / "torn.h5"), RecordingError);
}

TEST(ExportCsv, WritesAHeadingAndNumbersThatReadBackToTheSameBits) {
  const ScratchFolder folder;
  RecordColumns columns{};
  columns.fingers = 1;
  columns.hand_values = 1;
  TickRecord tick;
  tick.slot = 7;
  tick.due_ns = 8;
  tick.woke_ns = 9;
  tick.faults = 3;
  tick.hands[0].position.x = 0.1 + 0.2;
  tick.hands[0].velocity.x = -1e-300;
  tick.command[0].x = 2.5;
  {
    RecordingWriter writer(folder / "a.h5", test::some_header(), columns);
    writer.record(tick);
  }
  RecordingReader reader(folder / "a.h5");
  std::ostringstream csv;
  export_ticks_csv(reader, csv);
  EXPECT_EQ(csv.str(),
            "slot,due_ns,woke_ns,faults,fresh,hand_position[0],hand_velocity[0],command_force[0]\n"
            "7,8,9,3,0,0.30000000000000004,-1e-300,2.5\n");
  std::ostringstream packets;
  export_packets_csv(reader, packets);
  EXPECT_EQ(packets.str().substr(0, 17), "slot,peer,sender,");
}

}  // namespace
}  // namespace tandem::recording
