#!/bin/bash
# The installed units of systemd: systemd understands them, they shut the service in, and the service starts what is installed with
# flags that it has. Checked on files, without a running systemd. usage: units_test.sh BUILD_DIR
set -euo pipefail
build=$1
work=$(mktemp -d "${TMPDIR:-/tmp}/culld_units.XXXXXX")
trap 'rm -rf "$work"' EXIT
die() { echo "FAILED: $*" >&2; exit 1; }

cmake --install "$build" --prefix "$work" --component daemon >/dev/null
units=$work/lib/systemd/system
! grep -hE '@[a-z]+@' "$units"/culld.* || die "not filled in"
systemd-analyze verify --man=no --recursive-errors=no "$units/culld.service" "$units/culld.socket" 2>"$work/said" || die "verify: $(cat "$work/said")"
[ ! -s "$work/said" ] || die "verify: $(cat "$work/said")"
# 0 is shut in completely, 10 not at all; the port that it must serve is most of what is left.
systemd-analyze security --offline=true --no-pager --threshold=16 "$units/culld.service" >"$work/security" || die "$(tail -1 "$work/security")"

# The settings that docs/packaging.md gives reasons for.
mapfile -t settings < <(sed -n '/^| setting | why |/,/^$/p' "$(dirname "$0")/../../docs/packaging.md" | cut -d'|' -f2 | grep -v '^ no ' | grep -o '`[^`]*`' | tr -d '`')
[ "${#settings[@]}" -ge 8 ] || die "docs/packaging.md: no table of settings"
for setting in "${settings[@]}"; do
  grep -q "^$setting" "$units/culld.service" || die "docs/packaging.md names $setting, the unit does not have it"
done
! grep -E '^(PrivateUsers|IPAddressDeny)' "$units/culld.service" || die "docs/packaging.md says why that is not set"

command=$(sed -n 's/^ExecStart=//p' "$units/culld.service")
read -ra words <<<"$command"
[ "${words[0]}" = "$work/bin/culld" ] || die "ExecStart: $command"
"${words[0]}" serve --help >"$work/help"
for word in "${words[@]:2}"; do
  case $word in
    -*) grep -q -- "^  $word " "$work/help" || die "culld serve has no $word" ;;
    *) [ -f "$word" ] || die "$word is not installed" ;;
  esac
done
"${words[0]}" check-config "${words[-1]}" >/dev/null || die "the installed configuration is refused"
grep -q 'data = "/var/lib/culld"' "$work/etc/culld/culld.toml" || die "the installed configuration keeps nothing"
[ "$(sed -n 's/^StateDirectory=//p' "$units/culld.service")" = culld ] || die "the service has no such folder"

# A second install leaves the administrator's configuration alone.
echo 'threads = 1' >"$work/etc/culld/culld.toml"
cmake --install "$build" --prefix "$work" --component daemon >/dev/null
[ "$(cat "$work/etc/culld/culld.toml")" = 'threads = 1' ] || die "the configuration was replaced"
tail -1 "$work/security"
