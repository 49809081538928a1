#!/usr/bin/env python3
"""Fails when a file includes what its room may not see. The rules are data: tests/layers.txt.

usage: check_layers.py ROOT       checks the tree
       check_layers.py --self-test  breaks each kind of rule in a tree of its own
"""
import fnmatch
import pathlib
import re
import sys
import tempfile

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
TOP_FOLDERS = ("protocol", "culling", "server", "client", "tests")


class Rules:
    def __init__(self, text):
        self.rooms, self.isolated, self.only, self.at_most = {}, {}, [], []
        for number, line in enumerate(text.splitlines(), 1):
            line = line.split("#")[0].strip()
            if not line:
                continue
            left, colon, right = line.partition(":")
            word, *names = left.split()
            values = right.split()
            if not colon or not names:
                raise ValueError(f"layers.txt:{number}: not a rule: {line}")
            if word == "room":
                self.rooms[names[0]] = values
            elif word == "isolated":
                self.isolated[names[0]] = values
            elif word == "only":
                self.only += [(name, values) for name in names]
            elif word == "at_most":
                self.at_most.append((int(names[0]), names[1], values[0]))
            else:
                raise ValueError(f"layers.txt:{number}: unknown word {word}")

    def room_of(self, path):
        inside = [room for room in self.rooms if within(path, room)]
        return max(inside, key=len, default=None)


def within(path, room):
    return path == room or path.startswith(room + "/")


def matches(path, patterns):
    return any(fnmatch.fnmatchcase(path, pattern) for pattern in patterns)


def first_word(path):
    return pathlib.PurePosixPath(path).stem.split("_")[0]


def sources(root):
    for folder in TOP_FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp") and "node_modules" not in path.parts:
                yield path.relative_to(root).as_posix()


def check_own(rules, path, header):
    """Why `path` may not include our own `header`, or None."""
    here, there = rules.room_of(path), rules.room_of(header)
    if here is None:
        return f"{path} is in no room of layers.txt"
    if here == there:
        loose = rules.isolated.get(here)
        if loose is None or matches(path, loose) or first_word(path) == first_word(header):
            return None
        return f"files of {here} may not include each other"
    if any(within(header, room) for room in rules.rooms[here]):
        return None
    return f"{here} may not see {there or 'a header of no room'}"


def check_foreign(rules, path, header):
    """Why `path` may not include the library header `header`, or None."""
    named = [patterns for prefix, patterns in rules.only if header.startswith(prefix)]
    if not named:
        standard = "/" not in header and not header.endswith(".h")
        return None if standard else f"no rule names <{header}>"
    return None if any(matches(path, patterns) for patterns in named) else f"not the place for <{header}>"


def check_tree(root, rules):
    faults, includes, users = [], 0, {rule: set() for rule in rules.at_most}
    for path in sources(root):
        text = (root / path).read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(), 1):
            found = INCLUDE.match(line)
            if not found:
                continue
            includes += 1
            quote, header = found.groups()
            own = header if quote == '"' else None
            if own and not (root / own).exists() and (root / "client/sdk/include" / own).exists():
                own = "client/sdk/include/" + own  # the installed API is included as its users do
            if own and (root / own).exists():
                fault = check_own(rules, path, own)
            else:
                fault = check_foreign(rules, path, header)
            if fault:
                faults.append(f"{path}:{number}: {line.strip()}: {fault}")
            for rule in rules.at_most:
                if within(path, rule[1]) and header.startswith(rule[2]):
                    users[rule].add(path)
    for (limit, room, header), files in users.items():
        if len(files) > limit:
            faults.append(f"{room}: {len(files)} files include {header}, {limit} may: {', '.join(sorted(files))}")
    return faults, includes


SELF_TEST_RULES = """
room low :
room culling/mid : low
room culling/methods : culling/mid
room tests : low culling
isolated culling/methods : culling/methods/all.cpp
only big/ : culling/mid/loader_*.cpp
at_most 1 culling/mid : big/
"""
# (file, its include line, expected word of the fault or None)
SELF_TESTS = [
    ("culling/mid/a.cpp", '#include "low/x.h"', None),
    ("culling/mid/a.cpp", "#include <vector>", None),
    ("tests/a.cpp", '#include "culling/mid/m.h"', None),
    ("culling/methods/one_kernels.cpp", '#include "culling/methods/one.h"', None),
    ("culling/methods/all.cpp", '#include "culling/methods/one.h"', None),
    ("culling/mid/loader_a.cpp", "#include <big/all.h>", None),
    ("protocol/a.cpp", '#include "low/x.h"', "no room"),
    ("culling/mid/a.cpp", '#include "culling/methods/one.h"', "may not see"),
    ("culling/mid/a.cpp", '  #  include "culling/methods/one.h"', "may not see"),
    ("culling/methods/two.cpp", '#include "culling/methods/one.h"', "each other"),
    ("culling/mid/a.cpp", "#include <big/all.h>", "not the place"),
    ("culling/mid/a.cpp", '#include "big/all.h"', "not the place"),
    ("culling/mid/a.cpp", "#include <unknown/all.h>", "no rule"),
    ("culling/mid/a.cpp", '#include "x.h"', "no rule"),
]


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def faults_of_tree(files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for header in ("low/x.h", "culling/mid/m.h", "culling/methods/one.h"):
            write(root / header, "")
        for path, line in files:
            write(root / path, line + "\n")
        return check_tree(root, Rules(SELF_TEST_RULES))[0]


def self_test():
    for path, line, expected in SELF_TESTS:
        faults = faults_of_tree([(path, line)])
        fine = len(faults) == 1 and path in faults[0] and expected in faults[0] if expected else not faults
        if not fine:
            return f"self-test: {path}: {line}: expected {expected}, got {faults}"
    two = [(f"culling/mid/loader_{name}.cpp", "#include <big/all.h>") for name in "ab"]
    if len(faults_of_tree(two)) != 1:
        return f"self-test: at_most let two files through: {faults_of_tree(two)}"
    print(f"self-test: {len(SELF_TESTS) + 1} cases behave")
    return None


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) != 1:
        return __doc__
    root = pathlib.Path(arguments[0])
    rules = Rules((root / "tests/layers.txt").read_text(encoding="utf-8"))
    faults, includes = check_tree(root, rules)
    if includes == 0:
        return f"{root}: no includes found"
    print(f"{includes} includes, {len(faults)} forbidden")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
