#include "server/address_counts.h"

namespace culld::server {

AddressTicket AddressCounts::enter(const std::string& address, std::size_t limit) {
  std::size_t& count = (*counts_)[address];
  if (limit != 0 && count >= limit) return nullptr;
  ++count;
  // The ticket holds the table, so that it may outlive this object.
  return AddressTicket(counts_.get(), [counts = counts_, address](const void*) {
    const auto at = counts->find(address);
    if (--at->second == 0) counts->erase(at);
  });
}

}  // namespace culld::server
