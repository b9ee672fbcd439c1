#!/usr/bin/env python3
"""Switches each counter-measure of docs/measured/STABILITY.md off in a copy of the crate, and sees whether the row's test fails then.

    python3 tools/switch_off.py FOLDER > docs/measured/STABILITY-SWITCHED-OFF.md
    python3 tools/switch_off.py FOLDER "thin wall" shelf

FOLDER gets the copy and its build. Rows can be named to run only them. About a minute a row, and six minutes for the first build: 48 minutes
for all 35 changes on two cores that had other work too. The table is tests/stability/counter_measures.json: what is
replaced in which file, and the test that must fail then. Without any change all these tests must pass.
"""
import json
import os
import re
import subprocess
import sys
import time

from provenance import provenance

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TABLE = os.path.join(ROOT, "tests", "stability", "counter_measures.json")

HEADER = """# Counter-measures switched off

{provenance}

Made by `python3 tools/switch_off.py FOLDER > docs/measured/STABILITY-SWITCHED-OFF.md`: each counter-measure of [STABILITY.md](STABILITY.md) is switched off in a
copy of the crate, and the test of its row must fail then. What is replaced is in
[tests/stability/counter_measures.json](../../tests/stability/counter_measures.json). Seconds are those of building and testing.

| row | measure | switched off in | test | result | s |
|---|---|---|---|---|---:|"""


def read(path):
    return open(path, newline="").read()


def write(path, text):
    open(path, "w", newline="").write(text)


def copy_tracked(crate):
    """Copies what is tracked. Files that are as they were keep their time, so that builds stay incremental."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True).stdout
    for name in filter(None, names.split("\0")):
        source, target = os.path.join(ROOT, name), os.path.join(crate, name)
        if not os.path.exists(source):
            continue
        content = open(source, "rb").read()
        if not os.path.exists(target) or open(target, "rb").read() != content:
            os.makedirs(os.path.dirname(target), exist_ok=True)
            open(target, "wb").write(content)


def cargo(crate, *arguments):
    environment = {**os.environ, "CARGO_TARGET_DIR": os.path.join(os.path.dirname(crate), "target"), "CARGO_INCREMENTAL": "1"}
    command = ["cargo", "test", "--quiet", "--locked", "--test", "stability", *arguments]
    return subprocess.run(command, cwd=crate, env=environment, capture_output=True, text=True)


def run_tests(crate, tests):
    """Whether all `tests` pass, and what they or the compiler said; `None` when they could not be run."""
    built = cargo(crate, "--no-run")
    if built.returncode != 0:
        return None, built.stderr
    ran = cargo(crate, "--", "--exact", *tests)
    output = ran.stdout + ran.stderr
    counts = re.search(r"test result: \S+ (\d+) passed; (\d+) failed", output)
    if counts and int(counts[1]) + int(counts[2]) != len(tests):
        return None, f"there are {int(counts[1]) + int(counts[2])} of the {len(tests)} tests"
    return ran.returncode == 0, output


def first_line(pattern, output):
    """What `pattern` finds first, fit for a cell of a table."""
    found = re.search(pattern, output, re.M)
    line = found[1] if found else output.strip().split("\n")[-1]
    line = line if len(line) <= 120 else line[:119] + "…"
    return line.replace("|", "\\|")


def switch_off(crate, entry):
    """The result of the entry's test with its counter-measure off, and whether it fails as it should."""
    paths = {change["file"]: os.path.join(crate, change["file"]) for change in changes(entry)}
    before = {path: read(path) for path in paths.values()}
    for change in changes(entry):
        path = paths[change["file"]]
        text = read(path)
        if text.count(change["old"]) != 1:
            sys.exit(f"{entry['row']}: what is to be replaced is in {change['file']} {text.count(change['old'])} times")
        write(path, text.replace(change["old"], change["new"]))
    try:
        passes, output = run_tests(crate, [entry["test"]])
    finally:
        for path, text in before.items():
            write(path, text)
    if passes is None:
        return "**CANNOT RUN**: " + first_line(r"^(error.*)", output), False
    if passes:
        return "**STILL PASSES**", False
    return "fails: " + first_line(r"panicked at .*:\n(.*)", output), True


def changes(entry):
    return entry.get("changes", [entry])


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    crate, names = os.path.join(os.path.abspath(sys.argv[1]), "crate"), sys.argv[2:]
    entries = json.load(open(TABLE))["measures"]
    if unknown := set(names) - {entry["row"] for entry in entries}:
        sys.exit(f"no such rows: {', '.join(unknown)}")
    entries = [entry for entry in entries if not names or entry["row"] in names]
    start, held = time.monotonic(), 0
    copy_tracked(crate)
    passes, output = run_tests(crate, sorted({entry["test"] for entry in entries}))
    if not passes:
        sys.exit("not all tests pass as the crate is:\n" + output)
    print(HEADER.format(provenance=provenance(ROOT)), flush=True)
    for entry in entries:
        begin = time.monotonic()
        result, fails = switch_off(crate, entry)
        held += fails
        files = ", ".join(f"`{name}`" for name in dict.fromkeys(change["file"] for change in changes(entry)))
        cells = [f"**{entry['row']}**", entry["measure"], files, f"`{entry['test']}`", result, f"{time.monotonic() - begin:.0f}"]
        print("| " + " | ".join(cells) + " |", flush=True)
    print(f"\n{held} of {len(entries)} fail as they should, in {(time.monotonic() - start) / 60.0:.0f} minutes.")
    sys.exit(held < len(entries))


if __name__ == "__main__":
    main()
