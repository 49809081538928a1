#include "culling/planner/sample_views.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "culling/planner/sampled_objects.h"

namespace culld {
namespace {

constexpr double kEyeHeight = 1.7;
constexpr double kSmallestWorld = 8.0;  ///< half a diagonal; nobody walks in less
constexpr std::size_t kSampled = 4096;  ///< objects looked at to learn the scene's size

glm::dvec3 middleOf(const Box& box) { return 0.5 * box.min + 0.5 * box.max; }
double reachOf(const Box& box) { return glm::length(0.5 * box.max - 0.5 * box.min); }

/// Where nine tenths of the objects are, so that a sky dome or a stray object moves no camera.
Box crowdedPart(const std::vector<Box>& boxes) {
  Box part;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> middles;
    middles.reserve(boxes.size());
    for (const Box& box : boxes) middles.push_back(middleOf(box)[axis]);
    std::sort(middles.begin(), middles.end());
    const std::size_t last = middles.size() - 1;
    part.min[axis] = middles[last / 20];
    part.max[axis] = middles[last - last / 20];
  }
  return part;
}

class Sampler {
 public:
  explicit Sampler(std::vector<Box> boxes) : boxes_(std::move(boxes)), part_(crowdedPart(boxes_)) {
    std::vector<double> reaches;
    for (const Box& box : boxes_) reaches.push_back(reachOf(box));
    std::nth_element(reaches.begin(), reaches.begin() + static_cast<std::ptrdiff_t>(middle()),
                     reaches.end());
    typical_ = reaches[middle()];
    reach_ = reachOf(part_) + typical_;
    if (!(reach_ > 0.0)) reach_ = 1.0;
  }

  LookAt over() {
    const double turn = 2.0 * std::numbers::pi * unit();
    LookAt look;
    look.target = middleOf(part_);
    look.eye = look.target +
               reach_ * glm::dvec3(1.5 * std::cos(turn), 0.3 + 0.4 * unit(), 1.5 * std::sin(turn));
    return look;
  }

  LookAt beside(bool along_the_ground) {
    const Box& box = any();
    const double turn = 2.0 * std::numbers::pi * unit();
    const double away = std::min(reachOf(box), reach_) + 0.5 * typical_;
    LookAt look;
    look.eye = middleOf(box) + away * glm::dvec3(std::cos(turn), 0.0, std::sin(turn));
    const bool for_people = reach_ > kSmallestWorld;
    look.eye.y = for_people ? box.min.y + kEyeHeight : look.eye.y + 0.25 * typical_;
    const double heading = 2.0 * std::numbers::pi * unit();
    look.target = along_the_ground
                      ? look.eye + reach_ * glm::dvec3(std::cos(heading), 0.0, std::sin(heading))
                      : middleOf(any());
    return look;
  }

  double reach() const { return reach_; }

 private:
  std::size_t middle() const { return boxes_.size() / 2; }
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  const Box& any() { return boxes_[random_() % boxes_.size()]; }

  std::vector<Box> boxes_;
  Box part_;
  double typical_ = 0.0, reach_ = 1.0;
  std::mt19937_64 random_{0x636c64};  // the same on every standard library
};

}  // namespace

std::vector<SampledView> sampleViews(const SceneSnapshot& scene, std::size_t count) {
  std::vector<Box> boxes;
  for (const ObjectId id : sampledObjects(scene, kSampled)) {
    boxes.push_back(scene.instance(id).bounds_world);
  }
  std::vector<SampledView> views;
  if (boxes.empty()) return views;
  Sampler sampler(std::move(boxes));
  for (std::size_t i = 0; i < count; ++i) {
    const bool outside = i % 4 == 3;
    LookAt look = outside ? sampler.over() : sampler.beside(i % 2 == 0);
    look.znear_m = 1e-4 * sampler.reach();
    // A view straight up or onto itself is no camera; the scene has others.
    const auto camera = cameraFromLookAt(look, ImageSize{});
    if (camera) views.push_back({camera.value(), outside});
  }
  return views;
}

}  // namespace culld
