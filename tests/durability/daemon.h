// The daemon as a process of its own that tests start, ask, and kill.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/integration/raw_client.h"

namespace culld::testing {

class Daemon {
 public:
  /// On `data`, with a socket and a log beside it.
  explicit Daemon(std::filesystem::path data) : data_(std::move(data)) {}
  ~Daemon() { kill(); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  using Environment = std::map<std::string, std::string>;
  /// The process; `environment` is set for it alone.
  void launch(const Environment& environment = {});
  /// False when it ended or took 30 s.
  bool awaitReady();
  bool start(const Environment& environment = {}) {
    launch(environment);
    return awaitReady();
  }
  void kill();  ///< SIGKILL, and waits for the end
  int stop();   ///< SIGTERM; its exit code
  bool alive();
  std::string log() const;

  RawSocket connect() const { return RawSocket::unixDomain(socketPath().string()); }
  HttpAnswer ask(const std::string& method, const std::string& path,
                 std::string_view body = {}) const;

 private:
  std::filesystem::path socketPath() const { return data_.string() + ".sock"; }
  std::filesystem::path logPath() const { return data_.string() + ".log"; }

  const std::filesystem::path data_;
  pid_t pid_ = -1;
};

}  // namespace culld::testing
