// The scenes that a server holds: list, look at, upload, remove (docs/clients.md). Plain HTTP, one
// exchange a call, no connection kept.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "culld/address.h"
#include "culld/options.h"
#include "protocol/answer_file.h"
#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::client {

using protocol::Done;
using protocol::Error;
using protocol::ErrorCode;
using protocol::ObjectName;
using protocol::Result;
using protocol::SceneInfo;

/// A scene as its server describes it.
struct SceneDetails {
  SceneInfo info;
  std::uint64_t file_bytes = 0;
  std::string method;                 ///< what a view gets that names none
  std::vector<std::string> warnings;  ///< what the loader found odd and survived
};

/// What the scene's file calls its objects, at one version of the scene.
struct ObjectTable {
  std::uint64_t version = 0;
  std::vector<ObjectName> names;  ///< by object id
};

/// A server as it describes itself.
struct ServerDetails {
  std::string name;  ///< program and version
  std::uint32_t protocol_min = 0, protocol_max = 0;
};

struct HttpTimeouts {
  std::chrono::milliseconds connect{5'000};
  std::chrono::milliseconds exchange{30'000};  ///< silence allowed while bytes should flow
  std::chrono::milliseconds load{600'000};     ///< for the server to load an uploaded scene
};

/// ERROR of all: kUnavailable (no server there, or silent), kNotFound, kInvalidInput (what the
/// server says about the name or the file), kIo (a local file). THREADS: any; calls block.
class Scenes {
 public:
  explicit Scenes(Address address, Access access = {}, HttpTimeouts timeouts = {});

  Result<ServerDetails> server() const;
  Result<std::vector<SceneDetails>> list() const;
  Result<SceneDetails> info(const std::string& name) const;
  Result<Done> remove(const std::string& name) const;

  using Progress = std::function<void(std::uint64_t sent, std::uint64_t total)>;
  /// Uploads a .glb; a scene of that name is replaced. ERROR: kInvalidInput, kLimit: `path` and
  /// what the server finds wrong with it.
  Result<SceneDetails> put(const std::string& name, const std::string& path,
                           const Progress& progress = {}) const;

  Result<ObjectTable> objects(const std::string& name) const;

 private:
  Address address_;
  Access access_;
  HttpTimeouts timeouts_;
};

}  // namespace culld::client
