#!/bin/bash
# `cullctl edit`, `watch` and `load` against a daemon: what they change, say and count, and what they say about mistakes. usage: cullctl_edit_test.sh BIN_DIR
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/cullctl_server.sh" "$1"

ctl() { "$bin/cullctl" --connect "$tcp" "$@"; }
# expect CODE LINE COMMAND...: all of stderr.
expect() {
  local code=$1 line=$2 got=0
  shift 2
  "$@" >"$work/stdout" 2>"$work/stderr" || got=$?
  [ "$got" = "$code" ] || die "$* : exit $got instead of $code: $(cat "$work/stderr")"
  [ "$(cat "$work/stderr")" = "$line" ] || die "$* : said $(cat "$work/stderr") instead of $line"
}
visible() {
  ctl cull rows --cameras "$work/rows.json" --method frustum -o "$work/a.json" || die "cull"
  python3 -c 'import json, sys; f = json.load(open(sys.argv[1]))["frames"][0]; print(f["visible"], json.dumps(f.get("instances", {})))' "$work/a.json"
}
# await_lines FILE WORDS N: N lines of FILE hold WORDS, at last.
await_lines() {
  for _ in $(seq 600); do
    if [ "$(grep -cs -- "$2" "$1")" -ge "$3" ]; then return 0; fi
    sleep 0.05
  done
  die "$1 has not $3 lines with $2: $(cat "$1")"
}
shows() { [ "$(visible)" = "$1" ] || die "after $2: visible is $(visible), not $1"; }

# Node 0: a triangle at the origin. Node 1: four of it at x = -3, -1, 1, 3.
python3 - "$work/rows.gltf" <<'END'
import base64, json, struct, sys
data = struct.pack("<9f", -0.1, -0.1, 0, 0.1, -0.1, 0, 0, 0.1, 0) + struct.pack("<12f", *[c for x in (-3, -1, 1, 3) for c in (x, 0, 0)])
json.dump({
    "asset": {"version": "2.0"}, "extensionsUsed": ["EXT_mesh_gpu_instancing"], "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.1, -0.1, 0], "max": [0.1, 0.1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 48}],
    "buffers": [{"byteLength": 84, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open(sys.argv[1], "w"))
END
echo '[{"eye":[0,0,20],"target":[0,0,0],"up":[0,1,0],"yfov":0.8,"aspect":1,"znear":0.1,"zfar":null}]' >"$work/rows.json"
start_server --scene "rows=$work/rows.gltf"
shows '[0, 1] {"1": [0, 1, 2, 3]}' nothing

ctl watch rows --json --count 4 >"$work/watch.txt" &
watcher=$!
ctl watch rows --count 1 | grep -qx 'rows: scene, version 1, 5 objects, 5 triangles' || die "watch as text"
await_lines "$work/watch.txt" . 1

# IDs are those of answers files.
[ "$(ctl edit rows --hide 0,1:2)" = 'rows: version 2' ] || die "edit --hide"
shows '[1] {"1": [0, 1, 3]}' --hide
[ "$(ctl edit rows --show 0 --show 1 --set '0=1,0,0,500, 0,1,0,0, 0,0,1,0' --expect-version 2)" = 'rows: version 3' ] || die "edit --show --set"
shows '[1] {"1": [0, 1, 2, 3]}' --set
ctl edit rows --remove 1:0 --add '0=1 0 0 0 0 1 0 1 0 0 1 0' --json >"$work/edit.json"
python3 -c 'import json, sys; e = json.load(open(sys.argv[1])); assert e == {"scene": "rows", "version": 4, "added": [5]}, e' "$work/edit.json" || die "edit --json"
shows '[0, 1] {"0": [5], "1": [1, 2, 3]}' --add
wait "$watcher" || die "watch: exit $?"
python3 - "$work/watch.txt" <<'END' || die "watch --json: $(cat "$work/watch.txt")"
import json, sys
lines = [json.loads(line) for line in open(sys.argv[1])]
assert [line["event"] for line in lines] == ["scene", "edited", "edited", "edited"], lines
assert [line["version"] for line in lines] == [1, 2, 3, 4] and lines[3]["objects"] == 6, lines
END
[ "$(ctl edit rows --objects --hide 5)" = 'rows: version 5' ] || die "edit --objects"
shows '[1] {"1": [1, 2, 3]}' --objects

# Mistakes change nothing.
same='1,0,0,0,0,1,0,0,0,0,1,0'
expect 2 'cullctl: nothing to do: give --set, --add, --hide, --show or --remove' ctl edit rows
expect 2 'cullctl: --hide 7: no object of the scene is of that node' ctl edit rows --hide 7
expect 2 'cullctl: --hide 1:9: the node has no such instance' ctl edit rows --hide 0,1:9
expect 2 'cullctl: --hide x: not a node, or NODE:INSTANCE' ctl edit rows --hide x
expect 2 'cullctl: --hide -1: not a node, or NODE:INSTANCE' ctl edit rows --hide=-1
expect 2 'cullctl: --hide 1:2: not an object id' ctl edit rows --objects --hide 1:2
expect 2 'cullctl: --hide names no object' ctl edit rows --hide ,
expect 2 "cullctl: --set 1=$same: the node has 4 instances; name one as NODE:INSTANCE" ctl edit rows --set "1=$same"
expect 2 'cullctl: --set 0:0=1,2: wants 12 numbers, not 2' ctl edit rows --set 0:0=1,2
expect 2 "cullctl: --set 0:0=nan,${same#*,}: \"nan\" is not a finite number" ctl edit rows --set "0:0=nan,${same#*,}"
expect 2 'cullctl: --add 0: not ID=NUMBERS' ctl edit rows --add 0
expect 1 'cullctl: scene "nope" is not known' ctl edit nope --hide 0
expect 1 'cullctl: scene "nope" is not known' ctl watch nope
expect 1 'cullctl: scene "nope" is not known' ctl load nope
got=0
ctl edit rows --hide 0 --expect-version 1 2>"$work/stderr" || got=$?
if [ "$got" != 1 ] || ! grep -q 'version' "$work/stderr"; then die "--expect-version: exit $got, $(cat "$work/stderr")"; fi
ctl info rows | grep -q 'version 5' || die "a mistake changed the scene"

# Load: an open loop that counts every camera, and answers that hold for a motion cost fewer.
"$bin/make_scene" city --objects 2000 --frames 400 -o "$work/city.glb" --cameras "$work/city.json" >/dev/null
ctl put city "$work/city.glb" >/dev/null || die "put city"
for bound in '' '--radius 20 --angle 1'; do
  read -ra words <<<"$bound"
  ctl load city --cameras "$work/city.json" --method frustum --clients 4 --views 2 --rate 20 --seconds 2 --verify 5 --json "${words[@]}" >"$work/load.json" ||
    die "load $bound: exit $?: $(cat "$work/load.json")"
  python3 - "$work/load.json" "$bound" <<'END' || die "load $bound: $(cat "$work/load.json")"
import json, sys
r, bound = json.load(open(sys.argv[1])), sys.argv[2]
assert r["due"] == 4 * 2 * 20 * 2 and r["sent"] + r["within_bound"] == r["due"], "schedule"
assert r["answered"] + r["superseded"] == r["sent"] and r["wrong"] == r["failed"] == r["unanswered"] == 0, "accounts"
assert r["compared"] > 0 and r["changes"] > 0 and r["bytes_per_answer"] > 0, "checked"
l = r["latency_ms"]
assert 0 < l["p50"] <= l["p90"] <= l["p99"] <= l["p999"] <= l["max"], "quantiles"
assert (r["sent"] < r["due"] / 2) if bound else r["within_bound"] == 0, "bound"
END
done
ctl load city --clients 2 --rate 20 --seconds 1 >"$work/load.txt" || die "load as text: $(cat "$work/load.txt")"
grep -q '^answered [1-9][0-9]*, superseded [0-9]*, late [0-9]*, failed 0, unanswered 0, wrong 0$' "$work/load.txt" || die "load as text: $(cat "$work/load.txt")"
expect 2 'cullctl: --rate: Value 0 not in range 0.001000 to 1000000.000000' ctl load city --rate 0

# A server that is killed in the middle of a load is no success; watch outlives it.
ctl watch rows --json --count 3 >"$work/watch.txt" &
watcher=$!
await_lines "$work/watch.txt" . 1
city_answers() { curl -sS --max-time 20 "http://127.0.0.1:$port/metrics" | awk '/^culld_answers_total.*scene="city"/ { n += $NF } END { print n + 0 }'; }
before=$(city_answers)
ctl load city --clients 2 --seconds 30 >"$work/load.txt" 2>&1 &
loader=$!
for _ in $(seq 600); do
  if [ "$(city_answers)" -gt "$before" ]; then break; fi
  sleep 0.05
done
[ "$(city_answers)" -gt "$before" ] || die "load is not answered"
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null || true
got=0
wait "$loader" || got=$?
[ "$got" = 1 ] || die "load on a killed server: exit $got"
"$bin/culld" serve --listen "127.0.0.1:$port" --scene "rows=$work/rows.gltf" >>"$work/culld.log" 2>&1 &
daemon=$!
await_lines "$work/watch.txt" '"connected"' 1
wait "$watcher" || die "watch over a restart: exit $?"
python3 - "$work/watch.txt" <<'END' || die "watch over a restart: $(cat "$work/watch.txt")"
import json, sys
events = [json.loads(line)["event"] for line in open(sys.argv[1])]
assert events == ["scene", "reconnecting", "connected"], events
END
stop_server
expect 69 "cullctl: $tcp: cannot connect: Connection refused" ctl edit rows --hide 0
