#!/bin/bash
# `culld cull` in process and `cullctl cull` over both transports answer the same sets, byte for byte, with every method this build has; `cullctl fly`,
# whose answers come as changes, as well. usage: cullctl_answers_test.sh BIN_DIR
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/cullctl_server.sh" "$1"

# All that must not differ: everything but how long it took.
sets() { sed 's/"seconds":[^,]*,//' "$1"; }

same() {
  sets "$1" >"$work/left"
  sets "$2" >"$work/right"
  cmp -s "$work/left" "$work/right" || die "$3: answers differ: $(diff "$work/left" "$work/right" | cut -c1-400 | head -4)"
  compared=$((compared + 1))
}

# A mesh instanced four times at x = -3, -1, 1, 3 (node 1), and once without instancing (node 2, to the side).
instanced_scene() {
  python3 - "$1" <<'END'
import base64, json, struct, sys
corners = [-0.5, -0.5, 0, 0.5, -0.5, 0, 0, 0.5, 0]
offsets = [c for x in (-3, -1, 1, 3) for c in (x, 0, 0)]
data = struct.pack("<9f", *corners) + struct.pack("<12f", *offsets)
json.dump({
    "asset": {"version": "2.0"}, "extensionsUsed": ["EXT_mesh_gpu_instancing"], "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
    "nodes": [{}, {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}, {"mesh": 0, "translation": [5, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 48}],
    "buffers": [{"byteLength": 84, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open(sys.argv[1], "w"))
END
}

compared=0
refused=''
asked=0
"$bin/make_scene" city --objects 2000 --frames 20 -o "$work/city.glb" --cameras "$work/city.json" >/dev/null
"$bin/make_scene" random --seed 3 --frames 20 -o "$work/random.glb" --cameras "$work/random.json" >/dev/null
instanced_scene "$work/instanced.glb"
# From the right, so that only x = 1 and x = 3 are in the view; then all; then, as matrices, nothing.
cat >"$work/instanced.json" <<'END'
[{"eye":[2,0,4],"target":[2,0,0],"up":[0,1,0],"yfov":0.8,"aspect":1,"znear":0.1,"zfar":null,"width":200,"height":200},
 {"eye":[0,0,20],"target":[0,0,0],"up":[0,1,0],"yfov":0.8,"aspect":1,"znear":0.1,"zfar":100},
 {"view":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,-100,0,1],"projection":[1,0,0,0, 0,1,0,0, 0,0,-1,-1, 0,0,-0.2,0]}]
END

start_server --scene "city=$work/city.glb"
"$bin/cullctl" put random "$work/random.glb" --connect "$tcp" >/dev/null || die "put over TCP"
"$bin/cullctl" put instanced "$work/instanced.glb" --connect "$unix" >/dev/null || die "put over the Unix socket"

# Those on a GPU are compared by backend_command_test.sh.
methods=$("$bin/culld" methods --json | python3 -c 'import json, sys; print(*(m["name"] for m in json.load(sys.stdin) if "OpenGL" not in m["needs"]))')
for method in $methods; do
  for scene in city random instanced; do
    asked=$((asked + 1))
    ask=(--cameras "$work/$scene.json" --method "$method")
    if ! "$bin/culld" cull "$work/$scene.glb" "${ask[@]}" -o "$work/local.json" 2>"$work/refused"; then
      # A method may not be for a scene, and says why: here as there.
      why=$(sed "s|^culld: $work/$scene.glb: ||" "$work/refused")
      got=0
      "$bin/cullctl" --connect "$tcp" cull "$scene" "${ask[@]}" -o "$work/tcp.json" 2>"$work/refused" || got=$?
      { [ -n "$why" ] && [ "$got" != 0 ] && grep -qF "$why" "$work/refused"; } || die "$scene $method: refused here ($why), there: $(cat "$work/refused")"
      refused+=" $scene/$method"
      continue
    fi
    "$bin/cullctl" --connect "$tcp" cull "$scene" "${ask[@]}" -o "$work/tcp.json" || die "$scene $method: cullctl cull over TCP"
    "$bin/cullctl" cull "$scene" "${ask[@]}" -o "$work/unix.json" --connect "$unix" || die "$scene $method: cullctl cull over the Unix socket"
    "$bin/cullctl" fly "$scene" "${ask[@]}" -o "$work/fly.json" --json "$work/frames.json" --connect "$tcp" >"$work/fly.txt" || die "$scene $method: cullctl fly"
    same "$work/local.json" "$work/tcp.json" "$scene $method over TCP"
    same "$work/local.json" "$work/unix.json" "$scene $method over the Unix socket"
    same "$work/local.json" "$work/fly.json" "$scene $method along a flight"
  done
done

# The comparison above says nothing if everything is empty.
python3 - "$work" <<'END' || die "answers of the instanced scene are not the known ones"
import json, sys
frames = json.load(open(sys.argv[1] + "/local.json"))["frames"]
assert [f["visible"] for f in frames] == [[1], [1, 2], []], frames
assert frames[0]["instances"] == {"1": [2, 3]} and frames[1]["instances"] == {"1": [0, 1, 2, 3]}, frames
assert "instances" not in frames[2], frames
flight = json.load(open(sys.argv[1] + "/frames.json"))
assert [len(f["objects_visible"]) for f in flight] == [2, 5, 0] and flight[1]["answered"] == 5, flight
assert all(f["bytes"] > 0 and f["objects"] == 5 and f["in_frustum"] >= f["answered"] for f in flight), flight
assert flight[1]["in_frustum"] == 5, flight
END
[ "$refused" = ' city/horizon' ] || die "refused:$refused"
[ "$compared" = $((3 * (asked - 1))) ] || die "only $compared comparisons"

# A scene of the same name takes the place of the old one; a removed one is gone.
"$bin/cullctl" put random "$work/instanced.glb" --connect "$tcp" >/dev/null || die "replace"
"$bin/cullctl" cull random --cameras "$work/instanced.json" -o "$work/replaced.json" --connect "$tcp" || die "cull of a replaced scene"
same "$work/local.json" "$work/replaced.json" "replaced scene"
"$bin/cullctl" remove random --connect "$unix" || die "remove"
names=$("$bin/cullctl" list --json --connect "$tcp" | python3 -c 'import json, sys; print(*(s["name"] for s in json.load(sys.stdin)))')
[ "$names" = "city instanced" ] || die "scenes after remove: $names"
"$bin/cullctl" ping city --count 10 --connect "$unix" >/dev/null || die "ping"
echo "$compared answers files are the same"
