#!/usr/bin/env bash
# `culld serve` as a process: exit codes, one line of error, signals, scenes across restarts, kill -9.
# usage: serve_command_test.sh BIN_DIR
source "$(dirname "${BASH_SOURCE[0]}")/own_daemon.sh"

# expect CODE WORDS ARGUMENTS...: culld ends with CODE and says WORDS in one line on stderr.
expect() {
  local code=$1 words=$2 got=0
  shift 2
  timeout 20 "$bin/culld" "$@" >/dev/null 2>"$work/stderr" || got=$?
  [ "$got" = "$code" ] || die "culld $*: exit code $got, not $code: $(cat "$work/stderr")"
  [ "$(grep -c '^culld: ' "$work/stderr")" = 1 ] || die "culld $*: not one line: $(cat "$work/stderr")"
  grep -q -- "$words" "$work/stderr" || die "culld $*: does not name $words: $(cat "$work/stderr")"
}

start() {
  : >"$work/log"
  "$bin/culld" serve --listen 127.0.0.1:0 --unix "$work/sock" --data "$work/data" "$@" 2>"$work/log" &
  daemon=$!
  for _ in $(seq 300); do
    if grep -q ' ready$' "$work/log"; then return 0; fi
    kill -0 "$daemon" 2>/dev/null || die "culld serve ended"
    sleep 0.1
  done
  die "not ready after 30 s"
}

# stop SIGNAL CODE
stop() {
  local got=0
  kill -s "$1" "$daemon"
  wait "$daemon" || got=$?
  daemon=''
  [ "$got" = "$2" ] || die "after SIG$1: exit code $got, not $2"
}

get() { curl -sS --max-time 20 --unix-socket "$work/sock" "http://localhost$1"; }

expect 2 'subcommand'
expect 2 '--nonsense' serve --nonsense
expect 2 'nowhere' serve --listen nowhere
expect 2 'foo is not an IP address' serve --listen foo:1
expect 2 '127.0.0.1:99999: not HOST:PORT' serve --listen 127.0.0.1:99999
expect 2 'path too long' serve --listen 127.0.0.1:0 --unix "$work/$(printf 'x%.0s' $(seq 200))"
expect 2 '--listen: is empty' serve --listen ''
expect 2 '--unix: is empty' serve --unix ''
expect 2 '--simd: is empty' serve --simd ''
expect 2 'no\\nwhere' serve --listen $'no\nwhere'
expect 2 'y=b.glb: the name y is given twice' serve --listen 127.0.0.1:0 --scene y=a.glb --scene x=a.glb --scene y=b.glb
expect 2 'a/b' serve --listen 127.0.0.1:0 --scene a/b=x.glb
expect 2 'none.glb' serve --listen 127.0.0.1:0 --scene x="$work/none.glb"
expect 2 'pentium' serve --listen 127.0.0.1:0 --simd pentium
expect 78 'whoever reaches it may do everything.*--allow-public' serve --listen 203.0.113.1:80
expect 69 '203.0.113.1:80' serve --listen 203.0.113.1:80 --allow-public
expect 74 '/proc/none' serve --listen 127.0.0.1:0 --data /proc/none
printf 'glTF but no more' >"$work/broken.glb"
expect 2 'broken.glb' serve --listen 127.0.0.1:0 --scene x="$work/broken.glb"

"$bin/make_scene" random --seed 1 -o "$work/random.glb" >/dev/null
start --scene fixed="$work/random.glb"
[ "$(stat -c %a "$work/sock")" = 660 ] || die "the socket's mode is $(stat -c %a "$work/sock")"
expect 69 'another culld' serve --listen 127.0.0.1:0 --data "$work/data"
expect 69 "$work/sock" serve --listen 127.0.0.1:0 --unix "$work/sock"
curl -sS --max-time 60 --unix-socket "$work/sock" -T "$work/random.glb" \
  http://localhost/v1/scenes/kept >"$work/put" || die "upload"
grep -q '"name":"kept"' "$work/put" || die "upload: $(cat "$work/put")"
before=$(get /v1/scenes/kept)
stop TERM 0
[ ! -e "$work/sock" ] || die "the socket is still there"

start
[ "$(get /v1/scenes/kept)" = "$before" ] || die "the scene is not as it was uploaded"
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null || true
[ -S "$work/sock" ] || die "kill -9 leaves the socket file, which the next start must replace"

start
[ "$(get /v1/scenes/kept)" = "$before" ] || die "the scene did not survive kill -9"
get /metrics | grep -q '^culld_scenes 1$' || die "metrics"
stop INT 0

# A signal while scenes are still being loaded: gone at once, and nothing stays behind.
"$bin/make_scene" city --objects 20000 --frames 1 -o "$work/large.glb" --cameras "$work/large.json" >/dev/null
many=()
for i in $(seq 100); do many+=(--scene "s$i=$work/large.glb"); done
for signal in TERM INT; do
  mkdir "$work/tmp"
  : >"$work/log"
  TMPDIR=$work/tmp "$bin/culld" serve --listen 127.0.0.1:0 --unix "$work/sock" "${many[@]}" 2>"$work/log" &
  daemon=$!
  for _ in $(seq 300); do
    if grep -q "listening on $work/sock" "$work/log"; then break; fi
    sleep 0.05
  done
  [ -S "$work/sock" ] || die "does not listen while it loads"
  before=$SECONDS
  stop "$signal" 0
  [ $((SECONDS - before)) -le 5 ] || die "SIG$signal while loading: took $((SECONDS - before)) s"
  ! grep -q ' ready$' "$work/log" || die "was ready before SIG$signal came: the scenes are too small for this test"
  [ ! -e "$work/sock" ] || die "SIG$signal while loading leaves the socket"
  rmdir "$work/tmp" || die "SIG$signal while loading leaves $(ls "$work/tmp")"
done

# Few descriptors: what is too much is refused, not left to wait.
: >"$work/log"
(ulimit -n 96 && exec "$bin/culld" serve --listen 127.0.0.1:0 --unix "$work/sock" 2>"$work/log") &
daemon=$!
for _ in $(seq 300); do
  if grep -q ' ready$' "$work/log"; then break; fi
  sleep 0.1
done
grep -q 'max_connections=16 open_files=96' "$work/log" || die "does not say how many connections it takes"
python3 - "$work/sock" "$bin/cullctl" <<'END' || die "a flood of connections"
import select, socket, subprocess, sys, time
def ask(path):
    s = socket.socket(socket.AF_UNIX)
    s.settimeout(10)
    s.connect(path)
    return s
held = [ask(sys.argv[1]) for _ in range(200)]
waiting, refused = set(held), 0
until = time.monotonic() + 4  # before silence itself ends a connection
while refused < 184 and time.monotonic() < until:
    for s in select.select(list(waiting), [], [], 0.2)[0]:
        reply = s.recv(1000)
        assert b" 503 " in reply and b"too many connections: 16 are open" in reply, reply
        waiting.remove(s)
        refused += 1
assert refused == 184, refused
late = subprocess.run([sys.argv[2], "list", "--connect", "unix:" + sys.argv[1]], capture_output=True, text=True)
assert late.returncode == 69, late
assert late.stderr.startswith("cullctl: unix:" + sys.argv[1] + ": too many connections: 16 are open"), late
for s in held:
    s.close()
until = time.monotonic() + 10
while True:
    s = ask(sys.argv[1])
    try:
        s.sendall(b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        if b" 200 " in s.recv(1000):
            break
    except OSError:  # refused before it was heard
        pass
    assert time.monotonic() < until, "places do not become free"
    time.sleep(0.05)
END
stop TERM 0
echo "serve_command: fine"
