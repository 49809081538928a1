#!/usr/bin/env python3
"""Fails when what is written about the configuration differs: culld.toml(5) and the installed file
against the table of docs/configuration.md, which a test of the daemon holds against its keys.

usage: check_config_text.py CONFIGURATION.md PAGE.scd INSTALLED.toml
"""
import pathlib
import re
import sys
import tomllib

ROW = re.compile(r"^\| `([\w.]+)` \| (?:`([^`]*)`)? *\| [^|]* \| `\w+` \| [^|]*\| (yes)? *\|", re.M)
KEY = re.compile(r"^\*([\w.]+)\* = ")
DEFAULT = re.compile(r"Default: (none|\"[^\"]*\"|[\w.]+?)\.(?:$|\s)")


def value_of(text):
    """What TOML makes of a default as written; None for none."""
    value = None if text in (None, "none") else tomllib.loads(f"v = {text}")["v"]
    return None if value == [] else value


def documented(text):
    """{key: (default, whether a reload takes it up)}."""
    return {key: (value_of(default), bool(reloaded)) for key, default, reloaded in ROW.findall(text)
            for default in [default or None]}


def page_keys(text):
    """{key: its paragraph}."""
    found, table, key = {}, "", None
    for line in text.splitlines():
        if line.startswith("#"):
            name = line.lstrip("# ")
            table = name.strip("[]") + "." if name.startswith("[") else ""
            key = None
        elif match := KEY.match(line):
            key = table + match[1]
            found[key] = ""
        elif key:
            found[key] += line.strip() + " "
    return found


def page_faults(page, keys):
    told = page_keys(page)
    for key in sorted(set(keys) | set(told)):
        if key not in told:
            yield f"{key}: not in the manual page"
            continue
        if key not in keys:
            yield f"{key}: in the manual page only"
            continue
        default, reloaded = keys[key]
        written = DEFAULT.search(told[key])
        if written is None or value_of(written[1]) != default:
            yield f"{key}: default {default!r}, the manual page says {written and written[1]}"
        if reloaded == ("At start." in told[key]):
            yield f"{key}: {'reloaded' if reloaded else 'not reloaded'}, the manual page says otherwise"


def flat(table, before=""):
    found = {}
    for name, value in table.items():
        found.update(flat(value, f"{before}{name}.") if isinstance(value, dict) else {before + name: value})
    return found


def installed_faults(text, keys):
    shown = flat(tomllib.loads(re.sub(r"^#(?=\w+ = )", "", text, flags=re.M)))
    examples = flat(tomllib.loads(re.sub(r"^# (?=\w+ = )", "", text, flags=re.M)))
    for key in sorted(set(shown) | set(examples)):
        if key not in keys and not key.startswith("scenes."):
            yield f"{key}: in the installed file only"
    for key, value in shown.items():
        if key in keys and key not in flat(tomllib.loads(text)) and value != keys[key][0]:
            yield f"{key}: default {keys[key][0]!r}, the installed file shows {value!r}"
    if len(shown) < 8 or len(examples) < 5:
        yield "the installed file shows hardly anything"


def main(arguments):
    if len(arguments) != 3:
        return __doc__
    table, page, installed = (pathlib.Path(path).read_text(encoding="utf-8") for path in arguments)
    keys = documented(table)
    faults = [*page_faults(page, keys), *installed_faults(installed, keys)]
    if len(keys) < 30:
        faults.append(f"only {len(keys)} keys understood of {arguments[0]}")
    print(f"{len(keys)} keys, {len(faults)} faults")
    return "\n".join(faults) or None


sys.exit(main(sys.argv[1:]))
