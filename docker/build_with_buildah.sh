#!/bin/bash
# Builds the image where there is no Docker engine and no registry: makes the base debian:bookworm with debootstrap, builds docker/Dockerfile
# with buildah's chroot isolation, tries the image (smoke.sh) and says how large it is and how long that took.
# usage: build_with_buildah.sh [--storage DIR] [--mirror URL]    as root, with buildah and debootstrap
#   --storage DIR  keeps base and layers for the next time (default build/buildah)
#   --mirror URL   else debootstrap's own
#   CCACHE_DIR, if set, is used by the compiler inside
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
storage=$PWD/build/buildah mirror=()
while [ $# -gt 0 ]; do
  case $1 in
    --storage) mkdir -p "$2"; storage=$(cd "$2" && pwd); shift 2 ;;
    --mirror) mirror=("$2"); shift 2 ;;
    *) sed -n 's/^# usage: /usage: /p' "$0" >&2; exit 2 ;;
  esac
done
for tool in buildah debootstrap; do
  command -v "$tool" >/dev/null || { echo "$tool is missing: apt-get install buildah debootstrap" >&2; exit 69; }
done
mkdir -p "$storage/tmp"
export TMPDIR=$storage/tmp
options=(--root "$storage/root" --runroot "$storage/run" --storage-driver overlay)
step() { # step WHAT COMMAND...
  local what=$1 started=$SECONDS
  shift
  "$@"
  echo "== $what: $((SECONDS - started)) s"
}

make_base() {
  debootstrap --variant=minbase bookworm "$storage/base" "${mirror[@]}"
  rm -rf "$storage"/base/var/lib/apt/lists/* "$storage"/base/var/cache/apt/*
  local container
  container=$(buildah "${options[@]}" from scratch)
  buildah "${options[@]}" add -q "$container" "$storage/base" / >/dev/null
  buildah "${options[@]}" commit -q --rm "$container" localhost/debian:bookworm >/dev/null
  rm -rf "$storage/base"
}

build() {
  local cache=()
  [ -z "${CCACHE_DIR:-}" ] || cache=(--volume "$CCACHE_DIR:/ccache" --build-arg CCACHE_DIR=/ccache)
  buildah "${options[@]}" bud --isolation chroot --format docker --layers --pull-never "${cache[@]}" \
    -f docker/Dockerfile -t culld .
}

size() { buildah "${options[@]}" images --json "$1" | sed -n 's/.*"size": "\(.*\)",.*/\1/p'; }

buildah "${options[@]}" inspect --type image localhost/debian:bookworm >/dev/null 2>&1 || step "base" make_base
step "image" build
echo "== debian:bookworm $(size localhost/debian:bookworm), culld $(size localhost/culld)"
step "smoke test" env BUILDAH_OPTIONS="${options[*]}" docker/smoke.sh buildah localhost/culld
