#!/bin/bash
# Tries an image of culld: starts it with a volume of its own, waits until it is healthy, uploads a scene, asks what a camera sees,
# stops it, starts it again, and expects the same answer from what the volume kept.
# usage: smoke.sh docker|podman|buildah IMAGE
# With buildah, options for it (where its storage is, say) are taken from BUILDAH_OPTIONS, and the image runs with chroot isolation:
# its own files and user, the host's network, so culld takes a free port there.
set -euo pipefail
[ $# = 2 ] || { sed -n 's/^# usage: /usage: /p' "$0" >&2; exit 2; }
engine=$1 image=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_smoke.XXXXXX")
container='' daemon=''
say() { printf '== %s\n' "$*"; }
die() { echo "FAILED: $*" >&2; [ ! -f "$work/log" ] || cat "$work/log" >&2; exit 1; }

# ---- the engines: create, start, inside COMMAND..., stop (sets $code), destroy, config FIELD ----

case $engine in
  docker | podman)
    create() { container=culld_smoke_$$; "$engine" volume create "$container" >/dev/null; }
    start() {
      "$engine" run -d --name "$container" -v "$container:/var/lib/culld" --read-only --tmpfs /tmp --tmpfs /run/culld:mode=0755,uid=7420 \
        --cap-drop ALL --security-opt no-new-privileges -e CULLD_ACCESS_ALLOW_PUBLIC=true "$image" >/dev/null
    }
    running() { [ "$("$engine" inspect -f '{{.State.Running}}' "$container")" = true ]; }
    inside() { "$engine" exec -i "$container" "$@"; }
    user_of_daemon() { "$engine" exec "$container" id -u; }
    stop() {
      "$engine" stop -t 30 "$container" >/dev/null
      code=$("$engine" inspect -f '{{.State.ExitCode}}' "$container")
      "$engine" logs "$container" >"$work/log" 2>&1
      "$engine" rm "$container" >/dev/null
    }
    destroy() { "$engine" rm -f "$container" >/dev/null 2>&1 || true; "$engine" volume rm "$container" >/dev/null 2>&1 || true; }
    config() { "$engine" inspect --type image -f "{{.Config.$1}}" "$image"; }
    ;;
  buildah)
    read -ra options <<<"${BUILDAH_OPTIONS:-}"
    b() { buildah "${options[@]}" "$@"; }
    create() {
      container=$(b from "$image")
      mkdir -m 0777 "$work/data"
    }
    in_container() { b run --isolation chroot -v "$work/data:/var/lib/culld" -e CULLD_LISTEN=127.0.0.1:0 "$@"; }
    start() {
      local command
      mapfile -t command < <(b inspect --type image --format '{{range .OCIv1.Config.Entrypoint}}{{println .}}{{end}}{{range .OCIv1.Config.Cmd}}{{println .}}{{end}}' "$image" | grep .)
      in_container "$container" -- sh -c 'echo $$ >/var/lib/culld/pid; exec "$@"' sh "${command[@]}" >"$work/log" 2>&1 &
      daemon=$!
    }
    running() { kill -0 "$daemon" 2>/dev/null; }
    inside() { in_container "$container" -- "$@"; }
    user_of_daemon() { stat -c %u "/proc/$(cat "$work/data/pid")"; }
    stop() {
      code=0
      kill -TERM "$(cat "$work/data/pid")"
      wait "$daemon" || code=$?
      daemon=''
    }
    destroy() { [ -z "$daemon" ] || stop; b rm "$container" >/dev/null; }
    config() { b inspect --type image --format "{{.Docker.Config.$1}}" "$image"; }
    ;;
  *) die "$engine: not docker, podman or buildah" ;;
esac
clean_up() {
  [ -z "$container" ] || destroy
  rm -rf "$work"
}
trap clean_up EXIT

healthy() {
  local i
  for ((i = 0; i < 300; i++)); do
    if inside cullctl ping --connect unix:/run/culld/culld.sock >/dev/null 2>&1; then return 0; fi
    running || die "culld ended"
    sleep 0.2
  done
  die "not healthy after 60 s"
}

# One triangle at z = 0 whose glTF node is 0, and a camera that looks at it.
scene() {
  printf '%s' '{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],'
  printf '%s' '"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-0.5,-0.5,0],"max":[0.5,0.5,0]}],'
  printf '%s' '"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,'
  printf '\0\0\0\277\0\0\0\277\0\0\0\0\0\0\0\077\0\0\0\277\0\0\0\0\0\0\0\0\0\0\0\077\0\0\0\0' | base64 -w0
  printf '%s' '"}]}'
}
camera='[{"eye":[0,0,3],"target":[0,0,0],"up":[0,1,0],"yfov":0.8,"aspect":1,"znear":0.1,"zfar":null}]'
at=(--connect unix:/run/culld/culld.sock)

sees_the_triangle() {
  printf '%s' "$camera" | inside sh -c 'cat >/tmp/c.json && cullctl cull one --cameras /tmp/c.json -o /tmp/a.json "$@" && cat /tmp/a.json' sh "${at[@]}" >"$work/answers.json"
  grep -q '"visible":\[0\]' "$work/answers.json" || die "the triangle is not seen: $(cat "$work/answers.json")"
}

say "what the image says of itself"
for field in User Healthcheck StopSignal Volumes ExposedPorts; do
  value=$(config "$field")
  echo "$field: $value"
  case $value in '' | '<nil>' | 'map[]' | root | 0) die "the image has no $field" ;; esac
done

create
say "start"
start
healthy
user=$(user_of_daemon)
[ "$user" != 0 ] || die "culld runs as root"
echo "healthy, as user $user"
say "upload and ask"
scene | inside sh -c 'cat >/tmp/one.gltf && cullctl put one /tmp/one.gltf "$@"' sh "${at[@]}"
sees_the_triangle
echo "the camera sees it"
say "stop, start again with the same volume"
stop
[ "$code" = 0 ] || die "SIGTERM: exit code $code"
start
healthy
sees_the_triangle
echo "kept"
stop
[ "$code" = 0 ] || die "SIGTERM: exit code $code"
say "fine"
