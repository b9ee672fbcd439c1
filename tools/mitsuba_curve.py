#!/usr/bin/env python3
"""Error over processor time of Mitsuba 3 on references, as a file of peers for `photonfarm chart --peers` (docs/EVALUATION.md).

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python tools/mitsuba_curve.py tests/references/* --seconds 1,3,10,30 --seeds 3 -o mitsuba.json

Each scene is rendered once per seed, in batches of a few samples whose mean is the picture, until the largest budget is spent. Processor time
is that of the whole process while it renders: loading the scene does not count, as it does not for photonfarm. `scalar_rgb` works everywhere
and is compiled code without wide instructions; `llvm_ad_rgb` needs LLVM's library, and its just-in-time compilation counts as time.
"""
import argparse
import json
import os
import sys
import time

import numpy as np


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="folders with scene.xml, ref.exr and stderr.exr")
    parser.add_argument("--integrator", default="path", help="Mitsuba's name of the method")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--seconds", default="1,3,10,30", help="time budgets, processor-seconds")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-o", "--output", required=True)
    return parser.parse_args()


def read_exr(path):
    import mitsuba as mi
    return np.array(mi.Bitmap(path).convert(component_format=mi.Struct.Type.Float32), dtype=np.float64)


def load_reference(folder):
    """The truth and its standard error per pixel, or none where the truth is exact."""
    reference = read_exr(os.path.join(folder, "ref.exr"))[..., :3]
    meta = os.path.join(folder, "meta.json")
    exact = json.load(open(meta)).get("analytic_radiance") if os.path.exists(meta) else None
    if exact is not None:
        return np.full_like(reference, exact), None
    noise = os.path.join(folder, "stderr.exr")
    if not os.path.exists(noise):
        return reference, None
    error = read_exr(noise)
    return reference, error.mean(-1) if error.ndim == 3 else error


def metrics(image, reference, error):
    """As docs/EVALUATION.md defines them."""
    square = (image - reference) ** 2
    channel_mean = reference.mean(-1)
    below = channel_mean ** 2 + 1e-3 * reference.mean() ** 2
    relative = square.mean(-1) / below
    kept = np.sort(relative.ravel())[:int(0.999 * relative.size)]
    result = {"rmse": float(np.sqrt(square.mean())), "relmse": float(relative.mean()),
              "relmse_trimmed": float(kept.mean())}
    if error is not None:
        result["noise_rmse"] = float(np.sqrt((error ** 2).mean()))
        result["noise_relmse"] = float((error ** 2 / below).mean())
    return result


def curve(mi, folder, integrator, seed, budgets, batch):
    """(budget, processor-seconds, seconds, picture) for each budget."""
    scene = mi.load_file(os.path.join(folder, "scene.xml"))
    total, samples, passes = 0.0, 0, 0
    start, wall = time.process_time(), time.perf_counter()
    remaining = sorted(budgets)
    while remaining:
        # No two batches of any seed share random numbers.
        picture = mi.render(scene, integrator=integrator, spp=batch, seed=seed * 1_000_000 + passes)
        total = total + batch * np.array(picture, dtype=np.float64)[..., :3]
        samples, passes = samples + batch, passes + 1
        spent = time.process_time() - start
        while remaining and spent >= remaining[0]:
            yield remaining.pop(0), spent, time.perf_counter() - wall, total / samples


def main():
    options = arguments()
    import mitsuba as mi
    mi.set_variant(options.variant)
    # Before the threads are limited: Mitsuba 3.9.1 waits for ever when it reads an EXR with one thread only.
    references = {folder: load_reference(folder) for folder in options.scenes}
    import drjit
    drjit.set_thread_count(options.threads)
    budgets = [float(text) for text in options.seconds.split(",")]
    integrator = mi.load_dict({"type": options.integrator})
    # A just-in-time compiler wants large batches; compiled code small ones, to meet the budgets.
    batch = 1 if options.variant.startswith("scalar") else 16
    name = f"Mitsuba {mi.__version__} {options.integrator} ({options.variant})"
    points = []
    for folder in options.scenes:
        scene = os.path.basename(os.path.abspath(folder))
        reference, error = references[folder]
        for seed in range(1, options.seeds + 1):
            for budget, cpu, wall, picture in curve(mi, folder, integrator, seed, budgets, batch):
                points.append({"name": name, "scene": scene, "seed": seed, "budget": budget, "cpu_seconds": round(cpu, 4),
                               "wall_seconds": round(wall, 4), **metrics(picture, reference, error)})
                print(f"{scene}, seed {seed}, {cpu:.1f} s: relMSE {points[-1]['relmse']:.5f}", file=sys.stderr)
        with open(options.output, "w") as file:
            json.dump(points, file, indent=1)


if __name__ == "__main__":
    main()
