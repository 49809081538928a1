// The commands of cullctl. Each prints its result to stdout, or one line to stderr, and returns the
// exit code of the program (docs/clients.md "Exit codes").
#pragma once
#include <cstdint>
#include <string>

#include "culld/address.h"
#include "culld/options.h"
#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::client {

enum ExitCode { kFine = 0, kFailed = 1, kUsage = 2, kUnreachable = 69, kDisk = 74 };

/// Where the server is, and how to get there.
struct Server {
  Address address;
  Access access;

  /// For a command that asks once: a lost connection is an error.
  ConnectOptions once() const {
    ConnectOptions options;
    options.access = access;
    options.reconnect.enabled = false;
    return options;
  }
};

/// Says what went wrong, in one line.
int fail(ExitCode code, const std::string& message);
/// The same with the code that fits.
int fail(const protocol::Error& error);
/// `code`, or kDisk after it has said so if something that was printed never reached its reader.
int checkStdout(int code);

int runPut(const Server& server, const std::string& scene, const std::string& file, bool json);
int runList(const Server& server, bool json);
int runInfo(const Server& server, const std::string& scene, bool json);
int runRemove(const Server& server, const std::string& scene);

/// `scene` empty: an HTTP exchange; else through the message layer of that scene.
int runPing(const Server& server, const std::string& scene, std::uint32_t count, bool json);

/// What `cull` and `fly` have in common.
struct CullArguments {
  std::string scene, cameras, output;
  std::string method = "auto", guarantee = "conservative";
  protocol::Demand demand;  ///< all but the guarantee
  std::uint32_t width_px = 1280, height_px = 720;
};
int runCull(const Server& server, const CullArguments& arguments);

struct FlyArguments {
  CullArguments cull;
  std::string json_output;  ///< per frame: what was measured, and the ids of the visible objects
  bool loop = false;
};
int runFly(const Server& server, const FlyArguments& arguments);

}  // namespace culld::client
