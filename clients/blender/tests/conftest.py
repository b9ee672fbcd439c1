"""What tests share: an empty scene of Blender's, the add-on, and a farm."""

import os
import shutil
from pathlib import Path

import pytest
from photonfarm import LocalFarm

ADD_ON = Path(__file__).parents[1]
INSTALLED = "bl_ext.user_default.photonfarm_blender"


def pytest_addoption(parser):
    parser.addoption("--program", required=True, help="the photonfarm to test with")


@pytest.fixture(scope="session")
def program(request):
    return Path(request.config.getoption("--program")).resolve()


@pytest.fixture(scope="session")
def farm(program):
    with LocalFarm(workers=1, threads=1, program=program) as farm:
        yield farm


@pytest.fixture(scope="session")
def bpy(tmp_path_factory):
    """Blender with the add-on, installed from a zip file as a user does."""
    folder = tmp_path_factory.mktemp("blender")
    os.environ["BLENDER_USER_RESOURCES"] = str(folder)
    file = shutil.make_archive(str(folder / "photonfarm_blender"), "zip", ADD_ON, "photonfarm_blender")
    # Only bpy makes the other one importable.
    import bpy
    import addon_utils

    addon_utils.enable("bl_pkg")
    bpy.ops.extensions.package_install_files(filepath=file, repo="user_default", enable_on_install=True)
    yield bpy
    addon_utils.disable(INSTALLED)


@pytest.fixture
def scene(bpy, farm, monkeypatch):
    """An empty scene of 24 × 16 pixels with a camera that looks down from a height of 4, and the farm as the one of the environment."""
    monkeypatch.setenv("PHOTONFARM_URL", farm.connection.address)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 50
    scene.photonfarm.passes = 1
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Lens"))
    camera.location = (0, 0, 4)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene
