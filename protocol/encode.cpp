// The writing half of codec.h.
#include <algorithm>

#include "culld_generated.h"
#include "protocol/codec.h"

namespace culld::protocol {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
using flatbuffers::String;

/// What one writer overload makes: the union member and where it lies.
struct Written {
  fbs::Body type = fbs::Body::NONE;
  Offset<void> body;
};

/// Longer text would be refused by every decoder; the beginning says most.
Offset<String> text(FlatBufferBuilder& out, const std::string& s) {
  return out.CreateString(s.data(), std::min(s.size(), kMaxTextBytes));
}

fbs::Guarantee guarantee(Guarantee g) { return static_cast<fbs::Guarantee>(g); }

fbs::Feature features(Features bits) { return static_cast<fbs::Feature>(bits); }

fbs::Vec3 vec3(const std::array<double, 3>& v) { return fbs::Vec3(v[0], v[1], v[2]); }

Offset<fbs::SceneInfo> write(FlatBufferBuilder& out, const SceneInfo& s) {
  const auto name = text(out, s.name);
  return fbs::CreateSceneInfo(out, name, s.version, s.content_hash, s.objects, s.triangles);
}

Written write(FlatBufferBuilder& out, const Hello& m) {
  const auto client = text(out, m.client);
  return {fbs::Body::Hello,
          fbs::CreateHello(out, m.proto_min, m.proto_max, client, features(m.features)).Union()};
}

Written write(FlatBufferBuilder& out, const Welcome& m) {
  const auto server = text(out, m.server);
  const auto scene = write(out, m.scene);
  const fbs::Limits limits(m.limits.max_message_bytes, m.limits.max_views,
                           m.limits.max_edits_per_request, m.limits.idle_timeout_ms);
  const auto more = fbs::CreateMoreLimits(
      out, m.limits.max_requests_in_flight, m.limits.max_waiting_edits, m.limits.max_messages_per_s,
      m.limits.max_text_bytes, m.limits.max_image_side_px, m.limits.kept_frames);
  return {fbs::Body::Welcome,
          fbs::CreateWelcome(out, m.protocol, server, &limits, scene, features(m.features), more)
              .Union()};
}

Written write(FlatBufferBuilder& out, const OpenView& m) {
  const auto method = text(out, m.method);
  return {fbs::Body::OpenView, fbs::CreateOpenView(out, m.view, method, m.want_seen).Union()};
}

Written write(FlatBufferBuilder& out, const ViewOpened& m) {
  const auto method = text(out, m.method);
  return {fbs::Body::ViewOpened,
          fbs::CreateViewOpened(out, m.view, method, guarantee(m.guarantee)).Union()};
}

Written write(FlatBufferBuilder& out, const CloseView& m) {
  return {fbs::Body::CloseView, fbs::CreateCloseView(out, m.view).Union()};
}

Written write(FlatBufferBuilder& out, const ViewClosed& m) {
  return {fbs::Body::ViewClosed, fbs::CreateViewClosed(out, m.view).Union()};
}

Offset<fbs::Camera> write(FlatBufferBuilder& out, const Camera& c) {
  Offset<fbs::LookAt> look;
  Offset<flatbuffers::Vector<double>> view;
  Offset<flatbuffers::Vector<double>> projection;
  if (const auto* l = std::get_if<LookAt>(&c.pose)) {
    const fbs::Vec3 eye = vec3(l->eye);
    const fbs::Vec3 target = vec3(l->target);
    const fbs::Vec3 up = vec3(l->up);
    look = fbs::CreateLookAt(out, &eye, &target, &up, l->yfov_rad, l->aspect, l->znear_m,
                             l->zfar_m.value_or(0.0));
  } else {
    const Matrices& m = *std::get_if<Matrices>(&c.pose);
    view = out.CreateVector(m.view.data(), m.view.size());
    projection = out.CreateVector(m.projection.data(), m.projection.size());
  }
  return fbs::CreateCamera(out, look, view, projection, c.width_px, c.height_px, c.radius_m,
                           c.angle_rad);
}

Written write(FlatBufferBuilder& out, const CameraUpdate& m) {
  const auto camera = write(out, m.camera);
  const auto demand = fbs::CreateDemand(out, guarantee(m.demand.guarantee), m.demand.hole_px,
                                        m.demand.accepted_missed_px, m.demand.time_us);
  return {fbs::Body::CameraUpdate,
          fbs::CreateCameraUpdate(out, m.view, camera, demand, m.ack_frame, m.deadline_us).Union()};
}

Written write(FlatBufferBuilder& out, const Answer& m) {
  const auto payload = out.CreateVector(m.payload);
  const auto seen = m.seen.empty() ? 0 : out.CreateVector(m.seen);
  const auto method = text(out, m.method);
  const auto note = m.note.empty() ? Offset<String>() : text(out, m.note);
  const auto made_by = m.made_by.empty() ? Offset<String>() : text(out, m.made_by);
  const Stats& s = m.stats;
  const auto stats =
      fbs::CreateStats(out, s.cull_ns, s.queue_ns, s.nodes_visited, s.tested, s.outside, s.occluded,
                       s.in_frustum, s.always_kept, s.occluders_drawn, s.triangles_drawn);
  return {
      fbs::Body::Answer,
      fbs::CreateAnswer(out, m.view, m.frame, m.baseline, m.scene_version, m.scene_objects,
                        static_cast<fbs::Encoding>(m.encoding), payload, m.object_count, m.set_hash,
                        guarantee(m.guarantee), m.missed_px, m.proven, m.out_of_budget, method,
                        note, m.superseded, seen, stats, m.seen_count, m.kept_count, made_by)
          .Union()};
}

Offset<fbs::EditItem> write(FlatBufferBuilder& out, const EditItem& e) {
  Offset<flatbuffers::Vector<double>> rows;
  if (e.kind == EditKind::kMove || e.kind == EditKind::kAdd) {
    rows = out.CreateVector(e.world_from_mesh.data(), e.world_from_mesh.size());
  }
  return fbs::CreateEditItem(out, static_cast<fbs::EditKind>(e.kind), e.object, rows);
}

Written write(FlatBufferBuilder& out, const Edit& m) {
  std::vector<Offset<fbs::EditItem>> items;
  items.reserve(m.edits.size());
  for (const EditItem& e : m.edits) items.push_back(write(out, e));
  const auto edits = out.CreateVector(items);
  return {fbs::Body::Edit, fbs::CreateEdit(out, m.expected_version, edits).Union()};
}

Written write(FlatBufferBuilder& out, const Edited& m) {
  const auto added = out.CreateVector(m.added);
  return {fbs::Body::Edited, fbs::CreateEdited(out, m.scene_version, added).Union()};
}

Written write(FlatBufferBuilder& out, const Ping& m) {
  return {fbs::Body::Ping, fbs::CreatePing(out, m.time_ns).Union()};
}

Written write(FlatBufferBuilder& out, const Pong& m) {
  return {fbs::Body::Pong, fbs::CreatePong(out, m.time_ns).Union()};
}

Written write(FlatBufferBuilder& out, const SceneChanged& m) {
  const auto scene = write(out, m.scene);
  return {fbs::Body::SceneChanged, fbs::CreateSceneChanged(out, scene, m.replaced).Union()};
}

Written write(FlatBufferBuilder& out, const ErrorReply& m) {
  const auto message = text(out, m.message);
  return {fbs::Body::ErrorReply,
          fbs::CreateErrorReply(out, static_cast<fbs::WireCode>(m.code), message).Union()};
}

Written write(FlatBufferBuilder& out, const GoAway& m) {
  const auto reason = text(out, m.reason);
  return {fbs::Body::GoAway, fbs::CreateGoAway(out, reason).Union()};
}

Written write(FlatBufferBuilder& out, const Cancel& m) {
  return {fbs::Body::Cancel, fbs::CreateCancel(out, m.request_id).Union()};
}

Offset<flatbuffers::Vector<const fbs::Place*>> write(FlatBufferBuilder& out,
                                                     const std::vector<Place>& places) {
  std::vector<fbs::Place> structs;
  structs.reserve(places.size());
  for (const Place& p : places) structs.emplace_back(vec3(p.min), vec3(p.max), p.radius_m);
  return out.CreateVectorOfStructs(structs);
}

Written write(FlatBufferBuilder& out, const Pairs& m) {
  const auto viewers = write(out, m.viewers);
  const auto targets = write(out, m.targets);
  return {fbs::Body::Pairs, fbs::CreatePairs(out, viewers, targets, m.time_us).Union()};
}

Written write(FlatBufferBuilder& out, const PairsAnswer& m) {
  const auto may_see = out.CreateVector(m.may_see);
  return {fbs::Body::PairsAnswer,
          fbs::CreatePairsAnswer(out, m.scene_version, m.viewers, m.targets, may_see,
                                 m.out_of_budget, m.cull_ns, m.queue_ns)
              .Union()};
}

}  // namespace

std::vector<std::uint8_t> encode(const Message& message) {
  FlatBufferBuilder out;
  const Written written =
      std::visit([&out](const auto& body) { return write(out, body); }, message.body);
  fbs::FinishMessageBuffer(out, fbs::CreateMessage(out, message.id, written.type, written.body));
  return {out.GetBufferPointer(), out.GetBufferPointer() + out.GetSize()};
}

}  // namespace culld::protocol
