#include "protocol/camera_file.h"

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace culld::protocol {
namespace {

constexpr std::size_t kMaxSkippedDepth = 64;

enum class Shape { kNumber, kNumberOrNull, kVector, kMatrix, kSide };
enum FieldId : std::size_t {
  kEye,
  kTarget,
  kUp,
  kYfov,
  kAspect,
  kZnear,
  kZfar,
  kView,
  kProjection,
  kRadius,
  kAngle,
  kWidth,
  kHeight,
  kFieldCount
};
struct Field {
  std::string_view name;
  Shape shape;
};
constexpr std::array<Field, kFieldCount> kFields{{{"eye", Shape::kVector},
                                                  {"target", Shape::kVector},
                                                  {"up", Shape::kVector},
                                                  {"yfov", Shape::kNumber},
                                                  {"aspect", Shape::kNumber},
                                                  {"znear", Shape::kNumber},
                                                  {"zfar", Shape::kNumberOrNull},
                                                  {"view", Shape::kMatrix},
                                                  {"projection", Shape::kMatrix},
                                                  {"radius", Shape::kNumber},
                                                  {"angle", Shape::kNumber},
                                                  {"width", Shape::kSide},
                                                  {"height", Shape::kSide}}};

std::size_t lengthOf(Shape shape) {
  return shape == Shape::kVector ? 3 : shape == Shape::kMatrix ? 16 : 1;
}

std::string complaint(Shape shape) {
  switch (shape) {
    case Shape::kNumber:
      return " is not a number";
    case Shape::kNumberOrNull:
      return " is not a number or null";
    case Shape::kVector:
      return " is not a list of 3 numbers";
    case Shape::kMatrix:
      return " is not a list of 16 numbers";
    case Shape::kSide:
      break;
  }
  return " is not a whole number from 1 to 65536";
}

/// Builds cameras while the text streams by, so memory is bounded by the cameras themselves and the
/// first wrong field stops the reading. The member functions are nlohmann's SAX interface.
class CameraReader {
 public:
  CameraReader(std::string_view text, const std::string& name, ImageSize image)
      : text_(text), name_(name), image_(image) {}

  // NOLINTBEGIN(readability-identifier-naming): names given by nlohmann_json
  bool null() {
    if (skipping() || (level_ == kInCamera && kFields[field_].shape == Shape::kNumberOrNull)) {
      return true;
    }
    return wrongValue();
  }
  bool boolean(bool) { return skipping() || wrongValue(); }
  bool string(std::string&) { return skipping() || wrongValue(); }
  bool binary(std::vector<std::uint8_t>&) { return wrongValue(); }
  bool number_integer(std::int64_t value) { return number(static_cast<double>(value), false); }
  bool number_unsigned(std::uint64_t value) {
    return number(static_cast<double>(value), value >= 1 && value <= kMaxImageSide);
  }
  bool number_float(double value, const std::string&) { return number(value, false); }
  bool start_object(std::size_t) {
    if (skipping()) return deeper();
    if (level_ != kInList) return wrongValue();
    if (cameras_.size() == kMaxFileCameras) {
      return fail(ErrorCode::kLimit, "more than " + std::to_string(kMaxFileCameras) + " cameras");
    }
    level_ = kInCamera;
    given_.reset();
    has_far_ = false;
    return true;
  }
  bool key(std::string& key) {
    if (skipped_depth_ > 0) return true;
    const auto* found = std::find_if(kFields.begin(), kFields.end(),
                                     [&key](const Field& f) { return f.name == key; });
    field_ = static_cast<std::size_t>(found - kFields.begin());
    if (field_ == kFieldCount) return true;
    if (given_[field_]) return failField(" is given twice");
    given_[field_] = true;
    return true;
  }
  bool end_object() {
    if (leaveSkipped()) return true;
    level_ = kInList;
    return finishCamera();
  }
  bool start_array(std::size_t) {
    if (skipping()) return deeper();
    if (level_ == kOutside) {
      level_ = kInList;
      return true;
    }
    if (level_ != kInCamera || lengthOf(kFields[field_].shape) == 1) return wrongValue();
    level_ = kInNumbers;
    count_ = 0;
    return true;
  }
  bool end_array() {
    if (leaveSkipped()) return true;
    if (level_ == kInList) {
      level_ = kOutside;
      return true;
    }
    if (count_ != lengthOf(kFields[field_].shape)) return wrongValue();
    level_ = kInCamera;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& e) {
    constexpr int kNumberOverflow = 406;
    if (e.id == kNumberOverflow && level_ >= kInCamera && !skipping()) {
      return failField(" is not a finite number");
    }
    return refuseAt(position);
  }
  // NOLINTEND(readability-identifier-naming)

  /// `position`: how many bytes were read, the wrong one among them.
  bool refuseAt(std::size_t position) {
    const std::string_view before = text_.substr(0, std::min(position, text_.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 == 0
    return fail(ErrorCode::kInvalidInput, "line " + std::to_string(line) + ", column " +
                                              std::to_string(before.size() - line_start) +
                                              ": not valid JSON");
  }

  Result<std::vector<Camera>> take() && {
    if (!error_.message.empty()) return std::move(error_);
    return std::move(cameras_);
  }

 private:
  enum Level { kOutside, kInList, kInCamera, kInNumbers };

  bool skipping() const { return level_ == kInCamera && field_ == kFieldCount; }
  bool deeper() {
    if (++skipped_depth_ <= kMaxSkippedDepth) return true;
    return failCamera("nested deeper than " + std::to_string(kMaxSkippedDepth) + " levels");
  }
  bool leaveSkipped() {
    if (skipped_depth_ == 0) return false;
    --skipped_depth_;
    return true;
  }

  bool number(double value, bool is_side) {
    if (skipping()) return true;
    if (level_ < kInCamera) return wrongValue();
    const Shape shape = kFields[field_].shape;
    const bool one = lengthOf(shape) == 1;
    if (one != (level_ == kInCamera) || (shape == Shape::kSide && !is_side)) return wrongValue();
    if (one) {
      values_[field_][0] = value;
      if (field_ == kZfar) has_far_ = true;
      return true;
    }
    if (count_ == lengthOf(shape)) return wrongValue();
    values_[field_][count_++] = value;
    return true;
  }

  bool require(std::initializer_list<FieldId> ids) {
    for (const FieldId id : ids) {
      field_ = id;
      if (!given_[id]) return failField(" is missing");
    }
    return true;
  }

  bool finishCamera() {
    Camera camera;
    if (given_[kView] || given_[kProjection]) {
      for (const FieldId id : {kEye, kTarget, kUp, kYfov, kAspect, kZnear, kZfar}) {
        field_ = id;
        if (given_[id]) return failField(" does not go with \"view\" and \"projection\"");
      }
      if (!require({kView, kProjection})) return false;
      camera.pose = Matrices{values_[kView], values_[kProjection]};
    } else {
      if (!require({kEye, kTarget, kUp, kYfov, kAspect, kZnear})) return false;
      LookAt pose{vector(kEye),        vector(kTarget),    vector(kUp), values_[kYfov][0],
                  values_[kAspect][0], values_[kZnear][0], {}};
      field_ = kZfar;
      if (has_far_ && !(values_[kZfar][0] > 0.0)) return failField(" is not > 0");
      if (has_far_) pose.zfar_m = values_[kZfar][0];
      camera.pose = pose;
    }
    if (given_[kRadius]) camera.radius_m = values_[kRadius][0];
    if (given_[kAngle]) camera.angle_rad = values_[kAngle][0];
    camera.width_px = given_[kWidth] ? side(kWidth) : image_.width_px;
    camera.height_px = given_[kHeight] ? side(kHeight) : image_.height_px;
    cameras_.push_back(camera);
    return true;
  }

  std::array<double, 3> vector(FieldId id) const {
    return {values_[id][0], values_[id][1], values_[id][2]};
  }

  std::uint32_t side(FieldId id) const { return static_cast<std::uint32_t>(values_[id][0]); }

  bool wrongValue() {
    if (level_ == kOutside) return fail(ErrorCode::kInvalidInput, "is not a list of cameras");
    if (level_ == kInList) return failCamera("is not an object");
    return failField(complaint(kFields[field_].shape));
  }
  bool failField(const std::string& what) {
    return failCamera('"' + std::string(kFields[field_].name) + '"' + what);
  }
  bool failCamera(const std::string& what) {
    return fail(ErrorCode::kInvalidInput,
                "camera " + std::to_string(cameras_.size()) + ": " + what);
  }
  bool fail(ErrorCode code, const std::string& what) {
    error_ = {code, name_ + ": " + what};
    return false;
  }

  std::string_view text_;
  const std::string& name_;
  ImageSize image_;
  Level level_ = kOutside;
  std::size_t field_ = kFieldCount;  ///< kFieldCount: a field that is skipped
  std::size_t count_ = 0;            ///< numbers read of the list
  std::size_t skipped_depth_ = 0;
  std::bitset<kFieldCount> given_;
  bool has_far_ = false;
  std::array<std::array<double, 16>, kFieldCount> values_{};
  std::vector<Camera> cameras_;
  Error error_;
};

}  // namespace

Result<std::vector<Camera>> parseCameras(std::string_view text, const std::string& name,
                                         ImageSize image) {
  CameraReader reader(text, name, image);
  // The library takes a zero byte for the end of the text; no JSON holds one.
  const std::string_view read = text.substr(0, text.find('\0'));
  if (nlohmann::json::sax_parse(read.begin(), read.end(), &reader) && read.size() < text.size()) {
    reader.refuseAt(read.size() + 1);
  }
  return std::move(reader).take();
}

Result<std::vector<Camera>> readCameraFile(const std::string& path, ImageSize image) {
  const auto cannotRead = [&path] {
    return Error{ErrorCode::kIo, path + ": cannot read: " + std::strerror(errno)};
  };
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) return cannotRead();
  std::string text;
  std::array<char, 65536> block{};
  while (in.read(block.data(), block.size()), in.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > kMaxCameraFileBytes) {
      return Error{ErrorCode::kLimit,
                   path + ": larger than " + std::to_string(kMaxCameraFileBytes) + " bytes"};
    }
  }
  if (in.bad() || (errno != 0 && text.empty())) return cannotRead();
  return parseCameras(text, path, image);
}

}  // namespace culld::protocol
