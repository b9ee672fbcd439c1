#!/usr/bin/env python3
"""What `--method auto` would have cost: its choice beside the best method of an exhaustive evaluation, as a table.

    python3 tools/regret.py target/release/photonfarm results.jsonl tests/references [-D NAME=VALUE]

Time to relMSE 0.01 is read off each method's curve, straight lines between its points on logarithmic scales, and its last or first
segment beyond them (marked ~). Methods that are blind to some light of a scene, and those whose bias stays, are not counted as best.
"""
import collections
import json
import math
import os
import subprocess
import sys

TARGET = 0.01
NOT_CONSISTENT = ("photon_map", "bdpm")


def curves(path):
    """Scene → method → points (seconds, relMSE above the reference's noise), and the blind ones."""
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    blind = set()
    for line in open(path):
        record = json.loads(line)
        noise = (record["metrics"].get("reference_noise") or {}).get("relmse", 0.0)
        error = record["metrics"]["relmse"] - noise
        key = (record["scene"], record["label"])
        if record.get("blind"):
            blind.add(key)
        if error > 0.0:
            found[record["scene"]][record["label"]].append((record["cpu_seconds"], error))
    return found, blind


def time_to(points, target):
    """Seconds until the error is `target`, and whether that lies outside the points."""
    points = sorted(points)
    if len(points) == 1:
        (seconds, error), rate = points[0], 1.0
        return seconds * (error / target) ** (1.0 / rate), True
    logs = [(math.log(seconds), math.log(error)) for seconds, error in points]
    wanted = math.log(target)
    for (x0, y0), (x1, y1) in zip(logs, logs[1:]):
        if y1 <= wanted <= y0:
            return math.exp(x0 + (wanted - y0) / (y1 - y0) * (x1 - x0)), False
    (x0, y0), (x1, y1) = logs[:2] if logs[0][1] < wanted else logs[-2:]
    slope = min((y1 - y0) / (x1 - x0), -0.2)
    anchor = (x0, y0) if logs[0][1] < wanted else (x1, y1)
    return math.exp(anchor[0] + (wanted - anchor[1]) / slope), True


def chosen(program, scene, defines):
    command = [program, "plan", scene, "--error", str(TARGET), "--json", *defines]
    plan = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return plan["trials"][0]["method"]["name"], plan["trials"][0]["expected_seconds"]


def main():
    program, results, folder, *defines = sys.argv[1:]
    found, blind = curves(results)
    print("| scene | best | s to 0.01 | auto | s to 0.01 | promised | regret |")
    print("|---|---|---:|---|---:|---:|---:|")
    for scene in sorted(found):
        times = {label: time_to(points, TARGET) for label, points in found[scene].items()}
        fair = {k: v for k, v in times.items() if (scene, k) not in blind and k not in NOT_CONSISTENT}
        best = min(fair, key=lambda label: fair[label][0])
        auto, promised = chosen(program, os.path.join(folder, scene, "scene.xml"), defines)
        shown = lambda label: ("~" if times[label][1] else "") + f"{times[label][0]:.2g}"
        regret = times[auto][0] / times[best][0]
        print(f"| {scene} | {best} | {shown(best)} | {auto} | {shown(auto)} | {promised:.2g} | {regret:.2f} |", flush=True)


if __name__ == "__main__":
    main()
