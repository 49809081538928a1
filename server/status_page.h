// The page at "/": what the daemon holds and does, live.
#pragma once
#include <string_view>

namespace culld::server {

std::string_view statusPage() noexcept;

}  // namespace culld::server
