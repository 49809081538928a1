// What an answer makes a thin client draw, for all that weigh it against work on the server.
// Stated, not measured at run time, so that the same cameras give the same answers on every
// machine.
#pragma once
#include <chrono>

namespace culld {

/// A phone's browser draws about 300 objects in a 60 Hz frame.
inline constexpr std::chrono::nanoseconds kObjectPrice{50'000};
/// ... and about 100 million triangles a second.
inline constexpr std::chrono::nanoseconds kTrianglePrice{10};

}  // namespace culld
