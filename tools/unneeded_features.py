#!/usr/bin/env python3
"""What the materials that a scene does not use cost it: processor time of a diffuse box by the whole program, and by one that was
built without them.

    python3 tools/unneeded_features.py FOLDER [PAIRS]

FOLDER gets a copy of the crate without every material but `diffuse` and `twosided`, and both builds: about ten minutes of two cores, once.
Then PAIRS (default 12) pairs of runs follow, one program after the other, on one thread: about half a minute a pair.
"""
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys

KEPT = ("diffuse", "twosided")
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENE = os.path.join(ROOT, "tests", "references", "cornell-diffuse", "scene.xml")
RUNS = {"sppm": 48, "path": 96, "bdpt": 24}


def strip(crate):
    """Takes the rows of all other materials out of the table, and with them all code that only they reach."""
    path = os.path.join(crate, "src", "scene", "material", "mod.rs")
    text = open(path).read()
    head, table = text.split("\nmaterials! {\n")
    rows, rest = table.split("\n}\n", 1)
    kept = [row for row in rows.split("\n") if re.search(r'"(\w+)"', row).group(1) in KEPT]
    taken = len(rows.split("\n")) - len(kept)
    open(path, "w").write(head + "\nmaterials! {\n" + "\n".join(kept) + "\n}\n" + rest)
    # What nobody calls any more must not stop the build.
    library = os.path.join(crate, "src", "lib.rs")
    text = open(library).read()
    first = re.search(r"^(?!//!|\s*$)", text, re.M).start()
    open(library, "w").write(text[:first] + "#![allow(dead_code, unused_imports)]\n" + text[first:])
    return taken


def build(crate, target):
    environment = {**os.environ, "CARGO_TARGET_DIR": target}
    subprocess.run(["cargo", "build", "--release", "--quiet", "--locked"], cwd=crate, env=environment, check=True)
    binary = target + "-photonfarm"
    shutil.copy(os.path.join(target, "release", "photonfarm"), binary)
    return binary


def seconds(program, method, passes, picture):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [program, "render", SCENE, "--method", method, "--passes", str(passes), "--threads", "1", "-o", picture]
    subprocess.run(command, check=True, capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    folder = os.path.abspath(sys.argv[1])
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else 12
    crate, target = os.path.join(folder, "crate"), os.path.join(folder, "target")
    shutil.rmtree(crate, ignore_errors=True)
    shutil.copytree(ROOT, crate, ignore=shutil.ignore_patterns("target", ".git"))
    whole = build(crate, target)
    os.rename(whole, os.path.join(folder, "whole"))
    taken = strip(crate)
    os.rename(build(crate, target), os.path.join(folder, "stripped"))
    print(f"{taken} materials taken out of the table; {pairs} pairs of runs on one thread\n")
    print("| method | passes | whole: median CPU-s | stripped | whole over stripped, median | quartiles | same bytes |")
    print("|---|---:|---:|---:|---:|---:|---|")
    for method, passes in RUNS.items():
        times, pictures = [], []
        for _ in range(pairs):
            pair = []
            for name in ("whole", "stripped"):
                picture = os.path.join(folder, name + ".exr")
                pair.append(seconds(os.path.join(folder, name), method, passes, picture))
                pictures.append(open(picture, "rb").read())
            times.append(pair)
        ratios = sorted(whole / stripped for whole, stripped in times)
        low, middle, high = statistics.quantiles(ratios, n=4)
        medians = [statistics.median(column) for column in zip(*times)]
        same = "yes" if len(set(pictures)) == 1 else "NO"
        print(f"| `{method}` | {passes} | {medians[0]:.2f} | {medians[1]:.2f} | {middle:.3f} | {low:.3f}–{high:.3f} | {same} |", flush=True)


if __name__ == "__main__":
    main()
