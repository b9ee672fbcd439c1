"""A job of a farm."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from . import pictures, progress
from .connection import ANSWER_PATIENCE, Connection, Request
from .errors import found_here
from .event_stream import follow
from .generated.models import JobView, Layout, StopRule

FINAL_STATES = ("done", "failed", "cancelled")
# The longest that a coordinator keeps a request waiting.
LONGEST_WAIT = 60
# How often somebody who watches is told something.
PROGRESS_INTERVAL = 1

Progress = Callable[[JobView], object]
Stop = StopRule | Mapping[str, Any]
Exposure = float | Literal["auto"]
Tone = Literal["linear", "filmic", "agx"]


class Job:
    """A job of a farm, by its id. `known` is its status as it was last told."""

    def __init__(self, connection: Connection, known: JobView) -> None:
        self._connection = connection
        self.id = known.id
        self.known = known

    def __repr__(self) -> str:
        return f"<photonfarm job {self.id}, {self.known.state}>"

    def status(self, wait: int | None = None) -> JobView:
        """How it is doing; with `wait`, when it has ended, but after so many seconds at most, up to 60."""
        request = Request("GET", self._path(), headers=preference(wait), is_repeatable=True, patience=ANSWER_PATIENCE + (wait or 0))
        return self._told(request)

    def wait(self, progress: Progress | bool = False, timeout: float | None = None) -> JobView:
        """Waits until it has ended, also while the coordinator is started again. A paused job is waited for, too.

        `progress` is called with every status on the way, about one a second; True prints a line on standard error.

        Raises:
            FarmError: `job-failed` and `job-cancelled` when it ends so; `too-late` after `timeout` seconds.
        """
        end = None if timeout is None else time.monotonic() + timeout
        show = shown_by(progress)
        step = LONGEST_WAIT if show is None else PROGRESS_INTERVAL
        while True:
            left = step if end is None else min(step, end - time.monotonic())
            view = self.status(wait=max(0, int(left)))
            if show is not None:
                show(view)
            if view.state in FINAL_STATES:
                return well_ended(view)
            if end is not None and time.monotonic() >= end:
                raise found_here("too-late", f"job {self.id} has not ended after {timeout} seconds", "wait longer, or cancel it")
            if 0 < left < 1:
                # The header takes whole seconds only.
                time.sleep(left)

    def events(self) -> Iterator[JobView]:
        """Its status at once and then as it changes, at most about five times a second, until it has ended. Broken streams are opened again."""
        for event in follow(self._connection, self._path("/events")):
            if event.name == "status":
                self.known = self._connection.read(JobView, event.data)
                yield self.known
                if self.known.state in FINAL_STATES:
                    return

    def pause(self) -> JobView:
        """Stops issuing work; what is being traced is still merged."""
        return self._post("/pause")

    def resume(self) -> JobView:
        """Lets a paused job go on."""
        return self._post("/resume")

    def cancel(self) -> JobView:
        """Stops it and keeps its picture. A job that has ended already stays as it is."""
        return self._post("/cancel", is_repeatable=True)

    def extend(self, stop: Stop) -> JobView:
        """Lets an ended job go on to a later end, to the bits of the longer job."""
        return self._post("/extend", plain(stop))

    def clone(
        self,
        *,
        method: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        stop: Stop | None = None,
        seed: int | None = None,
        name: str | None = None,
        tags: Sequence[str] | None = None,
        priority: int | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submits a copy with some differences; what is left out is as it was submitted."""
        changes = given(method=method, parameters=parameters, stop=stop, seed=seed, name=name, tags=tags, priority=priority)
        return submitted(self._connection, self._path("/clone"), changes, idempotency_key)

    def change(self, *, name: str | None = None, tags: Sequence[str] | None = None, priority: int | None = None) -> JobView:
        """Changes name, tags or priority; an empty name is none."""
        request = Request("PATCH", self._path(), is_repeatable=True).with_json(given(name=name, tags=tags, priority=priority))
        return self._told(request)

    def delete(self) -> None:
        """Deletes it and its pictures. One that runs is cancelled first."""
        self._connection.send(Request("DELETE", self._path()))

    def picture(self) -> NDArray[np.float32]:
        """The picture so far: (height, width, 3), linear.

        Raises:
            FarmError: `no-picture-yet` before the first passes are merged.
        """
        return pictures.picture(pictures.read_channels(self.exr()))

    def layers(self, names: Sequence[str]) -> dict[str, NDArray[np.float32]]:
        """Layers by name: `radius`, `photons`, `error`, `depth` (height, width); `albedo`, `normal`, `position` (height, width, 3); `crypto_object`,
        `crypto_material` (height, width, 6, 2), pairs of id and coverage. `light_groups` gives `light_group.NAME` (height, width, 3) for each group."""
        return pictures.layers(pictures.read_channels(self.exr(names)), names)

    def exr(self, layers: Sequence[str] = ()) -> bytes:
        """The picture so far as an EXR file, with further layers."""
        query = {"layers": ",".join(layers) or None}
        return self._connection.bytes(Request("GET", self._path("/image.exr"), query, is_repeatable=True))

    def png(self, exposure: Exposure | None = None, *, tone: Tone | None = None, bits: int | None = None) -> bytes:
        """The picture so far as a PNG file to look at, brighter by `exposure` stops."""
        return self._display("png", exposure=exposure, tone=tone, bits=bits)

    def jpg(self, exposure: Exposure | None = None, *, tone: Tone | None = None, quality: int | None = None) -> bytes:
        """The same as a JPEG file; `quality` is 1 to 100."""
        return self._display("jpg", exposure=exposure, tone=tone, quality=quality)

    def webp(self, exposure: Exposure | None = None, *, tone: Tone | None = None) -> bytes:
        """The same as a WebP file without loss."""
        return self._display("webp", exposure=exposure, tone=tone)

    def layout(self) -> Layout:
        """Where the camera and the lights of its scene stand."""
        return self._connection.ask(Layout, Request("GET", self._path("/layout"), is_repeatable=True))

    def save(
        self, path: str | PathLike[str], *, layers: Sequence[str] = (), exposure: Exposure | None = None, tone: Tone | None = None
    ) -> Path:
        """Writes the picture so far to an .exr file, with `layers`, or to a .png, .jpg or .webp file, with `exposure` and `tone`."""
        place = Path(fspath(path))
        match place.suffix.lower():
            case ".exr" if exposure is None and tone is None:
                content = self.exr(layers)
            case ".png" | ".jpg" | ".jpeg" | ".webp" as ending if not layers:
                content = self._display(ending.removeprefix(".").replace("jpeg", "jpg"), exposure=exposure, tone=tone)
            case _:
                remedy = "name it .exr, which may have layers, or .png, .jpg or .webp, which may have an exposure and a tone"
                raise found_here("bad-file", f"\"{place}\" cannot be written so", remedy)
        # A program that is killed while it writes leaves no half picture under the name that others read.
        part = place.with_name(f".{place.name}.part")
        try:
            part.write_bytes(content)
            part.replace(place)
        except OSError as problem:
            raise found_here("bad-file", f"cannot write \"{place}\": {problem.strerror}", "check the folder and the permissions") from problem
        return place

    def _display(self, form: str, **query: object) -> bytes:
        return self._connection.bytes(Request("GET", self._path(f"/image.{form}"), query, is_repeatable=True))

    def _path(self, rest: str = "") -> str:
        return f"/v1/jobs/{self.id}{rest}"

    def _post(self, rest: str, body: object = None, *, is_repeatable: bool = False) -> JobView:
        request = Request("POST", self._path(rest), is_repeatable=is_repeatable)
        return self._told(request if body is None else request.with_json(body))

    def _told(self, request: Request) -> JobView:
        self.known = self._connection.ask(JobView, request)
        return self.known


def submitted(connection: Connection, path: str, body: object, key: str | None, wait: int | None = None) -> Job:
    """The job that a request makes, or made when it was sent with the same key before."""
    # With a key, a request whose answer was lost can be sent again and makes no second job.
    headers = {"Idempotency-Key": key or str(uuid.uuid4())} | preference(wait)
    request = Request("POST", path, headers=headers, is_repeatable=True, patience=ANSWER_PATIENCE + (wait or 0))
    return Job(connection, connection.ask(JobView, request.with_json(body)))


def preference(wait: int | None) -> dict[str, str]:
    """The header that asks for an answer at the job's end."""
    if wait is None:
        return {}
    if not 0 <= wait <= LONGEST_WAIT:
        raise found_here("bad-wait", f"a coordinator does not wait for {wait} seconds", f"give 0 to {LONGEST_WAIT}, or use wait() of the job")
    return {"Prefer": f"wait={wait}"}


def plain(value: object) -> object:
    """A value as JSON takes it."""
    return value.model_dump(exclude_none=True) if isinstance(value, BaseModel) else value


def given(**fields: object) -> dict[str, object]:
    """The fields that were given, as JSON takes them."""
    return {name: plain(value) for name, value in fields.items() if value is not None}


def shown_by(wish: Progress | bool) -> Progress | None:
    """Whom to tell of progress."""
    if isinstance(wish, bool):
        return progress.Line() if wish else None
    return wish


def well_ended(view: JobView) -> JobView:
    """A job that is done; one that failed or was cancelled is an error."""
    if view.state == "failed":
        raise found_here("job-failed", f"job {view.id} failed: {view.error or 'the coordinator does not say why'}")
    if view.state == "cancelled":
        raise found_here("job-cancelled", f"job {view.id} was cancelled", "clone it to have it once more")
    return view
