"""Scenes that are known beforehand, and jobs of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).parents[3]
BOX = REPOSITORY / "scenes/cornell-diffuse/scene.xml"
STILL_LIFE = REPOSITORY / "scenes/still-life/scene.xml"

SKY_RADIANCE = (0.5, 0.25, 2.0)
SKY: dict[str, Any] = {
    "type": "scene",
    "sensor": {"type": "perspective", "fov": 40, "film": {"type": "hdrfilm", "width": 24, "height": 16, "rfilter": {"type": "box"}}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(SKY_RADIANCE)}},
}
"""Nothing but a sky of one radiance, so that every pixel has it."""

WALL_DISTANCE = 4.0
WALL_ALBEDO = (0.5, 0.25, 0.75)
WALL: dict[str, Any] = {
    "type": "scene",
    "sensor": {
        "type": "orthographic",
        "to_world": [{"look_at": {"origin": [0, 0, WALL_DISTANCE], "target": [0, 0, 0], "up": [0, 1, 0]}}],
        "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
    },
    "wall": {
        "type": "rectangle",
        "to_world": [{"scale": 2}],
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(WALL_ALBEDO)}},
    },
    "sky": {"type": "constant"},
}
"""A wall straight before a camera of parallel rays."""

SMALL: dict[str, Any] = {"scene_changes": {"width": 32}, "parameters": {"photons_per_pass": 4096}}
"""A job of the box that takes about 10 ms a pass."""

ENDLESS: dict[str, Any] = {**SMALL, "stop": {"passes": 1_000_000}}
"""One that no test waits for."""
