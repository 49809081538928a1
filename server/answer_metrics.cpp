#include "server/answer_metrics.h"

#include <utility>

#include "protocol/answer_file.h"

namespace culld::server {
namespace {

using prometheus::Registry;

prometheus::Family<prometheus::Counter>& counters(Registry& registry, const char* name,
                                                  const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

prometheus::Family<prometheus::Histogram>& histograms(Registry& registry, const char* name,
                                                      const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

prometheus::Labels with(prometheus::Labels labels, bool proven) {
  labels.emplace("proven", proven ? "true" : "false");
  return labels;
}

const prometheus::Histogram::BucketBoundaries kSeconds{
    0.00001, 0.00003, 0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0};
const prometheus::Histogram::BucketBoundaries kPixels{0, 1, 10, 100, 1000, 10'000, 100'000};

}  // namespace

AnswerMetrics::AnswerMetrics(Registry& registry)
    : answers_(counters(registry, "culld_answers_total", "Answers made")),
      out_of_budget_(counters(registry, "culld_answers_out_of_budget_total",
                              "Answers cut short because the time given ran out")),
      objects_(counters(registry, "culld_answer_objects_total", "Objects in answers")),
      in_frustum_(counters(registry, "culld_answer_in_frustum_objects_total",
                           "Objects not proven outside the frustum, where the method counts them")),
      seen_(counters(registry, "culld_answer_seen_objects_total",
                     "Objects in answers that are certainly visible, where the method tells")),
      kept_(counters(registry, "culld_answer_kept_objects_total",
                     "Objects in answers that were kept for safety, where the method tells")),
      missed_px_(histograms(registry, "culld_answer_missed_px",
                            "Visible pixels an answer may have lost: a bound where proven, else an "
                            "estimate")),
      seconds_(histograms(registry, "culld_cull_duration_seconds",
                          "Time in the culling method for one camera")) {}

AnswerMetrics::Labels AnswerMetrics::labelsOf(const AnswerReport& report) {
  return {{"scene", report.scene},
          {"method", std::string(report.method)},
          {"made_by", std::string(report.made_by)},
          {"guarantee", protocol::guaranteeName(report.guarantee)}};
}

AnswerMetrics::Series& AnswerMetrics::seriesOf(const AnswerReport& report) {
  std::string key = report.scene;
  key += ' ';  // none of the words holds one
  key += report.method;
  key += ' ';
  key += report.made_by;
  key += ' ';
  key += protocol::guaranteeName(report.guarantee);
  const auto [at, fresh] = series_.try_emplace(std::move(key));
  Series& series = at->second;
  if (fresh) {
    const Labels labels = labelsOf(report);
    series.scene = report.scene;
    series.made_by = report.made_by;
    series.out_of_budget = &out_of_budget_.Add(labels);
    series.objects = &objects_.Add(labels);
    series.seconds = &seconds_.Add(labels, kSeconds);
  }
  return series;
}

void AnswerMetrics::count(const AnswerReport& report) {
  const std::lock_guard lock(mutex_);
  Series& series = seriesOf(report);
  const std::size_t proven = report.proven ? 1 : 0;
  if (series.answers[proven] == nullptr) {
    const Labels labels = with(labelsOf(report), report.proven);
    series.answers[proven] = &answers_.Add(labels);
    series.missed_px[proven] = &missed_px_.Add(labels, kPixels);
  }
  series.answers[proven]->Increment();
  series.missed_px[proven]->Observe(static_cast<double>(report.missed_px));
  series.seconds->Observe(std::chrono::duration<double>(report.cull).count());
  series.objects->Increment(static_cast<double>(report.objects));
  if (report.out_of_budget) series.out_of_budget->Increment();
  if (report.in_frustum > 0 && series.in_frustum == nullptr) {
    series.in_frustum = &in_frustum_.Add(labelsOf(report));
  }
  if (report.seen + report.kept > 0 && series.seen == nullptr) {
    series.seen = &seen_.Add(labelsOf(report));
    series.kept = &kept_.Add(labelsOf(report));
  }
  if (series.in_frustum != nullptr) {
    series.in_frustum->Increment(static_cast<double>(report.in_frustum));
  }
  if (series.seen != nullptr) {
    series.seen->Increment(static_cast<double>(report.seen));
    series.kept->Increment(static_cast<double>(report.kept));
  }
}

std::vector<MethodUse> AnswerMetrics::usesOf(const std::string& scene) const {
  std::map<std::string, MethodUse> uses;
  const std::lock_guard lock(mutex_);
  for (const auto& [key, series] : series_) {
    if (series.scene != scene) continue;
    MethodUse& use = uses[series.made_by];
    use.method = series.made_by;
    for (const Counter* answers : series.answers) {
      if (answers != nullptr) use.answers += answers->Value();
    }
    use.out_of_budget += series.out_of_budget->Value();
    use.objects += series.objects->Value();
    use.cull_seconds += series.seconds->Collect().histogram.sample_sum;
  }
  std::vector<MethodUse> out;
  for (auto& [name, use] : uses) out.push_back(std::move(use));
  return out;
}

void AnswerMetrics::keepScenes(const std::set<std::string>& names) {
  const std::lock_guard lock(mutex_);
  for (auto at = series_.begin(); at != series_.end();) {
    if (names.contains(at->second.scene)) {
      ++at;
    } else {
      drop(at->second);
      at = series_.erase(at);
    }
  }
}

void AnswerMetrics::drop(const Series& series) {
  const auto remove = [](auto& family, auto* one) {
    if (one != nullptr) family.Remove(one);
  };
  for (const std::size_t proven : {0U, 1U}) {
    remove(answers_, series.answers[proven]);
    remove(missed_px_, series.missed_px[proven]);
  }
  remove(out_of_budget_, series.out_of_budget);
  remove(objects_, series.objects);
  remove(in_frustum_, series.in_frustum);
  remove(seen_, series.seen);
  remove(kept_, series.kept);
  remove(seconds_, series.seconds);
}

}  // namespace culld::server
