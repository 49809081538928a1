#!/bin/bash
# The Debian packages on a Debian that has nothing else: install, run the daemon as a user without rights, ask it, remove, purge.
# Root, debootstrap and Debian's mirror are needed, so ./check does not run it. usage: deb_in_chroot.sh BUILD_DIR CHROOT
#   CHROOT is made by debootstrap if it is not there, and is as before afterwards.
set -euo pipefail
[ $# = 2 ] || { sed -n 's/.*\(usage: .*\)/\1/p' "$0" | head -1 >&2; exit 2; }
build=$1 root=$2
packages=(culld cullctl libculld-client1 libculld-client-dev)
daemon=''
clean_up() {
  [ -z "$daemon" ] || kill -KILL "$daemon" 2>/dev/null || true
  inside umount /proc 2>/dev/null || true
  rm -rf "$root/packages" "$root/tmp/culld"
}
die() { echo "FAILED: $*" >&2; exit 1; }
inside=(chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive)
inside() { "${inside[@]}" "$@"; }
files() { (cd "$root" && find etc usr/bin usr/lib/systemd var/lib -path var/lib/apt -prune -o -path var/lib/dpkg -prune -o -print | sort); }
say() { printf '== %s\n' "$*"; }

[ -d "$root/etc" ] || { say "debootstrap"; debootstrap --variant=minbase bookworm "$root" >/dev/null; }
trap clean_up EXIT
mkdir -p "$root/packages" "$root/tmp/culld"
inside mount -t proc proc /proc
cpack --config "$build/CPackConfig.cmake" -B "$root/packages" >/dev/null 2>&1
before=$(files)

say "install"
inside apt-get update -q >/dev/null
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/*.deb' >"$root/packages/log" 2>&1 || { cat "$root/packages/log" >&2; die "apt-get install"; }
inside dpkg -V "${packages[@]}" || die "dpkg -V"
inside culld --version
inside cullctl --version
[ -L "$root/etc/systemd/system/multi-user.target.wants/culld.service" ] || die "culld.service is not enabled"
inside culld check-config /etc/culld/culld.toml >/dev/null || die "the configuration that came with it is refused"

say "run as nobody"
cat >"$root/tmp/culld/run" <<'END'
exec setpriv --reuid 65534 --regid 65534 --clear-groups --no-new-privs \
  env CULLD_LISTEN=127.0.0.1:0 CULLD_UNIX=/tmp/culld/socket culld serve --config /etc/culld/culld.toml --data /tmp/culld/data
END
chmod 0777 "$root/tmp/culld"
"${inside[@]}" sh /tmp/culld/run >"$root/tmp/culld/log" 2>&1 &  # no function: the daemon itself has the number $!
daemon=$!
for ((i = 0; i < 100; i++)); do
  if inside cullctl ping --connect unix:/tmp/culld/socket >/dev/null 2>&1; then break; fi
  sleep 0.1
done
inside cullctl ping --connect unix:/tmp/culld/socket || { cat "$root/tmp/culld/log" >&2; die "does not answer"; }
[ "$(stat -c %u "/proc/$daemon")" = 65534 ] || die "runs as user $(stat -c %u "/proc/$daemon")"
"$build/bin/make_scene" random --seed 1 -o "$root/tmp/culld/s.glb" --cameras "$root/tmp/culld/c.json" >/dev/null
inside cullctl put s /tmp/culld/s.glb --connect unix:/tmp/culld/socket
inside cullctl cull s --cameras /tmp/culld/c.json -o /tmp/culld/a.json --connect unix:/tmp/culld/socket
inside culld cull /tmp/culld/s.glb --cameras /tmp/culld/c.json -o /tmp/culld/b.json
sets() { sed 's/"seconds":[^,]*,//' "$1"; }
[ "$(sets "$root/tmp/culld/a.json")" = "$(sets "$root/tmp/culld/b.json")" ] || die "daemon and command answer differently"
kill -TERM "$daemon"
wait "$daemon" || die "exit code $? after SIGTERM"
daemon=''

say "remove, purge"
mkdir -p "$root/var/lib/private/culld"
inside apt-get remove -y -q "${packages[@]}" >/dev/null 2>&1
[ -e "$root/etc/culld/culld.toml" ] || die "removal takes the configuration"
[ -d "$root/var/lib/private/culld" ] || die "removal takes the scenes"
inside apt-get purge -y -q culld >/dev/null 2>&1
[ ! -e "$root/var/lib/private/culld" ] || die "purge leaves the scenes"
inside apt-get autoremove -y -q --purge >/dev/null 2>&1
after=$(files)
[ "$before" = "$after" ] || die "left behind: $(diff <(echo "$before") <(echo "$after"))"
say "fine"
