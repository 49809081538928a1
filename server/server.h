// The daemon as an object: listens, serves, drains. The program wraps it; tests start it
// in-process.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "culling/core/result.h"
#include "culling/scene/gltf_loader.h"
#include "server/access_options.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/scene.h"
#include "server/systemd.h"

namespace culld::server {

struct ServerOptions {
  std::string listen_host = "127.0.0.1";
  std::uint16_t listen_port = 7420;        ///< 0: one that is free
  std::string unix_path;                   ///< empty: none
  std::vector<InheritedSocket> inherited;  ///< if any: these, and neither of the above
  std::string data_folder;                 ///< empty: uploads live as long as the process
  std::vector<std::pair<std::string, std::string>> scene_files;  ///< name, path
  std::size_t threads = 0;  ///< for culling; 0: as many as cores
  Methods methods;
  ServerLimits limits;
  AccessOptions access;
  TlsOptions tls;
  LoadOptions load;
  Log* log = nullptr;  ///< outlives the server; null: it is silent
};

class Server {
 public:
  /// Binds, then loads scenes while it answers already (not ready until all are loaded).
  /// ERROR: kInvalidInput: not an address to listen on, or as checkAccess(); kUnavailable: cannot
  /// bind, or the data folder is in use; kIo.
  static Result<std::unique_ptr<Server>> start(ServerOptions options);
  /// Stops at once.
  ~Server();

  /// Of the first TCP socket; 0: there is none.
  std::uint16_t port() const noexcept;
  /// Where it listens: HOST:PORT, or the path of a Unix socket.
  const std::vector<std::string>& addresses() const noexcept;
  /// Loads what the options name. Returns a line for each stored scene that could not be read.
  /// ERROR: a scene file that cannot be read. THREADS: the one that called start().
  Result<std::vector<std::string>> loadScenes();

  /// From now on these hold, for what connections ask for next; open live sessions keep those that
  /// they were told. max_scenes stays as it was at the start. THREADS: any.
  void setLimits(const ServerLimits& limits);
  /// For the metrics: a configuration was read, or refused.
  void configRead(bool good);
  /// Calls `task` on the I/O thread: proof that it turns over. THREADS: any.
  void whenAlive(std::function<void()> task);
  /// Reads tokens, users, origins and certificate anew. What was withdrawn ends its live sessions;
  /// new connections get the new certificate, old ones live on.
  /// GUARANTEES: after an error all is as it was. ERROR: as checkAccess() (server/access.h);
  /// kUnsupported: TLS cannot come or go while the server runs. THREADS: the one that called
  /// start().
  Result<void> reloadAccess(const AccessOptions& access, const TlsOptions& tls);

  /// Stops accepting, tells clients, lets work in flight finish (limits.drain_timeout), returns.
  void drain();

  /// For a process that ends without its destructors, because loadScenes() still runs: removes the
  /// folder that stood in for a data folder. REQUIRES: drain().
  void removeTemporaryFiles();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::server
