// The reading half of codec.h: nothing of a message is looked at before the verifier has passed it.
#include <cstring>
#include <optional>

#include "culld_generated.h"
#include "protocol/codec.h"

namespace culld::protocol {
namespace {

// A message is shallow: Message > Body > Camera > LookAt. Tables are few but for the items of an
// Edit.
constexpr flatbuffers::uoffset_t kMaxDepth = 8;
constexpr flatbuffers::uoffset_t kMaxTables = kMaxEdits + 64;

/// Collects the first thing that is wrong while a body is read, so that readers stay straight-line.
class Reader {
 public:
  const std::optional<Error>& failure() const noexcept { return failure_; }

  void fail(ErrorCode code, std::string message) {
    if (!failure_) failure_ = Error{code, std::move(message)};
  }

  std::string text(const flatbuffers::String* s, const char* field) {
    if (s == nullptr) return {};
    if (s->size() > kMaxTextBytes) {
      fail(ErrorCode::kLimit, std::string(field) + ": " + std::to_string(s->size()) +
                                  " bytes of text > " + std::to_string(kMaxTextBytes));
      return {};
    }
    return s->str();
  }

  /// A table that the meaning of the message needs.
  template <typename T>
  bool has(const T* table, const char* field) {
    if (table == nullptr) fail(ErrorCode::kInvalidInput, std::string(field) + " is missing");
    return table != nullptr;
  }

  template <typename To, typename From>
  To enumerator(From value, From last, const char* field) {
    if (value > last) {
      fail(ErrorCode::kInvalidInput,
           std::string(field) + ": unknown value " + std::to_string(static_cast<unsigned>(value)));
      return To{};
    }
    return static_cast<To>(value);
  }

  Guarantee guarantee(fbs::Guarantee g) {
    return enumerator<Guarantee>(g, fbs::Guarantee::MAX, "guarantee");
  }

  template <std::size_t N>
  std::array<double, N> numbers(const flatbuffers::Vector<double>* v, const char* field) {
    std::array<double, N> out{};
    if (v == nullptr || v->size() != N) {
      fail(ErrorCode::kInvalidInput, std::string(field) + ": " +
                                         std::to_string(v == nullptr ? 0 : v->size()) +
                                         " numbers instead of " + std::to_string(N));
      return out;
    }
    // The verifier does not see to the alignment of a vector's elements.
    std::memcpy(out.data(), v->Data(), sizeof out);
    return out;
  }

 private:
  std::optional<Error> failure_;
};

template <typename T>
std::vector<T> copy(const flatbuffers::Vector<T>* v) {
  if (v == nullptr || v->size() == 0) return {};
  std::vector<T> out(v->size());
  std::memcpy(out.data(), v->data(), out.size() * sizeof(T));
  return out;
}

std::array<double, 3> vec3(const fbs::Vec3& v) { return {v.x(), v.y(), v.z()}; }

SceneInfo read(Reader& in, const fbs::SceneInfo& s) {
  SceneInfo out{in.text(s.name(), "scene name"), s.version(), s.content_hash(), s.objects(),
                s.triangles()};
  if (out.objects > kMaxObjects) {
    in.fail(ErrorCode::kLimit,
            "scene: " + std::to_string(out.objects) + " objects > " + std::to_string(kMaxObjects));
  }
  return out;
}

Hello read(Reader& in, const fbs::Hello& m) {
  return {m.proto_min(), m.proto_max(), in.text(m.client(), "client"),
          static_cast<Features>(m.features())};
}

Welcome read(Reader& in, const fbs::Welcome& m) {
  Welcome out;
  out.protocol = m.protocol();
  out.server = in.text(m.server(), "server");
  if (in.has(m.limits(), "welcome.limits")) {
    out.limits = {m.limits()->max_message_bytes(), m.limits()->max_views(),
                  m.limits()->max_edits_per_request(), m.limits()->idle_timeout_ms()};
  }
  if (const fbs::MoreLimits* more = m.more_limits()) {
    out.limits.max_requests_in_flight = more->max_requests_in_flight();
    out.limits.max_waiting_edits = more->max_waiting_edits();
    out.limits.max_messages_per_s = more->max_messages_per_s();
    out.limits.max_text_bytes = more->max_text_bytes();
    out.limits.max_image_side_px = more->max_image_side_px();
    out.limits.kept_frames = more->kept_frames();
  }
  if (in.has(m.scene(), "welcome.scene")) out.scene = read(in, *m.scene());
  out.features = static_cast<Features>(m.features());
  return out;
}

OpenView read(Reader& in, const fbs::OpenView& m) {
  return {m.view(), in.text(m.method(), "method"), m.want_seen()};
}

ViewOpened read(Reader& in, const fbs::ViewOpened& m) {
  return {m.view(), in.text(m.method(), "method"), in.guarantee(m.guarantee())};
}

LookAt read(Reader& in, const fbs::LookAt& l) {
  LookAt out;
  if (in.has(l.eye(), "camera.eye")) out.eye = vec3(*l.eye());
  if (in.has(l.target(), "camera.target")) out.target = vec3(*l.target());
  if (in.has(l.up(), "camera.up")) out.up = vec3(*l.up());
  out.yfov_rad = l.yfov_rad();
  out.aspect = l.aspect();
  out.znear_m = l.znear_m();
  if (l.zfar_m() != 0.0) out.zfar_m = l.zfar_m();
  return out;
}

Camera read(Reader& in, const fbs::Camera& c) {
  Camera out;
  if (c.look_at() != nullptr && (c.view() != nullptr || c.projection() != nullptr)) {
    in.fail(ErrorCode::kInvalidInput, "camera: both look_at and matrices");
  }
  if (c.look_at() != nullptr) {
    out.pose = read(in, *c.look_at());
  } else {
    Matrices matrices;
    matrices.view = in.numbers<16>(c.view(), "camera.view");
    matrices.projection = in.numbers<16>(c.projection(), "camera.projection");
    out.pose = matrices;
  }
  out.width_px = c.width_px();
  out.height_px = c.height_px();
  out.radius_m = c.radius_m();
  out.angle_rad = c.angle_rad();
  return out;
}

CameraUpdate read(Reader& in, const fbs::CameraUpdate& m) {
  CameraUpdate out;
  out.view = m.view();
  out.ack_frame = m.ack_frame();
  out.deadline_us = m.deadline_us();
  if (in.has(m.camera(), "camera")) out.camera = read(in, *m.camera());
  if (const fbs::Demand* d = m.demand()) {
    out.demand = {in.guarantee(d->guarantee()), d->hole_px(), d->accepted_missed_px(),
                  d->time_us()};
  }
  return out;
}

Stats read(const fbs::Stats& s) {
  return {s.cull_ns(),         s.queue_ns(),       s.nodes_visited(), s.tested(),
          s.outside(),         s.occluded(),       s.in_frustum(),    s.always_kept(),
          s.occluders_drawn(), s.triangles_drawn()};
}

Answer read(Reader& in, const fbs::Answer& m) {
  Answer out;
  out.view = m.view();
  out.frame = m.frame();
  out.baseline = m.baseline();
  out.scene_version = m.scene_version();
  out.scene_objects = m.scene_objects();
  out.encoding = in.enumerator<Encoding>(m.encoding(), fbs::Encoding::MAX, "encoding");
  out.payload = copy(m.payload());
  out.object_count = m.object_count();
  out.set_hash = m.set_hash();
  out.guarantee = in.guarantee(m.guarantee());
  out.missed_px = m.missed_px();
  out.proven = m.proven();
  out.out_of_budget = m.out_of_budget();
  out.method = in.text(m.method(), "method");
  out.note = in.text(m.note(), "note");
  out.superseded = m.superseded();
  out.seen = copy(m.seen());
  if (m.stats() != nullptr) out.stats = read(*m.stats());
  out.seen_count = m.seen_count();
  out.kept_count = m.kept_count();
  out.made_by = in.text(m.made_by(), "made_by");
  if (out.scene_objects > kMaxObjects || out.object_count > out.scene_objects) {
    in.fail(ErrorCode::kLimit, "answer: " + std::to_string(out.object_count) + " objects of " +
                                   std::to_string(out.scene_objects));
  }
  if (out.frame == 0 || out.baseline >= out.frame) {
    in.fail(ErrorCode::kInvalidInput, "answer: frame " + std::to_string(out.frame) +
                                          " on baseline " + std::to_string(out.baseline));
  }
  if ((out.encoding == Encoding::kAddRemove) != (out.baseline != 0)) {
    in.fail(ErrorCode::kInvalidInput, "answer: encoding does not fit its baseline");
  }
  if (!out.seen.empty() && out.seen.size() != (std::size_t{out.object_count} + 7) / 8) {
    in.fail(ErrorCode::kInvalidInput, "answer: seen does not fit the number of objects");
  }
  const std::uint64_t told = std::uint64_t{out.seen_count} + out.kept_count;
  if (told != 0 && told != out.object_count) {
    in.fail(ErrorCode::kInvalidInput, "answer: " + std::to_string(told) +
                                          " objects seen or kept of " +
                                          std::to_string(out.object_count));
  }
  return out;
}

Edit read(Reader& in, const fbs::Edit& m) {
  Edit out;
  out.expected_version = m.expected_version();
  if (m.edits() == nullptr) return out;
  if (m.edits()->size() > kMaxEdits) {
    in.fail(ErrorCode::kLimit,
            "edit: " + std::to_string(m.edits()->size()) + " edits > " + std::to_string(kMaxEdits));
    return out;
  }
  for (const fbs::EditItem* item : *m.edits()) {
    EditItem edit;
    edit.kind = in.enumerator<EditKind>(item->kind(), fbs::EditKind::MAX, "edit kind");
    edit.object = item->object();
    if (edit.kind == EditKind::kMove || edit.kind == EditKind::kAdd) {
      edit.world_from_mesh = in.numbers<12>(item->world_from_mesh(), "edit.world_from_mesh");
    }
    out.edits.push_back(edit);
  }
  return out;
}

std::vector<Place> read(const flatbuffers::Vector<const fbs::Place*>* v) {
  static_assert(sizeof(fbs::Place) == 7 * sizeof(double));
  std::vector<Place> out(v == nullptr ? 0 : v->size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    // The verifier does not see to the alignment of a vector's elements.
    std::array<double, 7> n{};
    std::memcpy(n.data(), v->Data() + i * sizeof n, sizeof n);
    out[i] = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6]};
  }
  return out;
}

/// More than every server answers is no question.
bool tooMany(Reader& in, const char* what, std::uint64_t viewers, std::uint64_t targets) {
  if (viewers * targets <= kMaxPairs) return false;  // both have 32 bits
  in.fail(ErrorCode::kLimit, std::string(what) + ": " + std::to_string(viewers) + " viewers x " +
                                 std::to_string(targets) + " targets > " +
                                 std::to_string(kMaxPairs));
  return true;
}

Pairs read(Reader& in, const fbs::Pairs& m) {
  const auto count = [](const auto* v) { return v == nullptr ? 0U : v->size(); };
  if (tooMany(in, "pairs", count(m.viewers()), count(m.targets()))) return {};
  return {read(m.viewers()), read(m.targets()), m.time_us()};
}

PairsAnswer read(Reader& in, const fbs::PairsAnswer& m) {
  if (tooMany(in, "pairs answer", m.viewers(), m.targets())) return {};
  PairsAnswer out{m.scene_version(), m.viewers(), m.targets(), copy(m.may_see()),
                  m.out_of_budget(), m.cull_ns(), m.queue_ns()};
  const std::size_t pairs = std::size_t{out.viewers} * out.targets;
  if (out.may_see.size() != (pairs + 7) / 8) {
    in.fail(ErrorCode::kInvalidInput, "pairs answer: may_see does not fit the number of pairs");
  }
  return out;
}

SceneChanged read(Reader& in, const fbs::SceneChanged& m) {
  SceneChanged out;
  out.replaced = m.replaced();
  if (in.has(m.scene(), "scene")) out.scene = read(in, *m.scene());
  return out;
}

Body readBody(Reader& in, const fbs::Message& m) {
  switch (m.body_type()) {
    case fbs::Body::Hello:
      return read(in, *m.body_as_Hello());
    case fbs::Body::Welcome:
      return read(in, *m.body_as_Welcome());
    case fbs::Body::OpenView:
      return read(in, *m.body_as_OpenView());
    case fbs::Body::ViewOpened:
      return read(in, *m.body_as_ViewOpened());
    case fbs::Body::CloseView:
      return CloseView{m.body_as_CloseView()->view()};
    case fbs::Body::ViewClosed:
      return ViewClosed{m.body_as_ViewClosed()->view()};
    case fbs::Body::CameraUpdate:
      return read(in, *m.body_as_CameraUpdate());
    case fbs::Body::Answer:
      return read(in, *m.body_as_Answer());
    case fbs::Body::Edit:
      return read(in, *m.body_as_Edit());
    case fbs::Body::Edited:
      return Edited{m.body_as_Edited()->scene_version(), copy(m.body_as_Edited()->added())};
    case fbs::Body::Ping:
      return Ping{m.body_as_Ping()->time_ns()};
    case fbs::Body::Pong:
      return Pong{m.body_as_Pong()->time_ns()};
    case fbs::Body::SceneChanged:
      return read(in, *m.body_as_SceneChanged());
    case fbs::Body::ErrorReply:
      return ErrorReply{static_cast<WireCode>(m.body_as_ErrorReply()->code()),
                        in.text(m.body_as_ErrorReply()->message(), "error")};
    case fbs::Body::GoAway:
      return GoAway{in.text(m.body_as_GoAway()->reason(), "reason")};
    case fbs::Body::Cancel:
      return Cancel{m.body_as_Cancel()->request_id()};
    case fbs::Body::Pairs:
      return read(in, *m.body_as_Pairs());
    case fbs::Body::PairsAnswer:
      return read(in, *m.body_as_PairsAnswer());
    case fbs::Body::NONE:
      break;
  }
  in.fail(ErrorCode::kUnsupported, "message body type " +
                                       std::to_string(static_cast<unsigned>(m.body_type())) +
                                       " is not known");
  return GoAway{};
}

/// REQUIRES: `bytes` aligned to 8, as FlatBuffers reads its numbers in place.
Result<Message> decodeAligned(std::span<const std::uint8_t> bytes, std::uint64_t* request_id) {
  if (bytes.size() < 8 || !fbs::MessageBufferHasIdentifier(bytes.data())) {
    return invalidInput("message: not a CLD1 FlatBuffer");
  }
  flatbuffers::Verifier verifier(bytes.data(), bytes.size(), kMaxDepth, kMaxTables);
  if (!fbs::VerifyMessageBuffer(verifier)) return invalidInput("message: malformed FlatBuffer");
  const fbs::Message& root = *fbs::GetMessage(bytes.data());
  if (request_id != nullptr) *request_id = root.id();
  if (root.body() == nullptr) return invalidInput("message: without a body");
  Reader in;
  Message out{root.id(), readBody(in, root)};
  if (in.failure()) return *in.failure();
  return out;
}

}  // namespace

Result<Message> decode(std::span<const std::uint8_t> bytes, std::size_t max_bytes,
                       std::uint64_t* request_id) {
  if (request_id != nullptr) *request_id = 0;
  if (bytes.size() > max_bytes) {
    return Error{ErrorCode::kLimit, "message: " + std::to_string(bytes.size()) + " bytes > " +
                                        std::to_string(max_bytes)};
  }
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % 8 == 0) {
    return decodeAligned(bytes, request_id);
  }
  const std::vector<std::uint8_t> aligned(bytes.begin(), bytes.end());
  return decodeAligned(aligned, request_id);
}

}  // namespace culld::protocol
