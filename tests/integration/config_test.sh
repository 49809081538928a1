#!/usr/bin/env bash
# The configuration of a daemon: file, environment, flags; check-config; SIGHUP; log lines.
# usage: config_test.sh BIN_DIR
source "$(dirname "${BASH_SOURCE[0]}")/own_daemon.sh"

# refused CODE LINE ARGUMENTS...: culld ends with CODE and says exactly LINE on stderr.
refused() {
  local code=$1 line=$2 got=0
  shift 2
  timeout 20 "$bin/culld" "$@" >"$work/stdout" 2>"$work/stderr" || got=$?
  [ "$got" = "$code" ] || die "culld $*: exit code $got, not $code: $(cat "$work/stderr")"
  [ "$(cat "$work/stderr")" = "$line" ] || die "culld $*: says $(cat "$work/stderr"), not $line"
  [ ! -s "$work/stdout" ] || die "culld $*: prints in spite of a mistake"
}
# await WORDS: a line of the log that holds WORDS (a basic regular expression).
await() {
  for _ in $(seq 300); do
    if grep -qs -- "$1" "$work/log"; then return 0; fi
    [ -z "$daemon" ] || kill -0 "$daemon" 2>/dev/null || die "culld serve ended before it said $1"
    sleep 0.1
  done
  die "does not say $1"
}
stop() {
  local got=0
  kill -TERM "$daemon"
  wait "$daemon" || got=$?
  daemon=''
  [ "$got" = 0 ] || die "exit code $got after SIGTERM"
}
get() { curl -sS --max-time 20 --unix-socket "$work/sock" "http://localhost$1"; }
# metric NAME VALUE, at last.
metric() {
  for _ in $(seq 100); do
    if get /metrics | grep -q "^$1 $2\$"; then return 0; fi
    sleep 0.1
  done
  die "$1 is not $2: $(get /metrics | grep "^$1")"
}

cd "$work"
"$bin/make_scene" random --seed 1 -o scene.glb >/dev/null
mkdir conf
cat >conf/culld.toml <<END
listen = "127.0.0.1:0"
unix = "../sock"
threads = 1
[limits]
max_connections = 50
hello_timeout_s = 0.5
[log]
format = "json"
[scenes]
in_file = "../scene.glb"
END

# check-config: merged, with origins; what it prints is a configuration again.
CULLD_LIMITS_MAX_CONNECTIONS=60 CULLD_LOG_LEVEL=debug "$bin/culld" check-config conf/culld.toml \
  --log-level error --scene in_flag=scene.glb >merged.toml || die "check-config"
for line in 'threads = 1 *# conf/culld.toml:3' 'max_connections = 60 *# CULLD_LIMITS_MAX_CONNECTIONS' \
    'level = "error" *# --log-level' 'format = "json" *# conf/culld.toml:8' 'max_scenes = 1024 *# default' \
    '"in_file" = "conf/../scene.glb" *# conf/culld.toml:10' '"in_flag" = "scene.glb" *# --scene'; do
  grep -q "^$line\$" merged.toml || die "check-config does not print $line: $(cat merged.toml)"
done
"$bin/culld" check-config merged.toml >again.toml || die "check-config of what it printed"
[ "$(sed 's/ *#.*//' again.toml)" = "$(sed 's/ *#.*//' merged.toml)" ] || die "check-config says something else the second time"

# Mistakes: one line, its place, 78; on the command line 2. serve and check-config agree.
printf '[limits]\nmax_conections = 4\n' >bad.toml
for command in 'check-config' 'serve --config'; do
  refused 78 'culld: bad.toml:2: limits.max_conections is not known; did you mean limits.max_connections?' $command bad.toml
  refused 78 'culld: none.toml: cannot open: No such file or directory' $command none.toml
  CULLD_THREADS=many refused 78 'culld: CULLD_THREADS=many: not a whole number' $command conf/culld.toml
  CULLD_LISTN=x refused 78 'culld: CULLD_LISTN is not known; did you mean CULLD_LISTEN?' $command conf/culld.toml
  refused 2 'culld: --threads 9999: is not from 0 to 1024' $command conf/culld.toml --threads 9999
done
CULLD_CONFIG=bad.toml refused 78 'culld: bad.toml:2: limits.max_conections is not known; did you mean limits.max_connections?' serve
printf '[scenes]\na = "gone.glb"\n' >gone.toml
refused 78 'culld: gone.toml:2: scenes.a: gone.glb: No such file or directory' check-config gone.toml

# serve --config: what was said holds, whoever said it.
CULLD_LIMITS_MAX_SCENES=2 "$bin/culld" serve --config conf/culld.toml --scene in_flag=scene.glb 2>log &
daemon=$!
await '"msg":"ready"'
get /v1/scenes | grep -q '"name":"in_file".*"name":"in_flag"' || die "scenes: $(get /v1/scenes)"
metric culld_config_last_reload_successful 1
code=$(curl -sS -o put -w '%{http_code}' --unix-socket sock -T scene.glb http://localhost/v1/scenes/third)
[ "$code" = 503 ] || die "a third scene: $code"
curl -sS -o put --unix-socket sock -T scene.glb "http://localhost/v1/scenes/in_flag?ticket=very-secret" -H 'Authorization: Bearer very-secret'
await '"msg":"scene uploaded","scene":"in_flag"'
curl -sS -o gone --unix-socket sock "http://localhost/nowhere?ticket=very-secret" -H 'Authorization: Bearer very-secret'
await '"msg":"request refused".*"path":"/nowhere","status":404'
! grep -q very-secret log || die "a secret is in the log"
python3 - log <<'END' || die "a line that is no JSON"
import json, re, sys
for line in open(sys.argv[1]):
    event = json.loads(line)
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z", event["time"]), line
    assert event["level"] in ("debug", "info", "warning", "error") and event["msg"], line
END

# A session that never says Hello: the limit of the file, and after SIGHUP that of the new file.
python3 - sock >first <<'END'
import socket, sys, time
s = socket.socket(socket.AF_UNIX)
s.connect(sys.argv[1])
s.sendall(b"GET /v1/scenes/in_file/live HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
          b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
          b"Sec-WebSocket-Protocol: culld.v1\r\n\r\n")
s.settimeout(20)
assert b" 101 " in s.recv(1000)
began = time.monotonic()
assert s.recv(1000)[0] == 0x88  # a close frame
print(time.monotonic() - began)
END
python3 -c "import sys; sys.exit(not 0.3 < float(open('first').read()) < 4)" || die "Hello is awaited for $(cat first) s"
await '"msg":"session opened".*"scene":"in_file","peer":"unix"'
await '"msg":"session closed".*"seconds":'

sed -i 's/max_connections = 50/max_connections = 3/; s/format = "json"/format = "text"/; s/threads = 1/threads = 2/' conf/culld.toml
kill -HUP "$daemon"
await ' info configuration read$'
await ' warning changed, but taken up at the next start only keys=threads$'
metric culld_config_last_reload_successful 1
python3 - sock <<'END' || die "max_connections after a reload"
import socket, sys
held = [socket.socket(socket.AF_UNIX) for _ in range(4)]
for s in held:
    s.connect(sys.argv[1])
held[3].settimeout(10)
assert b"too many connections: 3 are open" in held[3].recv(1000)
END

# An invalid file changes nothing, and says so.
cp conf/culld.toml conf/good.toml
printf 'listen = 5\n' >conf/culld.toml
kill -HUP "$daemon"
await ' error configuration refused, the old one stays error="conf/culld.toml:1: listen: a whole number where a text belongs"$'
metric culld_config_last_reload_successful 0
[ "$(get /livez)" = live ] || die "does not live on"
sed 's/\[log\]/[log]\nlevel = "debug"/' conf/good.toml >conf/culld.toml
kill -HUP "$daemon"
metric culld_config_last_reload_successful 1
get /livez >/dev/null
await ' debug request method=GET path=/livez peer=unix$'
stop

# Metrics that every process has.
rm log
"$bin/culld" serve --config conf/good.toml --unix "$work/sock" 2>log &
daemon=$!
await ' listening on .*sock$'
get /metrics >metrics
for name in process_start_time_seconds process_cpu_seconds_total process_resident_memory_bytes process_open_fds \
    process_max_fds culld_config_last_reload_success_timestamp_seconds; do
  awk -v name="$name" '$1 == name && $2 > 0 { found = 1 } END { exit !found }' metrics || die "$name"
done
grep -q '^culld_build_info{compiler=".*",version=".*"} 1$' metrics || die "culld_build_info"
awk -v now="$(date +%s)" '$1 == "process_start_time_seconds" && ($2 > now + 2 || $2 < now - 60) { exit 1 }' metrics ||
  die "started at $(grep '^process_start_time' metrics), and it is $(date +%s)"
stop

# The journal: priorities where stderr is its stream, and only there.
: >log
JOURNAL_STREAM=$(stat -c '%d:%i' log) "$bin/culld" serve --listen 127.0.0.1:0 2>log &
daemon=$!
await '^<6>2.* info ready$'
stop
: >log
JOURNAL_STREAM=1:1 "$bin/culld" serve --listen 127.0.0.1:0 2>log &
daemon=$!
await '^2.* info ready$'
stop
echo "config: fine"
