#!/usr/bin/env python3
"""Fails when the text around the code rots: links and named documents that are not there, left-over
TODOs, files that grew too long, compiler flags for one file.

usage: check_text.py ROOT         checks the tree
       check_text.py --self-test  breaks each rule in a tree of its own
"""
import pathlib
import re
import sys
import tempfile

CODE_FOLDERS = ("protocol", "culling", "server", "client", "tests", "cmake", "packaging", "docker")
CODE_SUFFIXES = (".h", ".cpp", ".txt", ".cmake", ".py", ".sh", ".fbs")
MAX_LINES = 500  # the aim is 400; what is longer has become two ideas
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
NAMED_DOCUMENT = re.compile(r"docs/[\w./-]*\w")
LEFT_OVER = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")
TARGET_FLAG = re.compile(r"-m(avx|sse|fma|bmi|arch|tune)")


def documents(root):
    yield from sorted(root.glob("*.md"))
    yield from sorted((root / "docs").rglob("*.md"))


def code(root):
    for folder in CODE_FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in CODE_SUFFIXES and "node_modules" not in path.parts:
                yield path


def document_faults(root, path):
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        for link in LINK.findall(line):
            if "://" not in link and not (path.parent / link).exists():
                yield f"{path.relative_to(root)}:{number}: no such file: {link}"


def is_document(root, name):
    """docs/adr/0001 stands for docs/adr/0001-highway-not-per-isa.md."""
    return (root / name).exists() or any(root.glob(name + "*"))


def code_faults(root, path):
    name = path.relative_to(root).as_posix()
    lines = path.read_text(encoding="utf-8").splitlines()
    if name.startswith("tests/check_text"):
        return
    if path.suffix in (".h", ".cpp") and len(lines) > MAX_LINES:
        yield f"{name}: {len(lines)} lines, more than {MAX_LINES}"
    for number, line in enumerate(lines, 1):
        if LEFT_OVER.search(line):
            yield f"{name}:{number}: left over: {line.strip()}"
        if TARGET_FLAG.search(line) and name != "cmake/culld_targets.cmake" and path.suffix in (".txt", ".cmake"):
            yield f"{name}:{number}: a target flag for part of the tree (docs/adr/0001): {line.strip()}"
        for document in NAMED_DOCUMENT.findall(line):
            if not is_document(root, document):
                yield f"{name}:{number}: no such file: {document}"


def check(root):
    faults, files = [], 0
    for path in documents(root):
        files += 1
        faults += document_faults(root, path)
    for path in code(root):
        files += 1
        faults += code_faults(root, path)
    return files, faults


# (file, text, expected word of the fault or None)
SELF_TESTS = [
    ("README.md", "[a](docs/there.md) [b](https://example.org) [c](docs/there.md#part)", None),
    ("README.md", "[a](docs/gone.md)", "gone.md"),
    ("culling/a.cpp", "// docs/there.md §2, docs/adr/0001", None),
    ("culling/a.cpp", "// docs/gone.md §2", "gone.md"),
    ("culling/a.cpp", "// TODO later", "left over"),
    ("culling/a.cpp", "\n" * (MAX_LINES + 1), "lines"),
    ("culling/CMakeLists.txt", "target_compile_options(a PRIVATE -mavx2)", "target flag"),
]


def faults_of_tree(path, text):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, content in (("docs/there.md", ""), ("docs/adr/0001-a.md", ""), (path, text)):
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(content, encoding="utf-8")
        return check(root)[1]


def self_test():
    for path, text, expected in SELF_TESTS:
        faults = faults_of_tree(path, text)
        if (len(faults) == 1 and expected in faults[0]) if expected else not faults:
            continue
        return f"self-test: {path}: {text[:60]!r}: expected {expected}, got {faults}"
    print(f"self-test: {len(SELF_TESTS)} cases behave")
    return None


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) != 1:
        return __doc__
    files, faults = check(pathlib.Path(arguments[0]))
    print(f"{files} files, {len(faults)} faults")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
