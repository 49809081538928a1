#!/bin/bash
# `cullctl pairs` against a daemon. usage: cullctl_pairs_test.sh BIN_DIR
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/cullctl_server.sh" "$1"

pairs() { "$bin/cullctl" --connect "$tcp" pairs wall --viewers "$work/viewers.json" --targets "$work/targets.json" "$@"; }
# refuses CODE LINE OPTION...
refuses() {
  local code=$1 line=$2 got=0
  shift 2
  pairs "$@" >"$work/stdout" 2>"$work/stderr" || got=$?
  [ "$got" = "$code" ] && [ "$(cat "$work/stderr")" = "cullctl: $line" ] || die "exit $got, said $(cat "$work/stderr") instead of $line"
}

# A wall from -5 to 5 in x and y at z = 0, to be seen from +z.
python3 - "$work/wall.gltf" <<'END'
import base64, json, struct, sys
data = struct.pack("<12f", -5, -5, 0, 5, -5, 0, 5, 5, 0, -5, 5, 0) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-5, -5, 0], "max": [5, 5, 0]},
        {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open(sys.argv[1], "w"))
END
echo '[{"at": [0, 0, 5]}, {"at": [0, 0, -5], "radius": 1}]' >"$work/viewers.json"
echo '[{"min": [-1, -1, -6], "max": [1, 1, -4]}, {"at": [0, 0, 5]}, {"min": [-1, -1, -6], "max": [1, 1, -4], "radius": 9}]' >"$work/targets.json"
start_server --scene "wall=$work/wall.gltf"

pairs >"$work/text" || die "exit $?"
[ "$(head -2 "$work/text")" = $'viewer 0: 1 2\nviewer 1: 0 1 2' ] || die "said $(cat "$work/text")"
tail -1 "$work/text" | grep -q '^1 of 6 pairs proven hidden in [0-9.e+-]* us$' || die "said $(tail -1 "$work/text")"
pairs --json --time-us 1000000 | python3 -c '
import json, sys
answer = json.load(sys.stdin)
assert answer.pop("cull_ns") > 0
assert answer == {"scene": "wall", "version": 1, "viewers": 2, "targets": 3, "may_see": [[1, 2], [0, 1, 2]], "out_of_budget": False}, answer
' || die "--json"
counted() { curl -sS --max-time 20 "http://127.0.0.1:$port/metrics" | awk -v name="$1" '$1 == name { print $2 }'; }
[ "$(counted culld_pairs_total)" = 12 ] || die "pairs asked about: $(counted culld_pairs_total)"
[ "$(counted culld_pairs_hidden_total)" = 2 ] || die "pairs hidden: $(counted culld_pairs_hidden_total)"
[ "$(counted culld_pairs_seconds_total)" != 0 ] || die "no time for pairs"

echo '[{"at": [0, 0, 5]}, {"at": [0, 0]}]' >"$work/targets.json"
refuses 2 "$work/targets.json: place 1: \"at\" is not a list of 3 numbers"
echo '[{"at": [0, 0, 5], "min": [0, 0, 0]}]' >"$work/targets.json"
refuses 2 "$work/targets.json: place 0: wants either \"at\" or \"min\" and \"max\""
echo '[{"at": [0, 0, 5], "radus": 3}]' >"$work/targets.json"
refuses 2 "$work/targets.json: place 0: \"radus\" is not known; there are at, min, max, radius"
echo '{' >"$work/targets.json"
refuses 2 "$work/targets.json: not a JSON list"
echo '[{"at": [0, 0, 5], "radius": -1}]' >"$work/targets.json"
refuses 2 "pairs: target 0: the radius is not a number from 0 to 1e90 m"
rm "$work/targets.json"
refuses 2 "$work/targets.json: cannot read: No such file or directory"
