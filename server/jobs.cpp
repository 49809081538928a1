#include "server/jobs.h"

#include <algorithm>
#include <exception>

#include "protocol/codec.h"
#include "protocol/text.h"
#include "server/translate.h"

namespace culld::server {
namespace {

using protocol::Message;
using protocol::WireCode;

std::vector<std::uint8_t> errorMessage(std::uint64_t request_id, WireCode code,
                                       const std::string& what) {
  return protocol::encode(Message{request_id, protocol::ErrorReply{code, protocol::oneLine(what)}});
}

/// What the job asks for, within the time that is left; nothing when none is.
std::optional<Demand> demandBy(const CullJob& job, std::chrono::nanoseconds now) {
  Demand demand = job.demand;
  if (!job.deadline) return demand;
  const auto left = *job.deadline - now;
  if (left <= std::chrono::nanoseconds(0)) return std::nullopt;
  if (demand.time == std::chrono::nanoseconds(0) || left < demand.time) demand.time = left;
  return demand;
}

std::string place(const CullJob& job) { return "view " + std::to_string(job.view) + ": "; }

/// A culler's memory may describe the snapshot it was made for. Another culler means another
/// version of the same scene: a scene that was replaced brings another ViewMemory.
ViewState& stateFor(ViewMemory& memory, const std::shared_ptr<const Culler>& culler) {
  if (memory.culler != culler) {
    memory.state.sceneEdited();
    memory.culler = culler;
  }
  return memory.state;
}

AnswerReport reportOn(const CullJob& job, const Method& method, const Answer& answer) {
  AnswerReport report;
  report.scene = job.scene_name;
  report.method = method.info().name;
  report.made_by = answer.made_by.empty() ? report.method : answer.made_by;
  report.guarantee = toWire(answer.guarantee);
  report.missed_px = answer.missed_px;
  report.proven = answer.proven;
  report.out_of_budget = answer.out_of_budget;
  report.cull = answer.stats.time;
  report.objects = answer.visible.size();
  report.in_frustum = answer.stats.in_frustum;
  report.seen = static_cast<std::size_t>(
      std::count_if(answer.seen.begin(), answer.seen.end(), [](auto flag) { return flag != 0; }));
  report.kept = answer.seen.size() - report.seen;
  return report;
}

protocol::Answer answerMessage(const CullJob& job, const Method& method, Answer& answer,
                               const AnswerReport& report, std::chrono::nanoseconds queued) {
  protocol::Answer out;
  out.view = job.view;
  out.frame = job.frame;
  out.scene_version = job.scene->snapshot()->version();
  out.scene_objects = static_cast<std::uint32_t>(job.scene->snapshot()->objectCount());
  protocol::EncodedSet set = job.baseline ? protocol::encodeSmallest(*job.baseline, answer.visible)
                                          : protocol::encodeSmallest(answer.visible);
  out.baseline = set.encoding == protocol::Encoding::kAddRemove ? job.baseline_frame : 0;
  out.encoding = set.encoding;
  out.payload = std::move(set.payload);
  out.object_count = static_cast<std::uint32_t>(answer.visible.size());
  out.set_hash = protocol::setHash(answer.visible);
  out.guarantee = toWire(answer.guarantee);
  out.missed_px = answer.missed_px;
  out.proven = answer.proven;
  out.out_of_budget = answer.out_of_budget;
  out.method = std::string(method.info().name);
  out.note = std::move(answer.note);
  out.superseded = job.superseded;
  if (job.want_seen) out.seen = packBits(answer.seen);
  out.seen_count = static_cast<std::uint32_t>(report.seen);
  out.kept_count = static_cast<std::uint32_t>(report.kept);
  out.made_by = std::string(answer.made_by);
  out.stats = toWire(answer.stats, queued);
  return out;
}

void cullInto(CullOutcome& outcome, const Clock& clock) {
  const CullJob& job = outcome.job;
  const auto fail = [&](WireCode code, const std::string& what) {
    outcome.error = code;
    outcome.message = errorMessage(job.request_id, code, place(job) + what);
  };
  const std::string late = "the cull could not begin before the deadline";
  if (!demandBy(job, clock.now())) return fail(WireCode::kDeadlineExceeded, late);
  const auto method = job.scene->method(job.method);
  if (!method) {
    return fail(toWire(method.error().code, WireCode::kUnknownMethod), method.error().message);
  }
  const auto culler = job.scene->culler(*method.value());
  if (!culler) {
    return fail(toWire(culler.error().code, WireCode::kUnsupported), culler.error().message);
  }
  ViewState& state = stateFor(*job.memory, culler.value());
  const auto begun = clock.now();
  const auto demand = demandBy(job, begun);  // preparing the culler may have taken its time
  if (!demand) return fail(WireCode::kDeadlineExceeded, late);
  const auto queued = begun - job.received;
  Answer answer = culler.value()->cull(job.camera, *demand, state);
  outcome.report = reportOn(job, *method.value(), answer);
  outcome.report.queued = queued;
  outcome.message = protocol::encode(
      {job.request_id, answerMessage(job, *method.value(), answer, outcome.report, queued)});
  outcome.report.bytes = outcome.message.size();
  outcome.visible = std::make_shared<const protocol::IdSet>(std::move(answer.visible));
}

EditDone editRefused(const EditJob& job, WireCode code, const std::string& what) {
  return {errorMessage(job.request_id, code, what), code, false};
}

EditDone editDone(const EditJob& job, const Result<EditOutcome>& edited) {
  if (!edited) {
    const WireCode code = edited.error().code == ErrorCode::kUnavailable
                              ? WireCode::kConflict
                              : toWire(edited.error().code, WireCode::kInvalidEdit);
    return editRefused(job, code, edited.error().message);
  }
  const EditOutcome& outcome = edited.value();
  return {protocol::encode({job.request_id, protocol::Edited{outcome.version, outcome.added}}),
          WireCode::kNone, true};
}

}  // namespace

CullOutcome runCull(CullJob job, const Clock& clock) {
  const auto started = clock.now();
  CullOutcome outcome;
  outcome.job = std::move(job);
  if (!outcome.job.gate->begin()) return outcome;
  try {
    cullInto(outcome, clock);
  } catch (const std::exception& failure) {
    outcome.visible = nullptr;
    outcome.error = WireCode::kInternal;
    outcome.message = errorMessage(outcome.job.request_id, WireCode::kInternal,
                                   place(outcome.job) + failure.what());
  }
  outcome.took = clock.now() - started;
  return outcome;
}

std::vector<EditDone> runEdits(Scene& scene, std::span<const EditJob> jobs) {
  std::vector<EditDone> done;
  try {
    std::vector<EditRequest> requests;
    for (const EditJob& job : jobs) requests.push_back({toEngine(job.edits), job.expected_version});
    const auto outcomes = scene.edit(requests);
    for (std::size_t i = 0; i < jobs.size(); ++i) done.push_back(editDone(jobs[i], outcomes[i]));
  } catch (const std::exception& failure) {
    // What was answered was not sent: all of them hear the same.
    done.clear();
    for (const EditJob& job : jobs) {
      done.push_back(editRefused(job, WireCode::kInternal, failure.what()));
    }
  }
  return done;
}

}  // namespace culld::server
