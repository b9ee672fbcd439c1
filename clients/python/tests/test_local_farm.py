"""A farm for as long as a block."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from photonfarm import Farm, FarmError, LocalFarm

from .scenes import SKY


def test_it_works_and_is_gone_afterwards(program: Path) -> None:
    with LocalFarm(workers=2, threads=1, program=program) as farm:
        address = farm.connection.address
        assert farm.submit(SKY, stop={"passes": 1}).wait().state == "done"
        assert len(farm.workers()) == 2
    with pytest.raises(FarmError) as error:
        Farm(address, token="").workers()
    assert error.value.kind == "unreachable"


def test_a_folder_keeps_jobs(program: Path, tmp_path: Path) -> None:
    with LocalFarm(threads=1, program=program, data=tmp_path) as farm:
        job = farm.submit(SKY, stop={"passes": 1}, wait=60)
        picture = job.picture()
    with LocalFarm(workers=0, program=program, data=tmp_path) as farm:
        assert (farm.job(job.id).picture() == picture).all()


def test_it_is_stopped_after_an_exception(program: Path) -> None:
    addresses = []
    with pytest.raises(ZeroDivisionError), LocalFarm(workers=0, program=program) as farm:
        addresses.append(farm.connection.address)
        raise ZeroDivisionError
    with pytest.raises(FarmError, match="no coordinator answers"):
        Farm(addresses[0], token="").workers()


def test_it_ends_with_python(program: Path) -> None:
    code = f"from photonfarm import LocalFarm; print(LocalFarm(0, program={str(program)!r}).start().connection.address)"
    address = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()
    with pytest.raises(FarmError, match="no coordinator answers"):
        Farm(address, token="").workers()


def test_one_farm_is_not_started_twice(program: Path) -> None:
    local = LocalFarm(workers=0, program=program)
    with local as farm:
        with pytest.raises(FarmError, match="runs already"):
            local.start()
        assert farm.workers() == []
    assert local.start().workers() == []
    local.stop()
    local.stop()


def test_the_environment_names_other_farms(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHOTONFARM_TOKEN", "z" * 40)
    monkeypatch.setenv("PHOTONFARM_DATABASE", "postgres://nobody@127.0.0.1:9/none")
    with LocalFarm(workers=0, program=program) as farm:
        assert farm.workers() == []


def test_why_it_does_not_start_is_told(program: Path, tmp_path: Path) -> None:
    with pytest.raises(FarmError, match="cannot start") as error:
        LocalFarm(program=tmp_path / "none").start()
    assert error.value.kind == "program-failed"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        listen = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(FarmError, match="cannot listen at"):
            LocalFarm(program=program, listen=listen).start()
