#!/usr/bin/env python3
"""Holds the schema to what old clients rely on: it may only grow at its ends.

usage: check_schema.py FLATC RELEASED.fbs NEW.fbs | check_schema.py FLATC --self-test

`flatc --conform` judges types, numbers and defaults. It passes over structs that grow, and over what
was renamed or removed at an end, so those are compared here: every enum, table and union of the
released schema must be the beginning of the new one's, and every struct the same.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(r"(enum|struct|table|union)\s+(\w+)([^{]*)\{([^}]*)\}")


def blocks(text):
    """{(kind, name): (what stands before the brace, [items])}"""
    text = re.sub(r"//[^\n]*", "", text)
    found = {}
    for kind, name, head, body in BLOCK.findall(text):
        items = [" ".join(item.split()) for item in re.split(r"[,;]", body)]
        found[kind, name] = (head.strip(), [item for item in items if item])
    return found


def statements(text):
    """What stands outside the blocks: namespace, identifier, root type."""
    outside = BLOCK.sub("", re.sub(r"//[^\n]*", "", text))
    return [" ".join(s.split()) for s in outside.split(";") if s.strip()]


def complaints(released, new):
    wrong = []
    if statements(released) != statements(new):
        wrong.append(f"{statements(released)} became {statements(new)}")
    after = blocks(new)
    for (kind, name), (head, items) in blocks(released).items():
        if (kind, name) not in after:
            wrong.append(f"{kind} {name} is gone")
            continue
        new_head, new_items = after[kind, name]
        if new_head != head:
            wrong.append(f"{kind} {name}: \"{head}\" became \"{new_head}\"")
        if new_items[:len(items)] != items:
            wrong.append(f"{kind} {name}: the released items are not its beginning")
        if kind == "struct" and new_items != items:
            wrong.append(f"struct {name}: a struct cannot change")
    return wrong


def check(flatc, released, new):
    judged = subprocess.run([flatc, "--conform", released, new], capture_output=True, text=True)
    wrong = complaints(Path(released).read_text(), Path(new).read_text())
    if judged.returncode != 0:
        wrong.append("flatc --conform: " + (judged.stdout + judged.stderr).strip())
    return wrong


SAMPLE = """namespace n;
file_identifier "ABCD";
enum E : ushort { A = 0, B = 1 }
struct S { x:uint; y:uint; }
table T { s:S; name:string; number:uint; }
table U { e:E; }
union Body { T, U }
table M { body:Body; }
root_type M;
"""

# (what, from, to, allowed)
CHANGES = [
    ("nothing", "n;", "n;", True),
    ("a comment", "namespace", "// why\nnamespace", True),
    ("a field at the end", "number:uint;", "number:uint; more:uint;", True),
    ("a value at the end", "B = 1", "B = 1, C = 2", True),
    ("a table and a member at the end", "union Body { T, U }", "table V { x:uint; }\nunion Body { T, U, V }", True),
    ("a field in the middle", "name:string;", "more:uint; name:string;", False),
    ("a field removed at the end", "number:uint;", "", False),
    ("a field removed in the middle", "name:string;", "", False),
    ("a field renamed", "number:uint", "count:uint", False),
    ("a field's type", "number:uint", "number:ulong", False),
    ("a field's default", "number:uint", "number:uint = 7", False),
    ("a struct grows", "y:uint;", "y:uint; z:uint;", False),
    ("a struct's type", "y:uint;", "y:ulong;", False),
    ("a value renumbered", "B = 1", "B = 2", False),
    ("a value removed", ", B = 1", "", False),
    ("a value in the middle", "A = 0,", "A = 0, Z,", False),
    ("an enum's type", "E : ushort", "E : uint", False),
    ("a member in front", "{ T, U }", "{ U, T }", False),
    ("a table renamed", "U", "W", False),
    ("the identifier", "ABCD", "ABCE", False),
    ("the root", "root_type M", "root_type T", False),
]


def self_test(flatc):
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        released, new = Path(folder, "released.fbs"), Path(folder, "new.fbs")
        released.write_text(SAMPLE)
        for what, before, after, allowed in CHANGES:
            new.write_text(SAMPLE.replace(before, after))
            wrong = check(flatc, released, new)
            if (not wrong) != allowed:
                print(f"{what}: should be {'allowed' if allowed else 'refused'}, is not: {wrong}")
                failed = 1
    return failed


def main():
    if len(sys.argv) == 3 and sys.argv[2] == "--self-test":
        return self_test(sys.argv[1])
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    flatc, released, new = sys.argv[1:]
    wrong = check(flatc, released, new)
    for line in wrong:
        print(f"{new}: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
