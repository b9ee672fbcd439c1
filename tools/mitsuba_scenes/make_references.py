#!/usr/bin/env python3
"""Writes tests/mitsuba_scenes: small scenes, the files they need, and what Mitsuba 3.9.1 makes of them: in its variant
scalar_rgb, or scalar_spectral where that has no color.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python tools/mitsuba_scenes/make_references.py [--seconds 30] [NAME ...]

NAME.xml is a scene of `scenes.py`; NAME.json holds the means of square blocks of its picture and their standard errors, which come
from batches with seeds of their own. Batches are added until the worst standard error is 0.3 % of its block (of a tenth of the
picture's mean where the block is darker), or the time is over. Without names all scenes are written, and those that are in the folder and
no longer in the table are removed.
"""

import argparse
import json
import pathlib
import time

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)

from files import write_files
from scenes import SCENES, SPECTRAL

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "tests/mitsuba_scenes"
FEWEST_BATCHES = 16
WANTED = 0.003


def block_of(name):
    """Side of a scene's blocks, pixels: filters are seen in single pixels, textures in few."""
    return {"film": 1, "texture": 4}.get(name.split("-")[0], 8)


def block_means(picture, block):
    height, width, _ = picture.shape
    return picture.reshape(height // block, block, width // block, block, 3).mean(axis=(1, 3)).reshape(-1, 3)


def worst_noise(means, errors):
    return float((errors / np.maximum(means, max(0.1 * means.mean(), 1e-9))).max())


def render(scene, block, seconds):
    """Block means, their standard errors, and samples per pixel."""
    samples = 1024 if block == 1 else 64
    batches = []
    start = time.process_time()
    while True:
        picture = np.array(mi.render(scene, spp=samples, seed=len(batches)), dtype=np.float64)[:, :, :3]
        batches.append(block_means(picture, block))
        if len(batches) < FEWEST_BATCHES:
            continue
        means = np.mean(batches, axis=0)
        errors = np.std(batches, axis=0, ddof=1) / np.sqrt(len(batches))
        if worst_noise(means, errors) < WANTED or time.process_time() - start > seconds:
            return picture.shape, means, errors, samples * len(batches)


def rounded(values):
    return [[float(f"{value:.5g}") for value in row] for row in values]


def write_reference(name, seconds):
    block = block_of(name)
    mi.set_variant("scalar_spectral" if name in SPECTRAL else "scalar_rgb")
    shape, means, errors, samples = render(mi.load_file(str(FOLDER / f"{name}.xml")), block, seconds)
    reference = {
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        "samples": samples,
        "width": shape[1],
        "height": shape[0],
        "block": block,
        "means": rounded(means),
        "standard_errors": rounded(errors),
    }
    text = json.dumps(reference).replace('"means"', '\n"means"').replace('"standard_errors"', '\n"standard_errors"')
    (FOLDER / f"{name}.json").write_text(text + "\n")
    print(f"{name}: {samples} samples, mean {means.mean():.4f}, worst noise {100 * worst_noise(means, errors):.2f} %", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--seconds", type=float, default=30, help="processor-seconds for one scene")
    arguments = parser.parse_args()
    write_files(FOLDER / "files")
    for name, text in SCENES.items():
        (FOLDER / f"{name}.xml").write_text(text)
    for path in FOLDER.iterdir():
        if path.is_file() and path.stem not in SCENES:
            path.unlink()
    for name in arguments.names or SCENES:
        try:
            write_reference(name, arguments.seconds)
        except RuntimeError as error:
            print(f"{name}: {error}", flush=True)


if __name__ == "__main__":
    main()
