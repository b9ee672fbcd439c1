"""The generated models are those of the coordinator that is tested with."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CLIENT = Path(__file__).parents[1]


def test_the_models_are_not_stale(program: Path, tmp_path: Path) -> None:
    fresh = tmp_path / "models.py"
    fresh.touch()
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    subprocess.run([CLIENT / "generate.sh", program, fresh], check=True, env={**os.environ, "PATH": path})
    committed = (CLIENT / "photonfarm/generated/models.py").read_text()
    assert committed == fresh.read_text(), "run clients/python/generate.sh PROGRAM"
