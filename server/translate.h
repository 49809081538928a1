// The only place where words of the wire and types of the engine meet.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "culling/pairs/places.h"
#include "culling/scene/edit.h"
#include "protocol/messages.h"

namespace culld::server {

/// ERROR: kInvalidInput naming the field: NaN, singular, zero-sized image, ...
Result<Camera> toEngine(const protocol::Camera& camera);
/// ERROR: kInvalidInput: not finite or negative.
Result<Demand> toEngine(const protocol::Demand& demand);
std::vector<Place> toEngine(std::span<const protocol::Place> places);
std::vector<Edit> toEngine(std::span<const protocol::EditItem> edits);

protocol::Guarantee toWire(Guarantee guarantee) noexcept;
protocol::Stats toWire(const CullStats& stats, std::chrono::nanoseconds queued);
/// The code of an engine error on the wire; `invalid` stands for kInvalidInput.
protocol::WireCode toWire(ErrorCode code, protocol::WireCode invalid) noexcept;
protocol::SceneInfo describe(const std::string& name, const SceneSnapshot& scene);

/// Eight per byte, lowest bit first, as Answer::seen of the wire has them.
std::vector<std::uint8_t> packBits(std::span<const std::uint8_t> flags);

}  // namespace culld::server
