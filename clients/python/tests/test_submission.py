"""Scenes from everywhere a user may have them."""

from __future__ import annotations

import io
import shutil
import zipfile
from pathlib import Path

import pytest

from photonfarm import Farm, FarmError, JobOptions, StopRule
from photonfarm.generated.models import JobSubmission
from photonfarm.scene_files import pack

from .scenes import BOX, REPOSITORY, SKY, SMALL, STILL_LIFE


def names(archive: bytes) -> list[str]:
    return zipfile.ZipFile(io.BytesIO(archive)).namelist()


def test_a_file_that_names_no_others_is_sent_as_it_is(farm: Farm) -> None:
    assert pack(BOX) == BOX.read_bytes()
    job = farm.submit(BOX, stop={"passes": 1}, wait=60, **SMALL)
    assert (job.known.state, job.known.width, job.known.passes_done) == ("done", 32, 1)


def test_a_file_takes_along_what_it_names(farm: Farm) -> None:
    assert names(pack(STILL_LIFE)) == ["gem.obj", "scene.xml"]
    scene = farm.upload(STILL_LIFE)
    assert farm.submit(scene, scene_changes={"width": 16}, stop={"passes": 1}, wait=60).known.state == "done"


def test_a_file_takes_along_what_its_files_name() -> None:
    assert names(pack(REPOSITORY / "tests/cases/old-obj-mtl/scene.xml")) == ["m.mtl", "m.obj", "scene.xml"]


def test_every_scene_of_this_repository_is_taken(farm: Farm) -> None:
    suffixes = {".xml", ".json", ".gltf", ".glb", ".mgf", ".pbrt"}
    found = [file for folder in ("scenes", "tests/cases") for file in (REPOSITORY / folder).glob("*/scene.*") if file.suffix in suffixes]
    assert len(found) > 30
    for file in found:
        assert farm.upload(file).width > 0


def test_names_with_spaces_and_escapes_are_found(tmp_path: Path) -> None:
    (tmp_path / "a folder").mkdir()
    for name in ["a folder/one.bin", "two%.bin", "drei ß.bin"]:
        (tmp_path / name).write_bytes(b"x")
    gltf = r'{"asset": {"version": "2.0"}, "buffers": [{"uri": "a%20folder\/one.bin"}, {"uri": "two%25.bin"}, {"uri": "drei \u00df.bin"}]}'
    (tmp_path / "scene.gltf").write_text(gltf)
    assert names(pack(tmp_path / "scene.gltf")) == ["a folder/one.bin", "drei ß.bin", "scene.gltf", "two%.bin"]


def test_nothing_outside_of_the_scenes_folder_goes_along(farm: Farm, tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside/link.obj").symlink_to("../secret.obj")
    scene = tmp_path / "inside/scene.xml"
    for name in ["../secret.obj", str(tmp_path / "secret.obj"), "link.obj"]:
        text = f'<scene version="3.0.0"><shape type="obj"><string name="filename" value="{name}"/></shape></scene>'
        scene.write_text(text)
        assert pack(scene) == text.encode()
        with pytest.raises(FarmError, match="no file|leads|absolute"):
            farm.upload(scene)


def test_a_zip_archive_and_a_folder(farm: Farm, tmp_path: Path) -> None:
    folder = tmp_path / "still life"
    shutil.copytree(STILL_LIFE.parent, folder)
    (folder / ".hidden").write_text("not for others")
    archive = Path(shutil.make_archive(str(tmp_path / "scene"), "zip", folder))
    assert names(pack(folder)) == ["gem.obj", "scene.xml"]
    for place in [archive, folder]:
        assert farm.submit(str(place), scene_changes={"width": 16}, stop={"passes": 1}, wait=60).known.state == "done"


@pytest.mark.parametrize("inner", ["", "show/shot"])
def test_a_folder_with_several_scenes_is_told_which(farm: Farm, tmp_path: Path, inner: str) -> None:
    folder = tmp_path / inner
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(STILL_LIFE, folder / "day.xml")
    shutil.copy(STILL_LIFE, folder / "night.xml")
    shutil.copy(STILL_LIFE.with_name("gem.obj"), folder)
    assert farm.upload(tmp_path, scene=str(Path(inner, "night.xml"))).width > 0
    with pytest.raises(FarmError, match="several scene files"):
        farm.upload(tmp_path)
    with pytest.raises(FarmError, match="there is no file") as missing:
        farm.upload(tmp_path, scene=str(Path(inner, "noon.xml")))
    assert missing.value.kind == "bad-file"


def test_a_scene_below_other_folders(farm: Farm, tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "shots").mkdir()
    shutil.copy(STILL_LIFE.with_name("gem.obj"), tmp_path / "models")
    (tmp_path / "shots/one.xml").write_text(STILL_LIFE.read_text().replace("gem.obj", "../models/gem.obj"))
    assert farm.upload(tmp_path, scene="shots/one.xml").width > 0


def test_equal_scenes_are_kept_once(farm: Farm, tmp_path: Path) -> None:
    shutil.copytree(STILL_LIFE.parent, tmp_path / "copy")
    assert farm.upload(STILL_LIFE).hash == farm.upload(tmp_path / "copy/scene.xml").hash


def test_a_dictionary_a_hash_and_all_options(farm: Farm) -> None:
    first = farm.submit(SKY, stop=StopRule(passes=1), wait=60)
    options = JobOptions(
        method="path",
        parameters={"max_depth": 3},
        stop={"passes": 2},
        scene_changes={"width": 12},
        cut={"passes_per_shard": 1},
        seed=7,
        name="small sky",
        tags=["sky", "test"],
        priority=50,
    )
    view = farm.submit(first.known.scene, **options).wait()
    assert (view.method, view.parameters["max_depth"], view.stop.passes, view.width, view.seed) == ("path", 3, 2, 12, 7)
    assert view.cut is not None
    assert (view.name, view.tags, view.priority, view.cut.passes_per_shard) == ("small sky", ["sky", "test"], 50, 1)


def test_there_is_an_option_for_every_field_of_a_submission() -> None:
    assert set(JobOptions.__annotations__) == set(JobSubmission.model_fields) - {"scene", "scene_inline"}


def test_a_job_that_is_only_checked_is_not_made(farm: Farm) -> None:
    before = len(farm.jobs())
    checked = farm.validate(SKY, stop={"passes": 3})
    assert (checked.width, checked.height, checked.stop.passes) == (24, 16, 3)
    assert len(farm.jobs()) == before
