"""What goes wrong is told with its place and what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from photonfarm import Farm, FarmError

from .scenes import SKY


def error_of(farm: Farm, scene: Any, **options: Any) -> FarmError:
    with pytest.raises(FarmError) as error:
        farm.submit(scene, **options)
    return error.value


def test_a_fault_in_a_file_is_told_with_its_line(farm: Farm, tmp_path: Path) -> None:
    file = tmp_path / "shot.xml"
    file.write_text('<scene version="3.0.0">\n  <shape type="spere"/>\n</scene>\n')
    error = error_of(farm, file)
    assert (error.type, error.title, error.status) == ("urn:photonfarm:problem:bad-scene", "bad scene", 422)
    assert error.place is not None
    assert error.place.startswith("shot.xml:2")
    assert "spere" in error.detail
    assert error.remedy is not None
    assert "sphere" in error.remedy
    assert str(error) == f"{error.place}: {error.detail}; {error.remedy}"


def test_a_fault_in_a_dictionary_is_told_with_its_path(farm: Farm) -> None:
    error = error_of(farm, {"type": "scene", "ball": {"type": "spere"}})
    assert error.place is not None
    assert "scene/ball" in error.place


def test_unknown_methods_and_parameters_are_told_with_those_there_are(farm: Farm) -> None:
    error = error_of(farm, SKY, method="sppn")
    assert (error.kind, error.status, error.place) == ("bad-method", 422, None)
    assert error.remedy is not None
    assert "sppm" in error.remedy
    error = error_of(farm, SKY, parameters={"photns": 3})
    assert error.remedy is not None
    assert "photons_per_pass" in error.remedy


def test_an_unknown_option_is_an_error(farm: Farm) -> None:
    error = error_of(farm, SKY, hue=3)
    assert (error.status, error.kind) == (422, "bad-request")
    assert error.place is not None
    assert error.place.startswith("line 1, column")


def test_unknown_scenes_and_jobs(farm: Farm) -> None:
    assert error_of(farm, "0" * 64).kind == "unknown-scene"
    with pytest.raises(FarmError) as error:
        farm.job("0000000000")
    assert error.value.status == 404
    with pytest.raises(FarmError, match="not a job's id"):
        farm.job("../scenes")


def test_a_file_that_is_not_there(farm: Farm, tmp_path: Path) -> None:
    error = error_of(farm, tmp_path / "none.xml")
    assert (error.kind, error.status) == ("bad-file", 0)


def test_no_picture_is_there_before_the_first_passes(program: Path) -> None:
    from photonfarm import LocalFarm

    with LocalFarm(workers=0, program=program) as idle:
        job = idle.submit(SKY)
        with pytest.raises(FarmError) as error:
            job.picture()
        assert (error.value.kind, error.value.retry_after) == ("no-picture-yet", 1)


@pytest.mark.parametrize("address", ["farm:8080", "ftp://farm", "http://anna:secret@farm"])
def test_bad_addresses_are_told_at_once(address: str) -> None:
    with pytest.raises(FarmError) as error:
        Farm(address, token="")
    assert error.value.kind == "bad-address"
    assert "secret" not in str(error.value)


def test_an_address_where_nobody_is_heard_is_an_error_at_once() -> None:
    with pytest.raises(FarmError, match="photonfarm serve") as error:
        Farm("http://127.0.0.1:9", token="").workers()
    assert error.value.kind == "unreachable"
