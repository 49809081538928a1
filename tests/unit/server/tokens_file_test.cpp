#include "server/tokens_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace culld::server {
namespace {

const std::string kHex = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";  // abc

std::string token(const std::string& rest = "scopes = [\"read\"]", const std::string& hex = kHex) {
  return "[[token]]\nsha256 = \"" + hex + "\"\n" + rest + "\n";
}

std::string failure(const std::string& text) {
  const auto parsed = parseTokens(text, "t.toml");
  return parsed.ok() ? "fine" : parsed.error().message;
}

TEST(TokensFile, GivesTokensAndQuotas) {
  const auto parsed = parseTokens(token("tenant = \"acme\"\nscopes = [\"edit\", \"read\"]") +
                                      token("scopes = [\"admin\"]", std::string(64, 'A')) +
                                      "[tenant.acme]\ncull_ms_per_s = 200\nscenes = 5\n",
                                  "t.toml");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  const auto& tokens = parsed.value().tokens;
  ASSERT_EQ(tokens.size(), 2U);
  EXPECT_EQ(tokens[0].digest, sha256("abc"));
  EXPECT_EQ(tokens[0].tenant, "acme");
  EXPECT_EQ(tokens[0].scope, Scope::kEdit) << "the largest of them";
  EXPECT_EQ(tokens[1].tenant, "") << "the operator's";
  EXPECT_EQ(tokens[1].scope, Scope::kAdmin);
  EXPECT_EQ(parsed.value().tenants.at("acme"), (Quotas{200, 0, 5}));
}

TEST(TokensFile, TakesNoTokensForATable) {
  const auto parsed = parseTokens("# none yet\n", "t.toml");
  ASSERT_TRUE(parsed.ok());
  EXPECT_TRUE(parsed.value().tokens.empty());
}

TEST(TokensFile, NamesTheLineOfEachMistake) {
  const std::string tenant = token("tenant = \"acme\"\nscopes = [\"read\"]");
  const std::pair<std::string, std::string> cases[] = {
      {"[[token]\n", "t.toml: line 1: "},
      {"[[token]]\nsha256 = \"x\n", "t.toml: line 2: "},
      {token("scopes = []"), "t.toml: line 3: token: scopes is not a list of any"},
      {token("scopes = \"read\""), "t.toml: line 3: token: scopes is not a list of any"},
      {token("scopes = [\"write\"]"), "t.toml: line 3: token: a scope is one of read, edit, admin"},
      {token("scopes = [1]"), "t.toml: line 3: token: a scope is one of"},
      {token(""), "t.toml: line 1: token: scopes is missing"},
      {"[[token]]\nscopes = [\"read\"]\n", "t.toml: line 1: token: sha256 is missing"},
      {token("scopes = [\"read\"]", "abc"), "t.toml: line 2: token: sha256 is not 64 hexadecimal"},
      {token("scopes = [\"read\"]", std::string(64, 'g')), "t.toml: line 2: token: sha256 is not"},
      {"[[token]]\nsha256 = 12\nscopes = [\"read\"]\n", "t.toml: line 2: token: sha256 is not"},
      {token("scopes = [\"read\"]",
             "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"),
       "t.toml: line 2: token: sha256 is that of no words at all"},
      {token() + token(), "t.toml: line 4: token: the same sha256 as in line 1"},
      {token("scope = [\"read\"]"), "t.toml: line 3: token: unknown key \"scope\""},
      {token("tenant = \"a b\"\nscopes = [\"read\"]"), "t.toml: line 3: token: tenant is not"},
      {token("tenant = \"\"\nscopes = [\"read\"]"), "t.toml: line 3: token: tenant is not"},
      {token("tenant = \"a:b\"\nscopes = [\"read\"]"), "t.toml: line 3: token: tenant is not"},
      {"tokens = []\n", "t.toml: line 1: unknown key \"tokens\""},
      {"token = 3\n", "t.toml: line 1: token: not a list of tables"},
      {"token = [3]\n", "t.toml: line 1: token: not a list of tables"},
      {"tenant = 3\n", "t.toml: line 1: tenant: not a table"},
      {"[tenant]\nacme = 3\n", "t.toml: line 2: tenant.acme: not a table"},
      {tenant + "[tenant.acme]\ncull_ms = 3\n", "t.toml: line 6: tenant.acme: unknown key"},
      {tenant + "[tenant.acme]\nscenes = 0\n", "t.toml: line 6: tenant.acme: scenes: not a whole"},
      {tenant + "[tenant.acme]\nscenes = -1\n", "t.toml: line 6: tenant.acme: scenes: not a whole"},
      {tenant + "[tenant.acme]\nscenes = 2.5\n", "t.toml: line 6: tenant.acme: scenes: not a"},
      {tenant + "[tenant.acme]\nbytes_per_s = 2000000000000\n", "t.toml: line 6: tenant.acme: byt"},
      {tenant + "[tenant.amce]\nscenes = 1\n", "t.toml: line 5: tenant.amce: no token names it"},
      {tenant + "[tenant.\"a/b\"]\nscenes = 1\n", "t.toml: line 5: tenant \"a/b\": not [A-Za-z0"},
  };
  for (const auto& [text, words] : cases) {
    EXPECT_EQ(failure(text).substr(0, words.size()), words) << text << failure(text);
    EXPECT_EQ(failure(text).find('\n'), std::string::npos) << text;
  }
}

TEST(TokensFile, NeverRepeatsWhatMayBeAToken) {
  EXPECT_EQ(failure(token("scopes = [\"read\"]", "my-secret-token")).find("my-secret"),
            std::string::npos);
}

TEST(TokensFile, HasALimit) {
  std::string many;
  for (int i = 0; i < 1001; ++i) {
    std::string hex = std::to_string(i);
    many += token("scopes = [\"read\"]", hex.insert(0, 64 - hex.size(), '0'));
  }
  EXPECT_EQ(failure(many).substr(0, 32), "t.toml: line 1: more than 1000 t");
}

TEST(TokensFile, IsReadFromDisk) {
  const auto path = std::filesystem::path(::testing::TempDir()) /
                    ("culld_tokens_" + std::to_string(::getpid()) + ".toml");
  EXPECT_EQ(readTokens(path.string()).error().code, ErrorCode::kIo);
  std::ofstream(path) << token();
  EXPECT_EQ(readTokens(path.string()).value().tokens.size(), 1U);
  std::ofstream(path) << std::string((std::size_t{1} << 20) + 1, '#');
  EXPECT_EQ(readTokens(path.string()).error().code, ErrorCode::kLimit);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace culld::server
