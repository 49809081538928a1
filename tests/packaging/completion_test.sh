#!/bin/bash
# The installed completions work: bash and zsh offer every command and every option of each command's --help, known values,
# files, and the names of the scenes that the server has which the line names. usage: completion_test.sh BIN_DIR COMPLETION_DIR
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
here=$(dirname "${BASH_SOURCE[0]}")
source "$here/../integration/cullctl_server.sh" "$1"
completions=$2
export PATH=$bin:$PATH

# What bash offers for a line, one a line, sorted.
offers() {
  local program=${1%% *}
  (
    source "$completions/bash/$program"
    COMP_LINE=$1 COMP_POINT=${#1}
    "_$program" 2>/dev/null
    printf '%s\n' "${COMPREPLY[@]}" | sort
  )
}

# expect LINE WORD...: exactly these. `sort` of both, as the order is the shell's.
expect() {
  local line=$1
  shift
  [ "$(offers "$line")" = "$(printf '%s\n' "$@" | sort)" ] || die "bash, '$line': offers $(offers "$line" | tr '\n' ' '), not $*"
  compared=$((compared + 1))
}

# The options that a --help text names.
options_of() { "$@" --help | sed -n 's/^  \(-[^ ]*\).*/\1/p' | tr ',' '\n'; }
commands_of() { "$1" --help | sed -n '/^Subcommands:/,$s/^  \([a-z][a-z-]*\) .*/\1/p'; }

compared=0
cd "$work" || die "$work"
touch notes.txt cameras.json
"$bin/make_scene" random --seed 1 -o random.glb >/dev/null
start_server --scene "city=$work/random.glb" --scene "random.2=$work/random.glb"

for program in culld cullctl; do
  mapfile -t commands < <(commands_of "$program")
  [ "${#commands[@]}" -ge 5 ] || die "$program: --help names too few commands: ${commands[*]}"
  expect "$program " "${commands[@]}"
  expect "$program ${commands[0]:0:2}" "${commands[0]}"
  for command in "${commands[@]}"; do
    mapfile -t options < <({ options_of "$program" "$command"; [ "$program" = culld ] || options_of "$program"; } | sort -u)
    expect "$program $command -" "${options[@]}"
  done
done
expect "culld cull x.glb --guarantee " conservative hole sampled approximate
expect "culld cull x.glb --me" --method
mapfile -t methods < <("$bin/culld" methods --json | python3 -c 'import json, sys; [print(m["name"]) for m in json.load(sys.stdin)]')
expect "culld cull x.glb --method " "${methods[@]}"
expect "culld cull ra" random.glb
expect "culld serve --scene city=ran" random.glb
expect "culld serve --threads " ""
expect "culld bench random.glb no" notes.txt
expect "cullctl --connect $tcp info " city random.2
expect "cullctl --connect $unix cull --cameras cameras.json ra" random.2
expect "cullctl fly --loop --connect $tcp c" city
expect "cullctl put city no" notes.txt
expect "cullctl cull city --cameras cam" cameras.json
expect "cullctl fly city --json cam" cameras.json
expect "cullctl list --json cam" ""
expect "cullctl --connect ws://127.0.0.1:1 info " ""

# zsh, through a terminal of its own, as only its line editor can ask.
cat >"$work/ask.zsh" <<'END'
zmodload zsh/zpty
zpty shell "TERM=dumb PS1=% zsh -f -i"
ask() {
  local line text=''
  zpty -w shell "$1"
  repeat 300; do
    if zpty -rt shell line; then text+=$line; [[ $text == *"$2"* ]] && break; else sleep 0.02; fi
  done
  print -r -- "$text"
}
ask "fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -d $3/zcompdump; setopt no_beep interactive_comments; zstyle ':completion:*' list-prompt ''; LISTMAX=1000; stty cols 200 rows 200; print made-\ready" made-ready >/dev/null
zpty -wn shell "$2"$'\t\t'
sleep 0.3
zpty -wn shell $'\C-a#\n'
ask "print the-\end" the-end
zpty -d shell
END
# zsh_offers LINE WORD...: at least these.
zsh_offers() {
  local line=$1 text word
  shift
  text=$(zsh -f "$work/ask.zsh" "$completions/zsh" "$line" "$work")
  for word in "$@"; do
    grep -q -e "$word" <<<"$text" || die "zsh, '$line': does not offer $word: $text"
  done
  compared=$((compared + 1))
}
for program in culld cullctl; do
  mapfile -t commands < <(commands_of "$program")
  zsh_offers "$program " "${commands[@]}"
  for command in "${commands[@]}"; do
    mapfile -t options < <(options_of "$program" "$command")
    zsh_offers "$program $command -" "${options[@]}"
  done
done
zsh_offers "culld cull x.glb --guarantee " conservative hole sampled approximate
zsh_offers "cullctl --connect $tcp info " city random.2
zsh_offers "cullctl info --connect $unix ra" random.2
echo "$compared lines are completed"
