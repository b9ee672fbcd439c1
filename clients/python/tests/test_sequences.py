"""Sequences: many pictures by one call."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photonfarm import Farm, FarmError

from .scenes import BOX, SMALL

LAMP = """<scene version="3.0.0"><integrator type="path"/>
  <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="8"/></film></sensor>
  <shape type="sphere"><emitter type="area"/><animation name="to_world">
    <transform time="0"><translate x="-2" z="5"/></transform><transform time="1"><translate x="2" z="5"/></transform>
  </animation></shape></scene>"""


def test_a_sequence_is_waited_for_and_saved(farm: Farm, tmp_path: Path) -> None:
    sequence = farm.submit_sequence(LAMP, (1, 3), name="lamp", seed=4, stop={"passes": 2})
    seen: list[int] = []
    status = sequence.wait(progress=lambda status: seen.append(status.frames_done), timeout=120)
    assert (status.frames_done, status.frames_total, status.progress) == (3, 3, 1)
    jobs = sequence.jobs()
    assert [(number, job.known.name, job.known.seed) for number, job in jobs.items()] == [
        (1, "lamp.0001", 5), (2, "lamp.0002", 6), (3, "lamp.0003", 7)
    ]
    assert seen == sorted(seen) and seen[-1] == 3
    # The lamp goes from left to right, or from right to left: it stands on one side first, and on the other one last.
    left = [job.picture()[:, :8].sum() for job in jobs.values()]
    assert abs(left[0] - left[2]) > 0.5 * max(left)
    files = list(sequence.save(tmp_path / "lamp.png"))
    assert [file.name for file in files] == ["lamp.0001.png", "lamp.0002.png", "lamp.0003.png"]
    alone = farm.submit(LAMP, seed=5, scene_changes={"time": 0.0}, stop={"passes": 2}, wait=60)
    assert np.array_equal(alone.picture(), jobs[1].picture())
    assert farm.sequence(sequence.id).known.state == "done"
    sequence.delete()
    assert sequence.id not in [known.id for known in farm.sequences()]


def test_a_sequence_is_paused_and_cancelled_as_one(farm: Farm) -> None:
    frames: dict[str, Any] = {"first": 1, "last": 9, "camera_path": ["0", "0"]}
    sequence = farm.submit_sequence(BOX, frames, at_once=1, idempotency_key="a-film", stop={"passes": 1_000_000}, **SMALL)
    assert farm.submit_sequence(BOX, frames, at_once=1, idempotency_key="a-film", stop={"passes": 1_000_000}, **SMALL).id == sequence.id
    assert sequence.pause().state == "paused"
    assert [job.known.state for job in sequence.jobs().values()] == ["paused"]
    assert sequence.resume().state == "running"
    sequence.cancel()
    with pytest.raises(FarmError) as error:
        sequence.wait(timeout=60)
    assert error.value.kind == "sequence-cancelled"
    sequence.delete()


def test_frames_that_cannot_be_are_refused(farm: Farm) -> None:
    with pytest.raises(FarmError) as error:
        farm.submit_sequence(BOX, (1, 3))
    assert error.value.status == 422 and "nothing in the scene moves" in error.value.detail
    with pytest.raises(FarmError) as error:
        farm.sequence("seq-0000000z")
    assert error.value.kind == "unknown-sequence"
