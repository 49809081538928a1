#include "culling/methods/item_buffer_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace culld {
namespace {

using Stage = gpu::ItemPass::Stage;

// What the GPU gets between two looks at the clock.
constexpr std::size_t kMostInBatch = 4096;  ///< items
constexpr std::uint64_t kManyTriangles = 250'000;

/// Depths are this over the distance in metres: within (0, 1) for all that is farther than 1e-18 m,
/// and a normal float up to 1e19 m.
constexpr double kDepthMetres = 0x1p-60;

/// Clipping in floats moves a corner by 2^-24 of what is clipped: no farther than the guard band if
/// the sum of an object's terms is at most so many times its least distance.
constexpr double kLargestReach = 0x1p22;
/// And what the rasterizer computes with stays far from overflow.
constexpr double kLargestTerm = 1e15;
/// ObjectRows' bounds on errors, in terms.
constexpr double kErrorOfTerms = 16.0 * 0x1p-53;

// Nanoseconds of counted work: rough, and of a software renderer.
constexpr std::uint64_t kFrameNs = 500'000, kItemNs = 400, kTriangleNs = 150;

std::array<double, 4> scaled(const ObjectRow& row, double factor) {
  return {factor * row.x, factor * row.y, factor * row.z, factor * row.constant};
}

std::array<double, 4> sum(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}

gpu::Item itemOf(const ObjectRows& rows, bool perspective, std::uint32_t number) {
  gpu::Item item;
  item.x = scaled(rows.u, 1.0);
  item.y = scaled(rows.v, 1.0);
  item.w = scaled(rows.w, 1.0);
  // An orthographic nearness reaches from 0 to 1: away from both, so that nothing is cut off there.
  item.z =
      perspective ? scaled(rows.n, kDepthMetres) : sum(scaled(rows.n, 0.5), scaled(rows.w, 0.25));
  item.near_cut = scaled(rows.near_cut, 1.0);
  item.far_cut = scaled(rows.far_cut, 1.0);
  item.number = number;
  return item;
}

/// The camera's view with clip coordinates for cells.
CellView clipView(const Camera& camera) {
  CellView view = cellView(camera, gridOf(2, 2));  // from 0 to 2 across the image
  view.u -= view.w;
  view.v -= view.w;
  return view;
}

gpu::Facing facingOf(int sign, bool both_sides) {
  if (both_sides || sign == 0) return gpu::Facing::kBoth;
  return sign > 0 ? gpu::Facing::kCounterClockwise : gpu::Facing::kClockwise;
}

}  // namespace

ItemBufferFrame::ItemBufferFrame(const SceneSnapshot& scene, const ItemMeshes& meshes,
                                 const ItemBufferParts& parts, const Camera& camera,
                                 const Deadline& deadline, std::chrono::nanoseconds most_work)
    : scene_(scene),
      meshes_(meshes),
      source_(meshes.source(scene)),
      parts_(parts),
      budget_(deadline, most_work),
      eye_world_(camera.origin_world),
      width_(camera.width_px * parts.lattice),
      height_(camera.height_px * parts.lattice),
      view_(clipView(camera)) {}

bool ItemBufferFrame::fits(const Camera& camera, std::uint32_t lattice) noexcept {
  const std::uint64_t width = std::uint64_t{camera.width_px} * lattice;
  const std::uint64_t height = std::uint64_t{camera.height_px} * lattice;
  return width <= gpu::ItemPass::kMostSide && height <= gpu::ItemPass::kMostSide &&
         width * height <= gpu::ItemPass::kMostSamples;
}

Result<ItemPixels> ItemBufferFrame::run(gpu::ContextPool::Lease& gpu, Answer& answer) {
  auto& pass = gpu.data<gpu::ItemPass>();
  if (!pass.ready()) {  // another context may do better
    gpu.drop(pass.ready().error().message);
    return pass.ready().error();
  }
  stats_ = answer.stats;
  sortOut(answer.visible);
  pass.begin(width_, height_, items_.size());
  drawAll(pass);
  if (!budget_.stopped()) pass.read(counts_);
  if (auto fine = gpu.check(); !fine) return fine.error();
  return report(answer);
}

/// What is drawn, in an order of its own: it decides which of equally near surfaces is found.
void ItemBufferFrame::sortOut(std::span<const ObjectId> found) {
  for (const ObjectId id : found) {
    const Instance& instance = scene_.instance(id);
    const bool drawable = isDrawable(rowsOf(instance), meshes_.mesh(instance.mesh).largest);
    if (meshes_.mesh(instance.mesh).thin || !drawable) kept_.push_back(id);
    if (!drawable) continue;
    const double sign = view_.front_sign * handedness(instance.world_from_mesh);
    items_.push_back({static_cast<std::int8_t>(sign), instance.mesh, id});
  }
  std::sort(items_.begin(), items_.end());
}

/// NaN is not.
bool ItemBufferFrame::isDrawable(const ObjectRows& rows, const glm::dvec3& largest) const {
  const CellVertexError& e = rows.error;
  const double terms = (e.u + e.v + e.w + e.n + e.near_cut + e.far_cut) / kErrorOfTerms;
  const double reach = std::abs(rows.w.x) * largest.x + std::abs(rows.w.y) * largest.y +
                       std::abs(rows.w.z) * largest.z;
  const double near = view_.perspective ? -view_.near_cut.w : 0.0;
  const double distance = std::max(near, rows.w.constant - reach);
  const double beside = (e.u + e.v + e.w) / kErrorOfTerms;
  return terms <= kLargestTerm && beside <= kLargestReach * distance;
}

void ItemBufferFrame::drawAll(gpu::ItemPass& pass) {
  // Where nobody can tell which side is shown, a surface may be seen and does not block.
  const auto sided = [&](std::uint32_t i) { return items_[i].facing != 0; };
  draw(pass, Stage::kNearest, Part::kBlocking, sided);
  stats_.occluders_drawn = static_cast<std::uint32_t>(items_drawn_);
  pass.countTaken();
  if (parts_.ties && !budget_.stopped()) pass.read(counts_);
  const auto not_found = [&](std::uint32_t i) {
    return !sided(i) || (parts_.ties && counts_[i] == 0);
  };
  draw(pass, Stage::kAsked, Part::kBlocking, not_found);
  draw(pass, Stage::kAsked, Part::kShowing, [](std::uint32_t) { return true; });
}

template <typename Wanted>
void ItemBufferFrame::draw(gpu::ItemPass& pass, Stage stage, Part part, const Wanted& wanted) {
  for (std::uint32_t i = 0; i < items_.size() && !budget_.stopped(); ++i) {
    const ItemMesh& mesh = meshes_.mesh(items_[i].mesh);
    if (!(part == Part::kBlocking ? mesh.blocks() : mesh.shows()) || !wanted(i)) continue;
    add(i, part);
    if (batch_.size() == kMostInBatch || batch_triangles_ >= kManyTriangles) flush(pass, stage);
  }
  flush(pass, stage);
}

/// To the batch, and to the draws of its mesh if the last one was of the same.
void ItemBufferFrame::add(std::uint32_t number, Part part) {
  const Drawn& item = items_[number];
  const Drawn* last = batch_.empty() ? nullptr : &items_[batch_.back().number];
  if (last == nullptr || last->mesh != item.mesh || last->facing != item.facing) {
    const auto first = static_cast<std::uint32_t>(batch_.size());
    const bool blocking = part == Part::kBlocking;
    group_draws_ = 0;
    for (const ItemRun run :
         {blocking ? kBlockFront : kShowFront, blocking ? kBlockBoth : kShowBoth}) {
      const ItemMesh::Run& indices = meshes_.mesh(item.mesh).runs[run];
      if (indices.index_count == 0) continue;
      const bool both_sides = run == kBlockBoth || run == kShowBoth;
      draws_.push_back(
          {indices.first_index, indices.index_count, first, 0, facingOf(item.facing, both_sides)});
      ++group_draws_;
    }
  }
  batch_.push_back(itemOf(rowsOf(scene_.instance(item.id)), view_.perspective, number));
  for (std::size_t i = draws_.size() - group_draws_; i < draws_.size(); ++i) {
    ++draws_[i].item_count;
    batch_triangles_ += draws_[i].index_count / 3;
  }
}

void ItemBufferFrame::flush(gpu::ItemPass& pass, Stage stage) {
  items_drawn_ += batch_.size();
  triangles_ += batch_triangles_;
  budget_.lookNext();
  if (budget_.mayGoOn(countedNs())) pass.draw(stage, source_, batch_, draws_);
  batch_.clear();
  draws_.clear();
  batch_triangles_ = 0;
}

ItemPixels ItemBufferFrame::report(Answer& answer) {
  constexpr std::uint64_t kMost = 0xFFFFFFFFU;
  stats_.work = budget_.work(countedNs());
  stats_.triangles_drawn = static_cast<std::uint32_t>(std::min(triangles_, kMost));
  answer.stats = stats_;
  answer.out_of_budget = budget_.stopped();
  ItemPixels pixels;
  if (budget_.stopped()) return pixels;
  answer.visible = kept_;
  const auto samples_per_pixel = static_cast<float>(parts_.lattice * parts_.lattice);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const ObjectId id = items_[i].id;
    const bool kept = meshes_.mesh(items_[i].mesh).thin;
    if (counts_[i] != 0)
      pixels.emplace_back(id, static_cast<float>(counts_[i]) / samples_per_pixel);
    if (counts_[i] != 0 && !kept) answer.visible.push_back(id);
    if (counts_[i] == 0 && !kept) ++answer.stats.occluded;
  }
  std::sort(pixels.begin(), pixels.end());
  return pixels;
}

ObjectRows ItemBufferFrame::rowsOf(const Instance& instance) const {
  return objectRows(view_, instance.world_from_mesh, eye_world_,
                    meshes_.mesh(instance.mesh).largest);
}

std::uint64_t ItemBufferFrame::countedNs() const {
  return static_cast<std::uint64_t>(stats_.work.count()) + kFrameNs + kItemNs * items_drawn_ +
         kTriangleNs * triangles_;
}

}  // namespace culld
