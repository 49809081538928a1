// HTTP/1.1 on one socket: requests one after another, each under a timeout and a size limit.
// Uploads go straight to disk. A WebSocket upgrade hands the socket on.
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "protocol/version.h"
#include "server/admission.h"
#include "server/client_stream.h"
#include "server/connections.h"
#include "server/http_api.h"
#include "server/request_log.h"
#include "server/scene_names.h"

namespace culld::server {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace asio = boost::asio;

constexpr std::size_t kPartBytes = std::size_t{256} << 10;
constexpr std::size_t kReadBytes = 65'536;  ///< what Beast reads at most at once

std::string_view view(beast::string_view s) { return {s.data(), s.size()}; }

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(StreamSocket socket, Caller caller, Context& context)
      : context_(context),
        caller_(std::move(caller)),
        stream_(std::move(socket), caller_.peer.unix_socket || context.tls == nullptr
                                       ? nullptr
                                       : context.tls->current()) {
    context_.metrics.connectionOpened();
  }
  ~HttpConnection() {
    busy(false);
    context_.metrics.connectionClosed();
  }

  void start() {
    socket().expires_after(context_.limits.header_timeout);
    stream_.handshake([self = shared_from_this()](beast::error_code failure) {
      if (!failure) return self->readHeader();
      self->context_.metrics.handshakeFailed();
      self->context_.log.info("TLS handshake failed",
                              {{"peer", self->caller_.name}, {"why", failure.message()}});
      self->socket().close();
    });
  }

  void readHeader() {
    busy(false);
    route_ = {};
    grant_ = {};
    origin_.reset();
    header_.emplace();
    header_->header_limit(context_.limits.max_header_bytes);
    // Also bounds what no limit of the parser counts: headers of chunks, and trailers.
    buffer_.max_size(context_.limits.max_header_bytes + kReadBytes);
    header_->body_limit(context_.limits.max_upload_bytes);
    socket().expires_after(context_.limits.header_timeout);
    http::async_read_header(stream_, buffer_, *header_,
                            [self = shared_from_this()](beast::error_code failure, std::size_t) {
                              self->headerRead(failure);
                            });
  }

 private:
  void headerRead(beast::error_code failure) {
    if (failure == http::error::end_of_stream) return close();
    if (failure) return refuseBytes(failure);
    busy(true);
    const auto& request = header_->get();
    method_ = std::string(view(request.method_string()));
    route_ = routeOf(view(request.target()));
    keep_alive_ = request.keep_alive();
    version_ = request.version();
    if (auto refusal = refuseRepeated()) return refuseBody(*std::move(refusal));
    const bool uploads = route_.kind == Route::Kind::kScene && method_ == "PUT";
    if (uploads) {
      if (auto refusal = admission()) return refuseBody(*std::move(refusal));
      return beginPut();
    }
    // No other request has a use for a body: what follows the header would be taken for a request.
    if (request.chunked() || request.has_content_length()) keep_alive_ = false;
    if (auto refusal = admission()) return reply(*std::move(refusal));
    if (route_.kind == Route::Kind::kLive && beast::websocket::is_upgrade(request)) {
      return upgrade();
    }
    if (!heavy(method_, route_)) return reply(handleRequest(method_, route_, grant_, context_));
    context_.workers.post(grant_.tenant->name(), [self = shared_from_this()]() mutable {
      Context& context = self->context_;
      auto made = std::make_shared<HttpReply>(self->guarded(
          [&] { return handleRequest(self->method_, self->route_, self->grant_, context); }));
      context.onIoThread([self = std::move(self), made] { self->reply(std::move(*made)); });
    });
  }

  /// Two of a header that says who asks, and of whom, could be read in two ways.
  std::optional<HttpReply> refuseRepeated() const {
    const auto& request = header_->get();
    for (const http::field field :
         {http::field::host, http::field::authorization, http::field::origin}) {
      const std::size_t count = request.count(field);
      const bool missing = count == 0 && field == http::field::host && version_ >= 11;
      if (count <= 1 && !missing) continue;  // RFC 9112 section 3.2
      return errorReply(400, std::string(view(http::to_string(field))) + ": " +
                                 std::to_string(count) + " of them instead of one");
    }
    return std::nullopt;
  }

  /// A list may be spread over several lines (RFC 9110 section 5.3).
  std::string offeredSubprotocols() const {
    std::string all;
    const auto lines = header_->get().equal_range(http::field::sec_websocket_protocol);
    for (auto line = lines.first; line != lines.second; ++line) {
      all += (all.empty() ? "" : ",") + std::string(view(line->value()));
    }
    return all;
  }

  /// Learns who asks. The refusal, or the answer to a browser's question whether it may ask.
  std::optional<HttpReply> admission() {
    const auto& request = header_->get();
    const auto has = [&request](http::field field) { return request.count(field) > 0; };
    const std::string offered = offeredSubprotocols();
    RequestFacts facts{
        method_, route_, caller_.peer, stream_.tls(), view(request[http::field::host]),
        {},      {},     offered};
    if (has(http::field::origin))
      facts.origin = origin_.emplace(view(request[http::field::origin]));
    if (has(http::field::authorization))
      facts.authorization = view(request[http::field::authorization]);
    auto admitted = admit(facts, {context_.access, context_.metrics, context_.clock.now()});
    if (auto* refusal = std::get_if<HttpReply>(&admitted)) return std::move(*refusal);
    grant_ = std::move(*std::get_if<Grant>(&admitted));
    return std::nullopt;
  }

  /// Out of memory, say: this request fails, the daemon goes on.
  template <typename Work>
  HttpReply guarded(Work&& work) const {
    try {
      return work();
    } catch (const std::exception& failure) {
      return errorReply(500, inScene(failure.what()));
    }
  }

  /// Bytes that are no request get an answer where one can still be read. (Past a timeout none can:
  /// the stream is closed.)
  void refuseBytes(beast::error_code failure) {
    keep_alive_ = false;
    version_ = 11;
    if (!body_) method_.clear();
    if (failure == http::error::header_limit) {
      return reply(errorReply(431, "request header larger than " +
                                       std::to_string(context_.limits.max_header_bytes) +
                                       " bytes"));
    }
    if (failure == http::error::body_limit) return reply(tooLarge());
    if (failure == http::error::buffer_overflow) {
      return reply(errorReply(431, inScene("a chunk's header, or a trailer, larger than " +
                                           std::to_string(buffer_.max_size()) + " bytes")));
    }
    if (failure == http::error::partial_message) {  // the peer may have shut only its own half
      return reply(errorReply(400, body_ ? inScene("the upload ends before its length")
                                         : "the request ends within its header"));
    }
    if (failure.category() != httpCategory()) return close();
    reply(errorReply(400, "not an HTTP/1.1 request: " + failure.message()));
  }

  static const boost::system::error_category& httpCategory() {
    return beast::error_code(http::error::bad_method).category();
  }

  HttpReply tooLarge() const {
    return errorReply(413, inScene("upload larger than " +
                                   std::to_string(context_.limits.max_upload_bytes) + " bytes"));
  }

  std::string inScene(const std::string& what) const {
    return route_.scene.empty() ? what : "scene \"" + route_.scene + "\": " + what;
  }
  Error inScene(const Error& error) const { return {error.code, inScene(error.message)}; }

  // --- upgrade -----------------------------------------------------------------------------------

  void upgrade() {
    const auto& request = header_->get();
    const std::string offered = offeredSubprotocols();
    if (!http::token_list(offered).exists(protocol::kSubprotocol)) {
      return reply(errorReply(400, "Sec-WebSocket-Protocol: \"" +
                                       std::string(protocol::kSubprotocol) +
                                       "\" is not among those offered"));
    }
    if (request[http::field::sec_websocket_version] != "13") {
      HttpReply refusal = errorReply(426, "Sec-WebSocket-Version: only 13 is spoken here");
      refusal.headers.emplace_back("Sec-WebSocket-Version", "13");
      return reply(std::move(refusal));
    }
    if (request[http::field::sec_websocket_key].empty()) {
      return reply(errorReply(400, "Sec-WebSocket-Key is missing"));
    }
    if (header_->chunked() || header_->content_length().value_or(0) != 0) {
      return reply(errorReply(400, "an upgrade has no body"));
    }
    if (auto refusal = refuseName(route_)) return reply(*std::move(refusal));
    if (context_.draining) return reply(errorReply(503, inScene("the server is draining")));
    auto scene = findScene(route_.scene, grant_, context_);
    if (scene == nullptr && !context_.ready) {
      return reply(errorReply(503, inScene("the server is still loading scenes")));
    }
    if (scene == nullptr) {
      return reply(errorReply(404, "scene \"" + route_.scene + "\" is not known"));
    }
    std::ostringstream bytes;
    bytes << handshakeOf(request) << beast::buffers_to_string(buffer_.data());
    socket().expires_never();
    serveLive(std::move(stream_), {bytes.str(), std::move(scene), std::move(caller_), grant_},
              context_);
  }

  /// Only what the handshake needs: the WebSocket stream reads 1536 bytes of it, cookies are
  /// longer.
  static http::request_header<> handshakeOf(const http::request_header<>& request) {
    http::request_header<> handshake;
    handshake.method(request.method());
    handshake.target(request.target());
    handshake.version(request.version());
    for (const http::field field :
         {http::field::host, http::field::connection, http::field::upgrade,
          http::field::sec_websocket_key, http::field::sec_websocket_version}) {
      handshake.set(field, request[field]);
    }
    handshake.set(http::field::sec_websocket_protocol, protocol::kSubprotocol);
    return handshake;
  }

  // --- upload ------------------------------------------------------------------------------------

  void beginPut() {
    if (auto refusal = refuseName(route_)) return refuseBody(*std::move(refusal));
    if (!header_->chunked() && !header_->content_length()) {
      return refuseBody(errorReply(411, inScene("an upload needs Content-Length or chunks")));
    }
    const auto& request = header_->get();
    if (header_->chunked() && !beast::iequals(request[http::field::transfer_encoding], "chunked")) {
      return refuseBody(errorReply(501, inScene("Transfer-Encoding: only chunked is read here")));
    }
    if (request.count(http::field::content_encoding) > 0) {
      return refuseBody(
          errorReply(415, inScene("Content-Encoding: uploads are taken as they are")));
    }
    const auto length = header_->content_length();
    if (length && *length > context_.limits.max_upload_bytes) return refuseBody(tooLarge());
    if (context_.draining) return refuseBody(errorReply(503, inScene("the server is draining")));
    if (!context_.ready) {
      return refuseBody(errorReply(503, inScene("the server is still loading scenes")));
    }
    if (auto refusal = refuseShare(route_.scene, grant_, context_)) {
      return refuseBody(*std::move(refusal));
    }
    auto upload = context_.store.beginUpload();
    if (!upload) return refuseBody(errorReply(inScene(upload.error())));
    upload_.emplace(std::move(upload).value());
    upload_started_ = context_.clock.now();
    const bool waits = beast::iequals(request[http::field::expect], "100-continue");
    body_.emplace(std::move(*header_));
    if (!waits) return readPart();
    auto go = std::make_shared<http::response<http::empty_body>>(http::status::continue_, version_);
    http::async_write(stream_, *go,
                      [self = shared_from_this(), go](beast::error_code failure, std::size_t) {
                        if (!failure) self->readPart();
                      });
  }

  /// The body is still to come and nobody will read it, so the connection cannot go on.
  void refuseBody(HttpReply refusal) {
    keep_alive_ = false;
    reply(std::move(refusal));
  }

  void readPart() {
    if (!part_) part_ = std::make_unique<std::array<std::byte, kPartBytes>>();
    body_->get().body().data = part_->data();
    body_->get().body().size = part_->size();
    if (body_->is_done()) return finishUpload();
    socket().expires_after(context_.limits.body_timeout);
    http::async_read_some(stream_, buffer_, *body_,
                          [self = shared_from_this()](beast::error_code failure, std::size_t) {
                            self->partRead(failure);
                          });
  }

  void partRead(beast::error_code failure) {
    if (failure == http::error::need_buffer) failure = {};
    if (failure) {
      upload_.reset();
      return refuseBytes(failure);
    }
    const std::size_t got = part_->size() - body_->get().body().size;
    if (auto written = upload_->append({part_->data(), got}); !written) {
      return refuseBody(errorReply(inScene(written.error())));
    }
    const auto seconds =
        std::chrono::duration<double>(context_.clock.now() - upload_started_).count() -
        std::chrono::duration<double>(context_.limits.body_timeout).count();
    const auto least = static_cast<double>(context_.limits.min_upload_bytes_per_s);
    if (!body_->is_done() && static_cast<double>(upload_->size()) < seconds * least) {
      return refuseBody(errorReply(
          408,
          inScene("upload slower than " + std::to_string(context_.limits.min_upload_bytes_per_s) +
                  " bytes per second")));
    }
    readPart();
  }

  void finishUpload() {
    part_.reset();
    body_.reset();
    socket().expires_never();
    uploaded_bytes_ = upload_->size();
    context_.loaders.post(grant_.tenant->name(), [self = shared_from_this()]() mutable {
      Context& context = self->context_;
      auto made = std::make_shared<HttpReply>(self->guarded([&] {
        // The body may have taken days.
        if (!context.access.stillGood(self->grant_, self->caller_.peer)) {
          return errorReply(401, self->inScene("the token was withdrawn during the upload"));
        }
        return finishPut(self->route_.scene, std::move(*self->upload_), self->grant_, context);
      }));
      context.onIoThread([self = std::move(self), made] {
        self->upload_.reset();
        self->reply(std::move(*made));
      });
    });
  }

  // --- reply -------------------------------------------------------------------------------------

  void reply(HttpReply made) {
    const std::string stored =
        grant_.tenant == nullptr ? route_.scene : ownedName(grant_.tenant->name(), route_.scene);
    logReply(context_.log, {method_, caller_.name, route_, stored, uploaded_bytes_}, made);
    context_.metrics.httpRequest(method_, made.status);
    if (origin_ && context_.access.listsOrigin(*origin_)) letOriginRead(*origin_, made);
    if (made.status < 400 && grant_.tenant != nullptr && method_ != "HEAD") {
      grant_.tenant->sent(made.body.size(), context_.clock.now());
    }
    response_.emplace(static_cast<http::status>(made.status), version_);
    response_->set(http::field::server, context_.server_name);
    response_->set(http::field::cache_control, "no-store");
    if (!made.body.empty()) response_->set(http::field::content_type, made.content_type);
    for (const auto& [name, value] : made.headers) response_->set(name, value);
    if (context_.draining) keep_alive_ = false;
    response_->keep_alive(keep_alive_);
    if (made.status == 426) response_->set(http::field::connection, "Upgrade");
    const std::size_t length = made.body.size();
    if (method_ != "HEAD") response_->body() = std::move(made.body);
    if (made.status != 204) response_->content_length(length);
    socket().expires_after(context_.limits.write_timeout);
    if (method_ != "HEAD") {
      http::async_write(stream_, *response_, replyWritten());
    } else {
      serializer_.emplace(*response_);
      http::async_write_header(stream_, *serializer_, replyWritten());
    }
  }

  std::function<void(beast::error_code, std::size_t)> replyWritten() {
    return [self = shared_from_this()](beast::error_code failure, std::size_t) {
      if (failure) return;
      self->upload_.reset();
      if (self->keep_alive_) return self->readHeader();
      self->close();
    };
  }

  /// Says that nothing more will come, then reads what the peer still sends until it closes: a
  /// socket closed with unread bytes would tear the reply away from it.
  void close() {
    busy(false);
    socket().expires_after(std::chrono::seconds(2));
    stream_.endWriting([self = shared_from_this()] { self->linger(); });
  }

  void linger() {
    buffer_.consume(buffer_.size());
    socket().async_read_some(buffer_.prepare(kReadBytes),
                             [self = shared_from_this()](beast::error_code failure, std::size_t) {
                               if (!failure) self->linger();
                             });
  }

  void busy(bool now) {
    if (now == busy_) return;
    busy_ = now;
    context_.busy_requests += now ? 1U : std::size_t(-1);
  }

  ClientStream::PlainStream& socket() { return stream_.next_layer(); }

  Context& context_;
  Caller caller_;
  ClientStream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> header_;
  std::optional<http::request_parser<http::buffer_body>> body_;
  std::optional<http::response<http::string_body>> response_;
  std::optional<http::response_serializer<http::string_body>> serializer_;
  std::optional<Upload> upload_;
  std::unique_ptr<std::array<std::byte, kPartBytes>> part_;
  std::chrono::nanoseconds upload_started_{0};
  std::uint64_t uploaded_bytes_ = 0;
  std::string method_;
  Route route_;
  Grant grant_;  ///< of the request under way
  std::optional<std::string> origin_;
  unsigned version_ = 11;
  bool keep_alive_ = true;
  bool busy_ = false;
};

}  // namespace

void serveHttp(StreamSocket socket, Caller caller, Context& context) {
  std::make_shared<HttpConnection>(std::move(socket), std::move(caller), context)->start();
}

}  // namespace culld::server
