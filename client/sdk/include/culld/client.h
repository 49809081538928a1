/* The client SDK of culld for C11, and for whatever calls C: a live connection to one scene, views
 * on it, and their answers. docs/clients.md "C".
 *
 * Errors are codes; where a function takes a culld_error*, it may be NULL, and else receives code
 * and message. Handles are opaque; each is freed once by its own function, which takes NULL too.
 * Strings are UTF-8, end with a zero, and are copied before a function returns.
 *
 * Threads: every function may be called on any thread. A connection has a thread of its own, and
 * all its callbacks are called on it, one at a time. A callback may call everything: what would
 * wait for its own thread (culld_open_view, culld_cull, culld_edit, culld_pairs, culld_ping)
 * refuses with CULLD_INVALID_INPUT, and freeing the connection there is allowed. A call that is
 * refused without asking the server, as after the end, may call back before it returns.
 *
 * Structs begin with their size: a program built with an older header works with a newer library.
 * Functions that are given a struct of a size which they do not know use what they do. */
#ifndef CULLD_CLIENT_H
#define CULLD_CLIENT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CULLD_API __attribute__((visibility("default")))

/* What this header describes; grows with every addition. The SONAME changes when something goes. */
#define CULLD_CLIENT_ABI 1
CULLD_API uint32_t culld_client_abi(void);        /* what the library has */
CULLD_API const char* culld_client_version(void); /* "0.1.0" */

typedef int32_t culld_code;
enum {
  CULLD_OK = 0,
  CULLD_INVALID_INPUT = 1, /* an argument, or what the server says about it */
  CULLD_UNSUPPORTED = 2,
  CULLD_NOT_FOUND = 3,
  CULLD_LIMIT = 4,
  CULLD_IO = 5,
  CULLD_UNAVAILABLE = 6, /* no server, no answer in time, connection lost, another version */
  CULLD_FORBIDDEN = 7,
  CULLD_CANCELLED = 8,
  CULLD_DEADLINE = 9,
  CULLD_NO_MEMORY = 10
};

typedef struct culld_error {
  culld_code code;
  char message[1020]; /* one line, cut if longer */
} culld_error;

typedef struct culld_connection culld_connection;
typedef struct culld_view culld_view;
typedef struct culld_frame culld_frame;

/* --- connections ------------------------------------------------------------------------------ */

typedef struct culld_options {
  size_t size;
  const char* token;   /* bearer token, or NULL */
  const char* ca_file; /* PEM, for wss://, or NULL: the authorities of the system */
  uint32_t connect_ms, reply_ms, idle_ms;
  int32_t reconnect; /* 0: a lost connection is the end */
  uint32_t reconnect_first_ms, reconnect_longest_ms;
  double reconnect_factor, reconnect_jitter;
  uint32_t reconnect_max_attempts; /* in a row; 0: for ever */
} culld_options;

/* Fills in the defaults. `size`: sizeof(culld_options). */
CULLD_API void culld_options_init(culld_options* options, size_t size);

/* "ws://HOST:PORT", "wss://HOST:PORT" or "unix:PATH". `options` NULL: the defaults. One attempt. */
CULLD_API culld_code culld_connect(const char* address, const char* scene,
                                   const culld_options* options, culld_connection** connection,
                                   culld_error* error);
/* Ends every wait on it, on whatever thread, and returns at once. */
CULLD_API void culld_connection_close(culld_connection* connection);
/* Closes it, and waits for its callbacks but the one it is called in. Views of it stay valid, and
 * answer with errors. */
CULLD_API void culld_connection_free(culld_connection* connection);

enum { CULLD_CONNECTED = 0, CULLD_RECONNECTING = 1, CULLD_ENDED = 2 };
CULLD_API int32_t culld_connection_state(const culld_connection* connection);
/* `reason->code` is CULLD_OK with CULLD_CONNECTED. NULL takes the callback away. */
typedef void (*culld_on_state)(void* user, int32_t state, const culld_error* reason);
CULLD_API void culld_connection_on_state(culld_connection* connection, culld_on_state callback,
                                         void* user);

typedef struct culld_scene_info {
  size_t size;
  uint64_t version, content_hash, triangles;
  uint32_t objects; /* every id is below this */
} culld_scene_info;
CULLD_API void culld_connection_scene(const culld_connection* connection, culld_scene_info* info,
                                      size_t size);
/* `replaced`: another scene under the name; every id is void. */
typedef void (*culld_on_scene)(void* user, const culld_scene_info* scene, int32_t replaced);
CULLD_API void culld_connection_on_scene(culld_connection* connection, culld_on_scene callback,
                                         void* user);

CULLD_API culld_code culld_ping(culld_connection* connection, uint64_t* round_trip_ns,
                                culld_error* error);

enum { CULLD_MOVE = 0, CULLD_HIDE = 1, CULLD_SHOW = 2, CULLD_REMOVE = 3, CULLD_ADD = 4 };
typedef struct culld_edit_item { /* of fixed size: an array of them is passed */
  int32_t kind;
  uint32_t object;            /* with CULLD_ADD: the object to be like */
  double world_from_mesh[12]; /* three rows; with CULLD_MOVE and CULLD_ADD */
} culld_edit_item;
/* All or none. `expected_version` 0: any. `added` receives up to `added_capacity` ids of added
 * objects, `added_count` how many there are. `version`, `added`, `added_count` may be NULL. */
CULLD_API culld_code culld_edit(culld_connection* connection, const culld_edit_item* items,
                                size_t count, uint64_t expected_version, uint64_t* version,
                                uint32_t* added, size_t added_capacity, size_t* added_count,
                                culld_error* error);

typedef struct culld_place { /* of fixed size: arrays of them are passed */
  double min[3], max[3];     /* a box of world space, metres; equal for a point */
  double radius_m;           /* how far it may move */
} culld_place;
/* Which viewers may see which targets? Of `may_see` bit v * target_count + t, lowest of each byte
 * first, is 0 only where it is proven that they cannot; (viewer_count * target_count + 7) / 8
 * bytes. `time_us` 0: what the server allows, two seconds. `version` may be NULL. */
CULLD_API culld_code culld_pairs(culld_connection* connection, const culld_place* viewers,
                                 size_t viewer_count, const culld_place* targets,
                                 size_t target_count, uint32_t time_us, uint8_t* may_see,
                                 uint64_t* version, culld_error* error);

/* --- views ------------------------------------------------------------------------------------ */

enum { CULLD_LOOK_AT = 0, CULLD_MATRICES = 1 };
typedef struct culld_camera {
  size_t size;
  int32_t kind;
  double eye[3], target[3], up[3];  /* CULLD_LOOK_AT; metres, world space */
  double yfov_rad, aspect, znear_m; /* CULLD_LOOK_AT */
  double zfar_m;                    /* CULLD_LOOK_AT; 0: infinite */
  double view[16], projection[16];  /* CULLD_MATRICES; column-major, OpenGL clip space */
  uint32_t width_px, height_px;
  double radius_m, angle_rad; /* motion bound */
} culld_camera;
CULLD_API void culld_camera_init(culld_camera* camera, size_t size);

enum { CULLD_CONSERVATIVE = 0, CULLD_HOLE = 1, CULLD_SAMPLED = 2, CULLD_APPROXIMATE = 3 };
typedef struct culld_demand {
  size_t size;
  int32_t guarantee;
  float hole_px, accepted_missed_px;
  uint32_t time_us; /* 0: no limit */
} culld_demand;
CULLD_API void culld_demand_init(culld_demand* demand, size_t size);

/* `method` NULL: the server chooses. */
CULLD_API culld_code culld_open_view(culld_connection* connection, const char* method,
                                     int32_t want_seen, culld_view** view, culld_error* error);
CULLD_API void culld_view_free(culld_view* view);

/* Asks and waits. `demand` NULL: a conservative answer. */
CULLD_API culld_code culld_cull(culld_view* view, const culld_camera* camera,
                                const culld_demand* demand, culld_frame** frame,
                                culld_error* error);

/* `frame` is NULL if there is an error; it is lent for the time of the call. */
typedef void (*culld_on_answer)(void* user, const culld_frame* frame, const culld_error* error);
/* Asks and returns at once; `callback` (may be NULL) is called once, with the answer to this camera
 * or to a newer one. Returns the camera's number, from 1, or 0 if nothing was asked. */
CULLD_API uint64_t culld_set_camera(culld_view* view, const culld_camera* camera,
                                    const culld_demand* demand, culld_on_answer callback,
                                    void* user);
typedef void (*culld_on_frame)(void* user, const culld_frame* frame);
/* For every answer. NULL takes the callback away. */
CULLD_API void culld_view_on_frame(culld_view* view, culld_on_frame callback, void* user);
/* 0: none. */
CULLD_API void culld_view_set_deadline(culld_view* view, uint32_t deadline_us);
/* What waits ends with CULLD_CANCELLED, unless an answer is on its way. */
CULLD_API void culld_view_cancel(culld_view* view);

/* --- answers ---------------------------------------------------------------------------------- */

typedef struct culld_frame_info {
  size_t size;
  uint64_t camera; /* the number of the camera that it answers */
  uint64_t scene_version, cull_ns;
  uint32_t scene_objects, seen_count, kept_count, superseded;
  int32_t guarantee, proven, out_of_budget, delta;
  float missed_px;
} culld_frame_info;
CULLD_API void culld_frame_get_info(const culld_frame* frame, culld_frame_info* info, size_t size);
/* The visible object ids, ascending; they live as long as the frame. */
CULLD_API const uint32_t* culld_frame_ids(const culld_frame* frame, size_t* count);
/* Per id 1: certainly visible. NULL if the method does not tell, or it was not asked for. */
CULLD_API const uint8_t* culld_frame_seen(const culld_frame* frame);
/* A handle of one's own to a frame that was lent; NULL without memory. */
CULLD_API culld_frame* culld_frame_keep(const culld_frame* frame);
CULLD_API void culld_frame_free(culld_frame* frame);

#ifdef __cplusplus
}
#endif
#endif
