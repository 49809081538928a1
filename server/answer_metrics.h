// What is counted about answers, by scene, methods and guarantee (docs/protocol.md "Metrics").
#pragma once
#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "server/metrics.h"

namespace culld::server {

/// THREADS: any.
class AnswerMetrics {
 public:
  explicit AnswerMetrics(prometheus::Registry& registry);

  void count(const AnswerReport& report);
  std::vector<MethodUse> usesOf(const std::string& scene) const;
  /// Drops the series of all other scenes.
  void keepScenes(const std::set<std::string>& names);

 private:
  using Counter = prometheus::Counter;
  using Histogram = prometheus::Histogram;
  using Labels = prometheus::Labels;

  /// The series of one scene, method, its choice and guarantee; null until there is something to
  /// count.
  struct Series {
    std::string scene, made_by;
    Counter* answers[2] = {};  ///< by proven
    Counter* out_of_budget = nullptr;
    Counter* objects = nullptr;
    Counter* in_frustum = nullptr;
    Counter* seen = nullptr;
    Counter* kept = nullptr;
    Histogram* missed_px[2] = {};  ///< by proven
    Histogram* seconds = nullptr;
  };
  static Labels labelsOf(const AnswerReport& report);
  Series& seriesOf(const AnswerReport& report);
  void drop(const Series& series);

  prometheus::Family<Counter>& answers_;
  prometheus::Family<Counter>& out_of_budget_;
  prometheus::Family<Counter>& objects_;
  prometheus::Family<Counter>& in_frustum_;
  prometheus::Family<Counter>& seen_;
  prometheus::Family<Counter>& kept_;
  prometheus::Family<Histogram>& missed_px_;
  prometheus::Family<Histogram>& seconds_;
  mutable std::mutex mutex_;
  std::map<std::string, Series> series_;  ///< by all labels in one word
};

}  // namespace culld::server
