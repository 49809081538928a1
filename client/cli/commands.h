// The commands of cullctl. Each prints its result to stdout, or one line to stderr, and returns the
// exit code of the program (docs/clients.md "Exit codes").
#pragma once
#include <cstdint>
#include <string>
#include <vector>

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

struct EditArguments {
  std::string scene;
  std::vector<std::string> set, add;            ///< ID=12 numbers
  std::vector<std::string> hide, show, remove;  ///< IDs
  std::uint64_t expected_version = 0;
  bool by_object = false;  ///< IDs are the server's object ids, not nodes of the file
  bool json = false;
};
int runEdit(const Server& server, const EditArguments& arguments);

struct PairsArguments {
  std::string scene, viewers, targets;  ///< files of places
  std::uint32_t time_us = 0;
  bool json = false;
};
int runPairs(const Server& server, const PairsArguments& arguments);

struct WatchArguments {
  std::string scene;
  std::uint32_t count = 0;  ///< lines; 0: until interrupted
  bool json = false;
};
int runWatch(const Server& server, const WatchArguments& arguments);

struct LoadArguments {
  CullArguments cull;  ///< all but the output; `cameras` may be empty
  std::uint32_t clients = 1, views = 1;
  double rate_hz = 60.0, seconds = 10.0;
  double radius_m = 0.0, angle_rad = 0.0;  ///< a client asks again when it leaves this bound
  double late_ms = 0.0;                    ///< 0: the time between two cameras
  std::uint32_t verify_every = 100;        ///< answers of a client; 0: none
  bool json = false;
};
int runLoad(const Server& server, const LoadArguments& arguments);

}  // namespace culld::client
