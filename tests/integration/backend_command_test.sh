#!/bin/bash
# `--backend`: what it names is used or is one line of error that lists the attempts; without a GPU nothing is loaded or said; `serve` says what it
# draws with. usage: backend_command_test.sh BIN_DIR
set -u
bin=$1
work=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server" 2>/dev/null; rm -rf "$work"' EXIT
die() { echo "backend_command_test: $*" >&2; exit 1; }

"$bin/make_scene" random --seed 3 --frames 2 -o "$work/s.glb" --cameras "$work/c.json" >/dev/null || die "make_scene"
# cull BACKEND: leaves stderr in $work/said.
cull() { "$bin/culld" cull "$work/s.glb" --cameras "$work/c.json" --backend "$1" -o "$work/$1.json" >/dev/null 2>"$work/said"; }
sets() { python3 -c 'import json, sys; print([f["visible"] for f in json.load(open(sys.argv[1]))["frames"]])' "$work/$1.json"; }

for backend in auto cpu; do
  cull $backend || die "$backend: $(cat "$work/said")"
  [ ! -s "$work/said" ] || die "$backend said: $(cat "$work/said")"
done
if ! ls /dev/dri /dev/nvidia* >/dev/null 2>&1; then
  LD_DEBUG=files "$bin/culld" cull "$work/s.glb" --cameras "$work/c.json" -o "$work/a.json" >/dev/null 2>"$work/loaded"
  grep -qE 'libEGL|libOSMesa|libGL' "$work/loaded" && die "OpenGL was loaded without a GPU"
fi

"$bin/culld" cull "$work/s.glb" --cameras "$work/c.json" --method gpu-depth-pyramid --backend cpu -o "$work/a.json" 2>"$work/said" && die "gpu-depth-pyramid on a CPU"
grep -q 'gpu-depth-pyramid: the backend is cpu' "$work/said" || die "gpu-depth-pyramid on a CPU said: $(cat "$work/said")"

cull egl-device:4000
[ $? = 69 ] || die "a device that is not there: exit code"
[ "$(wc -l <"$work/said")" = 1 ] || die "not one line: $(cat "$work/said")"
grep -q '^culld: backend egl-device:4000: no OpenGL backend: egl-device: ' "$work/said" || die "said: $(cat "$work/said")"

opened=0
for backend in egl-surfaceless osmesa; do
  # OSMesa keeps memory until the process ends, in places where LeakSanitizer's tracer itself crashes now and then.
  [ $backend = egl-surfaceless ] || export ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0"
  if cull $backend; then
    [ ! -s "$work/said" ] || die "$backend said: $(cat "$work/said")"
    [ "$(sets $backend)" = "$(sets cpu)" ] || die "$backend: other answers than cpu"
    "$bin/culld" serve --listen 127.0.0.1:0 --backend $backend --scene "s=$work/s.glb" 2>"$work/log" &
    server=$!
    for _ in $(seq 600); do grep -q ' ready' "$work/log" && break; sleep 0.1; done
    url=ws://$(sed -n 's/.*listening on //p' "$work/log" | head -1)
    gpu_cull=(--cameras "$work/c.json" --method gpu-depth-pyramid)
    "$bin/culld" cull "$work/s.glb" "${gpu_cull[@]}" --backend $backend -o "$work/here.json" || die "$backend: gpu-depth-pyramid here"
    "$bin/cullctl" --connect "$url" cull s "${gpu_cull[@]}" -o "$work/there.json" || die "$backend: gpu-depth-pyramid there"
    [ "$(sets here)" = "$(sets there)" ] || die "$backend: gpu-depth-pyramid answers otherwise on a server"
    kill $server
    wait $server || die "serve --backend $backend: exit $?: $(cat "$work/log")"
    server=
    grep -q "drawing with $backend (" "$work/log" || die "serve does not say what it draws with: $(cat "$work/log")"
    opened=$((opened + 1))
  else
    grep -q 'cannot open shared object' "$work/said" || die "$backend: $(cat "$work/said")"
  fi
done
[ $opened = 2 ] || { echo "backend_command_test: of two backends $opened could be opened; the others are not installed"; exit 77; }
