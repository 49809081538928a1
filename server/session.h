// One client's conversation about one scene, without any I/O: bytes and time come in, actions go
// out. So it runs on a socket, under a fuzzer and in a simulation alike (docs/protocol.md).
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "protocol/messages.h"
#include "server/jobs.h"
#include "server/limits.h"
#include "server/pairs_job.h"
#include "server/quota.h"
#include "server/scene.h"

namespace culld::server {

/// What the client may do, as those know who let it in.
struct SessionRights {
  TenantPtr tenant;          ///< who pays for its cameras; none: nobody counts
  std::string edit_refusal;  ///< why it may not edit; empty: it may
};

/// Says which bytes have left, when the host reports them sent.
struct SendTag {
  enum class Kind : std::uint8_t { kReply, kAnswer, kNotice };
  Kind kind = Kind::kReply;
  std::uint32_t view = 0;
  std::uint64_t incarnation = 0;
};

struct Send {
  std::vector<std::uint8_t> bytes;
  SendTag tag;
  protocol::WireCode error = protocol::WireCode::kNone;  ///< of an ErrorReply
  std::optional<QuotaReason> quota = std::nullopt;       ///< of a kQuotaExceeded
};
struct StartCull {
  CullJob job;
};
struct StartEdit {
  EditJob job;
};
struct StartPairs {
  PairsJob job;
};
struct Close {
  std::uint16_t code = 1000;  ///< RFC 6455 §7.4.1
  std::string reason;
};
using Action = std::variant<Send, StartCull, StartEdit, StartPairs, Close>;
using Actions = std::vector<Action>;

/// GUARANTEES: at most one job and one unsent answer per view; a newer camera replaces a waiting
/// one; the newest camera of a view is answered, or refused with a reason: a fault, its deadline,
/// or that it was cancelled; edits of one client are applied in order and seen by its later
/// cameras and questions about pairs, which are answered one at a time. THREADS: one at a time.
class Session {
 public:
  Session(std::shared_ptr<Scene> scene, const SessionLimits& limits, std::string server_name,
          Time now, SessionRights rights = {});

  /// One binary message. Garbage gets an error message; the session goes on.
  Actions receive(std::span<const std::uint8_t> bytes, Time now);
  Actions receiveText();
  /// REQUIRES: `outcome` came of a StartCull of this session.
  Actions culled(CullOutcome outcome);
  Actions edited(EditDone done);
  /// REQUIRES: `outcome` came of a StartPairs of this session.
  Actions paired(PairsOutcome outcome);
  /// The bytes of a Send have left this process.
  Actions sent(const SendTag& tag);
  /// The scene was edited or replaced, by whomever.
  Actions sceneMoved();
  Actions tick(Time now);
  /// When tick() is due next; none: not before something else happens.
  std::optional<Time> nextTick() const;
  /// Nobody is left to read answers: culls that have not begun are given up.
  void hangUp();
  /// No further work is taken; what runs is finished. See drained().
  Actions goAway(const std::string& reason);

  bool drained() const noexcept;
  bool greeted() const noexcept { return greeted_; }
  std::size_t viewCount() const noexcept { return views_.size(); }
  const std::shared_ptr<Scene>& scene() const noexcept { return scene_; }

 private:
  struct WaitingCamera {
    std::uint64_t request_id = 0;
    Camera camera;
    Demand demand;
    Time received{0};
    std::optional<Time> deadline;
  };
  struct RunningCull {
    std::uint64_t request_id = 0;
    std::optional<Time> deadline;
    std::shared_ptr<JobGate> gate;
    bool refused = false;  ///< replied to already: its outcome is not sent
    bool queued = true;    ///< as far as is known: its deadline is to be watched
  };
  struct KeptFrame {
    std::uint32_t frame = 0;
    IdSetPtr visible;
  };
  struct View {
    std::uint64_t incarnation = 0;
    std::string method;
    bool want_seen = false;
    std::uint32_t last_frame = 0;
    std::uint32_t acked_frame = 0;  ///< 0: the client holds none
    std::uint32_t superseded = 0;
    std::optional<RunningCull> running;
    bool unsent = false;
    std::optional<WaitingCamera> mailbox;
    std::deque<KeptFrame> kept;  ///< ascending by frame
    std::shared_ptr<ViewMemory> memory = std::make_shared<ViewMemory>();
    std::chrono::nanoseconds last_took{0};
  };

  void handle(std::uint64_t id, const protocol::Hello& m);
  void handle(std::uint64_t id, const protocol::OpenView& m);
  void handle(std::uint64_t id, const protocol::CloseView& m);
  void handle(std::uint64_t id, const protocol::CameraUpdate& m);
  void handle(std::uint64_t id, protocol::Edit& m);
  void handle(std::uint64_t id, const protocol::Ping& m);
  void handle(std::uint64_t id, const protocol::Cancel& m);
  void handle(std::uint64_t id, protocol::Pairs& m);
  void dispatch(protocol::Message& message);

  void reply(std::uint64_t id, protocol::Body body);
  void fail(std::uint64_t id, protocol::WireCode code, const std::string& message);
  void giveUp(View& view);
  bool refusedByQuota(std::uint64_t id, const std::string& what);
  void startPairs();
  void cancelPairs(std::uint64_t request_id);
  bool full() const;
  std::string fullText() const;
  void refuseWaiting(std::uint32_t number, View& view, protocol::WireCode code, const char* why);
  void refuseRunning(std::uint32_t number, View& view, protocol::WireCode code, const char* why);
  void expire(std::uint32_t number, View& view);
  void acknowledge(View& view, std::uint32_t frame);
  void keep(View& view, std::uint32_t frame, IdSetPtr visible);
  void startCull(std::uint32_t number, View& view);
  void startCulls();
  void startEdit();
  void noticeScene();
  void forgetFrames();
  View* find(std::uint32_t number, std::uint64_t incarnation);
  Actions take() { return std::exchange(actions_, {}); }

  const std::shared_ptr<Scene> scene_;
  const SessionLimits limits_;
  const std::string server_name_;
  const SessionRights rights_;
  const Time started_;
  Time now_;
  bool greeted_ = false;
  bool leaving_ = false;
  bool closed_ = false;
  std::map<std::uint32_t, View> views_;
  std::uint64_t next_incarnation_ = 1;
  std::deque<EditJob> waiting_edits_;
  bool editing_ = false;
  std::deque<PairsJob> waiting_pairs_;
  struct RunningPairs {
    std::uint64_t request_id = 0;
    std::shared_ptr<JobGate> gate;
  };
  std::optional<RunningPairs> running_pairs_;
  std::size_t jobs_ = 0;  ///< that run: culls, those of closed views too, and questions about pairs
  std::size_t unsent_ = 0;  ///< messages not yet reported sent
  // What the client was last told about the scene.
  std::uint64_t told_epoch_ = 0;
  std::uint64_t told_version_ = 0;
  bool notice_unsent_ = false;
  Actions actions_;
};

}  // namespace culld::server
