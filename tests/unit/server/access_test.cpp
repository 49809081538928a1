#include "server/access.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/unit/server/access_fixture.h"

namespace culld::server {
namespace {

using testing::tokenEntry;
using testing::usualTokens;
using namespace std::chrono_literals;

constexpr Peer kTcp{};

class AccessTest : public ::testing::Test {
 protected:
  std::unique_ptr<Access> open() {
    auto opened = Access::open(options, {30s, 3});
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(opened).value();
  }
  std::unique_ptr<Access> openWithTokens(const std::string& text = usualTokens()) {
    options.tokens_file = files.write("tokens.toml", text);
    return open();
  }
  std::string failure() {
    const auto opened = Access::open(options);
    return opened.ok() ? "fine" : opened.error().message;
  }

  TlsOptions tls() const { return encrypted ? TlsOptions{"c", "k"} : TlsOptions{}; }

  testing::Files files;
  AccessOptions options;
  bool encrypted = false;
};

TEST_F(AccessTest, GivesEverythingToAllWithoutTokens) {
  const auto access = open();
  EXPECT_FALSE(access->needsTokens());
  const auto grant = access->standing(kTcp);
  ASSERT_TRUE(grant);
  EXPECT_EQ(grant->scope, Scope::kAdmin);
  EXPECT_EQ(grant->tenant->name(), "");
}

TEST_F(AccessTest, KnowsWhoHoldsWhichToken) {
  const auto access = openWithTokens();
  EXPECT_TRUE(access->needsTokens());
  EXPECT_FALSE(access->standing(kTcp));
  const auto reader = access->ofToken("reader");
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->tenant->name(), "acme");
  EXPECT_EQ(reader->scope, Scope::kRead);
  EXPECT_EQ(access->ofToken("editor")->tenant, reader->tenant) << "they pay together";
  EXPECT_EQ(access->ofToken("chief")->tenant->name(), "");
  for (const char* wrong : {"", "Reader", "reader ", "readerx", "reade"}) {
    EXPECT_FALSE(access->ofToken(wrong)) << wrong;
  }
}

TEST_F(AccessTest, KnowsUsersOfTheUnixSocket) {
  const std::uint32_t stranger = ::geteuid() + 12345;
  auto access = open();
  EXPECT_TRUE(access->mayConnect({true, stranger})) << "the file's mode decides";
  options.unix_users = {"root", std::to_string(stranger + 1)};
  access = open();
  EXPECT_TRUE(access->mayConnect({true, ::geteuid()})) << "the same user always may";
  EXPECT_TRUE(access->mayConnect({true, 0}));
  EXPECT_TRUE(access->mayConnect({true, stranger + 1}));
  EXPECT_FALSE(access->mayConnect({true, stranger}));
  EXPECT_TRUE(access->mayConnect(kTcp));
  options.unix_users = {"no such user"};
  EXPECT_EQ(failure(), "unix user \"no such user\": not known on this machine");
}

TEST_F(AccessTest, AsksNoTokenOfUsersWhomTheKernelVouchesFor) {
  const std::uint32_t stranger = ::geteuid() + 12345;
  auto access = openWithTokens();
  EXPECT_TRUE(access->standing({true, ::geteuid()}));
  EXPECT_FALSE(access->standing({true, stranger})) << "the socket's group is not named";
  options.unix_users = {std::to_string(stranger)};
  access = open();
  EXPECT_TRUE(access->standing({true, stranger}));
  EXPECT_FALSE(access->standing(kTcp));
}

TEST_F(AccessTest, ReadsOriginsStrictly) {
  options.origins = {"https://App.example", "http://localhost:8080"};
  const auto access = open();
  EXPECT_TRUE(access->listsOrigin("https://app.example"));
  EXPECT_TRUE(access->listsOrigin("http://LOCALHOST:8080"));
  EXPECT_FALSE(access->listsOrigin("http://app.example"));
  EXPECT_FALSE(access->listsOrigin("https://app.example:444"));
  EXPECT_FALSE(access->listsOrigin("https://app.example.evil.example"));
  EXPECT_FALSE(access->listsOrigin("null"));
  EXPECT_TRUE(access->listsHost("app.example"));
  EXPECT_FALSE(access->listsHost("app.example:80"));
  for (const char* wrong : {"app.example", "https://", "https://a/", "*", "https://*.a", "null",
                            "https://u@a", "ftp://a", "https://a b", ""}) {
    options.origins = {wrong};
    EXPECT_NE(failure(), "fine") << wrong;
  }
}

TEST_F(AccessTest, ReloadsTokensAndKeepsDebts) {
  const auto access = openWithTokens();
  const auto before = *access->ofToken("editor");
  before.tenant->setQuotas({100, 0, 0});
  before.tenant->culled(100s, 0s);
  files.write("tokens.toml", tokenEntry("reader", "acme", "edit") +
                                 tokenEntry("chief", "acme", "admin") +
                                 "[tenant.acme]\ncull_ms_per_s = 50\n");
  ASSERT_TRUE(access->reload(options).ok());
  EXPECT_FALSE(access->ofToken("editor"));
  EXPECT_FALSE(access->stillGood(before, kTcp));
  EXPECT_EQ(access->ofToken("reader")->scope, Scope::kEdit);
  EXPECT_EQ(access->ofToken("reader")->tenant, before.tenant);
  EXPECT_TRUE(before.tenant->refuseCull(0s)) << "a reload pays no debts";
}

TEST_F(AccessTest, KnowsWhatWasWithdrawn) {
  const auto access = openWithTokens();
  const auto reader = *access->ofToken("reader");
  const auto editor = *access->ofToken("editor");
  const auto chief = *access->ofToken("chief");
  EXPECT_TRUE(access->stillGood(reader, kTcp));
  files.write("tokens.toml", tokenEntry("reader", "acme", "admin") +
                                 tokenEntry("editor", "acme", "read") +
                                 tokenEntry("chief", "acme", "admin"));
  ASSERT_TRUE(access->reload(options).ok());
  EXPECT_TRUE(access->stillGood(reader, kTcp)) << "it was widened";
  EXPECT_FALSE(access->stillGood(editor, kTcp)) << "it was narrowed";
  EXPECT_FALSE(access->stillGood(chief, kTcp)) << "it is another tenant's now";
}

TEST_F(AccessTest, EndsWhatNeededNoTokenOnceTokensAreNeeded) {
  const auto access = open();
  const auto all = *access->standing(kTcp);
  EXPECT_TRUE(access->stillGood(all, kTcp));
  options.tokens_file = files.write("tokens.toml", usualTokens());
  ASSERT_TRUE(access->reload(options).ok());
  EXPECT_FALSE(access->stillGood(all, kTcp));
  const auto local = *access->standing({true, ::geteuid()});
  EXPECT_TRUE(access->stillGood(local, {true, ::geteuid()}));
  EXPECT_TRUE(access->stillGood(local, kTcp)) << "a ticket carried it over";
}

TEST_F(AccessTest, KeepsWhatItHasWhenTheNewIsBad) {
  const auto access = openWithTokens();
  files.write("tokens.toml", "[[token]]\n");
  EXPECT_FALSE(access->reload(options).ok());
  EXPECT_TRUE(access->ofToken("reader"));
  options.tokens_file = (files.folder / "none").string();
  EXPECT_EQ(access->reload(options).error().code, ErrorCode::kIo);
  options.origins = {"nonsense"};
  EXPECT_FALSE(access->reload(options).ok());
  EXPECT_TRUE(access->ofToken("reader"));
}

TEST_F(AccessTest, RefusesToBeOpenToThePublic) {
  const auto check = [this](const std::string& host) {
    const auto checked = checkExposure(host, options, tls());
    return checked.ok() ? "fine" : checked.error().message;
  };
  for (const char* safe : {"127.0.0.1", "127.9.9.9", "::1", "localhost"}) {
    EXPECT_EQ(check(safe), "fine") << safe;
  }
  for (const char* open : {"0.0.0.0", "::", "192.168.1.2", "203.0.113.1", "::ffff:1.2.3.4"}) {
    EXPECT_NE(check(open).find("whoever reaches it may do everything"), std::string::npos) << open;
    EXPECT_NE(check(open).find("--allow-public"), std::string::npos) << open;
  }
  options.tokens_file = "t.toml";
  EXPECT_NE(check("0.0.0.0").find("in plain text"), std::string::npos);
  encrypted = true;
  EXPECT_EQ(check("0.0.0.0"), "fine");
  options.tokens_file = "";
  EXPECT_NE(check("0.0.0.0"), "fine") << "whom it is encrypted for is not known";
  options.allow_public = true;
  EXPECT_EQ(check("0.0.0.0"), "fine");
}

TEST_F(AccessTest, SpendsATicketOnce) {
  const auto access = openWithTokens();
  Tickets& tickets = access->tickets();
  const auto issued = tickets.issue(*access->ofToken("editor"), 0s);
  ASSERT_TRUE(issued);
  const auto ticket = std::get<std::string>(*issued);
  EXPECT_EQ(ticket.size(), 32U);
  const auto grant = tickets.redeem(ticket, 29s);
  ASSERT_TRUE(grant);
  EXPECT_EQ(grant->scope, Scope::kEdit);
  EXPECT_EQ(grant->tenant->name(), "acme");
  EXPECT_FALSE(tickets.redeem(ticket, 29s)) << "it was used";
  EXPECT_FALSE(tickets.redeem("", 0s));
}

TEST_F(AccessTest, LetsTicketsGrowStale) {
  const auto access = openWithTokens();
  const auto ticket = *access->tickets().issue(*access->ofToken("editor"), 0s);
  EXPECT_FALSE(access->tickets().redeem(std::get<std::string>(ticket), 30s));
}

TEST_F(AccessTest, BoundsTicketsByTenant) {
  const auto access = openWithTokens();
  Tickets& tickets = access->tickets();
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(std::holds_alternative<std::string>(
        *tickets.issue(*access->ofToken("reader"), std::chrono::seconds(i))));
  }
  const auto refusal = *tickets.issue(*access->ofToken("editor"), 5s);
  ASSERT_TRUE(std::holds_alternative<QuotaRefusal>(refusal));
  EXPECT_EQ(std::get<QuotaRefusal>(refusal).retry_after, 25s) << "when the oldest is stale";
  EXPECT_TRUE(std::holds_alternative<std::string>(*tickets.issue(*access->ofToken("other"), 5s)))
      << "another tenant has its own";
  EXPECT_TRUE(std::holds_alternative<std::string>(*tickets.issue(*access->ofToken("editor"), 30s)));
}

}  // namespace
}  // namespace culld::server
