"""Renders references for some seconds, denoises them in two ways, and prints how far each picture is from the truth.

Run by denoise.sh, which says what the environment may hold.
"""

import json
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

import numpy
import OpenEXR
import pyoidn

PROGRAM = os.environ.get("PHOTONFARM", "target/release/photonfarm")
SECONDS = os.environ.get("SECONDS_LIST", "1 4 16").split()
PICTURES = os.environ.get("PICTURES")
REFERENCES = Path("tests/references")
# Each scene with the method that its light asks for.
SCENES = {
    "cornell-diffuse": "path",
    "cornell-glass": "sppm",
    "dof": "path",
    "door-ajar": "bdpt",
    "glossy-blocks-a010": "path",
    "lantern": "sppm",
    "spot-mirror": "sppm",
    "textured-env": "path",
}


def run(*arguments):
    """Standard output and standard error of the program."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True)
    return done.stdout, done.stderr


def layer(channels, prefix, names="RGB"):
    """Three channels as one array of rows, columns and channels."""
    return numpy.ascontiguousarray(numpy.stack([channels[prefix + name].pixels for name in names], axis=-1), dtype=numpy.float32)


def write(path, colors):
    channels = {name: colors[..., index].copy() for index, name in enumerate("RGB")}
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels) as file:
        file.write(str(path))


def measured(path, scene):
    metrics = json.loads(run("compare", path, REFERENCES / scene / "ref.exr", "--json")[0])
    return metrics["relmse"], metrics["flip"]


def told_relmse(messages):
    """What the program says of the denoised picture's error."""
    lines = [line for line in messages.splitlines() if line.startswith("denoised: relMSE ")]
    return float(lines[0].split()[2].rstrip(",")) if lines else float("nan")


def measure(scene, method, seconds, folder):
    """Table cells of one picture; None where the time was too short for two passes."""
    picture = folder / f"{scene}-{seconds}.exr"
    options = ["--method", method, "--seconds", seconds, "--threads", 1, "--layers", "albedo,normal", "--denoise"]
    _, messages = run("render", REFERENCES / scene / "scene.xml", *options, "-o", picture)
    with OpenEXR.File(str(picture), separate_channels=True) as file:
        channels = file.channels()
        if "denoised.R" not in channels:
            return None
        raw, ours = layer(channels, ""), layer(channels, "denoised.")
        albedo, normal = layer(channels, "albedo."), layer(channels, "normal.", "XYZ")
    began = time.perf_counter()
    theirs = pyoidn.denoise(raw, albedo=albedo, normal=normal, hdr=True)
    spent = time.perf_counter() - began
    cells = []
    for name, colors in [("raw", raw), ("ours", ours), ("intel", theirs)]:
        path = folder / f"{scene}-{seconds}-{name}.exr"
        write(path, colors)
        cells.append((*measured(path, scene), colors.mean() / raw.mean() - 1.0))
    return cells, told_relmse(messages), spent


def main():
    print("| scene | method | seconds | raw | ours | Intel's | told | FLIP raw | ours | Intel's | mean of ours | of Intel's |")
    print("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    logarithms, spent = [], 0.0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(PICTURES or temporary)
        folder.mkdir(exist_ok=True)
        for scene, method in SCENES.items():
            for seconds in SECONDS:
                found = measure(scene, method, seconds, folder)
                if found is None:
                    print(f"| {scene} | {method} | {seconds} | one pass |" + " |" * 8, flush=True)
                    continue
                (raw, ours, theirs), told, time_of_theirs = found
                errors = " | ".join(f"{cell[0]:.5f}" for cell in (raw, ours, theirs))
                flips = " | ".join(f"{cell[1]:.4f}" for cell in (raw, ours, theirs))
                print(f"| {scene} | {method} | {seconds} | {errors} | {told:.5f} | {flips} | {100 * ours[2]:+.2f} % | {100 * theirs[2]:+.2f} % |", flush=True)
                logarithms.append([numpy.log(cell[:2]) for cell in (raw, ours, theirs)])
                spent += time_of_theirs
    means = numpy.exp(numpy.mean(logarithms, axis=0))
    print(f"| geometric mean | | | {' | '.join(f'{mean:.5f}' for mean in means[:, 0])} | | {' | '.join(f'{mean:.4f}' for mean in means[:, 1])} | | |")
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"\n{children.ru_utime + children.ru_stime:.0f} processor-seconds of photonfarm, {spent:.1f} s in Intel's filter.")


main()
