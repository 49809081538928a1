# shellcheck shell=bash disable=SC2086  # lists of packages are split into words
# Shared by ./demo and ./check: say what happens, install what is missing. Sourced by bash.

if [ -t 1 ]; then bold=$'\e[1m' green=$'\e[32m' plain=$'\e[0m'; else bold='' green='' plain=''; fi

say() { printf '%s\n' "${bold}== $*${plain}"; }

# step WHAT COMMAND...: runs the command and says how long it took. A failure ends the script.
# Within a function run so, `set -e` has no effect: it must return its own failures.
step() {
  local what=$1 started=$SECONDS
  shift
  say "$what"
  "$@" || { local status=$?; echo "failed after $((SECONDS - started)) s: $what" >&2; exit "$status"; }
  printf '%s\n' "${green}== $what: done in $((SECONDS - started)) s${plain}"
}

# missing_packages LIST...: the packages of these files that dpkg does not have.
missing_packages() {
  local package
  cat "$@" | while read -r package; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
  done
}

# install_missing LIST...: from Debian 12, through apt-get; asks for sudo when not root.
install_missing() {
  command -v apt-get >/dev/null || { echo "no apt-get here: install by hand what is in $*" >&2; return; }
  local missing as_root=()
  missing=$(missing_packages "$@") || return
  [ -n "$missing" ] || { echo "nothing is missing"; return; }
  [ "$(id -u)" = 0 ] || as_root=(sudo)
  echo "installing:" $missing
  "${as_root[@]}" apt-get update -q || return
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
}
