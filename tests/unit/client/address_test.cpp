#include "culld/address.h"

#include <gtest/gtest.h>

#include <string>

namespace culld::client {
namespace {

TEST(Address, ReadsTcpAndUnixSocketsAndWritesThemBack) {
  for (const char* text :
       {"ws://127.0.0.1:7420", "ws://localhost:1", "ws://[::1]:65535", "wss://culld.example:443",
        "unix:/run/culld.sock", "unix:relative path"}) {
    const auto address = parseAddress(text);
    ASSERT_TRUE(address.ok()) << address.error().message;
    EXPECT_EQ(toString(address.value()), text);
  }
  EXPECT_EQ(parseAddress("ws://[::1]:7420").value().host, "::1");
  EXPECT_EQ(parseAddress("ws://a:7420/").value().port, 7420);
  EXPECT_TRUE(parseAddress("unix:x").value().unixSocket());
  EXPECT_TRUE(parseAddress("wss://a:1").value().tls);
  EXPECT_FALSE(parseAddress("ws://a:1").value().tls);
}

TEST(Address, NamesWhatIsNoAddress) {
  for (const char* text :
       {"", "localhost", "localhost:7420", "http://a:1", "ws://", "ws://a", "ws://:7420",
        "ws://a:", "ws://a:0", "ws://a:65536", "ws://a:-1", "ws://a:7420x", "ws://a:7420/live",
        "ws://::1:7420", "ws://a b:7420", "unix:", "wss://", "wss:a:1"}) {
    const auto address = parseAddress(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_EQ(address.error().message,
              std::string(text) + ": not an address like ws://127.0.0.1:7420 or unix:PATH");
  }
}

}  // namespace
}  // namespace culld::client
