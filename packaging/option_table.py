"""The commands and options of a program, read from its --help: what completions are made of, and
what the man pages are held against."""
import dataclasses
import re
import subprocess

ENTRY = re.compile(r"^  (\S.*?)(?:  +(\S.*))?$")  # "  -o,--output TEXT REQUIRED   answers file"


@dataclasses.dataclass
class Option:
    names: tuple  # ("-o", "--output")
    takes_value: bool
    many: bool = False  # may be repeated
    help: str = ""


@dataclasses.dataclass
class Command:
    options: list = dataclasses.field(default_factory=list)
    positionals: list = dataclasses.field(default_factory=list)  # names
    many: set = dataclasses.field(default_factory=set)  # those that may be repeated
    commands: dict = dataclasses.field(default_factory=dict)  # name -> one line of help


def entries(text):
    """(section, head, help) of each entry of a --help text."""
    section, found = "", []
    for line in text.splitlines():
        if line and not line.startswith(" ") and line.endswith(":"):
            section = line[:-1]
        elif line.startswith("   ") and found and found[-1][0] == section:  # wrapped
            found[-1][2] = (found[-1][2] + " " + line.strip()).strip()
        elif match := ENTRY.match(line):
            found.append([section, match[1], match[2] or ""])
    return found


def parse(text):
    command = Command()
    for section, head, help_text in entries(text):
        name, _, kind = head.partition(" ")
        if section == "Options":
            takes_value = re.match(r"(TEXT|UINT|INT|FLOAT)\b", kind) is not None
            command.options.append(Option(tuple(name.split(",")), takes_value, "..." in kind, help_text))
        elif section == "Positionals":
            command.positionals.append(name)
            if "..." in kind:
                command.many.add(name)
        elif section == "Subcommands":
            command.commands[name] = help_text
    return command


def help_of(program, *words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True).stdout


def read(program):
    """{"": what stands before a command, "serve": ...}. ERROR: ValueError if nothing was understood."""
    table = {"": parse(help_of(program))}
    for name in table[""].commands:
        table[name] = parse(help_of(program, name))
        if not table[name].options:
            raise ValueError(f"{program} {name} --help: no options understood")
    if len(table) < 2:
        raise ValueError(f"{program} --help: no commands understood")
    return table
