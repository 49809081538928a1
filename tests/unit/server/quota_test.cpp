#include "server/quota.h"

#include <gtest/gtest.h>

namespace culld::server {
namespace {

using namespace std::chrono_literals;

TEST(TokenBucket, IsNeverShutWithoutARate) {
  TokenBucket bucket;
  bucket.charge(1e18, 0ns);
  EXPECT_EQ(bucket.wait(0ns), 0ns);
}

TEST(TokenBucket, ShutsWhenASecondsWorthIsGoneAndOpensAgain) {
  TokenBucket bucket(1000);
  bucket.charge(999, 5s);
  EXPECT_EQ(bucket.wait(5s), 0ns);
  bucket.charge(1, 5s);
  EXPECT_GT(bucket.wait(5s), 0ns);
  EXPECT_EQ(bucket.wait(5s + 1ms), 0ns);
}

TEST(TokenBucket, MakesADebtorWaitForAllOfIt) {
  TokenBucket bucket(1000);
  bucket.charge(3000, 0s);
  EXPECT_NEAR(static_cast<double>(bucket.wait(0s).count()), 2e9, 10);
  EXPECT_GT(bucket.wait(1999ms), 0ns);
  EXPECT_EQ(bucket.wait(2001ms), 0ns);
}

TEST(TokenBucket, HoldsNoMoreThanASecondBrings) {
  TokenBucket bucket(1000);
  bucket.charge(1, 0s);
  bucket.charge(1000, 1h);
  EXPECT_GT(bucket.wait(1h), 0ns);
}

TEST(TokenBucket, AllowsItsRateInTheLongRun) {
  TokenBucket bucket(1000);
  double used = 0;
  for (Time now = 0s; now < 100s; now += 1ms) {
    if (bucket.wait(now) > 0ns) continue;
    bucket.charge(7, now);
    used += 7;
  }
  EXPECT_NEAR(used, 101'000, 20);
}

TEST(TokenBucket, DoesNotGoBackInTime) {
  TokenBucket bucket(1000);
  bucket.charge(1000, 10s);
  bucket.charge(0, 5s);
  EXPECT_GT(bucket.wait(10s), 0ns) << "the five seconds before were not given twice";
}

TEST(Tenant, RefusesCamerasForTimeAndForBytes) {
  Tenant tenant("acme", {100, 1000, 0});
  EXPECT_FALSE(tenant.refuseCull(0s));
  tenant.culled(350ms, 0s);
  auto refusal = tenant.refuseCull(0s);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, QuotaReason::kCull);
  EXPECT_EQ(refusal->message, "tenant acme: 100 ms of culling per second are used up");
  EXPECT_EQ(refusal->retry_after, 3s) << "rounded up from 2.5 s";
  EXPECT_FALSE(tenant.refuseBytes(0s)) << "a GET costs no culling";
  EXPECT_FALSE(tenant.refuseCull(2501ms));
  tenant.sent(1000, 2501ms);
  refusal = tenant.refuseCull(2501ms);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, QuotaReason::kBytes);
  EXPECT_EQ(refusal->retry_after, 1s);
  EXPECT_TRUE(tenant.refuseBytes(2501ms));
}

TEST(Tenant, RefusesScenesPastItsShare) {
  EXPECT_FALSE(Tenant("acme", {0, 0, 2}).refuseScene(1));
  EXPECT_FALSE(Tenant("acme").refuseScene(1'000'000));
  const auto refusal = Tenant("acme", {0, 0, 2}).refuseScene(2);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, QuotaReason::kScenes);
}

TEST(Tenant, KeepsItsDebtsWhenItsQuotasChange) {
  Tenant tenant("acme", {100, 0, 0});
  tenant.culled(10s, 0s);
  tenant.setQuotas({200, 0, 0});
  EXPECT_TRUE(tenant.refuseCull(1s));
  tenant.setQuotas({});
  EXPECT_FALSE(tenant.refuseCull(1s));
}

}  // namespace
}  // namespace culld::server
