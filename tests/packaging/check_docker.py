#!/usr/bin/env python3
"""Fails when docker/ and the tree it builds differ: packages, targets, flags, paths, ports. Reads
files only; docker/build_with_buildah.sh builds.

usage: check_docker.py ROOT CULLD
"""
import json
import pathlib
import re
import subprocess
import sys


def instructions(text):
    """[(WORD, the rest)] of a Dockerfile, continued lines joined."""
    text = re.sub(r"^#.*\n", "", text, flags=re.M)
    lines = re.sub(r"\\\n", " ", text).splitlines()
    return [tuple(line.split(None, 1)) for line in lines if line.strip()]


def last(found, word):
    return [rest for name, rest in found if name == word][-1]


def package_faults(root, found):
    listed = {name for file in ("packages.txt", "packages-check.txt")
              for name in (root / "cmake" / file).read_text().split()}
    runs = [rest for word, rest in found if word == "RUN"]
    if not any("</src/cmake/packages.txt" in run for run in runs):
        yield "the build does not install what cmake/packages.txt lists"
    for run in runs:
        for words in re.findall(r"apt-get install([^<&]*)", run):
            for word in words.split():
                if not word.startswith(("-", "/")) and word not in listed:
                    yield f"{word}: installed, but in none of cmake/packages*.txt"


def target_faults(root, found):
    text = "\n".join(path.read_text() for path in root.rglob("CMakeLists.txt") if "build" not in path.parts)
    run = next(rest for word, rest in found if word == "RUN" and "--target" in rest)
    for target in re.search(r"--target([\w\s]+)", run)[1].split():
        if not re.search(rf"(culld_program|culld_room|add_custom_target|add_library)\({target}\b", text):
            yield f"{target}: no such target"
    packages = (root / "cmake" / "package.cmake").read_text()
    for _, rest in (pair for pair in found if pair[0] == "COPY" and "--from" in pair[1]):
        for name in re.findall(r"/packages/([a-z-]+)_", rest):
            if not re.search(rf"culld_package\(\w+ {name}\b", packages):
                yield f"{name}: no such package"


def run_faults(found, culld, compose):
    entry, command = json.loads(last(found, "ENTRYPOINT")), json.loads(last(found, "CMD"))
    help_text = subprocess.run([culld, command[0], "--help"], check=True, capture_output=True, text=True).stdout
    if entry != ["culld"]:
        yield f"ENTRYPOINT {entry}"
    for word in command[1:]:
        if word.startswith("-") and f"  {word} " not in help_text:
            yield f"culld {command[0]} has no {word}"
    environment = dict(pair.split("=", 1) for pair in last(found, "ENV").split())
    if environment["CULLD_LISTEN"] != f"0.0.0.0:{last(found, 'EXPOSE')}":
        yield "CULLD_LISTEN and EXPOSE differ"
    for want, value in (("USER", "culld"), ("STOPSIGNAL", "SIGTERM"), ("VOLUME", "/var/lib/culld")):
        if last(found, want) != value:
            yield f"{want} is {last(found, want)}"
    if f"unix:{environment['CULLD_UNIX']}" not in last(found, "HEALTHCHECK"):
        yield "HEALTHCHECK asks another socket than CULLD_UNIX"
    for need in (f'"127.0.0.1:{last(found, "EXPOSE")}:{last(found, "EXPOSE")}"', "read_only: true", "cap_drop: [ALL]",
                 "data:" + last(found, "VOLUME"), "no-new-privileges"):
        if need not in compose:
            yield f"compose.yaml: no {need}"


def variable_faults(root):
    """Every CULLD_* that docker/ gives the daemon is a key's, as docs/configuration.md lists them."""
    known = set(re.findall(r"`(CULLD_[A-Z_]+)`", (root / "docs" / "configuration.md").read_text()))
    given = {name for path in (root / "docker").iterdir() for name in re.findall(r"\bCULLD_[A-Z_]+\b", path.read_text())}
    yield from (f"{name}: no variable of culld" for name in sorted(given - known))
    if len(given) < 3:
        yield f"docker/ gives hardly any variables: {given}"


def main(arguments):
    if len(arguments) != 2:
        return __doc__
    root, culld = pathlib.Path(arguments[0]), arguments[1]
    found = instructions((root / "docker" / "Dockerfile").read_text())
    compose = (root / "docker" / "compose.yaml").read_text()
    faults = [*package_faults(root, found), *target_faults(root, found), *run_faults(found, culld, compose),
              *variable_faults(root)]
    print(f"{len(found)} instructions, {len(faults)} faults")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
