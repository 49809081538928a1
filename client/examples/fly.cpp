// Sends cameras without waiting, and prints every answer as it comes: the SDK from C++, with
// callbacks. usage: fly ADDRESS SCENE [CAMERAS]; exit 0 if the last camera was answered.
#include <culld/connection.h>

#include <cstdlib>
#include <future>
#include <iostream>
#include <string>

using namespace culld::client;

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: fly ADDRESS SCENE [CAMERAS]\n";
    return 2;
  }
  const auto address = parseAddress(argv[1]);
  if (!address) {
    std::cerr << "fly: " << address.error().message << '\n';
    return 2;
  }
  ConnectOptions options;
  if (const char* token = std::getenv("CULLD_TOKEN")) options.access.token = token;
  auto connection = Connection::open(address.value(), argv[2], options);
  if (!connection) {
    std::cerr << "fly: " << connection.error().message << '\n';
    return 69;
  }
  auto view = connection.value()->openView();
  if (!view) {
    std::cerr << "fly: " << view.error().message << '\n';
    return 1;
  }
  view.value().onFrame([](const FramePtr& frame) {
    std::cout << "camera " << frame->camera << ": " << frame->visible.size() << " of "
              << frame->scene_objects << " objects\n";
  });
  std::future<Result<FramePtr>> last;
  const int cameras = argc > 3 ? std::atoi(argv[3]) : 10;
  for (int i = 0; i < cameras; ++i) {
    culld::protocol::LookAt look;
    look.eye = {0, 1.7, 50.0 - i};
    look.target = {0, 1.7, 0};
    Camera camera;
    camera.pose = look;
    last = view.value().setCamera(camera);  // the newest wins
  }
  return last.valid() && last.get().ok() ? 0 : 1;
}
