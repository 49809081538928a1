#!/usr/bin/env python3
"""Every limit has a test that goes past it, and a line in the document.

usage: check_limits.py ROOT

Holds tests/limits.txt to the fields of server/limits.h and protocol/limits.h, to the tests that
exist, and to the keys in the table of docs/protocol.md.
"""

import re
import sys
from pathlib import Path

FIELD = re.compile(r"^\s+(?:std::\w+(?:::\w+)?)\s+(\w+)(?:\s*=|\{)", re.M)
CONSTANT = re.compile(r"^inline constexpr \S+ (k\w+) =", re.M)
TEST = re.compile(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)")


def limits(root):
    fields = FIELD.findall((root / "server/limits.h").read_text())
    return fields + CONSTANT.findall((root / "protocol/limits.h").read_text())


def listed(root):
    """{limit: (key, [tests])}"""
    found = {}
    for line in (root / "tests/limits.txt").read_text().splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        names, tests = line.split(":", 1)
        name, *key = names.split()
        found[name] = (key[0] if key else name, tests.split())
    return found


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    root = Path(sys.argv[1])
    there = limits(root)
    have = listed(root)
    tests = {f"{suite}.{name}" for file in (root / "tests").rglob("*.cpp")
             for suite, name in TEST.findall(file.read_text())}
    table = (root / "docs/protocol.md").read_text().split("## Limits", 1)[1].split("\n## ", 1)[0]
    wrong = [f"{name} is not listed" for name in there if name not in have]
    wrong += [f"{name} is no limit" for name in have if name not in there]
    for name, (key, its_tests) in have.items():
        if key != "-" and f"`{key}`" not in table:
            wrong.append(f"{name}: docs/protocol.md \"Limits\" has no `{key}`")
        if not its_tests:
            wrong.append(f"{name} has no test")
        wrong += [f"{name}: there is no test {test}" for test in its_tests if test not in tests]
    for line in wrong:
        print("tests/limits.txt: " + line)
    print(f"{len(there)} limits, {len(wrong)} faults")
    return 1 if wrong or len(there) < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
