// A Session and a model of what docs/protocol.md promises about it: whatever the session does is
// held against the model at once. Who plays the client, the workers and the socket decides what
// happens.
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "tests/unit/server/session_fixture.h"

namespace culld::server {

using Random = std::mt19937_64;

/// What was asked, and what has come of it.
struct Asked {
  enum class Kind : std::uint8_t { kCamera, kEdit, kOther };
  Kind kind = Kind::kOther;
  std::uint64_t incarnation = 0;  ///< of a camera's view
  std::optional<Time> deadline{};
  bool cancelled = false;  ///< Cancel was said
  bool replied = false;
  bool refused = false;           ///< by an ErrorReply
  bool begun = false;             ///< its cull or edit was given to a worker
  std::vector<ObjectId> right{};  ///< of a camera that is culled: what the answer must be
  std::uint64_t epoch = 0;
};

/// A view as its client knows it.
struct Seen {
  bool open = true;
  std::vector<std::uint64_t> cameras;  ///< valid ones, in order
  std::map<std::uint32_t, wire::IdSet> frames;
  std::uint32_t newest_frame = 0;
  std::uint64_t last_answered = 0;
  std::uint32_t superseded = 0;
  bool culling = false;
  bool unsent = false;
};

/// What all seeds together came upon: a simulation in which nothing happens keeps every promise.
struct Tally {
  std::uint64_t answers = 0, changes = 0, superseded = 0, edited = 0, replaced = 0, gone = 0;
  std::map<wire::WireCode, std::uint64_t> refusals;
};

/// One conversation: a Session, and the model that it is held against.
class Conversation {
 public:
  Conversation(std::shared_ptr<Scene> scene, const SessionLimits& limits, TestClock& clock,
               Tally& tally)
      : tally_(tally),
        scene_(std::move(scene)),
        limits_(limits),
        clock_(clock),
        session_(scene_, limits, "simulated", clock.time) {
    told_epoch_ = scene_->current()->epoch();
    say(wire::Hello{1, 1, "simulated", wire::kFeatureCancel}, {});
  }

  // --- what a client may do ---

  void openView(std::uint32_t number) {
    const bool fits = numbers_.contains(number) || numbers_.size() < limits_.max_views;
    if (fits) {
      close(number);
      ++incarnations_;
      numbers_[number] = incarnations_;
      views_[incarnations_];
    }
    say(wire::OpenView{number, "", false}, {});
  }
  void closeView(std::uint32_t number) {
    close(number);
    say(wire::CloseView{number}, {});
  }
  void sendCamera(std::uint32_t number, double x, std::chrono::microseconds deadline,
                  bool acknowledges) {
    wire::CameraUpdate update{number, cameraAt(x), {}, 0};
    update.deadline_us = static_cast<std::uint32_t>(deadline.count());
    Asked asked{Asked::Kind::kCamera};
    if (deadline.count() > 0) asked.deadline = clock_.time + deadline;
    const auto at = numbers_.find(number);
    if (at != numbers_.end()) {
      asked.incarnation = at->second;
      Seen& view = views_[at->second];
      view.cameras.push_back(last_id_ + 1);
      if (acknowledges) update.ack_frame = view.newest_frame;
    }
    say(update, asked);
  }
  void sendEdit(wire::EditItem item) { say(wire::Edit{0, {item}}, {Asked::Kind::kEdit}); }
  void cancel(std::uint64_t back) {
    if (back >= last_id_) return;
    const std::uint64_t id = last_id_ - back;
    const auto at = asked_.find(id);
    if (at != asked_.end()) at->second.cancelled = true;
    ++last_id_;
    absorb(session_.receive(wire::encode({last_id_, wire::Cancel{id}}), clock_.time));
    if (at == asked_.end()) return;
    const Asked& asked = at->second;
    if (asked.kind == Asked::Kind::kEdit) {
      EXPECT_TRUE(asked.replied || asked.begun) << "edit " << id << " was not cancelled in time";
    }
    const auto view = views_.find(asked.incarnation);
    if (view != views_.end() && view->second.open && view->second.cameras.back() == id) {
      EXPECT_TRUE(asked.replied) << "camera " << id << " was not cancelled";
    }
  }
  void garbage(Random& random) {
    std::vector<std::uint8_t> bytes(random() % 64);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    absorb(session_.receive(bytes, clock_.time));
  }
  void hangUp() {
    gone_ = true;
    ++tally_.gone;
    session_.hangUp();
  }

  // --- what happens around it ---

  void tick() {
    const auto next = session_.nextTick();
    if (!next || *next > clock_.time) return;
    absorb(session_.tick(clock_.time));
    for (const auto& [incarnation, view] : views_) {
      if (gone_ || !view.open || view.cameras.empty()) continue;
      const Asked& newest = asked_[view.cameras.back()];
      const bool late = newest.deadline && *newest.deadline <= clock_.time && !newest.begun;
      EXPECT_TRUE(newest.replied || !late) << "a camera waits past its deadline";
    }
  }
  void sceneMoved() {
    if (!gone_) absorb(session_.sceneMoved());
  }
  void goAway() {
    leaving_ = true;
    absorb(session_.goAway("over"));
  }
  bool finishCull(std::size_t which) {
    if (culls_.empty()) return false;
    const auto at = culls_.begin() + static_cast<std::ptrdiff_t>(which % culls_.size());
    CullJob job = std::move(*at);
    culls_.erase(at);
    views_[job.incarnation].culling = false;
    absorb(session_.culled(runCull(std::move(job), clock_)));
    return true;
  }
  /// True if the scene has changed.
  bool finishEdit() {
    if (edits_.empty()) return false;
    const EditJob job = std::move(edits_.front());
    edits_.clear();
    EditDone done = std::move(runEdits(*scene_, {&job, 1}).front());
    const bool changed = done.changed;
    absorb(session_.edited(std::move(done)));
    return changed;
  }
  bool reportSent() {
    if (unsent_.empty()) return false;
    const SendTag tag = unsent_.front();
    unsent_.pop_front();
    if (tag.kind == SendTag::Kind::kAnswer) views_[tag.incarnation].unsent = false;
    absorb(session_.sent(tag));
    return true;
  }
  bool busy() const { return !culls_.empty() || !edits_.empty() || !unsent_.empty(); }
  bool hasOpen(std::uint32_t number) const { return numbers_.contains(number); }
  bool gone() const { return gone_; }
  bool leaving() const { return leaving_; }

  /// REQUIRES: nothing is under way.
  void checkRest() {
    EXPECT_TRUE(session_.drained());
    if (gone_) return;
    EXPECT_EQ(session_.nextTick(), std::nullopt);
    for (const auto& [id, asked] : asked_) {
      if (asked.kind != Asked::Kind::kCamera) {
        EXPECT_TRUE(asked.replied) << "request " << id << " has no reply";
      }
    }
    for (const auto& [incarnation, view] : views_) checkView(view);
  }

 private:
  void checkView(const Seen& view) {
    if (!view.open || view.cameras.empty()) return;
    const Asked& newest = asked_[view.cameras.back()];
    EXPECT_TRUE(newest.replied) << "camera " << view.cameras.back() << " is the newest";
    std::uint32_t silent = 0;
    for (const std::uint64_t id : view.cameras) silent += asked_[id].replied ? 0U : 1U;
    EXPECT_LE(view.superseded, silent);
    if (newest.replied && !newest.refused) {
      EXPECT_EQ(view.superseded, silent);
    }
  }

  void close(std::uint32_t number) {
    const auto at = numbers_.find(number);
    if (at == numbers_.end()) return;
    views_[at->second].open = false;
    numbers_.erase(at);
  }

  void say(wire::Body body, Asked asked) {
    asked_[++last_id_] = std::move(asked);
    absorb(session_.receive(wire::encode({last_id_, std::move(body)}), clock_.time));
  }

  void absorb(Actions actions) {
    for (Action& action : actions) {
      if (auto* send = std::get_if<Send>(&action)) {
        sent(*send);
        unsent_.push_back(send->tag);
      } else if (auto* cull = std::get_if<StartCull>(&action)) {
        startCull(std::move(cull->job));
      } else if (auto* edit = std::get_if<StartEdit>(&action)) {
        EXPECT_TRUE(edits_.empty()) << "edits of a client come one after another";
        EXPECT_FALSE(asked_[edit->job.request_id].replied)
            << "an edit that was given up is applied";
        asked_[edit->job.request_id].begun = true;
        edits_.push_back(std::move(edit->job));
      } else {
        ADD_FAILURE() << "closed though Hello was said";
      }
    }
    EXPECT_LE(culls_.size() + edits_.size(), limits_.max_requests_in_flight);
  }

  void startCull(CullJob job) {
    Seen& view = views_[job.incarnation];
    EXPECT_TRUE(view.open) << "a view that is closed is culled";
    EXPECT_FALSE(view.culling) << "two culls of a view at once";
    EXPECT_FALSE(view.unsent) << "a cull while an answer has not left";
    view.culling = true;
    Asked& asked = asked_[job.request_id];
    EXPECT_FALSE(asked.replied) << "a camera that has its reply is culled";
    EXPECT_EQ(asked.incarnation, job.incarnation);
    asked.begun = true;
    for (const auto& [id, other] : asked_) {
      if (id >= job.request_id) break;
      if (other.kind == Asked::Kind::kEdit) {
        EXPECT_TRUE(other.replied) << "a camera is culled before an edit that was sent before it";
      }
    }
    asked.right = fakeVisible(*job.scene->snapshot(), job.camera.origin_world.x);
    asked.epoch = job.scene->epoch();
    if (asked.epoch == edited_epoch_) {
      EXPECT_GE(job.scene->snapshot()->version(), edited_version_) << "its own edit is not seen";
    }
    culls_.push_back(std::move(job));
  }

  void sent(const Send& send) {
    const auto message = wire::decode(send.bytes, wire::kMaxReplyBytes);
    ASSERT_TRUE(message.ok()) << message.error().message;
    const std::uint64_t id = message.value().id;
    const auto& body = message.value().body;
    if (const auto* changed = std::get_if<wire::SceneChanged>(&body)) return moved(*changed);
    if (id == 0) return;  // GoAway, and errors about garbage
    Asked& asked = asked_[id];
    EXPECT_FALSE(asked.replied) << "request " << id << " has two replies";
    asked.replied = true;
    if (const auto* error = std::get_if<wire::ErrorReply>(&body)) return refused(asked, *error);
    if (const auto* edited = std::get_if<wire::Edited>(&body)) {
      EXPECT_TRUE(asked.kind == Asked::Kind::kEdit && asked.begun);
      ++tally_.edited;
      edited_version_ = edited->scene_version;
      edited_epoch_ = scene_->current()->epoch();
      return;
    }
    if (const auto* answer = std::get_if<wire::Answer>(&body)) {
      answered(id, asked, *answer, views_[send.tag.incarnation]);
    }
  }

  void moved(const wire::SceneChanged& changed) {
    if (!changed.replaced) return;
    ++tally_.replaced;
    told_epoch_ = scene_->current()->epoch();
    for (auto& [incarnation, view] : views_) {
      view.frames.clear();  // the client may still acknowledge one: it has not read this yet
    }
  }

  void refused(Asked& asked, const wire::ErrorReply& error) {
    asked.refused = true;
    ++tally_.refusals[error.code];
    if (error.code == wire::WireCode::kCancelled) {
      EXPECT_TRUE(asked.cancelled) << "nobody cancelled it";
    }
    if (error.code == wire::WireCode::kDeadlineExceeded) {
      EXPECT_TRUE(asked.deadline && *asked.deadline <= clock_.time) << "before its deadline";
    }
    EXPECT_NE(error.code, wire::WireCode::kInternal) << error.message;
  }

  void answered(std::uint64_t id, const Asked& asked, const wire::Answer& answer, Seen& view) {
    EXPECT_TRUE(view.open) << "an answer of a view that is closed";
    EXPECT_FALSE(view.unsent) << "two answers of a view on their way";
    view.unsent = true;
    EXPECT_GT(id, view.last_answered) << "older than the answer before it";
    view.last_answered = id;
    view.superseded += answer.superseded;
    ++tally_.answers;
    tally_.changes += answer.baseline != 0 ? 1U : 0U;
    tally_.superseded += answer.superseded;
    EXPECT_EQ(asked.epoch, told_epoch_) << "an answer of a scene that was not announced";
    EXPECT_GT(answer.frame, view.newest_frame);
    ASSERT_TRUE(answer.baseline == 0 || view.frames.contains(answer.baseline))
        << "a change of a frame that was never sent";
    const auto set = wire::decodeSet(answer.encoding, answer.payload, answer.scene_objects,
                                     view.frames[answer.baseline]);
    ASSERT_TRUE(set.ok()) << set.error().message;
    EXPECT_EQ(set.value(), asked.right);
    EXPECT_EQ(wire::setHash(set.value()), answer.set_hash);
    view.frames[answer.frame] = set.value();
    view.newest_frame = answer.frame;
  }

  Tally& tally_;
  const std::shared_ptr<Scene> scene_;
  const SessionLimits limits_;
  TestClock& clock_;
  Session session_;
  std::uint64_t told_epoch_ = 0;
  std::uint64_t edited_version_ = 0, edited_epoch_ = 0;
  std::uint64_t last_id_ = 0, incarnations_ = 0;
  bool gone_ = false, leaving_ = false;
  std::map<std::uint64_t, Asked> asked_;
  std::map<std::uint32_t, std::uint64_t> numbers_;  ///< open views: incarnation by number
  std::map<std::uint64_t, Seen> views_;             ///< by incarnation
  std::vector<CullJob> culls_;
  std::vector<EditJob> edits_;
  std::deque<SendTag> unsent_;
};

}  // namespace culld::server
