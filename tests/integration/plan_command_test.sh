#!/bin/bash
# `culld plan` says the same to a person and as JSON, leaves occlusion out of an open scene and uses it in closed rooms, measures on cameras, and
# refuses what it cannot read with the exit code of the contract. usage: plan_command_test.sh BIN_DIR
set -u
bin=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
die() { echo "plan_command_test: $*" >&2; exit 1; }

for scene in arena rooms; do
  "$bin/make_scene" "$scene" --frames 6 -o "$work/$scene.glb" --cameras "$work/$scene.json" >/dev/null || die "make_scene $scene"
  "$bin/culld" plan "$work/$scene.glb" --json >"$work/$scene.plan.json" || die "plan $scene"
done
"$bin/culld" plan "$work/rooms.glb" --cameras "$work/rooms.json" --json >"$work/cameras.json" || die "plan with cameras"
python3 - "$work" <<'END' || die "the JSON does not say what is known of the scenes"
import json, sys
read = lambda name: json.load(open(f"{sys.argv[1]}/{name}.json"))
arena, rooms, cameras = read("arena.plan"), read("rooms.plan"), read("cameras")
stages = lambda plan: [s["what"] for s in plan["used"]["stages"]]
left_out = lambda plan: " ".join(l["what"] for l in plan["left_out"])
assert stages(arena) == ["frustum"] and "occlusion (raster)" in left_out(arena), arena
assert stages(rooms) == ["frustum", "raster"] and "occlusion" not in left_out(rooms), rooms
gain = lambda plan: sum(s["gain_us"] for s in plan["views"]["stages"])
assert gain(arena) < 0 < gain(rooms), (arena["views"], rooms["views"])
assert arena["used"]["prepared_bytes"] < rooms["used"]["prepared_bytes"]
assert arena["scene"]["objects"] == rooms["scene"]["objects"] == 2000
assert rooms["scene"]["closedness"] > arena["scene"]["closedness"], (rooms["scene"], arena["scene"])
assert rooms["depth"]["mean"] > 2 * arena["depth"]["mean"] > 0, (rooms["depth"], arena["depth"])
assert rooms["depth"]["p95"] <= rooms["depth"]["most"] and sum(rooms["depth"]["pixels_by_surfaces"]) == 320 * 180 * rooms["depth"]["views"]
assert "cameras" not in rooms
measured = {m["method"]: m for m in cameras["cameras"]["methods"]}
assert cameras["cameras"]["count"] == 6 and set(measured) == {"frustum", "raster", "auto"}, measured
assert measured["raster"]["objects"] <= measured["auto"]["objects"] <= measured["frustum"]["objects"]
assert (measured["frustum"]["with_occlusion"], measured["raster"]["with_occlusion"]) == (0, 6), measured
assert all(0 < m["min_us"] <= m["median_us"] for m in measured.values())
END

"$bin/culld" plan "$work/arena.glb" >"$work/text" || die "plan for a person"
for words in "2000 objects" "Measured" "Used" "Left out" "occlusion (raster): raster pays in 0 of" "only positions are kept"; do
  grep -qF "$words" "$work/text" || die "the text lacks: $words"
done
"$bin/culld" plan "$work/arena.glb" --depth-picture "$work/depth.png" >/dev/null && [ -s "$work/depth.png" ] || die "no picture of depth"
"$bin/culld" plan "$work/rooms.glb" --cameras "$work/rooms.json" | grep -qF "On 6 cameras" || die "the text lacks the cameras"

# Planning counts work and asks no clock: the same words every time.
"$bin/culld" plan "$work/rooms.glb" --json | cmp -s - "$work/rooms.plan.json" || die "two plans of one scene differ"

refused() {
  local code=$1; shift
  "$@" >"$work/out" 2>"$work/err"
  [ $? -eq "$code" ] || die "$*: exit code is not $code"
  [ "$(wc -l <"$work/err")" -eq 1 ] || die "$*: not one line of error"
  [ ! -s "$work/out" ] || die "$*: something on stdout"
}
printf 'no glTF' >"$work/broken.glb"
refused 2 "$bin/culld" plan
refused 2 "$bin/culld" plan "$work/missing.glb"
refused 2 "$bin/culld" plan "$work/broken.glb"
refused 2 "$bin/culld" plan "$work/arena.glb" --cameras "$work/missing.json"
refused 2 "$bin/culld" plan "$work/arena.glb" --colour
echo "plans are as the scenes are"
