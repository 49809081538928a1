// What this build calls itself.
#pragma once
#include <string>

namespace culld::server {

inline std::string serverName() { return "culld/" CULLD_VERSION; }

}  // namespace culld::server
