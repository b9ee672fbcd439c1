#!/usr/bin/env python3
"""The stability suite with other random numbers: how far what it measures is off over many seeds, and how often its bounds hold.

    python3 tools/stability_sweep.py FIRST_SEED SEEDS > docs/measured/STABILITY-SWEEP.md

About a minute of one core a seed in the release profile, after building it. Seeds already measured are kept in
target/stability-sweep/, so a sweep that was stopped goes on.
"""
import collections
import os
import re
import statistics
import subprocess
import sys

from provenance import provenance

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "target", "stability-sweep")
OFF = re.compile(r"^(?:test \S+ \.\.\. )?(.+): (\S+) of (\S+), off by (\S+) %$")
BOUND = re.compile(r"^(?:test \S+ \.\.\. )?(.+): (\S+), bound (\S+)$")

HEADER = """# The stability suite over seeds

{provenance}

Made by `python3 tools/stability_sweep.py {first} {count} > docs/measured/STABILITY-SWEEP.md`, about a minute of one core a seed in the release profile. What the suite of
[STABILITY.md](STABILITY.md) measures with other random numbers, {count} seeds from {first}, so that chance can be told from error.
"""


def measure(seed):
    """What the suite prints with `seed`."""
    path = os.path.join(FOLDER, f"{seed}.txt")
    if not os.path.exists(path):
        command = ["cargo", "test", "--release", "--test", "stability", "--", "--nocapture", "--test-threads", "1"]
        environment = {**os.environ, "STABILITY_SEED": str(seed)}
        output = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True).stdout
        if "test result:" not in output:
            sys.exit("the suite did not run; try it with: " + " ".join(command))
        open(path, "w").write(output)
    return open(path).read()


def main():
    first, count = int(sys.argv[1]), int(sys.argv[2])
    os.makedirs(FOLDER, exist_ok=True)
    offs, bounds, failures = collections.defaultdict(list), collections.defaultdict(list), collections.Counter()
    for seed in range(first, first + count):
        print(f"seed {seed}", file=sys.stderr)
        output = measure(seed)
        failures.update(re.findall(r"^    (\S+::\S+)$", output.split("failures:")[-1], re.M) if "failures:" in output else [])
        for line in output.splitlines():
            if found := OFF.match(line):
                offs[found[1]].append(float(found[4]))
            elif found := BOUND.match(line):
                bounds[found[1]].append((float(found[2]), float(found[3])))
    print(HEADER.format(first=first, count=count, provenance=provenance(ROOT)))
    for test, times in sorted(failures.items()):
        print(f"`{test}` fails in {times} of them.\n")
    print("| off by, % | mean | standard error | least | most |\n|---|---:|---:|---:|---:|")
    for what, values in sorted(offs.items()):
        if max(map(abs, values)) >= 0.05:
            error = statistics.stdev(values) / len(values) ** 0.5 if len(values) > 1 else float("nan")
            print(f"| {what} | {statistics.mean(values):+.2f} | {error:.2f} | {min(values):+.2f} | {max(values):+.2f} |")
    print("\n| measured | mean | most | bound |\n|---|---:|---:|---:|")
    for what, values in sorted(bounds.items()):
        if max(value for value, _ in values) > 0.0:
            mean, most = statistics.mean(value for value, _ in values), max(value for value, _ in values)
            print(f"| {what} | {mean:.3g} | {most:.3g} | {values[0][1]:.3g} |")


if __name__ == "__main__":
    main()
