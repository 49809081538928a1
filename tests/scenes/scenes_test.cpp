#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "tests/scenes/known_scenes.h"
#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

/// Six times the volume that the triangles enclose; positive if they face outwards.
double volumeOf(const Triangles& t) {
  double volume = 0.0;
  for (std::size_t i = 0; i < t.indices.size(); i += 3) {
    const glm::dvec3 a(t.positions[t.indices[i]]), b(t.positions[t.indices[i + 1]]),
        c(t.positions[t.indices[i + 2]]);
    volume += glm::dot(a, glm::cross(b, c));
  }
  return volume;
}

bool closed(const Triangles& t) {
  Model model;
  model.addMaterial({});
  model.addNode({kNone, model.addMesh({"", {{t, 0}}}), kIdentity, ""});
  const SnapshotPtr scene = toSnapshot(model);
  const auto& partners = scene->mesh(0).partners;
  return std::find(partners.begin(), partners.end(), kOpenEdge) == partners.end();
}

TEST(Shapes, ClosedBodiesAreClosedAndFaceOutwards) {
  Random random(4);
  const std::vector<glm::vec2> corner{{-1, -1}, {-1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, -1}};
  const std::vector<Triangles> bodies{
      box({1, 2, 3}, {2, 4, 6}), prism(corner, 0, 2, 3), prism(regularFootprint(7, 2), 1, 2),
      ball(6, 0.0, random),      ball(6, 0.3, random),   torus(9, 5, 1.0F, 0.3F)};
  for (const Triangles& body : bodies) {
    EXPECT_TRUE(closed(body));
    EXPECT_GT(volumeOf(body), 0.0);
  }
  EXPECT_NEAR(volumeOf(bodies[0]), 6 * 6.0, 1e-9);
  EXPECT_NEAR(volumeOf(bodies[1]), 6 * 6.0, 1e-9);
}

/// What the first tests of a method rely on, checked by trying rays one by one.
class Rays {
 public:
  explicit Rays(const SceneSnapshot& scene) {
    for (ObjectId id = 0; id < scene.objectCount(); ++id) {
      const Instance& instance = scene.instance(id);
      const Mesh& mesh = scene.mesh(instance.mesh);
      for (const Surface& s : mesh.surfaces) {
        for (std::uint32_t t = 0; t < s.triangle_count; ++t) {
          Face face{id, s.blocks, s.double_sided, {}};
          for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3 p(mesh.positions[mesh.triangles[s.first_triangle + t][k]]);
            const auto& m = instance.world_from_mesh;
            face.corner[k] = {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                              m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
          }
          if (mirrors(instance.world_from_mesh)) std::swap(face.corner[1], face.corner[2]);
          faces_.push_back(face);
        }
      }
    }
  }

  /// Objects that some ray of many finds: at random points, corners, and between any two corners.
  std::set<ObjectId> seenFrom(const Camera& camera) const {
    std::set<ObjectId> seen;
    Random random(9);
    std::vector<glm::dvec3> corners;
    for (const Face& f : faces_) {
      const bool few = faces_.size() < 200;
      for (const glm::dvec3& c : f.corner) {
        if (few) corners.push_back(c);
        shoot(camera, c, seen);
      }
      for (int i = 0; i < (few ? 200 : 4); ++i) {
        const double u = random.unit(), v = random.unit() * (1 - u);
        shoot(camera,
              f.corner[0] + u * (f.corner[1] - f.corner[0]) + v * (f.corner[2] - f.corner[0]),
              seen);
      }
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) shoot(camera, 0.5 * (corners[i] + corners[j]), seen);
    }
    return seen;
  }

 private:
  struct Face {
    ObjectId object;
    bool blocks, double_sided;
    std::array<glm::dvec3, 3> corner;
  };

  static bool inFrustum(const Camera& camera, const glm::dvec3& p) {
    const glm::dvec4 v(p - camera.origin_world, 1.0);
    const double x = glm::dot(camera.x_row, v), y = glm::dot(camera.y_row, v),
                 z = glm::dot(camera.z_row, v), w = glm::dot(camera.w_row, v);
    return std::abs(x) < w && std::abs(y) < w && std::abs(z) < w;
  }

  /// The ray of the pixel in which `through` lies: where it starts and where it goes.
  static std::pair<glm::dvec3, glm::dvec3> rayThrough(const Camera& camera,
                                                      const glm::dvec3& through) {
    if (camera.perspective) return {camera.origin_world, through - camera.origin_world};
    const glm::dvec3 ahead = glm::normalize(glm::dvec3(camera.z_row));
    const double depth = glm::dot(through - camera.origin_world, ahead);
    return {through - depth * ahead, depth * ahead};
  }

  void shoot(const Camera& camera, const glm::dvec3& through, std::set<ObjectId>& seen) const {
    const auto [from, along] = rayThrough(camera, through);
    double stop = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, const Face*>> hits;
    for (const Face& f : faces_) {
      const auto t = hit(f, from, along);
      if (!t) continue;
      hits.emplace_back(*t, &f);
      if (f.blocks) stop = std::min(stop, *t);
    }
    for (const auto& [t, face] : hits) {
      const bool first = t <= stop * (1 + 1e-9);  // a tie hides nothing
      if (first && inFrustum(camera, from + t * along)) seen.insert(face->object);
    }
  }

  /// Möller and Trumbore 1997; from the front only, unless double-sided.
  static std::optional<double> hit(const Face& f, const glm::dvec3& from, const glm::dvec3& along) {
    const glm::dvec3 u = f.corner[1] - f.corner[0], v = f.corner[2] - f.corner[0];
    const glm::dvec3 normal = glm::cross(u, v);
    const double facing = -glm::dot(normal, along);
    if (facing == 0.0 || (facing < 0.0 && !f.double_sided)) return std::nullopt;
    const glm::dvec3 to = from - f.corner[0], side = glm::cross(to, along);
    const double b = glm::dot(v, side) / facing, c = -glm::dot(u, side) / facing;
    const double t = glm::dot(to, normal) / facing;
    if (b < 0 || c < 0 || b + c > 1 || t <= 0) return std::nullopt;
    return t;
  }

  std::vector<Face> faces_;
};

TEST(KnownScenes, SayWhatRaysFind) {
  for (const KnownScene& known : knownScenes()) {
    SCOPED_TRACE(known.name);
    const Result<Camera> camera = toCamera(known.camera);
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    const std::set<ObjectId> seen = Rays(*known.snapshot).seenFrom(camera.value());
    for (const ObjectId id : known.must_be_visible) EXPECT_TRUE(seen.count(id)) << "object " << id;
    for (const ObjectId id : known.can_be_hidden) EXPECT_FALSE(seen.count(id)) << "object " << id;
    for (const ObjectId id : known.outside) EXPECT_FALSE(seen.count(id)) << "object " << id;
  }
}

TEST(KnownScenes, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const KnownScene& known : knownScenes()) EXPECT_TRUE(names.insert(known.name).second);
  EXPECT_GE(names.size(), 30U);
}

TEST(RandomScene, IsNamedByItsSeed) {
  EXPECT_EQ(toGlb(randomModel(5)), toGlb(randomModel(5)));
  EXPECT_EQ(randomScene(5)->contentHash(), randomScene(5)->contentHash());
  EXPECT_NE(randomScene(5)->contentHash(), randomScene(6)->contentHash());
}

TEST(RandomScene, KeepsToItsOptions) {
  RandomSceneOptions plain;
  plain.odd_transforms = plain.see_through = plain.any_scale = false;
  plain.max_offset_m = 0;
  std::size_t odd = 0, see_through = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const SnapshotPtr tame = randomScene(seed, plain), wild = randomScene(seed);
    EXPECT_GE(tame->objectCount(), plain.objects);
    EXPECT_LE(tame->objectCount(), plain.objects + 40);
    for (ObjectId id = 0; id < tame->objectCount(); ++id) {
      EXPECT_FALSE(mirrors(tame->instance(id).world_from_mesh));
      EXPECT_TRUE(tame->instance(id).active());
      EXPECT_EQ(tame->instance(id).node, id);
    }
    for (ObjectId id = 0; id < wild->objectCount(); ++id) {
      odd += mirrors(wild->instance(id).world_from_mesh) ? 1U : 0U;
    }
    for (MeshId m = 0; m < tame->meshCount(); ++m) {
      for (const Surface& s : tame->mesh(m).surfaces) EXPECT_TRUE(s.blocks);
    }
    for (MeshId m = 0; m < wild->meshCount(); ++m) {
      for (const Surface& s : wild->mesh(m).surfaces) see_through += s.blocks ? 0 : 1;
    }
  }
  EXPECT_GT(odd, 50U);
  EXPECT_GT(see_through, 50U);
}

TEST(RandomCameras, AreAllValidOfAllKindsAndRepeatable) {
  std::set<std::string> kinds;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const SnapshotPtr scene = randomScene(seed);
    const std::vector<CameraSpec> cameras = randomCameras(seed, *scene, 20);
    EXPECT_EQ(toJson(cameras), toJson(randomCameras(seed, *scene, 20)));
    for (const CameraSpec& spec : cameras) {
      EXPECT_TRUE(toCamera(spec).ok());
      kinds.insert(spec.what);
    }
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"look-at", "mirrored", "oblique", "off-centre",
                                          "orthographic", "perspective"}));
}

TEST(RandomCameras, ExistForAnEmptySceneToo) {
  EXPECT_EQ(randomCameras(1, *toSnapshot({}), 5).size(), 5U);
}

/// The JSON chunk of a .glb; checks the framing on the way.
nlohmann::json documentOf(const std::vector<std::byte>& glb) {
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, glb.data() + at, 4);
    return value;
  };
  EXPECT_EQ(word(0), 0x46546C67U);
  EXPECT_EQ(word(8), glb.size());
  const std::size_t json_size = word(12);
  EXPECT_EQ(json_size % 4, 0U);
  if (glb.size() > 20 + json_size) {
    EXPECT_EQ(word(20 + json_size) + 28 + json_size, glb.size());
  }
  const char* text = reinterpret_cast<const char*>(glb.data()) + 20;
  return nlohmann::json::parse(text, text + json_size);
}

TEST(GlbWriter, WritesNodesMaterialsAndTransformsByName) {
  Model model;
  const std::uint32_t glass = model.addMaterial({"glass", {1, 1, 1, 0.5F}, Alpha::kBlend, true});
  const std::uint32_t cube = model.addMesh({"cube", {{box({0, 0, 0}, {1, 1, 1}), glass}}});
  const std::uint32_t group = model.addNode({kNone, kNone, movedBy({1, 2, 3.5}), "group"});
  model.addNode({group, cube, scaledAndMoved({2, 2, -2}, {0, 0, 0}), "Würfel"});
  model.addNode({group, cube, {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 7}, ""});
  const nlohmann::json document = documentOf(toGlb(model));
  EXPECT_EQ(document["nodes"][0]["translation"], nlohmann::json({1, 2, 3.5}));
  EXPECT_EQ(document["nodes"][0]["children"], nlohmann::json({1, 2}));
  EXPECT_EQ(document["nodes"][1]["scale"], nlohmann::json({2, 2, -2}));
  EXPECT_EQ(document["nodes"][1]["name"], "Würfel");
  EXPECT_EQ(document["nodes"][2]["matrix"][14], 7);
  EXPECT_EQ(document["scenes"][0]["nodes"], nlohmann::json::array({0}));
  EXPECT_EQ(document["materials"][0]["alphaMode"], "BLEND");
  EXPECT_EQ(document["materials"][0]["doubleSided"], true);
  EXPECT_EQ(document["accessors"][0]["max"], nlohmann::json({1, 1, 1}));
}

TEST(GlbWriter, AnEmptyModelIsAFileToo) {
  const nlohmann::json document = documentOf(toGlb({}));
  EXPECT_EQ(document["asset"]["version"], "2.0");
  EXPECT_FALSE(document.contains("buffers"));
}

}  // namespace
}  // namespace culld::scenes
