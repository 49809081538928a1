/* Flies towards the middle of a scene and prints what can be seen: the SDK from C11.
 * usage: fly ADDRESS SCENE [FRAMES]; exit 0 if every camera was answered. */
#include <culld/client.h>
#include <stdio.h>
#include <stdlib.h>

static void tell_state(void* user, int32_t state, const culld_error* reason) {
  static const char* const names[] = {"connected", "reconnecting", "ended"};
  (void)user;
  fprintf(stderr, "fly: %s %s\n", names[state], reason->message);
}

static int fly(culld_view* view, int frames) {
  culld_camera camera;
  culld_camera_init(&camera, sizeof camera);
  for (int i = 0; i < frames; ++i) {
    culld_error error;
    culld_frame* frame = NULL;
    culld_frame_info info;
    size_t count = 0;
    camera.eye[1] = 1.7;
    camera.eye[2] = 50.0 - i;
    camera.target[1] = 1.7;
    camera.target[2] = 0.0;
    if (culld_cull(view, &camera, NULL, &frame, &error) != CULLD_OK) {
      fprintf(stderr, "fly: %s\n", error.message);
      return 1;
    }
    culld_frame_get_info(frame, &info, sizeof info);
    culld_frame_ids(frame, &count);
    printf("camera %llu: %zu of %u objects, %.3f ms%s\n", (unsigned long long)info.camera, count,
           (unsigned)info.scene_objects, (double)info.cull_ns * 1e-6,
           info.delta ? ", sent as a change" : "");
    culld_frame_free(frame);
  }
  return 0;
}

int main(int argc, char** argv) {
  culld_connection* connection = NULL;
  culld_view* view = NULL;
  culld_options options;
  culld_error error;
  if (argc < 3) {
    fprintf(stderr, "usage: fly ADDRESS SCENE [FRAMES]\n");
    return 2;
  }
  culld_options_init(&options, sizeof options);
  options.token = getenv("CULLD_TOKEN");
  if (culld_connect(argv[1], argv[2], &options, &connection, &error) != CULLD_OK) {
    fprintf(stderr, "fly: %s\n", error.message);
    return 69;
  }
  culld_connection_on_state(connection, tell_state, NULL);
  int result = 1;
  if (culld_open_view(connection, NULL, 0, &view, &error) == CULLD_OK) {
    result = fly(view, argc > 3 ? atoi(argv[3]) : 10);
  } else {
    fprintf(stderr, "fly: %s\n", error.message);
  }
  culld_view_free(view);
  culld_connection_free(connection);
  return result;
}
