#!/usr/bin/env python3
"""Fails when a header does not compile alone: each is the only thing a translation unit includes.

usage: check_headers.py ROOT COMPILER FLAG...   (FLAGs as the rooms are built with)

Left out: *-inl.h, which are parts of one SIMD kernel file by design.
"""
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

TOP_FOLDERS = ("protocol", "culling", "server", "client", "tests")


def headers(root):
    for folder in TOP_FOLDERS:
        for path in sorted((root / folder).rglob("*.h")):
            if not path.name.endswith("-inl.h") and "node_modules" not in path.parts:
                yield path.relative_to(root).as_posix()


def compile_alone(root, compiler, flags, header):
    """The compiler's complaint, or None. `-include`, as `#pragma once` warns in a main file."""
    command = [compiler, *flags, "-fsyntax-only", "-x", "c++", "-include", str(root / header), os.devnull]
    done = subprocess.run(command, capture_output=True, text=True)
    return None if done.returncode == 0 else f"{header} does not compile alone:\n{done.stderr}"


def check(root, compiler, flags):
    found = list(headers(root))
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
    print(f"{len(found)} headers, {len(faults)} do not compile alone")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
