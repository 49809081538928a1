// Counts connections by where they come from, so that one address cannot take them all.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <unordered_map>

namespace culld::server {

/// A connection's place among those of its address; given back when the last copy goes.
using AddressTicket = std::shared_ptr<const void>;

/// THREADS: the I/O thread.
class AddressCounts {
 public:
  /// Null: `limit` are open already. `limit` 0: any number.
  AddressTicket enter(const std::string& address, std::size_t limit);

 private:
  using Counts = std::unordered_map<std::string, std::size_t>;
  std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
};

}  // namespace culld::server
