"""The add-on in Blender itself, without a window, with a real farm."""

import importlib
import math

import numpy as np
import pytest

from conftest import INSTALLED


def plane(bpy, size=100.0, color=(0, 0, 0), emission=(0, 0, 0), strength=0.0):
    """A square in the plane z = 0 that emits or is matte."""
    bpy.ops.mesh.primitive_plane_add(size=size)
    material = bpy.data.materials.new("surface")
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value = 1
    shader.inputs["Specular IOR Level"].default_value = 0
    shader.inputs["Emission Color"].default_value = (*emission, 1)
    shader.inputs["Emission Strength"].default_value = strength
    bpy.context.object.data.materials.append(material)
    return bpy.context.object


def shown(bpy):
    """The image as rows from the top."""
    image = bpy.data.images["photonfarm"]
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)[::-1]


def test_a_surface_that_fills_the_picture_has_its_radiance(bpy, scene):
    plane(bpy, emission=(0.5, 0.25, 1.0), strength=3)
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    picture = shown(bpy)
    assert picture.shape == (16, 24, 4)
    np.testing.assert_allclose(picture[..., :3], np.broadcast_to((1.5, 0.75, 3.0), (16, 24, 3)), rtol=1e-3)
    assert (picture[..., 3] == 1).all()


def test_a_lamp_lights_as_in_blender(bpy, scene):
    albedo, power, height = 0.6, 100.0, 3.0
    plane(bpy, color=(albedo, albedo, albedo))
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size = power, 0
    lamp.location = (0, 0, height)
    scene.collection.objects.link(lamp)
    scene.photonfarm.environment, scene.photonfarm.method = "OFF", "path"
    scene.camera.data.angle = math.radians(5)
    scene.photonfarm.passes = 16
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    # The lamp sends power / 4π into every direction, and a matte surface spreads what arrives over π.
    expected = albedo / math.pi * power / (4 * math.pi) / height**2
    assert shown(bpy)[..., :3].mean() == pytest.approx(expected, rel=0.05)


def test_lamps_and_glow_are_balanced_as_in_cycles(bpy, scene, tmp_path):
    plane(bpy, color=(0.5, 0.5, 0.5))
    glow = plane(bpy, size=0.6, emission=(1, 0.5, 0.25), strength=4)
    glow.location, glow.rotation_euler = (0.7, 0, 0.8), (0, math.radians(-90), 0)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "SPOT"))
    lamp.data.energy, lamp.data.shadow_soft_size, lamp.data.spot_blend = 60, 0, 0
    lamp.location = (-0.5, 0, 2)
    scene.collection.objects.link(lamp)
    scene.photonfarm.environment, scene.photonfarm.method, scene.photonfarm.passes = "OFF", "path", 64
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    farm_picture = shown(bpy)[..., :3]
    cycles_picture = rendered_by_cycles(scene, tmp_path / "cycles.exr")
    halves = [(slice(None), slice(0, 12)), (slice(None), slice(12, 24))]
    for half in halves:
        assert farm_picture[half].mean() > 0.01
        np.testing.assert_allclose(farm_picture[half].mean(axis=(0, 1)), cycles_picture[half].mean(axis=(0, 1)), rtol=0.05)


def rendered_by_cycles(scene, file):
    """The same scene by Blender's own path tracer."""
    import bpy
    import OpenEXR

    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 256, False
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(str(file)) as written:
        return next(iter(written.channels().values())).pixels[..., :3]


def test_what_stands_above_and_on_the_left_is_shown_there(bpy, scene):
    bright = plane(bpy, size=0.5, emission=(1, 1, 1), strength=1)
    bright.location = (-0.8, 0.5, 0)
    scene.photonfarm.environment = "OFF"
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    lit = shown(bpy)[..., 0] > 0.5
    rows, columns = np.nonzero(lit)
    assert rows.size > 0
    assert rows.mean() < 7
    assert columns.mean() < 10


def test_the_picture_is_shown_while_it_converges(bpy, scene, farm):
    rendering = importlib.import_module(f"{INSTALLED}.rendering")
    plane(bpy, color=(0.5, 0.5, 0.5))
    scene.photonfarm.environment, scene.photonfarm.passes = "ON", 1_000_000
    begun = rendering.Rendering(farm, scene)
    versions = []
    while len(versions) < 2:
        status = begun.step(wait=1)
        if status.passes_done > 0:
            assert status.state == "running"
            versions.append(shown(bpy).copy())
    assert not np.array_equal(*versions)
    assert begun.job.cancel().state == "cancelled"


def test_modifiers_and_hidden_objects_count_as_in_blender(bpy, scene):
    bright = plane(bpy, size=2, emission=(1, 1, 1), strength=1)
    bright.modifiers.new("bigger", "SOLIDIFY").thickness = 0.1
    bright.hide_render = True
    scene.photonfarm.environment = "ON"
    plane(bpy, emission=(0, 1, 0), strength=2).location = (0, 0, -1)
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    assert shown(bpy)[8, 12, 0] < 0.5 < shown(bpy)[8, 12, 1]


def test_the_active_camera_is_used(bpy, scene):
    plane(bpy, emission=(1, 1, 1), strength=1)
    for name in ("Another", "Zebra"):
        aside = bpy.data.objects.new(name, bpy.data.cameras.new(name))
        aside.rotation_euler = (math.pi, 0, 0)
        scene.collection.objects.link(aside)
    scene.photonfarm.environment = "OFF"
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    assert shown(bpy)[..., :3].min() > 0.9


def test_what_the_farm_refuses_is_told(bpy, scene, capfd):
    plane(bpy)
    scene.photonfarm.method = "sppn"
    assert bpy.ops.photonfarm.render() == {"CANCELLED"}
    assert 'there is no method "sppn"' in "".join(capfd.readouterr())


def test_a_farm_that_is_away_is_told(bpy, scene, monkeypatch, capfd):
    monkeypatch.setenv("PHOTONFARM_URL", "http://127.0.0.1:9")
    plane(bpy)
    assert bpy.ops.photonfarm.render() == {"CANCELLED"}
    assert "no coordinator answers" in "".join(capfd.readouterr())


def test_preferences_count_before_the_environment(bpy, scene, monkeypatch, farm):
    monkeypatch.setenv("PHOTONFARM_URL", "http://127.0.0.1:9")
    preferences = bpy.context.preferences.addons[INSTALLED].preferences
    preferences.url = farm.connection.address
    plane(bpy, emission=(1, 1, 1), strength=1)
    assert bpy.ops.photonfarm.render() == {"FINISHED"}
    preferences.url = ""
