// Files that an operator would write, in a folder that goes with the test.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace culld::testing {

class Files {
 public:
  Files() {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  ~Files() { std::filesystem::remove_all(folder); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  /// Its path.
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return (folder / name).string();
  }

  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("culld_files_" + std::to_string(::getpid()));
};

/// SHA-256 of the tokens that tests use, as `printf %s WORD | sha256sum` gives them.
inline std::string tokenEntry(const std::string& word, const std::string& tenant,
                              const std::string& scope) {
  const std::vector<std::pair<std::string, std::string>> known = {
      {"reader", "3d0941964aa3ebdcb00ccef58b1bb399f9f898465e9886d5aec7f31090a0fb30"},
      {"editor", "1553cc62ff246044c683a61e203e65541990e7fcd4af9443d22b9557ecc9ac54"},
      {"keeper", "00aa8942525b763cbe72e4a0fbfbb027b909dd8299e9c6c85c28d3d42d2cc28b"},
      {"other", "d9298a10d1b0735837dc4bd85dac641b0f3cef27a47e5d53a54f2f3f5b2fcffa"},
      {"chief", "9285827b8031a1dbe7d1d04eb8a08c8891ee424a8002cfc7dd2df3d82cbff611"},
  };
  for (const auto& [name, hex] : known) {
    if (name != word) continue;
    return "[[token]]\nsha256 = \"" + hex + "\"\nscopes = [\"" + scope + "\"]\n" +
           (tenant.empty() ? "" : "tenant = \"" + tenant + "\"\n");
  }
  ADD_FAILURE() << "no such token: " << word;
  return "";
}

/// reader, editor and keeper (admin) of acme; other (admin) of globex; chief, the operator's.
inline std::string usualTokens() {
  return tokenEntry("reader", "acme", "read") + tokenEntry("editor", "acme", "edit") +
         tokenEntry("keeper", "acme", "admin") + tokenEntry("other", "globex", "admin") +
         tokenEntry("chief", "", "admin");
}

}  // namespace culld::testing
