// What the server counts, for Prometheus and for its status page.
#pragma once
#include <chrono>
#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"

namespace culld::server {

/// What an answer was worth and what it took.
struct AnswerReport {
  std::string scene;
  std::string_view method, made_by;  ///< asked for, and the one that it chose
  protocol::Guarantee guarantee = protocol::Guarantee::kConservative;
  float missed_px = 0.0F;
  bool proven = true;
  bool out_of_budget = false;
  std::chrono::nanoseconds queued{0};  ///< from the camera's arrival to the cull
  std::chrono::nanoseconds cull{0};
  std::size_t bytes = 0;
  std::size_t objects = 0;
  std::size_t in_frustum = 0;      ///< 0: the method does not count them
  std::size_t seen = 0, kept = 0;  ///< of `objects`; both 0: the method does not tell
};

/// What one method's answers about one scene came to, whether it was asked for or chosen.
struct MethodUse {
  std::string method;
  double answers = 0, out_of_budget = 0, objects = 0, cull_seconds = 0;
};

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
  void answered(const AnswerReport& report);
  void superseded(std::size_t cameras);
  void refused(protocol::WireCode code);  ///< an error message was sent
  void edited();
  /// A question about so many pairs was worked off.
  void paired(std::size_t pairs, std::size_t hidden, std::chrono::nanoseconds took);
  void authFailed(const char* reason);     ///< a client was turned away
  void quotaRejected(const char* reason);  ///< a tenant had used up its share
  void handshakeFailed();                  ///< of TLS
  void certificateExpires(std::int64_t unix_s);
  void received(std::size_t bytes);
  void httpRequest(std::string_view method, unsigned status);
  /// The scenes from now on; what was counted about others is dropped.
  /// `damaged`: so many more are stored and not served.
  void scenesHeld(const std::set<std::string>& names, std::size_t damaged);

  /// At the start, and at each reload: whether the configuration was taken.
  void configRead(bool good);

  /// Text format 0.0.4.
  std::string text() const;
  struct Totals {
    double connections = 0, sessions = 0, views = 0, answers = 0, answer_bytes = 0;
    double superseded = 0, errors = 0, edits = 0, cull_seconds = 0;
  };
  Totals totals() const;
  /// By name of the method; those that answered at all.
  std::vector<MethodUse> usesOf(const std::string& scene) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::server
