// The messages as plain structs: what a program handles, free of FlatBuffers (codec.h makes bytes
// of them). The fields' meaning is docs/protocol.md; names and
// order follow schema/culld.fbs.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/limits.h"
#include "protocol/result.h"

namespace culld::protocol {

enum class Guarantee : std::uint8_t { kConservative, kHole, kSampled, kApproximate };
enum class Encoding : std::uint8_t { kRawU32, kDeltaVarint, kTwoLevelBitset, kAddRemove };
enum class EditKind : std::uint8_t { kMove, kHide, kShow, kRemove, kAdd };

struct Limits {
  std::uint32_t max_message_bytes = static_cast<std::uint32_t>(kMaxRequestBytes);
  std::uint32_t max_views = kMaxViews;
  std::uint32_t max_edits_per_request = kMaxEdits;
  std::uint32_t idle_timeout_ms = 0;
  // 0: the server does not tell.
  std::uint32_t max_requests_in_flight = 0;
  std::uint32_t max_waiting_edits = 0;
  std::uint32_t max_messages_per_s = 0;
  std::uint32_t max_text_bytes = 0;
  std::uint32_t max_image_side_px = 0;
  std::uint32_t kept_frames = 0;
  bool operator==(const Limits&) const = default;
};

struct SceneInfo {
  std::string name;
  std::uint64_t version = 0;
  std::uint64_t content_hash = 0;
  std::uint32_t objects = 0;  ///< every id is below this; removed objects keep theirs
  std::uint64_t triangles = 0;
  bool operator==(const SceneInfo&) const = default;
};

/// Bits of Hello::features and Welcome::features; bits that a peer does not know mean nothing to
/// it.
using Features = std::uint64_t;
inline constexpr Features kFeatureCancel = 1;     ///< Cancel is understood
inline constexpr Features kFeatureDeadlines = 2;  ///< CameraUpdate::deadline_us is heeded
inline constexpr Features kFeaturePairs = 4;      ///< Pairs is answered

struct Hello {
  std::uint32_t proto_min = 0, proto_max = 0;
  std::string client;
  Features features = 0;
  bool operator==(const Hello&) const = default;
};

struct Welcome {
  std::uint32_t protocol = 0;
  std::string server;
  Limits limits;
  SceneInfo scene;
  Features features = 0;
  bool operator==(const Welcome&) const = default;
};

struct OpenView {
  std::uint32_t view = 0;  ///< chosen by the client
  std::string method;      ///< empty or "auto": the server chooses
  bool want_seen = false;  ///< send Answer::seen where the method knows it
  bool operator==(const OpenView&) const = default;
};

struct ViewOpened {
  std::uint32_t view = 0;
  std::string method;  ///< the one in use
  Guarantee guarantee = Guarantee::kConservative;
  bool operator==(const ViewOpened&) const = default;
};

struct CloseView {
  std::uint32_t view = 0;
  bool operator==(const CloseView&) const = default;
};

struct ViewClosed {
  std::uint32_t view = 0;
  bool operator==(const ViewClosed&) const = default;
};

struct LookAt {
  std::array<double, 3> eye{}, target{0, 0, -1}, up{0, 1, 0};
  double yfov_rad = 1.0;
  double aspect = 16.0 / 9.0;
  double znear_m = 0.1;
  std::optional<double> zfar_m;  ///< none: infinite
  bool operator==(const LookAt&) const = default;
};

/// Column-major; `projection` to OpenGL clip space.
struct Matrices {
  std::array<double, 16> view{}, projection{};
  bool operator==(const Matrices&) const = default;
};

struct Camera {
  std::variant<LookAt, Matrices> pose;
  std::uint32_t width_px = 1280, height_px = 720;
  double radius_m = 0.0, angle_rad = 0.0;  ///< motion bound
  bool operator==(const Camera&) const = default;
};

struct Demand {
  Guarantee guarantee = Guarantee::kConservative;
  float hole_px = 0.0F;
  float accepted_missed_px = 0.0F;
  std::uint32_t time_us = 0;  ///< 0: no limit
  bool operator==(const Demand&) const = default;
};

struct CameraUpdate {
  std::uint32_t view = 0;
  Camera camera;
  Demand demand;
  std::uint32_t ack_frame = 0;    ///< newest frame of this view that the client holds; 0: none
  std::uint32_t deadline_us = 0;  ///< from its arrival, for the cull to begin; 0: none
  bool operator==(const CameraUpdate&) const = default;
};

struct EditItem {
  EditKind kind = EditKind::kMove;
  std::uint32_t object = 0;                  ///< with kAdd: the object to be like
  std::array<double, 12> world_from_mesh{};  ///< rows; with kMove and kAdd
  bool operator==(const EditItem&) const = default;
};

struct Edit {
  std::uint64_t expected_version = 0;  ///< 0: any; else kConflict if the scene is at another
  std::vector<EditItem> edits;         ///< all or none are applied
  bool operator==(const Edit&) const = default;
};

struct Edited {
  std::uint64_t scene_version = 0;
  std::vector<std::uint32_t> added;  ///< ids of added objects, in order of the edits
  bool operator==(const Edited&) const = default;
};

struct Ping {
  std::uint64_t time_ns = 0;  ///< comes back unchanged
  bool operator==(const Ping&) const = default;
};

struct Pong {
  std::uint64_t time_ns = 0;
  bool operator==(const Pong&) const = default;
};

struct Stats {
  std::uint64_t cull_ns = 0, queue_ns = 0;
  std::uint32_t nodes_visited = 0, tested = 0, outside = 0, occluded = 0, in_frustum = 0;
  std::uint32_t always_kept = 0, occluders_drawn = 0, triangles_drawn = 0;
  bool operator==(const Stats&) const = default;
};

struct Answer {
  std::uint32_t view = 0;
  std::uint32_t frame = 0;     ///< of this view, counts from 1
  std::uint32_t baseline = 0;  ///< 0: the set stands alone; else the frame it changes
  std::uint64_t scene_version = 0;
  std::uint32_t scene_objects = 0;  ///< every id is below this
  Encoding encoding = Encoding::kRawU32;
  std::vector<std::uint8_t> payload;
  std::uint32_t object_count = 0;  ///< of the resulting set
  std::uint64_t set_hash = 0;      ///< of the resulting set (id_set.h)
  Guarantee guarantee = Guarantee::kConservative;
  float missed_px = 0.0F;
  bool proven = true;
  bool out_of_budget = false;
  std::string method, note;
  std::uint32_t superseded = 0;  ///< cameras of this view passed over since the last answer
  /// Bit i (lowest first): object i of the resulting set, ascending, is certainly visible. May be
  /// empty.
  std::vector<std::uint8_t> seen;
  Stats stats;
  /// Of the resulting set: certainly visible, and kept for safety. Both 0: the method does not
  /// tell.
  std::uint32_t seen_count = 0, kept_count = 0;
  std::string made_by;  ///< the method that made it, where `method` has a choice; else empty
  bool operator==(const Answer&) const = default;
};

struct SceneChanged {
  SceneInfo scene;
  bool replaced = false;  ///< another scene under the same name: every id and frame is void
  bool operator==(const SceneChanged&) const = default;
};

/// The numbers are those of schema/culld.fbs.
enum class WireCode : std::uint16_t {
  kNone = 0,
  kBadMessage = 1,
  kUnsupportedVersion = 2,
  kHelloExpected = 3,
  kUnknownScene = 4,
  kUnknownMethod = 5,
  kUnknownView = 6,
  kInvalidCamera = 7,
  kInvalidDemand = 8,
  kInvalidEdit = 9,
  kLimitExceeded = 10,
  kUnsupported = 11,
  kConflict = 12,
  kInternal = 13,
  kUnavailable = 14,
  kForbidden = 15,
  kQuotaExceeded = 16,
  kDeadlineExceeded = 17,
  kCancelled = 18,
};

/// "invalid-camera", ...; "error 99" for a code that this build does not know.
std::string wireCodeName(WireCode code);

struct ErrorReply {
  WireCode code = WireCode::kNone;
  std::string message;  ///< one line that names the input
  bool operator==(const ErrorReply&) const = default;
};

struct GoAway {
  std::string reason;
  bool operator==(const GoAway&) const = default;
};

/// Has no reply of its own: the request that it names gets one reply in any case.
struct Cancel {
  std::uint64_t request_id = 0;
  bool operator==(const Cancel&) const = default;
};

/// Somewhere in the box, and from there up to `radius_m` away.
struct Place {
  std::array<double, 3> min{}, max{};  ///< world space, metres; equal for a point
  double radius_m = 0.0;               ///< motion bound
  bool operator==(const Place&) const = default;
};

/// Which viewers may see which targets?
struct Pairs {
  std::vector<Place> viewers, targets;
  std::uint32_t time_us = 0;  ///< past it what is not proven hidden is kept; 0: the server's own
  bool operator==(const Pairs&) const = default;
};

struct PairsAnswer {
  std::uint64_t scene_version = 0;
  std::uint32_t viewers = 0, targets = 0;
  /// Bit v * targets + t, lowest of each byte first: 0 only if it is proven that they cannot.
  std::vector<std::uint8_t> may_see;
  bool out_of_budget = false;
  std::uint64_t cull_ns = 0, queue_ns = 0;
  bool operator==(const PairsAnswer&) const = default;
};

using Body = std::variant<Hello, Welcome, OpenView, ViewOpened, CloseView, ViewClosed, CameraUpdate,
                          Answer, Edit, Edited, Ping, Pong, SceneChanged, ErrorReply, GoAway,
                          Cancel, Pairs, PairsAnswer>;

/// Replies carry the id of the request they answer; what the server sends unasked has id 0.
struct Message {
  std::uint64_t id = 0;
  Body body;
  bool operator==(const Message&) const = default;
};

}  // namespace culld::protocol
