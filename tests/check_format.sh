#!/bin/bash
# Fails when a source file is not as .clang-format says. Version 14 is Debian 12's; others differ.
set -euo pipefail
cd "$1"
mapfile -t sources < <(find protocol culling server client tests -name node_modules -prune -o \
  \( -name '*.h' -o -name '*.cpp' \) -print | sort)
[ "${#sources[@]}" -gt 0 ] || { echo "$1: no sources found" >&2; exit 1; }
clang-format-14 --dry-run -Werror "${sources[@]}"
echo "${#sources[@]} files are formatted"
