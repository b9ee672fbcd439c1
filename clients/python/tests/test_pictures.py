"""Pictures as arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from photonfarm import Farm, FarmError, Job

from .scenes import BOX, SKY, SKY_RADIANCE, SMALL, WALL, WALL_ALBEDO, WALL_DISTANCE


@pytest.fixture(scope="module")
def box(farm: Farm) -> Job:
    return farm.submit(BOX, stop={"passes": 8}, wait=60, **SMALL)


def test_every_pixel_of_a_constant_sky_has_its_radiance(farm: Farm) -> None:
    picture = farm.submit(SKY, stop={"passes": 1}, wait=60).picture()
    assert picture.shape == (16, 24, 3)
    assert picture.dtype == np.float32
    assert np.array_equal(picture, np.broadcast_to(np.array(SKY_RADIANCE, np.float32), picture.shape))


def test_a_picture_holds_what_the_exr_file_holds(box: Job, tmp_path: Path) -> None:
    path = box.save(tmp_path / "box.exr")
    assert path.read_bytes() == box.exr()
    with OpenEXR.File(str(path)) as file:
        stored = file.channels()["RGB"].pixels
    assert np.array_equal(box.picture(), stored)
    assert stored.shape == (32, 32, 3)
    assert stored.min() >= 0
    assert stored.std() > 0.01


def test_rows_go_down_and_columns_to_the_right(farm: Farm, box: Job) -> None:
    changes = {"width": 32, "crop": {"x": 0, "y": 0, "width": 32, "height": 8}}
    cropped = farm.submit(BOX, stop={"passes": 1}, wait=60, **SMALL | {"scene_changes": changes})
    depth = cropped.layers(["depth"])["depth"]
    assert depth.shape == (8, 32)
    assert np.array_equal(depth, box.layers(["depth"])["depth"][:8])


def test_layers_of_a_wall_are_known_beforehand(farm: Farm) -> None:
    layers = farm.submit(WALL, stop={"passes": 1}, wait=60).layers(["normal", "depth", "albedo"])
    assert list(layers) == ["normal", "depth", "albedo"]
    assert layers["depth"].shape == (16, 16)
    np.testing.assert_allclose(layers["depth"], WALL_DISTANCE, rtol=1e-6)
    np.testing.assert_allclose(layers["normal"], np.broadcast_to((0, 0, 1), (16, 16, 3)), atol=1e-6)
    np.testing.assert_allclose(layers["albedo"], np.broadcast_to(WALL_ALBEDO, (16, 16, 3)), rtol=1e-6)


def test_mattes_cover_what_is_seen(box: Job) -> None:
    mattes = box.layers(["crypto_object", "crypto_material"])
    assert {name: array.shape for name, array in mattes.items()} == dict.fromkeys(["crypto_object", "crypto_material"], (32, 32, 6, 2))
    for pairs in mattes.values():
        ids, coverage = pairs[..., 0], pairs[..., 1]
        assert np.array_equal(coverage.sum(axis=-1), np.ones((32, 32)))
        assert np.all((ids != 0) == (coverage > 0))
        assert len(np.unique(ids)) > 3


def test_layers_of_photons(box: Job) -> None:
    layers = box.layers(["radius", "photons", "error"])
    assert {name: array.shape for name, array in layers.items()} == dict.fromkeys(["radius", "photons", "error"], (32, 32))
    assert layers["radius"].min() > 0
    assert layers["photons"].max() > 0


def test_light_groups_add_up_to_the_picture(farm: Farm) -> None:
    lamp = "<emitter type='point'><rgb name='intensity' value='1'/><string name='light_group' value='bulb'/></emitter></scene>"
    job = farm.submit(BOX.read_text().replace("</scene>", lamp), stop={"passes": 2}, wait=60, light_groups=True, **SMALL)
    groups = job.layers(["light_groups"])
    assert list(groups) == ["light_group.bulb", "light_group.others"] == [f"light_group.{name}" for name in job.status().light_groups or []]
    assert np.allclose(sum(groups.values()), job.picture(), rtol=1e-5)
    assert all(group.std() > 0 for group in groups.values())


def test_files_to_look_at(box: Job, tmp_path: Path) -> None:
    plain = box.save(tmp_path / "box.png").read_bytes()
    assert plain.startswith(b"\x89PNG")
    assert box.save(tmp_path / "bright.png", exposure=2).read_bytes() != plain
    with OpenEXR.File(str(box.save(tmp_path / "deep.exr", layers=["depth"])), separate_channels=True) as file:
        assert "depth.Z" in file.channels()
    assert box.save(tmp_path / "box.jpeg", exposure="auto", tone="agx").read_bytes().startswith(b"\xff\xd8")
    assert box.save(tmp_path / "box.webp").read_bytes()[8:12] == b"WEBP"
    assert len(box.jpg(quality=5)) < len(box.jpg(quality=95))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["box.jpeg", "box.png", "box.webp", "bright.png", "deep.exr"]


def test_lights_and_camera_are_told(box: Job) -> None:
    layout = box.layout()
    assert layout.world_to_ndc is not None and len(layout.world_to_ndc) == 16
    assert layout.lights and all(len(point) == 3 for light in layout.lights for point in light.points)


def test_what_a_file_cannot_hold_is_an_error(box: Job, tmp_path: Path) -> None:
    with pytest.raises(FarmError, match="name it .exr"):
        box.save(tmp_path / "box.tiff")
    with pytest.raises(FarmError, match="name it .exr"):
        box.save(tmp_path / "box.png", layers=["depth"])
    with pytest.raises(FarmError, match="name it .exr"):
        box.save(tmp_path / "box.exr", exposure=1)
    with pytest.raises(FarmError, match="name it .exr"):
        box.save(tmp_path / "box.exr", tone="agx")
    with pytest.raises(FarmError, match="cannot write"):
        box.save(tmp_path / "nowhere" / "box.png")


def test_an_unknown_layer_is_an_error_of_the_coordinator(box: Job) -> None:
    with pytest.raises(FarmError) as error:
        box.layers(["deepth"])
    assert (error.value.status, error.value.remedy is not None) == (422, True)
