// The SDK against the daemon with the engine behind it: what a program that links it lives on.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "culld/connection.h"
#include "culld/scenes.h"
#include "culling/culler.h"
#include "server/server.h"
#include "server/translate.h"
#include "tests/scenes/model.h"
#include "tests/scenes/random_scene.h"

namespace culld::client {
namespace {

using namespace std::chrono_literals;
using Ids = std::vector<std::uint32_t>;

constexpr std::uint32_t kRow = 9;

/// Triangles side by side at x = 0, 2, 4, ...; none hides another.
scenes::Model rowOfTriangles() {
  scenes::Model model;
  model.addMaterial({});
  const scenes::Triangles triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}};
  const auto mesh = model.addMesh({"triangle", {{triangle, 0}}});
  for (std::uint32_t i = 0; i < kRow; ++i) {
    model.addNode({scenes::kNone, mesh, scenes::movedBy({2.0 * i, 0, 0}), ""});
  }
  return model;
}

Camera lookingAt(double x, double distance) {
  protocol::LookAt look;
  look.eye = {x, 0.3, distance};
  look.target = {x, 0.3, 0};
  Camera camera;
  camera.pose = look;
  return camera;
}

Ids all(std::uint32_t count) {
  Ids ids;
  for (std::uint32_t i = 0; i < count; ++i) ids.push_back(i);
  return ids;
}

std::array<double, 3> onTheWire(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

std::array<double, 16> onTheWire(const glm::dmat4& m) {
  std::array<double, 16> columns{};
  for (std::size_t i = 0; i < 16; ++i) {
    columns[i] = m[static_cast<int>(i / 4)][static_cast<int>(i % 4)];
  }
  return columns;
}

Camera onTheWire(const scenes::CameraSpec& spec) {
  Camera camera;
  camera.width_px = spec.image.width_px;
  camera.height_px = spec.image.height_px;
  if (const auto* matrices = std::get_if<scenes::ViewProjection>(&spec.pose)) {
    camera.pose = protocol::Matrices{onTheWire(matrices->view), onTheWire(matrices->projection)};
    return camera;
  }
  const auto& look = std::get<LookAt>(spec.pose);
  camera.pose = protocol::LookAt{
      onTheWire(look.eye), onTheWire(look.target), onTheWire(look.up), look.yfov_rad,
      look.aspect,         look.znear_m,           look.zfar_m};
  return camera;
}

class SdkTest : public ::testing::Test {
 protected:
  SdkTest() {
    std::filesystem::create_directories(folder_);
    server::ServerOptions options;
    options.listen_port = 0;
    options.unix_path = (folder_ / "sock").string();
    options.threads = 2;
    options.methods = allMethods();
    options.limits.session.max_views = 2;
    auto started = server::Server::start(options);
    EXPECT_TRUE(started.ok()) << started.error().message;
    server_ = std::move(started).value();
    EXPECT_TRUE(server_->loadScenes().ok());
    tcp_ = {"127.0.0.1", server_->port(), {}};
    unix_ = {{}, 0, options.unix_path};
  }
  ~SdkTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  void put(const std::string& name, const scenes::Model& model) {
    const auto bytes = scenes::toGlb(model);
    const auto path = (folder_ / (name + ".glb")).string();
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    const auto scene = Scenes(tcp_).put(name, path);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene.value().info.objects, model.objectCount());
  }
  std::unique_ptr<Connection> connect(const std::string& scene, const Address& address) {
    auto connection = Connection::open(address, scene);
    EXPECT_TRUE(connection.ok()) << connection.error().message;
    return connection ? std::move(connection).value() : nullptr;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("culld_sdk_test." + std::to_string(::getpid()));
  std::unique_ptr<server::Server> server_;
  Address tcp_, unix_;
};

TEST_F(SdkTest, KeepsTheSetsOfTwoViewsEqualToThoseOfTheEngine) {
  const std::uint64_t seed = 11;
  scenes::RandomSceneOptions options;
  options.objects = 300;
  put("random", scenes::randomModel(seed, options));
  const SnapshotPtr snapshot = scenes::randomScene(seed, options);
  const auto cameras = scenes::randomCameras(seed, *snapshot, 60);
  for (const Address& address : {tcp_, unix_}) {
    auto connection = connect("random", address);
    ASSERT_NE(connection, nullptr);
    std::size_t changes = 0;
    std::vector<View> views;
    std::vector<std::unique_ptr<Culler>> cullers;
    for (const char* name : {"frustum", "raster"}) {
      auto view = connection->openView(name);
      ASSERT_TRUE(view.ok()) << view.error().message;
      views.push_back(view.value());
      cullers.push_back(findMethod(name)->prepare(snapshot).value());
    }
    for (const scenes::CameraSpec& spec : cameras) {
      const Camera camera = onTheWire(spec);
      const culld::Camera engine_camera = server::toEngine(camera).value();
      for (std::size_t v = 0; v < views.size(); ++v) {
        ViewState fresh;
        const auto frame = views[v].cull(camera);
        ASSERT_TRUE(frame.ok()) << frame.error().message;
        EXPECT_EQ(frame.value()->visible, cullers[v]->cull(engine_camera, {}, fresh).visible)
            << spec.what;
        if (frame.value()->delta) ++changes;
      }
    }
    EXPECT_GT(changes, 0U);
  }
}

TEST_F(SdkTest, SeesItsOwnEditInTheNextAnswer) {
  put("row", rowOfTriangles());
  auto connection = connect("row", tcp_);
  ASSERT_NE(connection, nullptr);
  auto view = connection->openView("frustum").value();
  const Camera camera = lookingAt(8.0, 30.0);
  EXPECT_EQ(view.cull(camera).value()->visible, all(kRow));

  EditItem hide{protocol::EditKind::kHide, 3, {}};
  EditItem move{protocol::EditKind::kMove, 4, {1, 0, 0, 8, 0, 1, 0, 500, 0, 0, 1, 0}};
  EditItem add{protocol::EditKind::kAdd, 0, {1, 0, 0, 8, 0, 1, 0, 0.5, 0, 0, 1, 0}};
  const auto edited = connection->edit({hide, move, add});
  ASSERT_TRUE(edited.ok()) << edited.error().message;
  EXPECT_EQ(edited.value().scene_version, 2U);
  EXPECT_EQ(edited.value().added, Ids{kRow});
  const auto frame = view.cull(camera);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, (Ids{0, 1, 2, 5, 6, 7, 8, 9}));
  EXPECT_EQ(frame.value()->scene_version, 2U);
  EXPECT_EQ(frame.value()->scene_objects, kRow + 1);

  EditItem show{protocol::EditKind::kShow, 3, {}};
  EditItem remove{protocol::EditKind::kRemove, 0, {}};
  ASSERT_TRUE(connection->edit({show, remove}, 2).ok());
  EXPECT_EQ(view.cull(camera).value()->visible, (Ids{1, 2, 3, 5, 6, 7, 8, 9}));
}

TEST_F(SdkTest, TellsWhichViewersMaySeeWhichTargets) {
  put("row", rowOfTriangles());
  auto connection = connect("row", unix_);
  ASSERT_NE(connection, nullptr);
  const Place before{{2.25, 0.25, 5}, {2.25, 0.25, 5}, 0.0};
  const Place behind{{2.25, 0.25, -5}, {2.25, 0.25, -5}, 0.0};
  const Place beside{{-20, 0, -5}, {-19, 1, -4}, 0.5};
  const auto outcome = connection->pairs({before, behind}, {behind, beside, before});
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome.value().viewers, 2U);
  EXPECT_EQ(outcome.value().targets, 3U);
  EXPECT_FALSE(outcome.value().maySee(0, 0));
  EXPECT_TRUE(outcome.value().maySee(0, 1));
  EXPECT_TRUE(outcome.value().maySee(0, 2));
  EXPECT_TRUE(outcome.value().maySee(1, 2)) << "triangles have one side";

  ASSERT_TRUE(connection->edit({{protocol::EditKind::kHide, 1, {}}}).ok());
  const auto after = connection->pairs({before}, {behind});
  ASSERT_TRUE(after.ok()) << after.error().message;
  EXPECT_TRUE(after.value().maySee(0, 0));
  EXPECT_EQ(after.value().scene_version, 2U);

  const Place none{{1, 0, 0}, {0, 0, 0}, 0.0};
  const auto refused = connection->pairs({before}, {behind, none});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidInput);
  EXPECT_NE(refused.error().message.find("target 1: an empty box"), std::string::npos)
      << refused.error().message;
  const auto many =
      connection->pairs(std::vector<Place>(300, before), std::vector<Place>(300, behind));
  ASSERT_FALSE(many.ok());
  EXPECT_EQ(many.error().code, ErrorCode::kLimit) << many.error().message;
}

TEST_F(SdkTest, LeavesTheSceneAloneWhenOneEditIsWrongOrTheVersionIsAnother) {
  put("row", rowOfTriangles());
  auto connection = connect("row", tcp_);
  ASSERT_NE(connection, nullptr);
  const EditItem hide{protocol::EditKind::kHide, 3, {}};
  const auto unknown = connection->edit({hide, {protocol::EditKind::kHide, 77, {}}});
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, ErrorCode::kInvalidInput);
  EXPECT_NE(unknown.error().message.find("77"), std::string::npos) << unknown.error().message;
  const auto conflict = connection->edit({hide}, 5);
  ASSERT_FALSE(conflict.ok());
  EXPECT_EQ(conflict.error().code, ErrorCode::kUnavailable);
  auto view = connection->openView("frustum").value();
  const auto frame = view.cull(lookingAt(8.0, 30.0)).value();
  EXPECT_EQ(frame->visible, all(kRow));
  EXPECT_EQ(frame->scene_version, 1U);
}

TEST_F(SdkTest, HearsOfEditsAndReplacementsByOthers) {
  put("row", rowOfTriangles());
  std::promise<std::uint64_t> edited;
  std::promise<std::uint32_t> replaced;
  auto listener = connect("row", unix_);
  auto editor = connect("row", tcp_);
  ASSERT_TRUE(listener != nullptr && editor != nullptr);
  auto view = listener->openView("frustum").value();
  const Camera camera = lookingAt(8.0, 30.0);
  EXPECT_EQ(view.cull(camera).value()->visible, all(kRow));
  listener->onSceneChanged([&](const SceneInfo& scene, bool other) {
    other ? replaced.set_value(scene.objects) : edited.set_value(scene.version);
  });
  ASSERT_TRUE(editor->edit({{protocol::EditKind::kHide, 0, {}}}).ok());
  auto version = edited.get_future();
  ASSERT_EQ(version.wait_for(10s), std::future_status::ready);
  EXPECT_EQ(version.get(), 2U);
  EXPECT_EQ(view.cull(camera).value()->visible.front(), 1U);

  scenes::Model shorter = rowOfTriangles();
  shorter.nodes.resize(2);
  put("row", shorter);
  auto objects = replaced.get_future();
  ASSERT_EQ(objects.wait_for(10s), std::future_status::ready);
  EXPECT_EQ(objects.get(), 2U);
  const auto frame = view.cull(camera);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, all(2));
}

TEST_F(SdkTest, EndsWithAReasonWhenItsSceneIsRemoved) {
  put("row", rowOfTriangles());
  auto connection = connect("row", tcp_);
  ASSERT_NE(connection, nullptr);
  auto view = connection->openView("frustum").value();
  ASSERT_TRUE(view.cull(lookingAt(0, 5)).ok());
  ASSERT_TRUE(Scenes(tcp_).remove("row").ok());
  Result<FramePtr> frame = view.cull(lookingAt(0, 5));
  for (int i = 0; i < 100 && frame.ok(); ++i) {
    std::this_thread::sleep_for(50ms);
    frame = view.cull(lookingAt(0, 5));
  }
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kNotFound) << frame.error().message;
  EXPECT_EQ(connection->state(), ConnectionState::kEnded);
  EXPECT_EQ(Connection::open(tcp_, "row").error().code, ErrorCode::kNotFound);
}

TEST_F(SdkTest, NamesWhatTheServerRefuses) {
  put("row", rowOfTriangles());
  const auto nowhere = Connection::open(unix_, "nowhere");
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(nowhere.error().message, "scene \"nowhere\" is not known");
  auto connection = connect("row", tcp_);
  ASSERT_NE(connection, nullptr);
  const auto method = connection->openView("nope");
  ASSERT_FALSE(method.ok());
  EXPECT_EQ(method.error().code, ErrorCode::kNotFound);
  {
    const auto first = connection->openView(), second = connection->openView();
    ASSERT_TRUE(first.ok() && second.ok());
    const auto third = connection->openView();
    ASSERT_FALSE(third.ok());
    EXPECT_EQ(third.error().code, ErrorCode::kLimit);
  }
  auto again = connection->openView();  // the views above closed when they went out of scope
  ASSERT_TRUE(again.ok()) << again.error().message;
  Camera flat = lookingAt(0, 5);
  flat.width_px = 0;
  const auto frame = again.value().cull(flat);
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kInvalidInput);
  EXPECT_TRUE(again.value().cull(lookingAt(0, 5)).ok());
}

TEST_F(SdkTest, AnswersTheNewestOfManyCamerasInAHurry) {
  put("row", rowOfTriangles());
  auto connection = connect("row", tcp_);
  ASSERT_NE(connection, nullptr);
  auto view = connection->openView("frustum").value();
  std::vector<std::future<Result<FramePtr>>> futures;
  for (std::uint32_t i = 0; i < 500; ++i)
    futures.push_back(view.setCamera(lookingAt(2.0 * (i % kRow), 2)));
  std::uint32_t newest = 0;
  for (auto& future : futures) {
    ASSERT_EQ(future.wait_for(20s), std::future_status::ready);
    const auto frame = future.get();
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_GE(frame.value()->number, newest);
    newest = frame.value()->number;
  }
  EXPECT_EQ(view.newest()->visible, view.cull(lookingAt(2.0 * (499 % kRow), 2)).value()->visible);
}

TEST_F(SdkTest, GivesEveryClientItsOwnAnswers) {
  put("row", rowOfTriangles());
  std::vector<std::thread> clients;
  for (std::uint32_t i = 0; i < kRow; ++i) {
    clients.emplace_back([this, i] {
      auto connection = connect("row", i % 2 == 0 ? tcp_ : unix_);
      ASSERT_NE(connection, nullptr);
      auto view = connection->openView("frustum").value();
      for (int frame = 0; frame < 50; ++frame) {
        const auto answer = view.cull(lookingAt(2.0 * i + 0.4, 1.0));
        ASSERT_TRUE(answer.ok()) << answer.error().message;
        EXPECT_EQ(answer.value()->visible, Ids{i});
      }
    });
  }
  for (std::thread& client : clients) client.join();
}

}  // namespace
}  // namespace culld::client
