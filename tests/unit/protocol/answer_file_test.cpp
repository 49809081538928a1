#include "protocol/answer_file.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace culld::protocol {
namespace {

const std::vector<std::uint32_t> kNone;

std::string framesOf(const AnswerWriter& writer) {
  const std::string text = writer.text({"m", Guarantee::kConservative, 3, 36});
  const std::string head =
      "{\"method\":\"m\",\"guarantee\":\"conservative\",\"scene\":{\"objects\":3,\"triangles\":36},"
      "\"frames\":[\n";
  const std::string tail = "\n]}\n";
  EXPECT_EQ(text.substr(0, head.size()), head);
  EXPECT_EQ(text.substr(text.size() - tail.size()), tail);
  return text.substr(head.size(), text.size() - head.size() - tail.size());
}

AnswerFrame frameOf(std::size_t camera, const std::vector<std::uint32_t>& visible) {
  AnswerFrame frame;
  frame.camera = camera;
  frame.visible = visible;
  frame.seconds = 0.25;
  return frame;
}

constexpr const char* kRest =
    R"(,"seconds":0.25,"missed_px":0,"proven":true,"out_of_budget":false,"guarantee":"conservative"})";

TEST(AnswerFile, ListsNodesNotObjects) {
  AnswerWriter writer({{7, 0}, {5, 0}, {9, 0}});
  const std::vector<std::uint32_t> visible{0, 1};
  ASSERT_TRUE(writer.add(frameOf(0, visible)).ok());
  EXPECT_EQ(framesOf(writer), std::string(R"({"camera":0,"visible":[5,7])") + kRest);
}

TEST(AnswerFile, ListsAnInstancedNodeOnceWithItsInstances) {
  AnswerWriter writer({{7, 2}, {5, 0}, {7, 0}, {7, 1}, {3, 1}, {3, 0}});
  const std::vector<std::uint32_t> visible{0, 1, 3, 4};
  ASSERT_TRUE(writer.add(frameOf(2, visible)).ok());
  EXPECT_EQ(
      framesOf(writer),
      std::string(R"({"camera":2,"visible":[3,5,7],"instances":{"3":[1],"7":[1,2]})") + kRest);
}

TEST(AnswerFile, MarksANodeSeenWhenOneOfItsInstancesIsAndCountsObjects) {
  AnswerWriter writer({{7, 0}, {7, 1}, {5, 0}});
  const std::vector<std::uint32_t> visible{0, 1, 2};
  const std::vector<std::uint8_t> seen{0, 1, 0};
  AnswerFrame frame = frameOf(0, visible);
  frame.seen = seen;
  ASSERT_TRUE(writer.add(frame).ok());
  std::string rest = kRest;
  rest.insert(rest.size() - 1, R"(,"seen_count":1,"kept_count":2)");
  EXPECT_EQ(framesOf(writer),
            R"({"camera":0,"visible":[5,7],"seen":[0,1],"instances":{"7":[0,1]})" + rest);
}

TEST(AnswerFile, WritesOneLineAFrameAndEveryFlag) {
  AnswerWriter writer({{1, 0}});
  AnswerFrame first = frameOf(0, kNone);
  first.missed_px = 1.5F;
  first.proven = false;
  first.out_of_budget = true;
  first.guarantee = Guarantee::kSampled;
  first.made_by = "a\"b";
  ASSERT_TRUE(writer.add(first).ok());
  AnswerFrame second = frameOf(1, kNone);
  second.seconds = std::numeric_limits<double>::quiet_NaN();
  second.missed_px = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(writer.add(second).ok());
  EXPECT_EQ(
      framesOf(writer),
      R"({"camera":0,"visible":[],"seconds":0.25,"missed_px":1.5,"proven":false,"out_of_budget":true,"guarantee":"sampled","made_by":"a\"b"},)"
      "\n"
      R"({"camera":1,"visible":[],"seconds":null,"missed_px":null,"proven":true,"out_of_budget":false,"guarantee":"conservative"})");
}

TEST(AnswerFile, EscapesWhatAMethodNameMightHold) {
  const AnswerWriter writer({});
  EXPECT_EQ(writer.text({"a\"\n\xff", Guarantee::kApproximate, 0, 0}),
            "{\"method\":\"a\\\"\\n\xEF\xBF\xBD\",\"guarantee\":\"approximate\","
            "\"scene\":{\"objects\":0,\"triangles\":0},\"frames\":[\n\n]}\n");
}

TEST(AnswerFile, NamesGuaranteesBothWays) {
  for (const char* name : {"conservative", "hole", "sampled", "approximate"}) {
    const auto guarantee = guaranteeNamed(name);
    ASSERT_TRUE(guarantee.ok()) << name;
    EXPECT_EQ(guaranteeName(guarantee.value()), name);
  }
  const auto exact = guaranteeNamed("exact");
  ASSERT_FALSE(exact.ok());
  EXPECT_EQ(exact.error().message,
            "guarantee exact: not one of conservative, hole, sampled, approximate");
}

TEST(AnswerFile, KnowsWhichGuaranteeSatisfiesWhich) {
  using enum Guarantee;
  for (const Guarantee g : {kConservative, kHole, kSampled, kApproximate}) {
    EXPECT_TRUE(satisfies(g, g));
    EXPECT_TRUE(satisfies(kConservative, g));
    EXPECT_TRUE(satisfies(g, kApproximate));
  }
  EXPECT_FALSE(satisfies(kHole, kConservative));
  EXPECT_FALSE(satisfies(kApproximate, kConservative));
  EXPECT_FALSE(satisfies(kSampled, kHole));
  EXPECT_FALSE(satisfies(kHole, kSampled));
}

TEST(AnswerFile, RefusesAnswersThatDoNotFitTheScene) {
  AnswerWriter writer({{1, 0}});
  const std::vector<std::uint32_t> unknown{1};
  const auto no_name = writer.add(frameOf(4, unknown));
  ASSERT_FALSE(no_name.ok());
  EXPECT_EQ(no_name.error().message, "camera 4: answer has unknown object 1");
  const std::vector<std::uint32_t> known{0};
  const std::vector<std::uint8_t> seen{1, 1};
  AnswerFrame frame = frameOf(5, known);
  frame.seen = seen;
  const auto marked = writer.add(frame);
  ASSERT_FALSE(marked.ok());
  EXPECT_EQ(marked.error().message, "camera 5: answer marks 2 of 1 objects");
  EXPECT_EQ(framesOf(writer), "");
}

TEST(AnswerFile, SaysWhyItCannotBeWritten) {
  const auto written = writeTextFile("/dev/full", std::string(100'000, 'x'));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().message, "/dev/full: cannot write: No space left on device");
  const auto folder = writeTextFile("/nonexistent/a.json", "x");
  ASSERT_FALSE(folder.ok());
  EXPECT_EQ(folder.error().message, "/nonexistent/a.json: cannot write: No such file or directory");
}

}  // namespace
}  // namespace culld::protocol
