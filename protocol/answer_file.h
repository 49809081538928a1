// The answers file (docs/clients.md). One writer for `culld cull` and `cullctl cull`: same sets,
// same bytes. Ids in it are glTF node indices, so that a reader needs only the scene's file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::protocol {

/// What an object is called in files: its glTF node, and which of the node's instances.
struct ObjectName {
  std::uint32_t node = 0;
  std::uint32_t instance = 0;
  bool operator==(const ObjectName&) const = default;
};

/// "conservative", "hole", "sampled", "approximate".
std::string guaranteeName(Guarantee guarantee);
/// The way back. ERROR: `guarantee exact: not one of conservative, hole, sampled, approximate`.
Result<Guarantee> guaranteeNamed(const std::string& name);
/// Conservative answers satisfy every demand; who accepts estimates accepts everything.
bool satisfies(Guarantee given, Guarantee demanded) noexcept;

struct AnswerHeader {
  std::string method;
  Guarantee guarantee = Guarantee::kConservative;
  std::uint64_t objects = 0, triangles = 0;
};

struct AnswerFrame {
  std::size_t camera = 0;                  ///< index in the cameras file
  std::span<const std::uint32_t> visible;  ///< object ids
  std::span<const std::uint8_t> seen;      ///< empty, or one 0 or 1 per visible object
  double seconds = 0.0;
  float missed_px = 0.0F;
  bool proven = true;
  bool out_of_budget = false;
  Guarantee guarantee = Guarantee::kConservative;
  std::string_view made_by;  ///< empty: the method has no choice
};

class AnswerWriter {
 public:
  /// `names[id]` is the name of object id; nodes that several objects share get "instances".
  explicit AnswerWriter(std::vector<ObjectName> names);

  /// ERROR: kInvalidInput: an id without a name, or `seen` of another length.
  Result<void> add(const AnswerFrame& frame);

  /// The whole file. GUARANTEES: nodes and instances ascending and unique; equal input, equal
  /// bytes.
  std::string text(const AnswerHeader& header) const;

 private:
  std::vector<ObjectName> names_;
  std::vector<bool> shared_;  ///< per node: has several objects
  std::string frames_;
};

/// ERROR: "PATH: cannot write: No space left on device".
Result<void> writeTextFile(const std::string& path, const std::string& text);

}  // namespace culld::protocol
