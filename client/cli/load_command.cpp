// `cullctl load`: prints what a LoadRun found.
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/commands.h"
#include "client/cli/load_run.h"
#include "protocol/text.h"

namespace culld::client {
namespace {

using nlohmann::json;

constexpr std::pair<const char*, double> kQuantiles[] = {
    {"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p999", 0.999}};

double perAnswer(std::uint64_t total, const LoadResult& r) {
  return r.answered == 0 ? 0.0 : static_cast<double>(total) / static_cast<double>(r.answered);
}

void printJson(const LoadArguments& a, const LoadResult& r) {
  json latency{{"max", static_cast<double>(r.latency_ns.max()) * 1e-6}};
  for (const auto& [name, share] : kQuantiles) {
    latency[name] = static_cast<double>(r.latency_ns.quantile(share)) * 1e-6;
  }
  const json report{{"scene", a.cull.scene},
                    {"method", r.method},
                    {"clients", a.clients},
                    {"views", a.views},
                    {"rate_hz", a.rate_hz},
                    {"seconds", r.seconds},
                    {"radius_m", a.radius_m},
                    {"angle_rad", a.angle_rad},
                    {"due", r.due},
                    {"within_bound", r.within},
                    {"sent", r.sent},
                    {"answered", r.answered},
                    {"superseded", r.superseded},
                    {"late", r.late},
                    {"failed", r.failed},
                    {"unanswered", r.unanswered},
                    {"wrong", r.wrong},
                    {"compared", r.compared},
                    {"changes", r.deltas},
                    {"latency_ms", latency},
                    {"bytes_per_answer", perAnswer(r.bytes, r)},
                    {"cull_ms_mean", perAnswer(r.cull_ns, r) * 1e-6},
                    {"queue_ms_mean", perAnswer(r.queue_ns, r) * 1e-6},
                    {"first_error", r.first_error}};
  std::cout << report.dump(2, ' ', false, json::error_handler_t::replace) << '\n';
}

unsigned long long number(std::uint64_t value) { return value; }

void printText(const LoadArguments& a, const LoadResult& r) {
  std::printf("%s, method %s: %u clients x %u views at %g Hz, %.1f s\n", a.cull.scene.c_str(),
              r.method.c_str(), a.clients, a.views, a.rate_hz, r.seconds);
  std::printf("cameras: %llu due, %llu within the last answer's bound, %llu sent (%.1f/s)\n",
              number(r.due), number(r.within), number(r.sent),
              static_cast<double>(r.sent) / r.seconds);
  std::printf(
      "answered %llu, superseded %llu, late %llu, failed %llu, unanswered %llu, wrong %llu\n",
      number(r.answered), number(r.superseded), number(r.late), number(r.failed),
      number(r.unanswered), number(r.wrong));
  std::printf(
      "checked: count and hash of all answers, %llu of them as changes; %llu against the "
      "whole answer to the same camera\n",
      number(r.deltas), number(r.compared));
  std::printf("latency from the schedule, ms:");
  for (const auto& [name, share] : kQuantiles) {
    std::printf(" %s %.3f", name, static_cast<double>(r.latency_ns.quantile(share)) * 1e-6);
  }
  std::printf(" max %.3f\n", static_cast<double>(r.latency_ns.max()) * 1e-6);
  std::printf("an answer, mean: %.0f bytes, %.3f ms in the cull, %.3f ms before it\n",
              perAnswer(r.bytes, r), perAnswer(r.cull_ns, r) * 1e-6,
              perAnswer(r.queue_ns, r) * 1e-6);
  if (!r.first_error.empty()) {
    std::printf("first error: %s\n", protocol::oneLine(r.first_error).c_str());
  }
}

}  // namespace

int runLoad(const Server& server, const LoadArguments& arguments) {
  LoadRun run;
  if (const int code = run.start(server, arguments); code != kFine) return code;
  const LoadResult result = run.run();
  if (arguments.json) {
    printJson(arguments, result);
  } else {
    printText(arguments, result);
  }
  const bool whole = result.within + result.sent == result.due;
  return whole && result.wrong == 0 && result.failed == 0 && result.unanswered == 0 ? kFine
                                                                                    : kFailed;
}

}  // namespace culld::client
