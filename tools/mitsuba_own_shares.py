#!/usr/bin/env python3
"""Judges Mitsuba 3 by its own render tests, and writes the shares as JSON.

    pip install mitsuba==3.9.1
    python3 tools/mitsuba_own_shares.py ../shared/mitsuba-tests 256 examples/mitsuba_tests/own_shares.json

The rule is that of examples/mitsuba_tests: variances of references are estimates, so that Mitsuba itself is below 99.75 % in many
tests, and a renderer that is right is, too. Takes about ten minutes with 256 samples.
"""

import json
import math
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np


def read(path):
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap)[:, :, :3]


def share(scene_file, samples):
    stem = scene_file.stem.rsplit("_", 1)[0]
    reference, variance = (read(scene_file.parent / "refs" / f"{stem}_ref_rgb{part}.exr") for part in ("", "_var"))
    picture = np.array(mi.render(mi.load_file(str(scene_file)), spp=samples, seed=1))[:, :, :3]
    z = np.abs(picture - reference) * np.sqrt(samples / np.maximum(variance, 1e-4))
    pixels = reference.shape[0] * reference.shape[1]
    significance = 1 - (1 - 0.01) ** (1 / pixels)
    tail = np.vectorize(lambda value: math.erfc(value / math.sqrt(2)))(z)
    return round(100 * float(np.mean(tail > significance)), 2)


def main():
    folder, samples = Path(sys.argv[1]), int(sys.argv[2])
    mi.set_variant("scalar_rgb")
    shares = {}
    for scene_file in sorted((folder / "tests" / "scenes").glob("*/*.xml")):
        try:
            shares[scene_file.stem] = share(scene_file, samples)
        except Exception as problem:  # Mitsuba refuses what this variant cannot render.
            print(f"{scene_file.stem}: {problem}", file=sys.stderr)
    result = {"mitsuba": mi.__version__, "samples": samples, "shares": shares}
    Path(sys.argv[3]).write_text(json.dumps(result, indent=1) + "\n")


main()
