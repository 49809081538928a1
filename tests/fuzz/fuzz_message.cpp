// Any bytes as a message: it is refused, or it is what encode() makes of it again. Id sets of
// answers are decoded as a client would.
#include <cstdint>
#include <cstdlib>

#include "protocol/codec.h"
#include "protocol/id_set.h"

namespace {

using namespace culld::protocol;

void require(bool holds) {
  if (!holds) std::abort();
}

void decodeIds(const Answer& answer) {
  const IdSet baseline = {0, 1, 5, 64, 4096};
  const auto ids = decodeSet(answer.encoding, answer.payload, answer.scene_objects, baseline);
  if (!ids.ok()) return;
  const EncodedSet again = encodeSmallest(baseline, ids.value());
  const auto back = decodeSet(again.encoding, again.payload, answer.scene_objects, baseline);
  require(back.ok() && back.value() == ids.value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto message = decode({data, size}, kMaxRequestBytes);
  if (!message.ok()) {
    require(!message.error().message.empty());
    return 0;
  }
  // Twice, as numbers that are not equal to themselves (NaN) only compare as bytes.
  const auto once = encode(message.value());
  const auto again = decode(once, kMaxReplyBytes);
  require(again.ok() && encode(again.value()) == once);
  if (const auto* answer = std::get_if<Answer>(&message.value().body)) decodeIds(*answer);
  return 0;
}
