// What the server counts, for Prometheus and for its status page.
#pragma once
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace culld::server {

/// THREADS: any.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  void connectionOpened();
  void connectionClosed();
  void connectionRefused();
  void sessionOpened();
  void sessionClosed();
  void viewsChanged(std::ptrdiff_t by);
  void answered(std::chrono::nanoseconds cull, std::size_t bytes, std::size_t objects);
  void superseded(std::size_t cameras);
  void failed();  ///< an error message was sent
  void edited();
  void received(std::size_t bytes);
  void httpRequest(std::string_view method, unsigned status);
  void scenesHeld(std::size_t count);

  /// Text format 0.0.4.
  std::string text() const;
  struct Totals {
    double connections = 0, sessions = 0, views = 0, answers = 0, answer_bytes = 0;
    double superseded = 0, errors = 0, edits = 0, cull_seconds = 0;
  };
  Totals totals() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::server
