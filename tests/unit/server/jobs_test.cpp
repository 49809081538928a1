#include "server/jobs.h"

#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "tests/unit/server/fake_method.h"

namespace culld::server {
namespace {

class JobsTest : public ::testing::Test {
 protected:
  protocol::Stats cullOnce(const std::shared_ptr<ViewMemory>& memory) {
    CullJob job;
    job.frame = 1;
    job.scene_name = scene.name();
    job.scene = scene.current();
    job.camera = cameraFromLookAt(LookAt{}, {64, 64}, {}).value();
    job.memory = memory;
    const CullOutcome outcome = runCull(std::move(job), steadyClock());
    const auto message = protocol::decode(outcome.message, protocol::kMaxReplyBytes);
    if (!message || !std::holds_alternative<protocol::Answer>(message.value().body)) {
      ADD_FAILURE() << "no answer";
      return {};
    }
    return std::get<protocol::Answer>(message.value().body).stats;
  }

  FakeMethod fake;
  const Method* table[1] = {&fake};
  Scene scene{"row", Methods(table), rowOfObjects(30)};
};

TEST_F(JobsTest, AViewRemembersAcrossAnEditAndIsToldOfIt) {
  const auto memory = std::make_shared<ViewMemory>();
  cullOnce(memory);
  auto stats = cullOnce(memory);
  EXPECT_EQ(stats.nodes_visited, 2U) << "culls that the view knows of";
  EXPECT_EQ(stats.occluders_drawn, 0U) << "edits that it knows of";
  ASSERT_TRUE(editScene(scene, {HideObject{3}}).ok());
  stats = cullOnce(memory);
  EXPECT_EQ(stats.nodes_visited, 3U);
  EXPECT_EQ(stats.occluders_drawn, 1U);
  EXPECT_EQ(cullOnce(std::make_shared<ViewMemory>()).nodes_visited, 1U) << "another view";
}

}  // namespace
}  // namespace culld::server
