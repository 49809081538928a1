#include "protocol/answer_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

namespace culld::protocol {
namespace {

struct Line {
  ObjectName name;
  bool seen = false;
  bool shared = false;
};

template <typename T>
void appendNumber(std::string& out, T value) {
  std::array<char, 40> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

/// JSON knows neither NaN nor infinity; the shortest text that reads back as the same number else.
template <typename T>
void appendReal(std::string& out, T value) {
  if (std::isfinite(value)) {
    appendNumber(out, value);
  } else {
    out += "null";
  }
}

std::string jsonText(std::string_view text) {
  const nlohmann::json value = text;
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

const char* word(bool value) { return value ? "true" : "false"; }

void appendInstances(std::string& out, const std::vector<Line>& lines) {
  const auto shared = [](const Line& line) { return line.shared; };
  auto at = std::find_if(lines.begin(), lines.end(), shared);
  if (at == lines.end()) return;
  out += ",\"instances\":{";
  for (bool first = true; at != lines.end(); first = false) {
    const std::uint32_t node = at->name.node;
    out += first ? "\"" : "],\"";
    appendNumber(out, node);
    out += "\":[";
    appendNumber(out, at->name.instance);
    for (++at; at != lines.end() && at->name.node == node; ++at) {
      out += ',';
      appendNumber(out, at->name.instance);
    }
    at = std::find_if(at, lines.end(), shared);
  }
  out += "]}";
}

/// "visible" and, if `with_seen`, "seen": 1 as soon as one instance of the node is seen.
void appendNodes(std::string& out, const std::vector<Line>& lines, bool with_seen) {
  std::string seen;
  out += ",\"visible\":[";
  for (std::size_t i = 0; i < lines.size();) {
    const std::uint32_t node = lines[i].name.node;
    const bool first = i == 0;
    bool any_seen = false;
    for (; i < lines.size() && lines[i].name.node == node; ++i) any_seen |= lines[i].seen;
    if (!first) out += ',';
    appendNumber(out, node);
    seen += first ? "" : ",";
    seen += any_seen ? '1' : '0';
  }
  out += ']';
  if (with_seen) out += ",\"seen\":[" + seen + ']';
}

/// Of objects, where "seen" is of nodes.
void appendCounts(std::string& out, const std::vector<Line>& lines) {
  const auto seen =
      std::count_if(lines.begin(), lines.end(), [](const Line& line) { return line.seen; });
  out += ",\"seen_count\":";
  appendNumber(out, seen);
  out += ",\"kept_count\":";
  appendNumber(out, std::ssize(lines) - seen);
}

}  // namespace

std::string guaranteeName(Guarantee guarantee) {
  switch (guarantee) {
    case Guarantee::kConservative:
      return "conservative";
    case Guarantee::kHole:
      return "hole";
    case Guarantee::kSampled:
      return "sampled";
    case Guarantee::kApproximate:
      break;
  }
  return "approximate";
}

Result<Guarantee> guaranteeNamed(const std::string& name) {
  for (const Guarantee guarantee :
       {Guarantee::kConservative, Guarantee::kHole, Guarantee::kSampled, Guarantee::kApproximate}) {
    if (guaranteeName(guarantee) == name) return guarantee;
  }
  return invalidInput("guarantee " + name +
                      ": not one of conservative, hole, sampled, approximate");
}

bool satisfies(Guarantee given, Guarantee demanded) noexcept {
  return given == demanded || given == Guarantee::kConservative ||
         demanded == Guarantee::kApproximate;
}

AnswerWriter::AnswerWriter(std::vector<ObjectName> names)
    : names_(std::move(names)), shared_(names_.size(), false) {
  std::vector<std::size_t> by_node(names_.size());
  std::iota(by_node.begin(), by_node.end(), std::size_t{0});
  std::sort(by_node.begin(), by_node.end(),
            [this](std::size_t a, std::size_t b) { return names_[a].node < names_[b].node; });
  for (std::size_t i = 1; i < by_node.size(); ++i) {
    if (names_[by_node[i - 1]].node != names_[by_node[i]].node) continue;
    shared_[by_node[i - 1]] = shared_[by_node[i]] = true;
  }
}

Result<void> AnswerWriter::add(const AnswerFrame& frame) {
  const auto bad = [&frame](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "camera " + std::to_string(frame.camera) + ": " + what};
  };
  const bool with_seen = !frame.seen.empty();
  if (with_seen && frame.seen.size() != frame.visible.size()) {
    return bad("answer marks " + std::to_string(frame.seen.size()) + " of " +
               std::to_string(frame.visible.size()) + " objects");
  }
  std::vector<Line> lines;
  lines.reserve(frame.visible.size());
  for (std::size_t i = 0; i < frame.visible.size(); ++i) {
    const std::uint32_t id = frame.visible[i];
    if (id >= names_.size()) return bad("answer has unknown object " + std::to_string(id));
    lines.push_back({names_[id], with_seen && frame.seen[i] != 0, shared_[id]});
  }
  std::sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) {
    return std::pair(a.name.node, a.name.instance) < std::pair(b.name.node, b.name.instance);
  });

  if (!frames_.empty()) frames_ += ",\n";
  frames_ += "{\"camera\":";
  appendNumber(frames_, frame.camera);
  appendNodes(frames_, lines, with_seen);
  appendInstances(frames_, lines);
  frames_ += ",\"seconds\":";
  appendReal(frames_, frame.seconds);
  frames_ += ",\"missed_px\":";
  appendReal(frames_, frame.missed_px);
  frames_ += std::string(",\"proven\":") + word(frame.proven);
  frames_ += std::string(",\"out_of_budget\":") + word(frame.out_of_budget);
  frames_ += ",\"guarantee\":\"" + guaranteeName(frame.guarantee) + '"';
  if (!frame.made_by.empty()) frames_ += ",\"made_by\":" + jsonText(frame.made_by);
  if (with_seen) appendCounts(frames_, lines);
  frames_ += '}';
  return Done{};
}

std::string AnswerWriter::text(const AnswerHeader& header) const {
  std::string out = "{\"method\":" + jsonText(header.method);
  out += ",\"guarantee\":\"" + guaranteeName(header.guarantee) + "\",\"scene\":{\"objects\":";
  appendNumber(out, header.objects);
  out += ",\"triangles\":";
  appendNumber(out, header.triangles);
  out += "},\"frames\":[\n";
  out += frames_;
  out += "\n]}\n";
  return out;
}

Result<void> writeTextFile(const std::string& path, const std::string& text) {
  errno = 0;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (out.good()) return Done{};
  const std::string why = errno != 0 ? std::strerror(errno) : "unknown error";
  return Error{ErrorCode::kIo, path + ": cannot write: " + why};
}

}  // namespace culld::protocol
