// The thread of a connection, and the socket on it: a new one whenever the old one is lost. Knows
// nothing of what the messages say.
#pragma once
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/live_socket.h"

namespace culld::client {

class Link {
 public:
  /// All are called on the link's thread.
  struct Handlers {
    std::function<void()> opened;
    std::function<void(std::span<const std::uint8_t>)> message;
    /// The socket is gone, or was never had. Returns how long to wait for the next one; none: that
    /// was the end.
    std::function<std::optional<std::chrono::milliseconds>(const Error&)> lost;
    /// The last: nothing more will come. May be called twice.
    std::function<void()> ended;
  };

  Link(Address address, std::string target, ConnectOptions options);
  /// Waits for the thread, unless it is the one that destroys.
  ~Link();

  /// `owner` is held until the thread ends.
  void start(Handlers handlers, std::shared_ptr<void> owner);

  // THREADS: any. COST: they return at once.
  /// In the order of the calls. Without a socket it does nothing.
  void send(std::vector<std::uint8_t> bytes);
  void post(std::function<void()> task);
  /// Says goodbye, for a second at most.
  void close();

  bool onThread() const noexcept { return thread_id_.load() == std::this_thread::get_id(); }
  /// Waits for the end of the thread. REQUIRES: !onThread(); one caller.
  void join();

  // THREADS: the link's.
  /// The two sides have agreed; until then `options.timeouts.connect` runs.
  void established();
  void breakOff(const Error& error);

 private:
  void connect();
  void flush();
  void after(std::chrono::milliseconds wait, std::function<void()> what);
  void forgetTimer();
  void opened();
  void closed(const Error& error);
  void finish();

  const Address address_;
  const std::string target_;
  const ConnectOptions options_;
  Handlers handlers_;
  boost::asio::io_context io_{1};
  boost::asio::steady_timer timer_{io_};  ///< agreement, next attempt, or goodbye
  std::unique_ptr<LiveSocket> socket_;
  std::uint64_t round_ = 0;  ///< of the timer: what is of an earlier one is void
  bool closing_ = false;
  std::mutex outbox_mutex_;
  std::vector<std::vector<std::uint8_t>> outbox_;  ///< in the order of send()
  std::thread thread_;
  std::atomic<std::thread::id> thread_id_{};
};

}  // namespace culld::client
