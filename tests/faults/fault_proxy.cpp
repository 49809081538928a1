#include "tests/faults/fault_proxy.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <thread>

#include "tests/scenes/random.h"

namespace culld::testing {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::microseconds;

/// What befalls one direction of one connection.
struct Fate {
  enum class End { kNone, kReset, kHalfClose };
  End end = End::kNone;
  std::uint64_t end_after_bytes = 0;
  std::size_t piece_bytes = 65'536;
  std::uint32_t delay_us = 0;
};

Fate drawFate(scenes::Random& random, const FaultMix& mix) {
  Fate fate;
  const double end = random.unit();
  if (end < mix.reset) {
    fate.end = Fate::End::kReset;
  } else if (end < mix.reset + mix.half_close) {
    fate.end = Fate::End::kHalfClose;
  }
  fate.end_after_bytes = random.below(mix.fault_within_bytes);
  if (random.chance(mix.split)) fate.piece_bytes = 1 + random.below(50);
  if (random.chance(mix.delay)) fate.delay_us = 400;
  return fate;
}

/// Both directions of one connection, until both have ended.
class Link : public std::enable_shared_from_this<Link> {
 public:
  Link(tcp::socket client, std::uint64_t seed, const FaultMix& mix, FaultCounts& counts)
      : client_(std::move(client)),
        server_(client_.get_executor()),
        dial_timer_(client_.get_executor()),
        random_(seed),
        counts_(counts),
        ways_{Way(client_, server_, drawFate(random_, mix)),
              Way(server_, client_, drawFate(random_, mix))} {
    for (const Way& way : ways_) {
      counts_.split += way.fate.piece_bytes < 65'536 ? 1U : 0U;
      counts_.delayed += way.fate.delay_us > 0 ? 1U : 0U;
    }
    if (random_.chance(mix.late_dial)) dial_delay_ = microseconds(random_.below(30'000));
    counts_.late += dial_delay_.count() > 0 ? 1U : 0U;
  }

  void dial(const tcp::endpoint& target) {
    dial_timer_.expires_after(dial_delay_);
    dial_timer_.async_wait([self = shared_from_this(), target](error_code failure) {
      if (failure) return;
      self->server_.async_connect(target, [self](error_code refused) {
        if (refused) return self->cut();
        error_code ignored;  // a peer that is gone already is noticed when it is read
        for (tcp::socket* socket : {&self->client_, &self->server_}) {
          socket->set_option(tcp::no_delay(true), ignored);  // the delays are ours to choose
        }
        for (Way& way : self->ways_) self->read(way);
      });
    });
  }

  void cut() {
    error_code ignored;  // whatever state they are in, they are gone afterwards
    for (tcp::socket* socket : {&client_, &server_}) {
      socket->set_option(asio::socket_base::linger(true, 0), ignored);  // a reset, not an end
      socket->close(ignored);
    }
    dial_timer_.cancel();
    for (Way& way : ways_) way.timer.cancel();
  }

 private:
  struct Way {
    Way(tcp::socket& source, tcp::socket& sink, const Fate& given)
        : from(source), to(sink), timer(source.get_executor()), fate(given) {}
    tcp::socket& from;
    tcp::socket& to;
    asio::steady_timer timer;
    Fate fate;
    std::uint64_t forwarded = 0;
    std::array<char, 65'536> buffer{};
  };

  void read(Way& way) {
    way.from.async_read_some(asio::buffer(way.buffer),
                             [self = shared_from_this(), &way](error_code ended, std::size_t got) {
                               if (ended) return self->finish(way);
                               self->forward(way, 0, got);
                             });
  }

  void forward(Way& way, std::size_t begin, std::size_t end) {
    if (begin == end) return read(way);
    const bool ends = way.fate.end != Fate::End::kNone;
    if (ends && way.forwarded >= way.fate.end_after_bytes) return fail(way);
    std::size_t count = std::min(end - begin, way.fate.piece_bytes);
    if (ends) count = std::min(count, way.fate.end_after_bytes - way.forwarded);
    const auto wait =
        way.fate.delay_us > 0 ? microseconds(random_.below(way.fate.delay_us)) : microseconds(0);
    way.timer.expires_after(wait);
    way.timer.async_wait([self = shared_from_this(), &way, begin, end, count](error_code stopped) {
      if (stopped) return;
      asio::async_write(way.to, asio::buffer(way.buffer.data() + begin, count),
                        [self, &way, begin, end, count](error_code gone, std::size_t) {
                          if (gone) return self->cut();
                          way.forwarded += count;
                          self->forward(way, begin + count, end);
                        });
    });
  }

  void fail(Way& way) {
    if (way.fate.end == Fate::End::kReset) {
      ++counts_.resets;
      return cut();
    }
    ++counts_.half_closes;
    finish(way);
  }

  /// This way carries nothing more; the other may.
  static void finish(Way& way) {
    error_code ignored;  // the peer may be gone already
    way.to.shutdown(tcp::socket::shutdown_send, ignored);
    way.from.shutdown(tcp::socket::shutdown_receive, ignored);
  }

  tcp::socket client_;
  tcp::socket server_;
  asio::steady_timer dial_timer_;
  scenes::Random random_;
  FaultCounts& counts_;
  microseconds dial_delay_{0};
  std::array<Way, 2> ways_;
};

}  // namespace

struct FaultProxy::Impl {
  Impl(std::uint16_t target_port, std::uint64_t seed, const FaultMix& given)
      : target(asio::ip::address_v4::loopback(), target_port), mix(given), random(seed) {}

  void accept() {
    acceptor.async_accept([this](error_code failure, tcp::socket socket) {
      if (failure) return;
      ++counts.connections;
      auto link = std::make_shared<Link>(std::move(socket), random.seed(), mix, counts);
      std::erase_if(links, [](const auto& weak) { return weak.expired(); });
      links.push_back(link);
      link->dial(target);
      accept();
    });
  }

  asio::io_context io{1};
  const tcp::endpoint target;
  const FaultMix mix;
  scenes::Random random;
  FaultCounts counts;
  std::vector<std::weak_ptr<Link>> links;
  tcp::acceptor acceptor{io, {asio::ip::address_v4::loopback(), 0}};
  std::thread thread;
};

FaultProxy::FaultProxy(std::uint16_t target_port, std::uint64_t seed, const FaultMix& mix)
    : impl_(std::make_unique<Impl>(target_port, seed, mix)) {
  impl_->accept();
  impl_->thread = std::thread([io = &impl_->io] { io->run(); });
}

FaultProxy::~FaultProxy() { stop(); }

std::uint16_t FaultProxy::port() const noexcept { return impl_->acceptor.local_endpoint().port(); }

FaultCounts FaultProxy::stop() {
  if (!impl_->thread.joinable()) return impl_->counts;
  asio::post(impl_->io, [impl = impl_.get()] {
    impl->acceptor.close();
    for (const auto& weak : impl->links) {
      if (const auto link = weak.lock()) link->cut();
    }
  });
  impl_->thread.join();
  return impl_->counts;
}

}  // namespace culld::testing
