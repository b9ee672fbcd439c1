"""The first example of README.md does what it shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from .scenes import REPOSITORY

README = Path(__file__).parents[1] / "README.md"


def test_the_first_example(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    found = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    assert found is not None
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/photonfarm").symlink_to(program)
    (tmp_path / "scenes").symlink_to(REPOSITORY / "scenes")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=":")
    monkeypatch.chdir(tmp_path)
    exec(found[1], {})
    assert capsys.readouterr().out.startswith("(128, 128, 3) float32 ")
    assert (tmp_path / "box.exr").stat().st_size > 0
    assert (tmp_path / "box.png").stat().st_size > 0
