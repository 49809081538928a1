# shellcheck shell=bash disable=SC2034  # tcp and unix are for the tests that source this
# Sourced by the tests of cullctl: a culld of their own on a free port and a Unix socket.
# usage: source cullctl_server.sh BIN_DIR; sets $bin, $work, $tcp, $unix; cleans up at exit.
set -euo pipefail
bin=$1
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_test.XXXXXX")
daemon=''

stop_server() {
  [ -n "$daemon" ] || return 0
  kill -TERM "$daemon" 2>/dev/null || true
  wait "$daemon" || true
  daemon=''
}
clean_up() {
  stop_server
  jobs -p | xargs -r kill -KILL 2>/dev/null || true  # what waits for a server that is gone holds up ctest
  rm -rf "$work"
}
trap clean_up EXIT

die() {
  echo "FAILED: $*" >&2
  [ ! -f "$work/culld.log" ] || sed 's/^/  culld: /' "$work/culld.log" >&2
  exit 1
}

start_server() {
  unix=unix:$work/culld.sock
  : >"$work/culld.log"  # it is read before the daemon has opened it
  "$bin/culld" serve --listen 127.0.0.1:0 --unix "$work/culld.sock" "$@" >"$work/culld.log" 2>&1 &
  daemon=$!
  for _ in $(seq 300); do
    port=$(sed -n 's/.*listening on 127\.0\.0\.1:\([0-9]*\)$/\1/p' "$work/culld.log")
    # Uploads are refused while it still loads.
    if [ -n "$port" ] && [ -S "$work/culld.sock" ] && grep -q ' ready$' "$work/culld.log"; then
      tcp=ws://127.0.0.1:$port
      return 0
    fi
    kill -0 "$daemon" 2>/dev/null || die "culld serve ended"
    sleep 0.1
  done
  die "culld serve does not listen after 30 s"
}
