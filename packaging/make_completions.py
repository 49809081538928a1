#!/usr/bin/env python3
"""Makes the bash and zsh completion of a program out of its --help, so that neither can drift.

usage: make_completions.py PROGRAM METHODS OUT_DIR
  PROGRAM  culld or cullctl, as it was built; METHODS  culld, which lists the culling methods
  writes   OUT_DIR/bash/PROGRAM and OUT_DIR/zsh/_PROGRAM
"""
import json
import pathlib
import subprocess
import sys

import option_table

FILES, FOLDERS, SCENES, NAMED_FILES = "files", "folders", "scenes", "NAME=FILE"
GUARANTEES = ["conservative", "hole", "sampled", "approximate"]
BACKENDS = ["auto", "cpu", "egl-device", "egl-surfaceless", "osmesa"]
SIMD_TARGETS = ["auto", "sse4", "avx2", "avx3"]

# What follows an option, where more is known than "a word". A positional's name is its key.
VALUES = {
    "--cameras": FILES, "--depth-picture": FILES, "--config": FILES, "--ca": FILES, "--log-format": ["text", "json"],
    "--log-level": ["debug", "info", "warning", "error"], "--output": FILES, "--json": FILES,
    "--unix": FILES, "--data": FOLDERS, "--report": FOLDERS, "--viewers": FILES, "--targets": FILES,
    "--scene": NAMED_FILES, "--guarantee": GUARANTEES, "--backend": BACKENDS, "--simd": SIMD_TARGETS,
    "SCENE": FILES, "FILE": FILES, "NAME": SCENES,
}


def methods_of(program):
    listed = subprocess.run([program, "methods", "--json"], check=True, capture_output=True, text=True)
    return [method["name"] for method in json.loads(listed.stdout)]


class Completion:
    def __init__(self, program, table, methods):
        self.program, self.table = program, table
        self.values = dict(VALUES, **{"--method": methods, "--methods": ["all", *methods]})

    def options(self, command):
        """Those of the command, and those that may stand before or after it."""
        own = list(self.table[command].options)
        names = {name for option in own for name in option.names}
        everywhere = self.table[""].options if self.program == "cullctl" else []
        return own + [option for option in everywhere if not names & set(option.names)]

    def value_of(self, option):
        return next((self.values[name] for name in option.names if name in self.values), None)

    def with_value(self, command):
        return [option for option in self.options(command) if option.takes_value]

    def takes_many(self, command):
        return any(name in self.table[command].many for name in self.table[command].positionals)

    def server_options(self):
        """What stands before a command and says which server; listing its scenes needs it too."""
        return [name for option in self.with_value("") for name in option.names]


# ---- bash ----

BASH = r"""# bash completion of @program@, made from its --help

@scenes@_@program@() {
  local words=() line=${COMP_LINE:0:COMP_POINT} command='' positionals=0 @server@i
  COMPREPLY=()
  read -ra words <<<"$line"  # not COMP_WORDS: readline takes addresses and NAME=FILE to pieces
  [[ $line != *[[:space:]] ]] || words+=('')
  local current=${words[-1]} previous=${words[-2]}
  for ((i = 1; i < ${#words[@]} - 1; i++)); do
    case $command:${words[i]} in
@skip@
      *:-*) ;;
      :*) command=${words[i]} ;;
      *) positionals=$((positionals + 1)) ;;
    esac
  done
  case $command:$previous in
@values@
  esac
  if [[ $current == -* ]]; then
    case $command in
@options@
    esac
    return
  fi
  case $command:$positionals in
@positionals@
  esac
}
complete -F _@program@ @program@
"""

BASH_SCENES = r"""_@program@_scenes() {
  timeout 2 @program@ "$@" list 2>/dev/null </dev/null | sed -n 's/^\([A-Za-z0-9._-]\{1,64\}\): .*/\1/p'
}

"""


def bash_words(text, current="$current"):
    return f'mapfile -t COMPREPLY < <(compgen -W "{text}" -- "{current}")'


def bash_reply(kind):
    if kind == NAMED_FILES:
        return ('[[ $current != *=* ]] || { compopt -o filenames 2>/dev/null; '
                'mapfile -t COMPREPLY < <(compgen -f -- "${current#*=}"); }')
    if kind in (FILES, FOLDERS):
        flag = "-d" if kind == FOLDERS else "-f"
        return f'compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen {flag} -- "$current")'
    if kind == SCENES:
        return bash_words('$(_@program@_scenes "${server[@]}")')
    return bash_words(" ".join(kind))


def bash_case(patterns, reply):
    return f"    {'|'.join(patterns)}) {reply} ;;"


def bash_values(completion):
    """What follows an option that takes a value; nothing where nothing is known."""
    lines = []
    for command in completion.table:
        for option in completion.with_value(command):
            kind = completion.value_of(option)
            reply = "return" if kind is None else bash_reply(kind) + "; return"
            lines.append(bash_case([f"{command}:{name}" for name in option.names], reply))
    return lines


def bash_positionals(completion):
    lines = [bash_case([":0"], bash_reply(list(completion.table[""].commands)))]
    for command, parsed in completion.table.items():
        for place, positional in enumerate(parsed.positionals):
            if positional in completion.values:
                at = "*" if completion.takes_many(command) else place
                lines.append(bash_case([f"{command}:{at}"], bash_reply(completion.values[positional])))
    return lines


def bash(completion):
    server = completion.server_options()
    skip = []
    if server:
        skip.append("  " + bash_case([f"*:{name}" for name in server],
                                     'server+=("${words[@]:i:2}"); i=$((i + 1))'))
    for command in completion.table:
        names = [name for option in completion.with_value(command) for name in option.names]
        if names := [f"{command}:{name}" for name in names if name not in server]:
            skip.append("  " + bash_case(names, "i=$((i + 1))"))
    options = []
    for command in completion.table:
        names = [name for option in completion.options(command) for name in option.names]
        options.append("  " + bash_case([f"'{command}'"], bash_words(" ".join(names))))
    return fill(BASH, completion.program, {
        "scenes": [BASH_SCENES] if server else [""], "server": ["server=() "] if server else [""],
        "skip": skip, "values": bash_values(completion), "options": options,
        "positionals": bash_positionals(completion)})


# ---- zsh ----

ZSH = r"""#compdef @program@
# zsh completion of @program@, made from its --help

@scenes@_@program@() {
  local context state state_descr line curcontext=$curcontext
  typeset -A opt_args
  local -a commands
  commands=(
@commands@
  )
  _arguments -C -A '-*' \
@global@
    '1:command:->command' '*::argument:->argument' && return
  case $state in
    command) _describe command commands ;;
    argument)
      curcontext=${curcontext%:*:*}:@program@-$words[1]:
      case $words[1] in
@cases@
      esac ;;
  esac
}

_@program@ "$@"
"""

ZSH_SCENES = r"""_@program@_scenes() {
  local -a typed=(${(Qz)LBUFFER}) server scenes
  local i
  for ((i = 2; i < $#typed; i++)); do
    [[ $typed[i] == (@server@) ]] && server+=($typed[i] $typed[++i])
  done
  scenes=(${(f)"$(timeout 2 @program@ $server list 2>/dev/null </dev/null |
    sed -n 's/^\([A-Za-z0-9._-]\{1,64\}\): .*/\1/p')"})
  compadd -a scenes
}

"""


def quoted(text):
    return text.replace("'", "'\\''").replace("[", "\\[").replace("]", "\\]").replace(":", "\\:")


def zsh_action(kind, program):
    if kind is None:
        return " "
    if kind in (FILES, NAMED_FILES):
        return "_files"
    if kind == FOLDERS:
        return "_files -/"
    if kind == SCENES:
        return f"_{program}_scenes"
    return "(" + " ".join(kind) + ")"


def zsh_option(option, completion):
    kind = completion.value_of(option)
    value = f":{option.names[-1].lstrip('-')}:{zsh_action(kind, completion.program)}" if option.takes_value else ""
    once = "*" if option.many else "(" + " ".join(option.names) + ")"
    return " ".join(f"'{once}{name}[{quoted(option.help)}]{value}'" for name in option.names)


def zsh(completion):
    table = completion.table
    cases = []
    for command in table[""].commands:
        specs = [zsh_option(option, completion) for option in completion.options(command)]
        for place, name in enumerate(table[command].positionals, 1):
            at = "*" if completion.takes_many(command) else place
            specs.append(f"'{at}:{name}:{zsh_action(completion.values.get(name), completion.program)}'")
        cases.append(f"        {command}) _arguments " + " \\\n          ".join(specs) + " ;;")
    server = completion.server_options()
    return fill(ZSH, completion.program, {
        "scenes": [ZSH_SCENES] if server else [""], "server": ["|".join(server)],
        "commands": [f"    '{name}:{quoted(text)}'" for name, text in table[""].commands.items()],
        "global": ["    " + zsh_option(option, completion) + " \\" for option in table[""].options],
        "cases": cases})


def fill(template, program, parts):
    for name, lines in parts.items():
        template = template.replace(f"@{name}@", "\n".join(lines))
    return template.replace("@program@", program)


def main(arguments):
    if len(arguments) != 3:
        return __doc__
    program, methods, out = arguments[0], arguments[1], pathlib.Path(arguments[2])
    completion = Completion(pathlib.Path(program).name, option_table.read(program), methods_of(methods))
    for shell, name, text in (("bash", completion.program, bash(completion)),
                              ("zsh", "_" + completion.program, zsh(completion))):
        (out / shell).mkdir(parents=True, exist_ok=True)
        (out / shell / name).write_text(text, encoding="utf-8")
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
