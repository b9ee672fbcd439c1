"""A scene that a farm renders, and the image of Blender's in which its picture stands."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from photonfarm import Farm, Job, JobView
from photonfarm.progress import sentence

from . import scene_export

IMAGE_NAME = "photonfarm"
FINAL_STATES = ("done", "failed", "cancelled")


class Rendering:
    """One job, from export to the last picture."""

    def __init__(self, farm: Farm, scene: bpy.types.Scene) -> None:
        """Exports the scene and submits it."""
        settings = scene.photonfarm
        method = {"method": settings.method} if settings.method else {}
        with tempfile.TemporaryDirectory(prefix="photonfarm-") as folder:
            file = scene_export.export(Path(folder))
            changes = scene_export.scene_changes(scene)
            self.job: Job = farm.submit(file, scene_changes=changes, stop={"passes": settings.passes}, name=scene.name, **method)
        self._shown_version = 0

    def step(self, wait: int = 0) -> JobView:
        """Asks how the job is doing, after `wait` seconds at most, and shows its picture if there is a new one."""
        status = self.job.status(wait=wait)
        if status.picture_version > self._shown_version and status.passes_done > 0:
            show(self.job.picture())
            self._shown_version = status.picture_version
        return status


def show(picture: np.ndarray) -> bpy.types.Image:
    """Puts a picture into the image `photonfarm`, which is made when it is not there."""
    height, width, _ = picture.shape
    image = bpy.data.images.get(IMAGE_NAME)
    if image is None:
        image = bpy.data.images.new(IMAGE_NAME, width, height, float_buffer=True)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    # Blender's rows begin at the bottom.
    opaque = np.ones((height, width, 1), np.float32)
    image.pixels.foreach_set(np.concatenate([picture[::-1], opaque], axis=-1).ravel())
    image.update()
    return image


def told(status: JobView) -> str:
    """A job's status in one line."""
    return f"{sentence(status)}: {status.error}" if status.error else sentence(status)
