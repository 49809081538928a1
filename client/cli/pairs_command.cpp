// `cullctl pairs`: which viewers may see which targets?
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/commands.h"
#include "client/cli/places_file.h"
#include "culld/connection.h"

namespace culld::client {
namespace {

std::vector<std::size_t> targetsOf(const PairsOutcome& outcome, std::size_t viewer) {
  std::vector<std::size_t> targets;
  for (std::size_t t = 0; t < outcome.targets; ++t) {
    if (outcome.maySee(viewer, t)) targets.push_back(t);
  }
  return targets;
}

void printJson(const PairsArguments& a, const PairsOutcome& outcome) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t v = 0; v < outcome.viewers; ++v) rows.push_back(targetsOf(outcome, v));
  const nlohmann::json all{{"scene", a.scene},
                           {"version", outcome.scene_version},
                           {"viewers", outcome.viewers},
                           {"targets", outcome.targets},
                           {"may_see", rows},
                           {"out_of_budget", outcome.out_of_budget},
                           {"cull_ns", outcome.cull.count()}};
  std::cout << all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

void print(const PairsOutcome& outcome) {
  std::size_t kept = 0;
  for (std::size_t v = 0; v < outcome.viewers; ++v) {
    const auto targets = targetsOf(outcome, v);
    kept += targets.size();
    std::cout << "viewer " << v << ':';
    for (const std::size_t t : targets) std::cout << ' ' << t;
    std::cout << '\n';
  }
  const std::size_t pairs = outcome.viewers * outcome.targets;
  std::cout << pairs - kept << " of " << pairs << " pairs proven hidden in "
            << static_cast<double>(outcome.cull.count()) * 1e-3 << " us"
            << (outcome.out_of_budget ? ", cut short by the time limit" : "") << '\n';
}

}  // namespace

int runPairs(const Server& server, const PairsArguments& arguments) {
  auto viewers = readPlacesFile(arguments.viewers);
  if (!viewers) return fail(kUsage, viewers.error().message);
  auto targets = readPlacesFile(arguments.targets);
  if (!targets) return fail(kUsage, targets.error().message);
  auto opened = Connection::open(server.address, arguments.scene, server.once());
  if (!opened) return fail(opened.error());
  const auto outcome = opened.value()->pairs(std::move(viewers).value(), std::move(targets).value(),
                                             std::chrono::microseconds(arguments.time_us));
  if (!outcome) return fail(outcome.error());
  if (arguments.json) {
    printJson(arguments, outcome.value());
  } else {
    print(outcome.value());
  }
  return kFine;
}

}  // namespace culld::client
