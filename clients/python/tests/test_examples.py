"""Programs in examples/, as render managers run them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import OpenEXR

from photonfarm import Farm

from .scenes import BOX

RENDER_FRAME = Path(__file__).parents[1] / "examples/render_frame.py"


def run(address: str, *words: str | Path) -> int:
    environment = {**os.environ, "PHOTONFARM_URL": address}
    return subprocess.run([sys.executable, RENDER_FRAME, *words, "--passes", "2"], env=environment, check=False).returncode


def test_a_frame_that_is_run_again_finds_its_job(farm: Farm, tmp_path: Path) -> None:
    output = tmp_path / "frame.exr"
    for _ in range(2):
        assert run(farm.connection.address, BOX, output, "--key", "show-shot-layer-0012") == 0
        with OpenEXR.File(str(output)) as file:
            assert file.header()["photonfarm.passes"] in (2, "2")
        output.unlink()
    assert len(farm.jobs(name="show-shot-layer-0012")) == 1


def test_exit_codes_are_those_of_the_command_line(farm: Farm, tmp_path: Path) -> None:
    (tmp_path / "bad.xml").write_text('<scene version="3.0.0"><shape type="spere"/></scene>')
    address = farm.connection.address
    assert run(address, tmp_path / "bad.xml", tmp_path / "frame.exr", "--key", "bad") == 3
    assert run("http://127.0.0.1:9", BOX, tmp_path / "frame.exr", "--key", "lost") == 4
    assert run(address, tmp_path / "none.xml", tmp_path / "frame.exr", "--key", "none") == 5
