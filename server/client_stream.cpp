#include "server/client_stream.h"

#include <boost/asio/bind_executor.hpp>

namespace culld::server {

// The executor is bound anew: Asio 1.26 cannot post to the one that an any_completion_handler
// tells.
void ClientStream::readSome(const FewBuffers<boost::asio::mutable_buffer>& buffers,
                            Transferred handler) {
  visit([&, bound = boost::asio::bind_executor(get_executor(), std::move(handler))](
            auto& stream) mutable { stream.async_read_some(buffers, std::move(bound)); });
}

void ClientStream::writeSome(const FewBuffers<boost::asio::const_buffer>& buffers,
                             Transferred handler) {
  visit([&, bound = boost::asio::bind_executor(get_executor(), std::move(handler))](
            auto& stream) mutable { stream.async_write_some(buffers, std::move(bound)); });
}

}  // namespace culld::server
