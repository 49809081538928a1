#include "server/fair_queue.h"

#include <algorithm>
#include <utility>

namespace culld::server {
namespace {

/// What a round gives each tenant: about one cull, so that turns are short.
constexpr std::chrono::nanoseconds kQuantum{1'000'000};

}  // namespace

void FairQueue::push(std::string payer, std::function<void()> work) {
  flowOf(payer).waiting.push_back(std::move(work));
  ++waiting_;
}

std::optional<FairQueue::Item> FairQueue::pop() {
  if (empty()) return std::nullopt;
  const auto may_run = [](const Flow& flow) {
    return !flow.waiting.empty() && flow.deficit.count() > 0;
  };
  auto next = std::find_if(flows_.begin(), flows_.end(), may_run);
  if (next == flows_.end()) {
    grant();
    next = std::find_if(flows_.begin(), flows_.end(), may_run);
  }
  Item item{next->payer, std::move(next->waiting.front())};
  next->waiting.pop_front();
  --waiting_;
  return item;
}

/// As many rounds at once as it takes until somebody who has work may run.
void FairQueue::grant() {
  auto least = std::chrono::nanoseconds::max();
  for (const Flow& flow : flows_) {
    if (!flow.waiting.empty()) least = std::min(least, -flow.deficit);
  }
  const auto given = (least / kQuantum + 1) * kQuantum;
  for (Flow& flow : flows_) {
    flow.deficit += given;
    // Credit is not saved up: who was away gets no more than who was here.
    flow.deficit = std::min(flow.deficit, kQuantum);
  }
  std::erase_if(flows_,
                [](const Flow& flow) { return flow.waiting.empty() && flow.deficit.count() > 0; });
}

void FairQueue::charge(const std::string& payer, std::chrono::nanoseconds cost) {
  Flow& flow = flowOf(payer);
  flow.deficit -= cost;
  if (flow.deficit.count() > 0) return;
  // Its turn is over: behind the others.
  const auto at = std::find_if(flows_.begin(), flows_.end(),
                               [&payer](const Flow& other) { return other.payer == payer; });
  flows_.splice(flows_.end(), flows_, at);
}

FairQueue::Flow& FairQueue::flowOf(const std::string& payer) {
  const auto at = std::find_if(flows_.begin(), flows_.end(),
                               [&payer](const Flow& flow) { return flow.payer == payer; });
  if (at != flows_.end()) return *at;
  return flows_.emplace_back(Flow{payer, kQuantum, {}});
}

void FairQueue::clear() {
  flows_.clear();
  waiting_ = 0;
}

}  // namespace culld::server
