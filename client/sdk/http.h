// One HTTP exchange on a connection of its own. http.cpp is one of the two files of this room that
// see Beast.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "culld/scenes.h"

namespace culld::client {

struct HttpRequest {
  std::string verb = "GET";
  std::string target;
  std::string body_path;  ///< file to send; empty: no body
  Scenes::Progress progress;
};

struct HttpReply {
  unsigned status = 0;
  std::string body;
};

/// A reply of any status is a value. ERROR: kUnavailable: no connection, broken, silent; kIo: file.
Result<HttpReply> exchange(const Address& address, const HttpRequest& request, const Access& access,
                           const HttpTimeouts& timeouts);

}  // namespace culld::client
