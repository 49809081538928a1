#!/usr/bin/env bash
# `culld bench` as a process, on generated scenes: reports, exit codes, first lines, errors that name the input.
# usage: bench_command_test.sh BIN_DIR
set -euo pipefail
bin=$1
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_bench.XXXXXX")
trap 'rm -rf "$work"' EXIT
die() {
  echo "FAILED: $*" >&2
  exit 1
}

# expect CODE WORDS ARGUMENTS...: culld bench ends with CODE and says WORDS in one line on stderr.
expect() {
  local code=$1 words=$2 got=0
  shift 2
  timeout 60 "$bin/culld" bench "$@" >/dev/null 2>"$work/stderr" || got=$?
  [ "$got" = "$code" ] || die "bench $*: exit code $got, not $code: $(cat "$work/stderr")"
  [ "$(grep -c '^culld: ' "$work/stderr")" = 1 ] || die "bench $*: not one line: $(cat "$work/stderr")"
  grep -q -- "$words" "$work/stderr" || die "bench $*: does not name $words: $(cat "$work/stderr")"
}

cd "$work"
"$bin/make_scene" city --objects 400 --frames 5 -o city.glb --cameras city.cameras.json >/dev/null
"$bin/make_scene" random --objects 60 --frames 40 -o random.glb --cameras random.cameras.json >/dev/null

# Two scenes, all methods, two sizes, a time limit: every report is there and says the same.
"$bin/culld" bench city.glb random.glb --sizes 160x90,320x180 --times-us 200 --repeat 2 --samples 1 --rays 4 \
  --every 2 --report out >stdout || die "exit code $? on sound methods: $(head -1 stdout)"
head -1 stdout | grep -q '^guarantees held in all [0-9]* answers$' || die "verdict: $(head -1 stdout)"
verdict=$(head -1 stdout)
[ "$(head -1 out/report.csv)" = "# $verdict" ] || die "first line of the CSV"
[ "$(head -1 out/report.html)" = "<!-- $verdict -->" ] || die "first line of the HTML"
python3 - "$verdict" <<'PY' || die "report.json or report.csv"
import csv, json, math, sys
report = json.load(open("out/report.json"))
assert next(iter(report)) == "verdict" and report["verdict"] == sys.argv[1]
assert report["guarantees_held"] and report["breaches"] == []
for name in ("processor", "compiler", "version", "commit", "date", "command", "truth"):
    assert report["facts"][name], name
assert [s["name"] for s in report["scenes"]] == ["city.glb", "random.glb"]
methods = [m["name"] for m in report["scenes"][0]["methods"]]
assert methods[0] == "frustum" and {"raster", "auto"} <= set(methods), methods
rows = list(csv.DictReader(line for line in open("out/report.csv") if not line.startswith("#")))
# A method that is not for a scene is named with its reason instead.
assert len(rows) == sum(len(s["methods"]) for s in report["scenes"]) * 2 * 2, len(rows)
assert {r.split(":")[0] for s in report["scenes"] for r in s["refused"]} <= {"horizon", "gpu-depth-pyramid", "item-buffer"}, report["scenes"]
assert len({len(s["methods"]) + len(s["refused"]) for s in report["scenes"]}) == 1
for scene in report["scenes"]:
    assert scene["truth"][0]["camera"][:3] == [0, 2, 4]
    for run in scene["runs"]:
        assert run["missed"] == run["missed_subpixel"] == 0
        assert run["visible"] <= run["answered"]
        assert 0 < run["time_us"]["low"] <= run["time_us"]["mean"] <= run["time_us"]["high"]
        assert len(run["cameras"]["us_min"]) == len(scene["truth"][0]["camera"])
for row in rows:
    assert all(math.isfinite(float(v)) for k, v in row.items()
               if v and k not in ("scene", "method", "made_by", "guarantee"))
page = open("out/report.html").read()
for word in ("<script", "<link", "http://", "https://", "nan"):
    assert word not in page, word
assert page.count("<svg") > 20 and page.count("data:image/png;base64,") == 2
PY

# One camera, one method more than the baseline, cameras from elsewhere.
"$bin/make_scene" city --objects 50 --frames 1 -o one.glb --cameras elsewhere.json >/dev/null
"$bin/culld" bench one.glb --cameras elsewhere.json --methods raster --repeat 1 --samples 1 --report one >/dev/null || die "one camera"
[ "$(grep -c '"one.glb"' one/report.csv)" = 2 ] || die "methods raster: $(cat one/report.csv)"

# A scene without objects, and a camera that sees nothing.
printf '{"asset":{"version":"2.0"}}' >empty.gltf
cp elsewhere.json empty.cameras.json
"$bin/culld" bench empty.gltf --repeat 1 --samples 1 --report empty >/dev/null || die "an empty scene"
! grep -qi 'nan' empty/report.json empty/report.csv empty/report.html || die "not a number in a report"

expect 2 'SCENE' --report out
expect 2 'report' city.glb
expect 2 'none.glb' none.glb --cameras city.cameras.json --report out
expect 2 'elsewhere.cameras.json' elsewhere.glb --report out
expect 2 'guess' city.glb --methods frustum,guess --report out
expect 2 '12by7' city.glb --sizes 12by7 --report out
expect 2 '0x5' city.glb --sizes 0x5 --report out
expect 2 '5ms' city.glb --times-us 5ms --report out
expect 2 'repeat' city.glb --repeat 0 --report out
expect 2 'pentium' city.glb --simd pentium --report out
expect 74 'stdout/out' city.glb --report stdout/out
printf 'glTF but no more' >broken.glb
cp city.cameras.json broken.cameras.json
expect 2 'broken.glb' random.glb broken.glb --report both
[ ! -e both/report.csv ] || die "measured before all that is to be measured was read"
expect 2 'seed' city.glb --seed -1 --report out

# Two files of one name are told apart, and the command in the report can be given to a shell.
mkdir -p "other city"
cp city.glb city.cameras.json "other city"
"$bin/culld" bench city.glb "other city/city.glb" --methods frustum --every 9 --repeat 1 --samples 1 --report twins >/dev/null
python3 - <<'END'
import json, shlex
report = json.load(open("twins/report.json"))
assert [s["name"] for s in report["scenes"]] == ["city.glb", "other city/city.glb"]
assert shlex.split(report["facts"]["command"])[3] == "other city/city.glb", report["facts"]["command"]
END
[ "$(ls twins)" = "$(printf 'report.csv\nreport.html\nreport.json')" ] || die "left in the report's folder: $(ls twins)"
printf '[]' >city.cameras.json
expect 2 'city.cameras.json' city.glb --report out
echo "culld bench: all as expected"
