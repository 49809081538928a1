// What a server's HTTP refusal means to a program.
#pragma once
#include <string>

#include "culld/address.h"

namespace culld::client {

/// The server's own words ({"error": ...}) on one line, or the status if it gave none.
protocol::Error refusal(const Address& address, unsigned status, const std::string& body);

}  // namespace culld::client
