#!/bin/bash
# Every example against a daemon with a small city. usage: run_examples.sh BIN_DIR EXAMPLE...
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/../integration/cullctl_server.sh" "$1"
shift
"$bin/make_scene" city --objects 500 --frames 2 -o "$work/city.glb" --cameras "$work/city.json" >/dev/null
start_server --scene "city=$work/city.glb"
for example in "$@"; do
  for address in "$tcp" "$unix"; do
    "$example" "$address" city 5 >"$work/out" || die "$example $address: exit $?"
    grep -q '^camera 5: [1-9][0-9]* of 500 objects' "$work/out" || die "$example $address: printed $(cat "$work/out")"
  done
  if "$example" "$tcp" nowhere 2>"$work/err"; then die "$example: flew through no scene"; fi
  [ "$(cat "$work/err")" = 'fly: scene "nowhere" is not known' ] || die "$example: said $(cat "$work/err")"
done
