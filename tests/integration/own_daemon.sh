# shellcheck shell=bash disable=SC2034  # bin is for the tests that source this
# Sourced by tests that run a culld their own way: a folder that goes with them, and a way to fail.
# usage: source own_daemon.sh BIN_DIR; sets $bin, $work, $daemon (empty); $work/log is shown by die.
set -euo pipefail
bin=$1
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_test.XXXXXX")
daemon=''
clean_up() {
  [ -z "$daemon" ] || kill -KILL "$daemon" 2>/dev/null || true
  rm -rf "$work"
}
trap clean_up EXIT
die() {
  echo "FAILED: $*" >&2
  [ ! -f "$work/log" ] || cat "$work/log" >&2
  exit 1
}
