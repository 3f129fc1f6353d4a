#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string>
#include <zlib.h>

#include <gtest/gtest.h>

#include "devices/column_mapping.h"
#include "devices/csv_table.h"
#include "devices/load_recorded_path.h"
#include "recording/recording_writer.h"
#include "tests/recording/scratch_folder.h"

namespace tandem::devices {
namespace {

using test::ScratchFolder;

std::string message_of(const auto& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

void expect_says(const std::string& message, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
  }
}

std::string written(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
  return file;
}

std::string packed(const std::string& file, const std::string& text) {
  const gzFile to = gzopen(file.c_str(), "wb");
  gzwrite(to, text.data(), static_cast<unsigned>(text.size()));
  gzclose(to);
  return file;
}

TEST(ColumnMapping, UnitsFactorsAndOffsetsMultiplyOut) {
  const auto m = parse_column_mapping(
      "time=stamp:ms,x=angle:rad@0.075*2+0.01,y=#3:mm,z=w*-1+-0.5,origin=first,end=loop,seam=0.1,"
      "interpolation=linear,start=1,stop=2.5,mode=driving");
  EXPECT_EQ(m.time.column, "stamp");
  EXPECT_DOUBLE_EQ(m.time.scale, 1e-3);
  EXPECT_EQ(m.position[0].column, "angle");
  EXPECT_DOUBLE_EQ(m.position[0].scale, 0.15);
  EXPECT_DOUBLE_EQ(m.position[0].offset, 0.01);
  EXPECT_EQ(m.position[1].column, "#3");
  EXPECT_DOUBLE_EQ(m.position[1].scale, 1e-3);
  EXPECT_DOUBLE_EQ(m.position[2].scale, -1.0);
  EXPECT_DOUBLE_EQ(m.position[2].offset, -0.5);
  EXPECT_TRUE(m.from_first);
  EXPECT_EQ(m.end, PathEnd::kLoop);
  EXPECT_DOUBLE_EQ(m.seam, 0.1);
  EXPECT_EQ(m.interpolation, Interpolation::kLinear);
  EXPECT_EQ(m.mode, RecordedMode::kDriving);
  EXPECT_DOUBLE_EQ(parse_column_mapping("rate_hz=1,x=a*1e+3").position[0].scale, 1000.0);
  EXPECT_DOUBLE_EQ(parse_column_mapping("rate_hz=1,x=a:deg@2").position[0].scale,
                   2.0 * std::numbers::pi / 180.0);
}

TEST(ColumnMapping, SaysWhichKeyAndValueItDoesNotUnderstandAndWhatIsAllowed) {
  const auto refused = [](const char* text) {
    return message_of([&] { static_cast<void>(parse_column_mapping(text)); });
  };
  expect_says(refused("x=a:rad"), {"x=a:rad", "rad@ARM"});
  expect_says(refused("x=a:inch"), {"x=a:inch", "m, mm, cm"});
  expect_says(refused("time=t:h"), {"time=t:h", "s, ms, us or ns"});
  expect_says(refused("x=a*two"), {"x=a*two", "\"two\""});
  expect_says(refused("w=a"), {"w=a", "time, rate_hz, x, y, z"});
  expect_says(refused("x"), {"KEY=VALUE"});
  expect_says(refused("x="), {"KEY=VALUE"});
  expect_says(refused("rate_hz=0"), {"above 0"});
  expect_says(refused("rate_hz=nan"), {"rate_hz=nan"});
  expect_says(refused("end=stop"), {"hold or loop"});
  expect_says(refused("start=3,stop=2"), {"start"});
}

TEST(CsvTable, ReadsNamedAndNumberedColumnsPlainAndPackedAlike) {
  const ScratchFolder folder;
  const std::string text = "# made by hand\r\n\"t\", a ,b\r\n0,1,2\r\n\r\n0.5,+3,-4e-1\r\n";
  for (const auto& file : {written(folder / "a.csv", text), packed(folder / "a.csv.gz", text)}) {
    const auto columns = read_csv_columns(file, {"b", "#1", "a"});
    ASSERT_EQ(columns.size(), 3u);
    EXPECT_EQ(columns[0], (std::vector<double>{2, -0.4}));
    EXPECT_EQ(columns[1], (std::vector<double>{0, 0.5}));
    EXPECT_EQ(columns[2], (std::vector<double>{1, 3}));
  }
  const auto headless = read_csv_columns(written(folder / "b.csv", "1;2\n3;4"), {"#2"});
  EXPECT_EQ(headless[0], (std::vector<double>{2, 4}));
}

TEST(CsvTable, ErrorsNameFileLineColumnAndText) {
  const ScratchFolder folder;
  const auto refused = [](const std::string& file, const std::string& column) {
    return message_of([&] { static_cast<void>(read_csv_columns(file, {column})); });
  };
  const std::string file = written(folder / "a.csv", "t,x\n0,1\n1,oops\n2\n");
  expect_says(refused(file, "x"), {"a.csv", "line 3", "\"x\"", "\"oops\" is no number"});
  expect_says(refused(file, "y"), {"no column \"y\"", "\"t\" \"x\"", "#1 to #2"});
  expect_says(refused(file, "#3"), {"no column \"#3\""});
  expect_says(refused(written(folder / "c.csv", "t,x\n0,1\n2\n"), "x"),
              {"line 3", "the line ends before it"});
  expect_says(refused(folder / "missing.csv", "x"), {"missing.csv", "No such file"});
  expect_says(refused(written(folder / "empty.csv", ""), "x"), {"is empty"});
  const std::string whole = packed(folder / "w.csv.gz", "t,x\n" + std::string(5000, '1') + "\n");
  std::ifstream from(whole, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(from)), {});
  std::ofstream(folder / "torn.csv.gz", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  expect_says(refused(folder / "torn.csv.gz", "x"), {"torn.csv.gz", "cannot be unpacked"});
}

TEST(LoadRecordedPath, AppliesTheMapping) {
  const ScratchFolder folder;
  const std::string file =
      written(folder / "a.csv", "t_ms,angle\n1000,0.1\n1500,0.2\n2000,0.4\n2500,0.4\n");
  const auto source = parse_recorded_source(
      file + "?time=t_ms:ms,y=angle:rad@0.5,interpolation=linear,origin=first,start=0.5");
  EXPECT_EQ(source.file, file);
  const RecordedPath path = load_recorded_path(source.file, source.mapping);
  EXPECT_DOUBLE_EQ(path.length(), 1.0);
  EXPECT_DOUBLE_EQ(path.at(0.0).position.y, 0.0);
  EXPECT_DOUBLE_EQ(path.at(0.5).position.y, 0.1);
  EXPECT_DOUBLE_EQ(path.at(0.25).position.y, 0.05);
  EXPECT_DOUBLE_EQ(path.at(0.25).position.x, 0.0);
}

TEST(LoadRecordedPath, RowsWithoutTimeStampsComeAtTheRateSaid) {
  const ScratchFolder folder;
  const std::string file = written(folder / "a.csv", "px\n0\n1\n2\n3\n");
  const RecordedPath path = load_recorded_path(file, parse_column_mapping("rate_hz=2,x=px"));
  EXPECT_DOUBLE_EQ(path.length(), 1.5);
  EXPECT_DOUBLE_EQ(path.at(0.75).position.x, 1.5);
}

TEST(LoadRecordedPath, SaysWhatTheMappingLacks) {
  const ScratchFolder folder;
  const std::string file = written(folder / "a.csv", "t,x\n0,0\n1,1\n1,2\n");
  const auto refused = [&](const char* mapping) {
    return message_of(
        [&] { static_cast<void>(load_recorded_path(file, parse_column_mapping(mapping))); });
  };
  expect_says(refused("x=x"), {"neither time=COLUMN nor rate_hz=RATE"});
  expect_says(refused("x=x,time=t,rate_hz=3"),
              {"both time=COLUMN and rate_hz=RATE", "give one of them"});
  expect_says(refused("time=t"), {"x=COLUMN"});
  expect_says(refused("time=t,x=x"), {"a.csv", "time must increase", "sample 3"});
  expect_says(refused("time=t,x=x,start=5"), {"0 samples"});
}

TEST(LoadRecordedPath, ATandemRecordingIsPlayedAtItsSlotsWithGapsKept) {
  const ScratchFolder folder;
  const std::string file = folder / "session.h5";
  recording::RecordingHeader header;
  header.local_rate_hz = 1000.0;
  const recording::RecordColumns columns{.fingers = 2,
                                         .hand_values = 2,
                                         .users = 0,
                                         .objects = 0,
                                         .object_values = 0,
                                         .contacts = false,
                                         .packet_values = 0};
  {
    recording::RecordingWriter writer(file, header, columns);
    for (const std::int64_t slot : {100, 101, 102, 105, 106}) {  // 103 and 104 were missed
      core::TickRecord tick;
      tick.slot = slot;
      tick.hands[1].position = {0.001 * static_cast<double>(slot), 0.5, 0.0};
      ASSERT_TRUE(writer.record(tick));
    }
  }
  const RecordedPath path = load_recorded_path(file, parse_column_mapping("finger=1"));
  ASSERT_EQ(path.samples().size(), 5u);
  EXPECT_DOUBLE_EQ(path.length(), 0.006);
  EXPECT_NEAR(path.at(0.0035).position.x, 0.1035, 1e-12);  // 1 m/s throughout
  EXPECT_DOUBLE_EQ(path.at(0.0035).position.y, 0.5);
  expect_says(message_of([&] {
                static_cast<void>(load_recorded_path(file, parse_column_mapping("finger=2")));
              }),
              {"finger is 2", "has 2"});
}

}  // namespace
}  // namespace tandem::devices
