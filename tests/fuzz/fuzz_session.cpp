// A client that does anything at all, against the session core: messages, garbage, jobs that finish
// late, sockets that stall. What a session promises is checked after every step.
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>

#include "protocol/codec.h"
#include "server/session.h"
#include "tests/unit/server/fake_method.h"

namespace {

using namespace culld;
using namespace culld::server;
namespace wire = culld::protocol;

void require(bool holds) {
  if (!holds) std::abort();
}

/// Reads numbers off the input; zeros past its end.
class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool done() const { return bytes_.empty(); }
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t value = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::span<const std::uint8_t> bytes(std::size_t count) {
    const auto part = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(part.size());
    return part;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

class PlayClock final : public Clock {
 public:
  Time time{0};
  Time now() const noexcept override { return time; }
};

class Play {
 public:
  explicit Play(Script script) : script_(script) {
    limits_.max_views = 3;
    limits_.max_edits_per_request = 4;
    limits_.max_waiting_edits = 2;
    limits_.kept_frames = 3;
    limits_.max_requests_in_flight = 6;
  }

  void run() {
    while (!script_.done()) step();
    finish();
  }

 private:
  void step() {
    const std::uint8_t kind = script_.byte();
    // Not cases below: old inputs keep their meaning.
    if (kind >= 240) return sayCancel();
    if (kind >= 236) return sayPairs();
    if (kind >= 234) return finishPairs();
    switch (kind % 10) {
      case 0:
        return say(wire::Hello{script_.byte() % 3U, script_.byte() % 3U, "f"});
      case 1:
        return say(wire::OpenView{script_.byte() % 5U, "", (script_.byte() & 1) != 0});
      case 2:
        return say(wire::CloseView{script_.byte() % 5U});
      case 3:
        return sayCamera();
      case 4:
        return sayEdit();
      case 5:
        return finishCull();
      case 6:
        return finishEdit();
      case 7:
        return reportSent();
      case 8:
        return disturb();
      default: {
        const auto bytes = script_.bytes(script_.byte());
        if (wire::decode(bytes, limits_.max_message_bytes).ok()) return;  // said above, with ids
        return absorb(session_.receive(bytes, clock_.time));
      }
    }
  }

  void sayCamera() {
    wire::CameraUpdate update;
    update.view = script_.byte() % 5U;
    update.ack_frame = script_.byte() % 8U;
    wire::LookAt look;
    look.eye = {static_cast<double>(script_.byte()), 0, 5};
    const std::uint8_t more = script_.byte();
    look.target = {0, 0, static_cast<double>(more % 3)};
    if (more >= 128) update.deadline_us = 1U << (more % 32U);
    update.camera.pose = look;
    say(update);
  }

  void sayPairs() {
    const auto places = [this](std::size_t count) {
      std::vector<wire::Place> made(count);
      for (wire::Place& place : made) {
        place.min = {static_cast<double>(script_.byte()), 0.25, script_.byte() - 128.0};
        place.max = place.min;
        place.max[0] += script_.byte() % 4 - 1.0;  // sometimes no box
      }
      return made;
    };
    const std::uint8_t counts = script_.byte();
    say(wire::Pairs{places(counts % 4U), places(counts / 4U % 8U), 0});
  }

  void sayCancel() {
    const std::uint64_t back = script_.byte() % 8U;
    if (back >= last_id_) return;
    cancelled_.insert(last_id_ - back);
    say(wire::Cancel{last_id_ - back});
  }

  void sayEdit() {
    wire::Edit edit;
    for (int i = script_.byte() % 6; i > 0; --i) {
      edit.edits.push_back({static_cast<wire::EditKind>(script_.byte() % 5),
                            script_.byte() % 40U,
                            {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
    }
    say(edit);
  }

  /// The scene moves under the session, time passes, text comes in, the server leaves.
  void disturb() {
    const std::uint8_t kind = script_.byte();
    if (kind >= 250) return hangUp();
    switch (kind % 5) {
      case 0:
        scene_->replace(rowOfObjects(30 + script_.byte() % 4U));
        break;
      case 1:
        absorb(session_.sceneMoved());
        break;
      case 2:
        clock_.time += std::chrono::milliseconds(script_.byte() * 20);
        absorb(session_.tick(clock_.time));
        break;
      case 3:
        absorb(session_.receiveText());
        break;
      default:
        absorb(session_.goAway("over"));
        break;
    }
  }

  /// Whoever is gone says nothing more.
  void hangUp() {
    gone_ = true;
    session_.hangUp();
    require(!session_.greeted() || !session_.nextTick());
  }

  void finishCull() {
    if (culls_.empty()) return;
    const std::size_t which = script_.byte() % culls_.size();
    CullJob job = std::move(culls_[which]);
    culls_.erase(culls_.begin() + static_cast<std::ptrdiff_t>(which));
    running_.erase(job.incarnation);
    absorb(session_.culled(runCull(std::move(job), clock_)));
  }

  void finishPairs() {
    if (pairs_.empty()) return;
    PairsJob job = std::move(pairs_.front());
    pairs_.pop_front();
    absorb(session_.paired(runPairs(std::move(job), clock_)));
  }

  void finishEdit() {
    if (edits_.empty()) return;
    EditJob job = std::move(edits_.front());
    edits_.pop_front();
    absorb(session_.edited(runEdits(*scene_, {&job, 1}).front()));
  }

  void reportSent() {
    if (unsent_.empty()) return;
    const SendTag tag = unsent_.front();
    unsent_.pop_front();
    if (tag.kind == SendTag::Kind::kAnswer) waiting_answers_.erase(tag.incarnation);
    absorb(session_.sent(tag));
  }

  void say(wire::Body body) {
    if (gone_) return;
    absorb(session_.receive(wire::encode({++last_id_, std::move(body)}), clock_.time));
  }

  void absorb(Actions actions) {
    for (Action& action : actions) {
      if (auto* send = std::get_if<Send>(&action)) {
        require(!closed_);
        check(*send);
        unsent_.push_back(send->tag);
      } else if (auto* cull = std::get_if<StartCull>(&action)) {
        require(running_.insert(cull->job.incarnation).second);
        require(!waiting_answers_.contains(cull->job.incarnation));
        culls_.push_back(std::move(cull->job));
      } else if (auto* edit = std::get_if<StartEdit>(&action)) {
        require(edits_.empty());
        edits_.push_back(std::move(edit->job));
      } else if (auto* pairs = std::get_if<StartPairs>(&action)) {
        pairs_.push_back(std::move(pairs->job));
      } else {
        closed_ = true;
      }
    }
  }

  /// An answer is decoded as a client would, with the frames it was sent.
  void check(const Send& send) {
    const auto message = wire::decode(send.bytes, wire::kMaxReplyBytes);
    require(message.ok());
    if (const auto* changed = std::get_if<wire::SceneChanged>(&message.value().body)) {
      if (changed->replaced) held_.clear();
    }
    const std::uint64_t id = message.value().id;
    if (const auto* error = std::get_if<wire::ErrorReply>(&message.value().body)) {
      require(error->code != wire::WireCode::kCancelled || cancelled_.contains(id));
      require(error->code != wire::WireCode::kCancelled || replied_.insert(id).second);
    }
    if (std::holds_alternative<wire::PairsAnswer>(message.value().body)) {
      require(replied_.insert(id).second);
    }
    const auto* answer = std::get_if<wire::Answer>(&message.value().body);
    if (answer == nullptr) return;
    require(replied_.insert(id).second);
    require(waiting_answers_.insert(send.tag.incarnation).second);
    auto& frames = held_[send.tag.incarnation];
    require(answer->baseline == 0 || frames.contains(answer->baseline));
    const auto ids = wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects,
                                     frames[answer->baseline]);
    require(ids.ok() && wire::setHash(ids.value()) == answer->set_hash);
    require(ids.value().size() == answer->object_count);
    frames[answer->frame] = ids.value();
  }

  /// The socket and the workers catch up: the session must come to rest.
  void finish() {
    for (int i = 0; i < 1000 && !idle(); ++i) {
      finishCull();
      finishPairs();
      finishEdit();
      reportSent();
    }
    require(idle());
    require(closed_ || session_.drained());
  }

  bool idle() const {
    return culls_.empty() && edits_.empty() && pairs_.empty() && unsent_.empty();
  }

  Script script_;
  FakeMethod fake_;
  const Method* table_[1] = {&fake_};
  std::shared_ptr<Scene> scene_ = std::make_shared<Scene>("f", Methods(table_), rowOfObjects(32));
  SessionLimits limits_;
  Session session_{scene_, limits_, "fuzz", Time(0)};
  PlayClock clock_;
  std::uint64_t last_id_ = 0;
  bool closed_ = false;
  bool gone_ = false;
  std::set<std::uint64_t> cancelled_;
  std::set<std::uint64_t> replied_;  ///< answered or cancelled
  std::vector<CullJob> culls_;
  std::deque<EditJob> edits_;
  std::deque<PairsJob> pairs_;
  std::deque<SendTag> unsent_;
  std::set<std::uint64_t> running_;
  std::set<std::uint64_t> waiting_answers_;
  std::map<std::uint64_t, std::map<std::uint32_t, wire::IdSet>> held_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Play(Script({data, size})).run();
  return 0;
}
