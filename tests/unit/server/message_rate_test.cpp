#include "server/message_rate.h"

#include <gtest/gtest.h>

#include "server/address_counts.h"

namespace culld::server {
namespace {

using namespace std::chrono_literals;

TEST(MessageRate, LetsATenthOfASecondThroughAndThenEvensOut) {
  MessageRate rate(1000);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rate.count(5s), 0ns) << i;
  EXPECT_EQ(rate.count(5s), 1ms);
  EXPECT_EQ(rate.count(5s + 1ms), 1ms) << "who waits as told stays at the rate";
  EXPECT_EQ(rate.count(6s), 0ns) << "a pause is forgiven";
}

TEST(MessageRate, HoldsASenderToTheRateInTheLongRun) {
  MessageRate rate(1000);
  std::chrono::nanoseconds now = 0ns;
  int count = 0;
  for (; now < 10s; ++count) now += rate.count(now) + 1us;
  EXPECT_NEAR(count, 10'000 + 100, 2);
}

TEST(MessageRate, ZeroIsAnyRate) {
  MessageRate rate(0);
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(rate.count(1s), 0ns);
}

TEST(AddressCounts, LimitsEachAddressByItself) {
  AddressCounts counts;
  const AddressTicket a = counts.enter("a", 2);
  AddressTicket second = counts.enter("a", 2);
  EXPECT_TRUE(a && second);
  EXPECT_FALSE(counts.enter("a", 2));
  EXPECT_TRUE(counts.enter("b", 2));
  EXPECT_TRUE(counts.enter("a", 0)) << "no limit";
  second.reset();
  EXPECT_TRUE(counts.enter("a", 2)) << "a place was given back";
}

TEST(AddressCounts, ATicketMayOutliveTheTable) {
  AddressTicket ticket;
  {
    AddressCounts counts;
    ticket = counts.enter("a", 1);
  }
  EXPECT_TRUE(ticket);
}

}  // namespace
}  // namespace culld::server
