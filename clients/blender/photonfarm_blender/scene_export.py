"""Blender's scene as glTF, as a farm reads it."""

from pathlib import Path

import bpy


def export(folder: Path) -> Path:
    """Writes the scene at its current frame into a folder, with its lights and cameras."""
    file = folder / "scene.glb"
    bpy.ops.export_scene.gltf(
        filepath=str(file),
        export_format="GLB",
        use_renderable=True,
        use_active_scene=True,
        export_apply=True,
        export_cameras=True,
        export_lights=True,
        # Watts stay watts, as in materials that emit: a farm takes numbers as they are.
        export_import_convert_lighting_mode="COMPAT",
        export_animations=False,
        export_current_frame=True,
    )
    return file


def scene_changes(scene: bpy.types.Scene) -> dict[str, object]:
    """What glTF does not say: the size of the picture, which camera it is of, and whether a white environment lights the scene."""
    render = scene.render
    changes: dict[str, object] = {
        "width": max(1, render.resolution_x * render.resolution_percentage // 100),
        "height": max(1, render.resolution_y * render.resolution_percentage // 100),
    }
    if scene.camera is not None:
        changes["camera"] = scene.camera.name
    if scene.photonfarm.environment != "AUTO":
        changes["environment"] = scene.photonfarm.environment.lower()
    return changes
