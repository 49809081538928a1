#!/bin/bash
# What culld cull and cullctl say about bad input: the exact line on stderr, and the exit code. usage: cullctl_bad_input_test.sh BIN_DIR
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/cullctl_server.sh" "$1"

checked=0
# expect CODE LINE COMMAND...: LINE is all of stderr; stdout is empty.
expect() {
  local code=$1 line=$2 got=0
  shift 2
  (cd "$work" && "$@") >"$work/stdout" 2>"$work/stderr" || got=$?
  local said
  said=$(cat "$work/stderr")
  [ "$got" = "$code" ] || die "$* : exit $got instead of $code: $said"
  [ "$said" = "$line" ] || die "$* : said
  $said
instead of
  $line"
  [ "$(wc -l <"$work/stderr")" = 1 ] || die "$* : not one line"
  [ ! -s "$work/stdout" ] || die "$* : wrote to stdout"
  checked=$((checked + 1))
}

culld=$(cd "$bin" && pwd)/culld
cullctl=$(cd "$bin" && pwd)/cullctl
"$bin/make_scene" random --seed 3 --frames 2 -o "$work/s.glb" --cameras "$work/c.json" >/dev/null
camera='"eye":[0,0,9],"target":[0,0,0],"up":[0,1,0],"aspect":1,"znear":0.1,"zfar":null'
echo "[{$camera,\"yfov\":1},{$camera,\"yfov\":\"wide\"}]" >"$work/text.json"
echo "[{$camera,\"yfov\":1},{$camera,\"yfov\":1e999}]" >"$work/huge.json"
echo "[{$camera,\"yfov\":1},{$camera,\"yfov\":4}]" >"$work/yfov.json"
echo "[{$camera,\"yfov\":1}]" >"$work/plain.json"
echo "[{$camera,\"yfov\":1,\"width\":0}]" >"$work/flat.json"
echo '[{"view":[0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1],"projection":[1,0,0,0, 0,1,0,0, 0,0,-1,-1, 0,0,-0.2,0]}]' >"$work/singular.json"
echo "[{$camera" >"$work/cut.json"
echo '{"cameras":[]}' >"$work/object.json"
echo 'not a scene' >"$work/text.glb"
head -c 100 "$work/s.glb" >"$work/cut.glb"
printf '[{%s,"yfov":1}]\0[{}]' "$camera" >"$work/zero.json"
printf '{"asset":{"version":"2.0"}}\0{' >"$work/zero.gltf"
printf '{"a":%s' "$(printf '[%.0s' $(seq 300))" >"$work/deep.gltf"  # past a limit of the loader
methods=$("$culld" methods --json | python3 -c 'import json, sys; print(*(m["name"] for m in json.load(sys.stdin)), sep=", ")')

start_server --scene "s=$work/s.glb"
local_cull=("$culld" cull s.glb)
remote_cull=("$cullctl" --connect "$tcp" cull s)

# The same mistakes, the same words.
while IFS='|' read -r code line words; do
  read -ra words <<<"$words"
  [[ " ${words[*]} " == *" -o "* ]] || words+=(-o a.json)
  expect "$code" "culld: $line" "${local_cull[@]}" "${words[@]}"
  expect "$code" "cullctl: $line" "${remote_cull[@]}" "${words[@]}"
done <<'END'
2|text.json: camera 1: "yfov" is not a number|--cameras text.json
2|huge.json: camera 1: "yfov" is not a finite number|--cameras huge.json
2|yfov.json: camera 1: yfov is not within (0, pi)|--cameras yfov.json
2|flat.json: camera 0: "width" is not a whole number from 1 to 65536|--cameras flat.json
2|singular.json: camera 0: view or projection matrix is singular|--cameras singular.json
2|cut.json: line 2, column 0: not valid JSON|--cameras cut.json
2|zero.json: line 1, column 92: not valid JSON|--cameras zero.json
2|object.json: is not a list of cameras|--cameras object.json
2|absent.json: cannot read: No such file or directory|--cameras absent.json
2|plain.json: camera 0: image size is zero|--cameras plain.json --width 0
2|guarantee exact: not one of conservative, hole, sampled, approximate|--cameras c.json --guarantee exact
2|demand.hole_px is not a number >= 0|--cameras c.json --guarantee hole --hole-px -1
2|demand.accepted_missed_px is not a number >= 0|--cameras c.json --accept-missed-px nan
2|Could not convert: --time-us = soon|--cameras c.json --time-us soon
2|Could not convert: --width = -1|--cameras c.json --width -1
2|--cameras is required|--method frustum
2|The following argument was not expected: --speed|--cameras c.json --speed
74|/dev/full: cannot write: No space left on device|--cameras c.json -o /dev/full
74|/nonexistent/a.json: cannot write: No such file or directory|--cameras c.json -o /nonexistent/a.json
END

expect 2 "culld: method nope: unknown; there are $methods" "${local_cull[@]}" --cameras c.json -o a.json --method nope
expect 2 'cullctl: method "nope" is not known' "${remote_cull[@]}" --cameras c.json -o a.json --method nope
expect 2 'culld: backend vulkan: is none of auto, cpu, egl-device[:n], egl-surfaceless, osmesa' "${local_cull[@]}" --cameras c.json -o a.json --backend vulkan
expect 2 'culld: absent.glb: file: No such file or directory' "$culld" cull absent.glb --cameras c.json -o a.json
expect 2 'culld: text.glb: file: is neither GLB nor a JSON object' "$culld" cull text.glb --cameras c.json -o a.json
expect 2 'culld: zero.gltf: JSON: a zero byte at byte 27' "$culld" cull zero.gltf --cameras c.json -o a.json
expect 2 'culld: deep.gltf: JSON: nested deeper than 256' "$culld" cull deep.gltf --cameras c.json -o a.json
expect 2 'culld: SCENE is required' "$culld" cull --cameras c.json -o a.json

expect 2 'cullctl: A subcommand is required' "$cullctl"
expect 2 'cullctl: --connect localhost:7420: not an address like ws://127.0.0.1:7420 or unix:PATH' "$cullctl" list --connect localhost:7420
expect 1 'cullctl: scene "nope" is not known' "$cullctl" info nope --connect "$tcp"
expect 1 'cullctl: scene "nope" is not known' "$cullctl" remove nope --connect "$tcp"
expect 1 'cullctl: scene "nope" is not known' "$cullctl" cull nope --cameras c.json -o a.json --connect "$tcp"
expect 1 'cullctl: scene "nope" is not known' "$cullctl" fly nope --cameras c.json --connect "$unix"
expect 1 'cullctl: scene "nope" is not known' "$cullctl" ping nope --connect "$unix"
expect 2 'cullctl: text.glb: file: is neither GLB nor a JSON object' "$cullctl" put t text.glb --connect "$tcp"
expect 2 'cullctl: deep.gltf: JSON: nested deeper than 256' "$cullctl" put t deep.gltf --connect "$tcp"
expect 2 'cullctl: zero.gltf: JSON: a zero byte at byte 27' "$cullctl" put t zero.gltf --connect "$unix"
expect 2 'cullctl: absent.glb: cannot read: No such file or directory' "$cullctl" put t absent.glb --connect "$tcp"
expect 2 'cullctl: .: cannot read: Is a directory' "$cullctl" put t . --connect "$tcp"
expect 2 'cullctl: --rate: nan is not a number' "$cullctl" load s --cameras c.json --rate nan --connect "$tcp"
expect 2 'cullctl: --output excludes --loop' "$cullctl" fly s --cameras c.json --loop -o a.json --connect "$tcp"
expect 2 'cullctl: --count: Value 0 not in range 1 to 1000000' "$cullctl" ping --count 0 --connect "$tcp"

# An empty word is a variable that was not set.
for option in --method --guarantee --cameras --output; do
  words=(--cameras c.json -o a.json "$option" '')
  [ "$option" != --cameras ] || words=(-o a.json --cameras '')
  [ "$option" != --output ] || words=(--cameras c.json -o '')
  expect 2 "culld: $option: is empty" "${local_cull[@]}" "${words[@]}"
  expect 2 "cullctl: $option: is empty" "${remote_cull[@]}" "${words[@]}"
done
expect 2 'culld: SCENE: is empty' "$culld" cull '' --cameras c.json -o a.json
expect 2 'cullctl: NAME: is empty' "$cullctl" info '' --connect "$tcp"
expect 2 'cullctl: --connect: is empty' "$cullctl" list --connect ''

# Whatever an argument holds, the error is one line.
expect 2 "culld: method x\\ny: unknown; there are $methods" "${local_cull[@]}" --cameras c.json -o a.json --method $'x\ny'
expect 2 'cullctl: method "x\ny" is not known' "${remote_cull[@]}" --cameras c.json -o a.json --method $'x\ny'
expect 2 'culld: no\n\x1b[31mfile: cannot read: No such file or directory' "${local_cull[@]}" --cameras $'no\n\e[31mfile' -o a.json
expect 2 'cullctl: The following argument was not expected: --a\nb' "$cullctl" list $'--a\nb' --connect "$tcp"

# What cannot be printed is not fine.
full() {
  local program=$1 got=0
  (cd "$work" && "${@:2}") >/dev/full 2>"$work/stderr" || got=$?
  [ "$got" = 74 ] || die "${*:2} >/dev/full: exit $got instead of 74"
  [[ $(cat "$work/stderr") =~ ^"$program: stdout: cannot write: "[^$'\n']+$ ]] || die "${*:2} >/dev/full: said $(cat "$work/stderr")"
  checked=$((checked + 1))
}
full culld "$culld" methods
full culld "$culld" methods --json
full culld "$culld" --help
full culld "$culld" cull --help
for words in list 'list --json' 'info s' 'info s --json' 'put t s.glb' ping 'ping s' 'fly s --cameras c.json' --version; do
  read -ra words <<<"$words"
  full cullctl "$cullctl" --connect "$tcp" "${words[@]}"
done

# A cut file is refused by both, and the server still serves.
for command in "$culld cull cut.glb --cameras c.json -o a.json" "$cullctl put t cut.glb --connect $tcp"; do
  got=0
  (cd "$work" && $command) 2>"$work/stderr" || got=$?
  if [ "$got" != 2 ] || [ "$(wc -l <"$work/stderr")" != 1 ]; then die "$command: exit $got, $(cat "$work/stderr")"; fi
  checked=$((checked + 1))
done
"$cullctl" info s --connect "$tcp" >/dev/null || die "the server is gone"

stop_server
expect 69 "cullctl: $tcp: cannot connect: Connection refused" "$cullctl" list --connect "$tcp"
expect 69 "cullctl: $tcp: cannot connect: Connection refused" "$cullctl" put t s.glb --connect "$tcp"
expect 69 "cullctl: $tcp: cannot connect: Connection refused" "$cullctl" fly s --cameras c.json --connect "$tcp"
expect 69 "cullctl: unix:gone: cannot connect: No such file or directory" "$cullctl" ping --connect unix:gone
echo "$checked mistakes were named"
