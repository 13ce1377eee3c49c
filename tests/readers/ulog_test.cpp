#include "sightline/readers/ulog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <cmath>
#include <fstream>
#include <numeric>

#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/shared_data.hpp"
#include "tests/support/ulog.hpp"

namespace sightline::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string ulog_refusal(const std::string& bytes) {
  return refusal_of([&] { ULog(bytes, "x.ulg"); });
}

TEST(ULog, TopicsAreColumnsByTheNamesOfTheirFields) {
  const ULog log(small_ulog(), "x.ulg");
  EXPECT_FALSE(log.truncated());
  ASSERT_EQ(log.topics().size(), 3U);
  const ULog::Topic& status = log.topic("status");
  EXPECT_THAT(log.times(status), ElementsAre(1'000'000, 1'020'000, 1'040'000));
  EXPECT_THAT(log.column(status, "esc[0].rpm"), ElementsAre(1000, 1001, 1002));
  EXPECT_THAT(log.column(status, "esc[0].u[1]"), ElementsAre(1, 1.25, 1.5));
  EXPECT_THAT(log.column(status, "esc[1].u[0]"), ElementsAre(2, 2.25, 2.5));
  EXPECT_THAT(log.column<std::int64_t>(status, "level"), ElementsAre(0, 1, 2));
  EXPECT_THAT(log.column(log.topic("battery"), "v"), ElementsAre(0, 0.1, 0.2));
  EXPECT_THAT(log.column(log.topic("battery", 1), "v"), ElementsAre(12));
  EXPECT_THAT(log.column<std::uint64_t>(log.topic("battery", 1), "on"), ElementsAre(0));
  EXPECT_THAT(log.info().at("ver_hw"), ElementsAre("SIM"));
  EXPECT_THAT(log.info().at("boot"), ElementsAre("abcd"));
  EXPECT_EQ(log.parameters().at("V_MAX"), 3.5);
  EXPECT_THAT(log.dropouts(), ElementsAre(40));
}

TEST(ULog, ATopicOrFieldThatIsNotThereIsNamedWithTheNearest) {
  const ULog log(small_ulog(), "x.ulg");
  const ULog::Topic& status = log.topic("status");
  EXPECT_EQ(refusal_of([&] { (void)log.topic("statsu"); }),
            "x.ulg: no topic statsu, expected a logged one, the nearest is \"status\"");
  EXPECT_EQ(refusal_of([&] { (void)log.topic("battery", 2); }),
            "x.ulg: no topic battery[2], expected a logged one, the nearest is \"battery\"");
  for (const char* field :
       {"esc", "esc[2].rpm", "esc[0]", "esc[0].u", "esc[0].u[2]", "level[0]", "levle", "_padding0[0]", ""}) {
    EXPECT_THAT(refusal_of([&] { (void)log.column(status, field); }),
                HasSubstr(fmt::format("x.ulg: status has no number {}, expected a field of it", field)));
  }
  EXPECT_EQ(refusal_of([&] { (void)log.column<std::int64_t>(log.topic("battery"), "v"); }),
            "x.ulg: v of battery is of the type double, expected a whole number");
  EXPECT_EQ(refusal_of([&] { (void)log.column<std::uint64_t>(status, "level"); }),
            "x.ulg: level of status is of the type int8_t, expected an unsigned whole number");
}

// A power cut leaves any beginning of a log.
TEST(ULog, ALogThatIsCutAnywhereIsReadUpToTheCut) {
  const std::string whole = small_ulog();
  std::size_t messages = 0;
  for (std::size_t size = 1; size <= whole.size(); ++size) {
    const ULog log(whole.substr(0, size), "x.ulg");
    std::size_t now = 0;
    for (const ULog::Topic& topic : log.topics()) now += topic.at.size();
    EXPECT_GE(now, messages);
    messages = now;
  }
  EXPECT_EQ(messages, 7U);
  EXPECT_TRUE(ULog(whole.substr(0, whole.size() - 1), "x.ulg").truncated());
}

TEST(ULog, DataThatWasAppendedIsReadAfterTheCut) {
  const std::string flags = ulog_flags();
  std::string crashed = small_ulog() + ulog_data(9, std::uint64_t{3}, 1.0, true);
  crashed.resize(crashed.size() - 5);
  const std::string whole = crashed + ulog_data(9, std::uint64_t{2'000'500}, 5.0, true);
  std::string log = whole;
  log.replace(ulog_head().size(), flags.size(), ulog_flags(crashed.size()));
  const ULog read(log, "x.ulg");
  EXPECT_TRUE(read.truncated());
  EXPECT_THAT(read.column(read.topic("battery", 1), "v"), ElementsAre(12, 5));

  // Cut once more, before the part that was appended.
  EXPECT_TRUE(ULog(log.substr(0, crashed.size() - 1), "x.ulg").truncated());
  std::string within = whole;
  within.replace(ulog_head().size(), flags.size(), ulog_flags(20));
  EXPECT_THAT(ulog_refusal(within),
              HasSubstr("x.ulg: byte 16: data appended at byte 20, expected at byte 59"));
}

TEST(ULog, EachFaultIsRefusedWithItsByte) {
  const std::string head = ulog_head(), time = "t:uint64_t timestamp;";
  const auto after = [&](const std::string& messages) { return ulog_refusal(head + messages); };
  const auto says = [](int byte, const char* what) {
    return testing::AllOf(testing::StartsWith(fmt::format("x.ulg: byte {}: ", byte)), HasSubstr(what));
  };
  EXPECT_THAT(ulog_refusal("MLog"), says(0, "does not begin"));
  EXPECT_THAT(ulog_refusal(""), says(0, "does not begin"));
  EXPECT_THAT(after(ulog_message('\1', "")), says(16, "0x01"));
  EXPECT_EQ(after(ulog_message('z', "later")), "");
  EXPECT_THAT(after(ulog_message('D', "a")), says(16, "D of 1 bytes"));
  EXPECT_THAT(after(ulog_data(4, 1.0)), says(16, "number 4"));
  EXPECT_THAT(after(ulog_topic(4, "t")), says(16, "type t"));
  EXPECT_THAT(after(ulog_message('F', "t:float a;") + ulog_topic(4, "t")), says(29, "timestamp"));
  EXPECT_THAT(after(ulog_message('F', time) + ulog_message('F', time)), says(40, "t is defined twice"));
  EXPECT_THAT(after(ulog_message('F', "t:float;")), says(16, "format t that has no type"));
  EXPECT_THAT(after(ulog_message('F', "t:float[0] a;")), says(16, "format t that has no type"));
  EXPECT_EQ(after(ulog_message('M', std::string("\x01\x1a") + "char[0] perf_top_preflight")), "");
  EXPECT_EQ(after(ulog_message('M', std::string("\x01\x23") + "char[3] perf_counter_preflight-00abc")), "");
  EXPECT_EQ(after(ulog_message('I', std::string("\x06") + "char a")), "");
  EXPECT_THAT(after(ulog_message('I', std::string("\x05") + "char ")), says(16, "a key"));
  EXPECT_THAT(after(ulog_message('F', "t:")), says(16, "t has no fields"));
  EXPECT_THAT(after(ulog_message('F', time + "t a;") + ulog_topic(4, "t")), says(44, "16 formats"));
  EXPECT_THAT(after(ulog_message('F', time + "double[9000] a;") + ulog_topic(4, "t")),
              says(55, "65535 bytes"));
  EXPECT_THAT(after(ulog_message('F', time) + ulog_topic(4, "t") + ulog_data(4, 1.0F)),
              says(47, "4 bytes of t, expected 8"));
  EXPECT_THAT(after(ulog_message('F', time) + ulog_message('F', "u:uint64_t timestamp;") +
                    ulog_topic(4, "t") + ulog_topic(4, "u")),
              says(71, "number 4"));
  EXPECT_THAT(after(ulog_message('P', ulog_key("float A", "xyz"))), says(16, "parameter A"));
  EXPECT_THAT(after(ulog_message('I', "\xff too short")), says(16, "255 bytes where 10"));
  EXPECT_THAT(after(ulog_message('S', "12345678")), says(16, "synchronisation"));
  EXPECT_THAT(after(ulog_message('F', time) + ulog_flags()), says(40, "flag bits"));
  std::string newer = ulog_flags();
  newer[3 + 8] = 2;
  EXPECT_THAT(after(newer), says(16, "newer format"));
}

// Each format is measured once: 2^16 copies of the innermost, but 16 steps of work.
TEST(ULog, FormatsThatDoubleAtEachLevelAreMeasuredOnce) {
  std::string log = ulog_head() + ulog_message('F', "f0:uint8_t a;");
  for (int i = 1; i < 15; ++i) log += ulog_message('F', fmt::format("f{0}:f{1} a;f{1} b;", i, i - 1));
  log += ulog_message('F', "t:uint64_t timestamp;f14 a;") + ulog_topic(1, "t");
  EXPECT_EQ(ULog(log, "x.ulg").topics().size(), 1U);
}

TEST(ULog, DefinitionsAreBounded) {
  std::string fields;
  while (fields.size() < 60'000) fields += "bool a;";
  std::string log = ulog_head();
  for (int i = 0; i < 123; ++i) log += ulog_message('F', fmt::format("f{}:{}", i, fields));
  EXPECT_THAT(ulog_refusal(log), HasSubstr("more than 1048576 fields, keys and topics"));
}

TEST(ULog, PackedLogsAreReadAndDamagedOnesRefused) {
  const std::filesystem::path folder = fresh_folder();
  const std::string log = small_ulog();
  const auto file = [&](const char* name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  };
  std::string packed(ZSTD_compressBound(log.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), log.data(), log.size(), 3));
  EXPECT_EQ(read_ulog(file("a.ulg", log)).topics().size(), 3U);
  EXPECT_EQ(read_ulog(file("a.ulg.zst", packed)).topics().size(), 3U);
  EXPECT_EQ(read_ulog(file("b.ulg.zst", packed + packed)).topics().size(), 3U) << "frames follow one another";
  const gzFile to = gzopen((folder / "a.ulg.gz").c_str(), "wb");
  gzwrite(to, log.data(), static_cast<unsigned>(log.size()));
  gzclose(to);
  EXPECT_EQ(read_ulog(folder / "a.ulg.gz").topics().size(), 3U);
  const auto cut = file("c.ulg.zst", packed.substr(0, packed.size() - 9));
  EXPECT_EQ(refusal_of([&] { read_ulog(cut); }),
            cut.native() + ": damaged, expected a file that is plain or packed by gzip or zstd");
  EXPECT_THAT(refusal_of([&] { read_ulog(folder / "none.ulg"); }), HasSubstr("none.ulg: not there"));
}

TEST(ULog, MutatedLogsAreReadOrRefusedInOneSentence) {
  const int accepted = read_mutated_ulogs(2'000, 1);
  EXPECT_GT(accepted, 200);
  EXPECT_LT(accepted, 1'900);
}

// The numbers are those of a parser of the format in Python.
TEST(ULog, ALogOfPx4HasTheNumbersOfAnotherReader) {
  const std::filesystem::path file = of_data("px4/identify_short.ulg.zst");
  if (file.empty()) return;
  const ULog log = read_ulog(file);
  EXPECT_FALSE(log.truncated());
  EXPECT_EQ(log.topics().size(), 94U);
  EXPECT_EQ(log.parameters().size(), 885U);
  EXPECT_EQ(log.parameters().at("MPC_XY_VEL_MAX"), 12.0);
  EXPECT_THAT(log.info().at("ver_hw"), ElementsAre("PX4_SITL"));
  struct Expected {
    const char *topic, *field;
    std::size_t messages;
    double sum, last;
    std::uint64_t times;
  };
  const std::vector<Expected> all = {
      {"vehicle_local_position", "x", 1723, 992.310201972723, 0.6611800789833069, 252054224000},
      {"vehicle_local_position_groundtruth", "z", 690, -25.962127685546875, 0.003326416015625, 100929084000},
      {"vehicle_attitude", "q[2]", 3444, 2.2635310101778714, -0.0021758549846708775, 503822760000},
      {"vehicle_attitude_groundtruth", "q[2]", 1379, 8.360562475167171, 0.00491692591458559, 201727028000},
      {"trajectory_setpoint", "velocity[2]", 70, 20.55986876785755, 0.6994885802268982, 10226191890},
      {"actuator_outputs", "output[2]", 139, 171450.0, 900.0, 20322460000},
      {"battery_status", "voltage_v", 70, 1120.3571481704712, 16.200000762939453, 10227212000},
      {"sensor_combined", "accelerometer_m_s2[2]", 3444, -33679.96454143524, -10.0914888381958,
       503795208000}};
  for (const Expected& one : all) {
    const ULog::Topic& topic = log.topic(one.topic);
    const std::vector<double> values = log.column(topic, one.field);
    const std::vector<std::uint64_t> times = log.times(topic);
    ASSERT_EQ(values.size(), one.messages) << one.topic;
    EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0), one.sum, 1e-9 * std::abs(one.sum));
    EXPECT_EQ(values.back(), one.last) << one.topic;
    EXPECT_EQ(std::accumulate(times.begin(), times.end(), std::uint64_t{0}), one.times) << one.topic;
  }
  EXPECT_EQ(log.topic("telemetry_status", 3).at.size(), 13U);
}

}  // namespace
}  // namespace sightline::test
