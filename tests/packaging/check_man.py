#!/usr/bin/env python3
"""Fails when a program's man page and its --help name different commands, options or arguments.

usage: check_man.py PROGRAM PAGE.scd    e.g. bin/culld docs/man/culld.1.scd
       check_man.py --self-test         drops and adds an option on each side of a page of its own
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging"))
import option_table  # noqa: E402

ENTRY = re.compile(r"^\*-{1,2}\w")  # a line that begins an option's paragraph
OPTION = re.compile(r"\*(-{1,2}[\w-]+)\*( _[^_]+_)?")
EVERYWHERE = {"-h", "--help"}  # said once, under OPTIONS


def page_table(page, program):
    """{command: (heading's arguments, {option: takes a value})}; "" for OPTIONS."""
    table, command = {}, None
    for line in page.splitlines():
        if line.startswith("# "):
            command = "" if line == "# OPTIONS" else None
            if command == "":
                table[""] = ([], {})
        elif line.startswith("## "):
            words = line[3:].split()
            command = words[1] if words[0] == program and len(words) > 1 else None
            if command:
                table[command] = (words[2:], {})
        elif command is not None and ENTRY.match(line):
            for name, value in OPTION.findall(line):
                table[command][1][name] = bool(value)
    return table


def help_table(table):
    described = {}
    for command, parsed in table.items():
        options = {}
        for option in parsed.options:
            if command and EVERYWHERE & set(option.names):
                continue
            options.update(dict.fromkeys(option.names, option.takes_value))
        described[command] = (parsed.positionals, options)
    return described


def plain(argument):
    return argument.strip("[].").replace("...", "")


def faults(program, helped, page):
    for command in sorted(set(helped) | set(page)):
        where = f"{program} {command}".strip()
        if command not in page:
            yield f"{where}: not in the man page"
            continue
        if command not in helped:
            yield f"{where}: in the man page only"
            continue
        (arguments, options), (shown, described) = helped[command], page[command]
        if [plain(a) for a in arguments] != [plain(a) for a in shown]:
            yield f"{where}: takes {arguments}, the man page says {shown}"
        for name in sorted(set(options) - set(described)):
            yield f"{where} {name}: not in the man page"
        for name in sorted(set(described) - set(options)):
            yield f"{where} {name}: in the man page only"
        for name in sorted(set(options) & set(described)):
            if name.startswith("--") and options[name] != described[name]:
                yield f"{where} {name}: only one of --help and man page gives it a value"


HELP = """does
Usage: p [OPTIONS] SUBCOMMAND

Options:
  -h,--help                   Print this
  --connect TEXT=ws://127.0.0.1:7420
                              where

Subcommands:
  cull                        Answers
"""
CULL = """does
Usage: p cull [OPTIONS] NAME

Positionals:
  NAME TEXT REQUIRED          scene

Options:
  -h,--help                   Print this
  -o,--output TEXT REQUIRED   file
  --width UINT                width
  --json                      print JSON
"""
PAGE = """# OPTIONS
*-h*, *--help*
*--connect* _ADDRESS_
# COMMANDS
## p cull NAME
Text that names *--width* _W_ is no entry.
*-o*, *--output* _FILE_
*--width* _W_
*--json*
"""
# (what is replaced, by what, in which text, how many faults)
MUTATIONS = [
    ("", "", PAGE, 0),
    ("*--json*\n", "", PAGE, 1),
    ("*--json*\n", "*--json*\n*--xml*\n", PAGE, 1),
    ("*--json*\n", "*--json* _FILE_\n", PAGE, 1),
    ("*--width* _W_\n*--json*", "*--width*\n*--json*", PAGE, 1),
    ("## p cull NAME", "## p cull", PAGE, 1),
    ("## p cull NAME", "## p fly NAME", PAGE, 2),
    ("  --json                      print JSON\n", "", CULL, 1),
    ("  --width UINT", "  --depth UINT", CULL, 2),
    ("  --connect TEXT", "  --address TEXT", HELP, 2),
]


def self_test():
    for before, after, text, expected in MUTATIONS:
        texts = [t.replace(before, after) if t is text and before else t for t in (HELP, CULL, PAGE)]
        helped = help_table({"": option_table.parse(texts[0]), "cull": option_table.parse(texts[1])})
        found = list(faults("p", helped, page_table(texts[2], "p")))
        if len(found) != expected:
            return f"self-test: {before!r} -> {after!r}: expected {expected} faults, got {found}"
    print(f"self-test: {len(MUTATIONS)} cases behave")
    return None


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) != 2:
        return __doc__
    program, page = arguments[0], pathlib.Path(arguments[1])
    name = pathlib.Path(program).name
    helped = help_table(option_table.read(program))
    found = list(faults(name, helped, page_table(page.read_text(encoding="utf-8"), name)))
    options = sum(len(options) for _, options in helped.values())
    print(f"{page.name}: {len(helped)} commands, {options} options, {len(found)} faults")
    return "\n".join(found) or None


sys.exit(main(sys.argv[1:]))
