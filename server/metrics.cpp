#include "server/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <atomic>
#include <iterator>
#include <utility>

#include "server/answer_metrics.h"
#include "server/process_metrics.h"

namespace culld::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Counter;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Registry;

Counter& counter(Registry& registry, const char* name, const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

Gauge& gauge(Registry& registry, const char* name, const char* help) {
  return BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

Histogram& queueSeconds(Registry& registry) {
  static const Histogram::BucketBoundaries kSeconds{0.00001, 0.0001, 0.001, 0.005, 0.01, 0.02,
                                                    0.05,    0.1,    0.2,   0.5,   1,    5};
  return BuildHistogram()
      .Name("culld_queue_duration_seconds")
      .Help("Time between the arrival of a camera and its cull")
      .Register(registry)
      .Add({}, kSeconds);
}

}  // namespace

struct Metrics::Impl {
  Registry registry;
  Gauge& config_good = gauge(registry, "culld_config_last_reload_successful",
                             "1: the configuration was taken when it was last read; 0: refused");
  Gauge& config_time = gauge(registry, "culld_config_last_reload_success_timestamp_seconds",
                             "When a configuration was last taken");
  Histogram& queued = queueSeconds(registry);
  Gauge& connections = gauge(registry, "culld_connections", "Open connections");
  Gauge& sessions = gauge(registry, "culld_sessions", "Open live sessions");
  Gauge& views = gauge(registry, "culld_views", "Open views");
  Gauge& scenes = gauge(registry, "culld_scenes", "Scenes held");
  Gauge& damaged =
      gauge(registry, "culld_scenes_damaged", "Scenes stored, but damaged and not served");
  Counter& refused = counter(registry, "culld_connections_refused_total",
                             "Connections refused because there were too many");
  AnswerMetrics answers{registry};
  Counter& answer_bytes = counter(registry, "culld_answer_bytes_total", "Bytes of answers made");
  Counter& superseded =
      counter(registry, "culld_cameras_superseded_total", "Cameras passed over for newer ones");
  Counter& edits = counter(registry, "culld_edits_total", "Edit messages applied");
  Counter& pairs =
      counter(registry, "culld_pairs_total", "Pairs of viewers and targets that were asked about");
  Counter& hidden_pairs =
      counter(registry, "culld_pairs_hidden_total", "Pairs that were proven hidden");
  Counter& pair_seconds =
      counter(registry, "culld_pairs_seconds_total", "Time spent on questions about pairs");
  Counter& received =
      counter(registry, "culld_received_bytes_total", "Bytes of live messages read");
  prometheus::Family<Counter>& errors = BuildCounter()
                                            .Name("culld_errors_total")
                                            .Help("Error messages sent, by their code")
                                            .Register(registry);
  prometheus::Family<Counter>& http =
      BuildCounter().Name("culld_http_requests_total").Help("HTTP requests").Register(registry);
  prometheus::Family<Counter>& auth_failures =
      BuildCounter()
          .Name("culld_auth_failures_total")
          .Help("Requests and connections refused for who asked, by reason")
          .Register(registry);
  prometheus::Family<Counter>& quota =
      BuildCounter()
          .Name("culld_quota_rejected_total")
          .Help("Requests refused because a tenant had used up its share, by reason")
          .Register(registry);
  Counter& handshakes = counter(registry, "culld_tls_handshake_failures_total",
                                "TLS connections that came to no agreement");
  prometheus::Family<Gauge>& certificate =
      BuildGauge()
          .Name("culld_tls_certificate_expiry_timestamp_seconds")
          .Help("When the certificate ends, as seconds since 1970")
          .Register(registry);
  // Sums over the series above, for totals().
  std::atomic<std::uint64_t> answers_made{0};
  std::atomic<std::uint64_t> errors_sent{0};
  std::atomic<std::int64_t> cull_ns{0};
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {
  prometheus::BuildGauge()
      .Name("culld_build_info")
      .Help("1, with what this program is as labels")
      .Register(impl_->registry)
      .Add({{"version", CULLD_VERSION}, {"compiler", __VERSION__}})
      .Set(1);
  configRead(true);
}
Metrics::~Metrics() = default;

void Metrics::connectionOpened() { impl_->connections.Increment(); }
void Metrics::connectionClosed() { impl_->connections.Decrement(); }
void Metrics::connectionRefused() { impl_->refused.Increment(); }
void Metrics::sessionOpened() { impl_->sessions.Increment(); }
void Metrics::sessionClosed() { impl_->sessions.Decrement(); }
void Metrics::viewsChanged(std::ptrdiff_t by) { impl_->views.Increment(static_cast<double>(by)); }

void Metrics::answered(const AnswerReport& report) {
  impl_->answers.count(report);
  impl_->queued.Observe(std::chrono::duration<double>(report.queued).count());
  impl_->answer_bytes.Increment(static_cast<double>(report.bytes));
  ++impl_->answers_made;
  impl_->cull_ns += report.cull.count();
}

void Metrics::superseded(std::size_t cameras) {
  if (cameras > 0) impl_->superseded.Increment(static_cast<double>(cameras));
}

void Metrics::refused(protocol::WireCode code) {
  impl_->errors.Add({{"code", protocol::wireCodeName(code)}}).Increment();
  ++impl_->errors_sent;
}

void Metrics::authFailed(const char* reason) {
  impl_->auth_failures.Add({{"reason", reason}}).Increment();
}
void Metrics::quotaRejected(const char* reason) {
  impl_->quota.Add({{"reason", reason}}).Increment();
}
void Metrics::handshakeFailed() { impl_->handshakes.Increment(); }
void Metrics::certificateExpires(std::int64_t unix_s) {
  impl_->certificate.Add({}).Set(static_cast<double>(unix_s));
}

void Metrics::edited() { impl_->edits.Increment(); }
void Metrics::paired(std::size_t pairs, std::size_t hidden, std::chrono::nanoseconds took) {
  impl_->pairs.Increment(static_cast<double>(pairs));
  impl_->hidden_pairs.Increment(static_cast<double>(hidden));
  impl_->pair_seconds.Increment(std::chrono::duration<double>(took).count());
}
void Metrics::received(std::size_t bytes) { impl_->received.Increment(static_cast<double>(bytes)); }

void Metrics::httpRequest(std::string_view method, unsigned status) {
  // A method is a client's word: only the known ones may become labels.
  const bool known = method == "GET" || method == "PUT" || method == "DELETE" || method == "HEAD" ||
                     method == "POST";
  impl_->http
      .Add({{"method", known ? std::string(method) : "other"}, {"code", std::to_string(status)}})
      .Increment();
}

void Metrics::scenesHeld(const std::set<std::string>& names, std::size_t damaged) {
  impl_->scenes.Set(static_cast<double>(names.size()));
  impl_->damaged.Set(static_cast<double>(damaged));
  impl_->answers.keepScenes(names);
}

void Metrics::configRead(bool good) {
  impl_->config_good.Set(good ? 1 : 0);
  if (good) impl_->config_time.SetToCurrentTime();
}

std::string Metrics::text() const {
  auto families = impl_->registry.Collect();
  auto process = processMetrics();
  std::move(process.begin(), process.end(), std::back_inserter(families));
  return prometheus::TextSerializer().Serialize(families);
}

std::vector<MethodUse> Metrics::usesOf(const std::string& scene) const {
  return impl_->answers.usesOf(scene);
}

Metrics::Totals Metrics::totals() const {
  Totals out;
  out.connections = impl_->connections.Value();
  out.sessions = impl_->sessions.Value();
  out.views = impl_->views.Value();
  out.answers = static_cast<double>(impl_->answers_made.load());
  out.answer_bytes = impl_->answer_bytes.Value();
  out.superseded = impl_->superseded.Value();
  out.errors = static_cast<double>(impl_->errors_sent.load());
  out.edits = impl_->edits.Value();
  out.cull_seconds = static_cast<double>(impl_->cull_ns.load()) * 1e-9;
  return out;
}

}  // namespace culld::server
