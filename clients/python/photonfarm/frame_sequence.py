"""A sequence of a farm: many pictures of one scene, each a job."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from os import PathLike, fspath
from pathlib import Path

from .connection import Connection, Request
from .errors import found_here
from .generated.models import JobView, SequenceStatus
from .job import Job
from .progress import Line

LOOK_INTERVAL = 1.0

SequenceProgress = Callable[[SequenceStatus], object]


class FrameSequence:
    """A sequence of a farm, by its id. `known` is its status as it was last told."""

    def __init__(self, connection: Connection, known: SequenceStatus) -> None:
        self._connection = connection
        self.id = known.id
        self.known = known

    def __repr__(self) -> str:
        return f"<photonfarm sequence {self.id}, {self.known.state}>"

    def status(self) -> SequenceStatus:
        """How it is doing, frame by frame."""
        return self._told(Request("GET", self._path(), is_repeatable=True))

    def wait(self, progress: SequenceProgress | bool = False, timeout: float | None = None) -> SequenceStatus:
        """Waits until it has ended, also while the coordinator is started again. A paused one is waited for, too.

        `progress` is called with every status on the way, about one a second; True prints a line on standard error.

        Raises:
            FarmError: `sequence-failed` and `sequence-cancelled` when it ends so; `too-late` after `timeout` seconds.
        """
        end = None if timeout is None else time.monotonic() + timeout
        show: SequenceProgress | None = (Line() if progress else None) if isinstance(progress, bool) else progress
        while True:
            status = self.status()
            if show is not None:
                show(status)
            if status.state not in ("running", "paused"):
                return well_ended(status)
            if end is not None and time.monotonic() >= end:
                raise found_here("too-late", f"sequence {self.id} has not ended after {timeout} seconds", "wait longer, or cancel it")
            time.sleep(LOOK_INTERVAL)

    def jobs(self) -> dict[int, Job]:
        """The frames that are jobs by now, by number. Those of deleted jobs are missing."""
        return {frame.frame: self._job(frame.job) for frame in self.status().jobs or []}

    def save(self, path: str | PathLike[str]) -> Iterator[Path]:
        """Writes the picture of each frame as it is now, `lamp.0001.exr` for `lamp.exr`, and names each file when it is there."""
        place = Path(fspath(path))
        for number, job in self.jobs().items():
            yield job.save(place.with_name(f"{place.stem}.{number:04}{place.suffix}"))

    def pause(self) -> SequenceStatus:
        """Stops issuing work of all frames; what is being traced is still merged."""
        return self._told(Request("POST", self._path("/pause")))

    def resume(self) -> SequenceStatus:
        """Lets a paused one go on, or one that failed because a frame could not become a job."""
        return self._told(Request("POST", self._path("/resume")))

    def cancel(self) -> SequenceStatus:
        """Stops all frames and keeps their pictures. One that has ended already stays as it is."""
        return self._told(Request("POST", self._path("/cancel"), is_repeatable=True))

    def delete(self) -> None:
        """Deletes it with its jobs and their pictures. One that runs is cancelled first."""
        self._connection.send(Request("DELETE", self._path()))

    def _job(self, id: str) -> Job:
        return Job(self._connection, self._connection.ask(JobView, Request("GET", f"/v1/jobs/{id}", is_repeatable=True)))

    def _path(self, rest: str = "") -> str:
        return f"/v1/sequences/{self.id}{rest}"

    def _told(self, request: Request) -> SequenceStatus:
        self.known = self._connection.ask(SequenceStatus, request)
        return self.known


def well_ended(status: SequenceStatus) -> SequenceStatus:
    """A sequence that is done; one that failed or was cancelled is an error."""
    if status.state == "failed":
        raise found_here("sequence-failed", f"sequence {status.id} failed: {status.error or 'the coordinator does not say why'}")
    if status.state == "cancelled":
        raise found_here("sequence-cancelled", f"sequence {status.id} was cancelled", "submit it once more")
    return status
