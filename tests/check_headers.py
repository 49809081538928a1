#!/usr/bin/env python3
"""Fails when a header does not compile alone: each is the only thing a translation unit includes.

usage: check_headers.py ROOT COMPILER FLAG...   (FLAGs as the rooms are built with)

Left out: *-inl.h, which are parts of one SIMD kernel file by design; and headers that some .cpp file
includes before anything else, as those have compiled alone when that file was built.
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOP_FOLDERS = ("protocol", "culling", "server", "client", "tests")


def files(root, pattern):
    for folder in TOP_FOLDERS:
        for path in sorted((root / folder).rglob(pattern)):
            if "node_modules" not in path.parts:
                yield path


def included_first(source):
    """The header that a source file begins with, or None. Comments and empty lines may precede it."""
    first = next((line for line in source.splitlines() if line.strip() and not line.startswith("//")), "")
    found = re.match(r'#include "([^"]+)"', first)
    return found and found.group(1)


def headers(root):
    compiled = {included_first(path.read_text()) for path in files(root, "*.cpp")}
    names = (path.relative_to(root).as_posix() for path in files(root, "*.h") if not path.name.endswith("-inl.h"))
    return [name for name in names if name not in compiled]


def compile_alone(root, compiler, flags, header):
    """The compiler's complaint, or None. `-include`, as `#pragma once` warns in a main file."""
    command = [compiler, *flags, "-fsyntax-only", "-x", "c++", "-include", str(root / header), os.devnull]
    done = subprocess.run(command, capture_output=True, text=True)
    return None if done.returncode == 0 else f"{header} does not compile alone:\n{done.stderr}"


def check(root, compiler, flags):
    found = headers(root)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        faults = [fault for fault in pool.map(lambda h: compile_alone(root, compiler, flags, h), found) if fault]
    return found, faults


def self_test(compiler, flags):
    """A header that needs another one to be included first must be found."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "culling").mkdir()
        (root / "culling/good.h").write_text("#pragma once\n#include <vector>\ninline std::vector<int> f() { return {}; }\n")
        (root / "culling/bad.h").write_text("#pragma once\ninline std::vector<int> g() { return {}; }\n")
        (root / "culling/built.h").write_text("#pragma once\n")
        (root / "culling/built.cpp").write_text('// Its own header comes first.\n\n#include "culling/built.h"\n')
        found, faults = check(root, compiler, flags)
        return len(found) == 2 and len(faults) == 1 and "culling/bad.h" in faults[0]


def main(arguments):
    if len(arguments) < 2:
        return __doc__
    root, compiler, flags = pathlib.Path(arguments[0]), arguments[1], arguments[2:]
    if not self_test(compiler, flags):
        return "self-test: a header that does not compile alone was not found"
    found, faults = check(root, compiler, flags)
    if not found:
        return f"{root}: no headers found"
    print(f"{len(found)} headers that no file begins with, {len(faults)} do not compile alone")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
