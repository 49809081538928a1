#!/bin/bash
# The Debian packages: what is in each, what they depend on, and lintian's opinion. usage: packages_test.sh BUILD_DIR
set -euo pipefail
build=$1
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_packages.XXXXXX")
trap 'rm -rf "$work"' EXIT
die() { echo "FAILED: $*" >&2; exit 1; }

(cd "$work" && cpack --config "$build/CPackConfig.cmake" -B "$work/out" >cpack.log 2>&1) || { cat "$work/cpack.log" >&2; die "cpack"; }
cd "$work/out"

# holds PACKAGE FILE...: the package has each of these, and nothing outside the folders of the last argument.
holds() {
  local package=$1 file
  shift
  dpkg-deb --fsys-tarfile "$package"_*.deb | tar -t | sed 's,^\.,,' | grep -v '/$' >"$work/files" || die "$package: not a package"
  for file in "$@"; do
    grep -qx -- "$file" "$work/files" || die "$package: has no $file: $(tr '\n' ' ' <"$work/files")"
  done
  for file in copyright changelog.Debian.gz; do
    grep -qx "/usr/share/doc/$package/$file" "$work/files" || die "$package: has no $file"
  done
  dpkg-deb --fsys-tarfile "$package"_*.deb | tar -tv | awk '$2 != "root/root"' | { ! grep . ; } || die "$package: files that are not root's"
}

# depends PACKAGE WORD...: its dependencies name these.
depends() {
  local package=$1 word
  shift
  for word in "$@"; do
    dpkg-deb -f "$package"_*.deb Depends | grep -q -e "$word" || die "$package: does not depend on $word"
  done
}

holds culld /usr/bin/culld /usr/share/man/man1/culld.1.gz /usr/share/bash-completion/completions/culld \
  /usr/share/zsh/vendor-completions/_culld /usr/share/man/man5/culld.toml.5.gz /etc/culld/culld.toml \
  /usr/lib/systemd/system/culld.service /usr/lib/systemd/system/culld.socket
[ "$(dpkg-deb -I culld_*.deb conffiles)" = /etc/culld/culld.toml ] || die "culld: an upgrade would overwrite the configuration"
dpkg-deb --fsys-tarfile culld_*.deb | tar -xO ./usr/lib/systemd/system/culld.service | grep -qx 'ExecStart=/usr/bin/culld serve --config /etc/culld/culld.toml' ||
  die "culld: the unit starts something else"
depends culld libc6 libstdc++6 libembree3-3 libspdlog
! grep -qE '/(include|cmake|pkgconfig)/' "$work/files" || die "culld: holds what belongs to the SDK"
holds cullctl /usr/bin/cullctl /usr/share/man/man1/cullctl.1.gz /usr/share/bash-completion/completions/cullctl \
  /usr/share/zsh/vendor-completions/_cullctl
depends cullctl libc6 libstdc++6
! dpkg-deb -f cullctl_*.deb Depends | grep -qE 'embree|draco|hwy|meshopt' || die "cullctl: depends on what only the daemon needs"
holds libculld-client1 /usr/lib/libculld-client.so.1
depends libculld-client1 libssl3
dpkg-deb -I libculld-client1_*.deb shlibs | grep -q '^libculld-client 1 libculld-client1' || die "libculld-client1: does not say who needs it"
! grep -q '/include/' "$work/files" || die "libculld-client1: holds headers"
depends libculld-client-dev libculld-client1 libssl-dev
holds libculld-client-dev /usr/lib/libculld-client.so /usr/include/culld-client/culld/client.h /usr/lib/libculld_client.a /usr/lib/pkgconfig/culld-client.pc \
  /usr/include/culld-client/culld/connection.h /usr/include/culld-client/protocol/messages.h
[ "$(find . -maxdepth 1 -name "*.deb" | wc -l)" = 4 ] || die "packages: $(echo ./*.deb)"

# Not for upload to Debian, so no bug is closed by it; not multi-arch; CPack calls ldconfig where debhelper would set a trigger.
tags=initial-upload-closes-no-bugs,pkg-config-unavailable-for-cross-compilation,maintscript-calls-ldconfig,package-must-activate-ldconfig-trigger
lintian --allow-root --fail-on error,warning --suppress-tags "$tags" ./*.deb ||
  die "lintian"
echo "packages: $(du -ch ./*.deb | tail -1 | cut -f1) in all, fine"
