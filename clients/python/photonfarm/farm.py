"""A farm, as programs speak to it."""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, TypedDict

from typing_extensions import Unpack

from .connection import Connection, Model, Request
from .errors import FarmError, found_here
from .event_stream import ServerEvent, follow
from .frame_sequence import FrameSequence
from .generated.models import (
    DeletedJob,
    Frames,
    JobList,
    JobState,
    Journal,
    JournalLine,
    JobView,
    Limits,
    Me,
    MethodList,
    MethodView,
    SceneChanges,
    SceneList,
    SceneSummary,
    SceneView,
    SequenceList,
    SequenceStatus,
    Validation,
    WorkerList,
    WorkerStatus,
)
from .job import Job, Stop, given, submitted
from .scene_files import pack

Scene = SceneSummary | Mapping[str, Any] | str | PathLike[str]
# A large scene is checked and prepared before the answer.
UPLOAD_PATIENCE = 900.0


class JobOptions(TypedDict, total=False):
    """What a job may be told beside its scene; docs/REST.md says what each means."""

    method: str
    parameters: Mapping[str, Any]
    stop: Stop
    scene_changes: SceneChanges | Mapping[str, Any]
    cut: Mapping[str, Any]
    seed: int
    name: str
    tags: Sequence[str]
    priority: int
    light_groups: bool


@dataclass(frozen=True)
class FarmEvent:
    """Something that happened to the jobs of a farm."""

    kind: str
    """`status`, `deleted`, or `reset`: what was known is to be forgotten."""
    job_id: str | None
    status: JobView | None
    id: str | None
    """What to give as `last_event_id` to hear what comes after it; only the last event of a batch has one."""


class Farm:
    """A coordinator, or several that stand in for each other, separated by commas.

    What is left out is taken from the environment, as the command line does: PHOTONFARM_URL, PHOTONFARM_TOKEN_FILE or PHOTONFARM_TOKEN,
    PHOTONFARM_AUTHORITIES, PHOTONFARM_FINGERPRINT.
    """

    def __init__(
        self,
        url: str | None = None,
        token: str | None = None,
        *,
        ca: str | PathLike[str] | None = None,
        fingerprint: str | None = None,
        patience: float = 60.0,
    ) -> None:
        """Opens no connection yet.

        Args:
            url: for example `https://farm.example:8080`.
            token: what the coordinator made for a user; an empty one is none.
            ca: file with the authorities that signed its certificate, PEM.
            fingerprint: `sha256:…` of its certificate, as it printed it; then no other is trusted.
            patience: seconds for which requests are sent again while the coordinator is busy, or is away after it was heard once.
        """
        url = url or os.environ.get("PHOTONFARM_URL") or "http://127.0.0.1:8080"
        if ca is None and fingerprint is None and "https:" in url:
            ca, fingerprint = os.environ.get("PHOTONFARM_AUTHORITIES"), os.environ.get("PHOTONFARM_FINGERPRINT")
        if ca is not None and fingerprint is not None:
            raise found_here("bad-address", "both authorities and a fingerprint are to be trusted", "give one of them")
        self.connection = Connection(url, token_of_environment() if token is None else token, ca, fingerprint, patience)

    def __enter__(self) -> Farm:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Closes its connections."""
        self.connection.close()

    def upload(self, path: str | PathLike[str], *, scene: str | None = None) -> SceneView:
        """Uploads a scene: a file with the files in its folder that it names, a zip archive, or a folder with all that is in it.

        `scene` names the scene file of a folder, as seen from there, where it is not plain which one it is.
        """
        headers = {"Content-Type": "application/octet-stream"}
        request = Request("POST", "/v1/scenes", body=pack(path, scene), headers=headers, is_repeatable=True, patience=UPLOAD_PATIENCE)
        try:
            return self.connection.ask(SceneView, request)
        except FarmError as error:
            raise error.in_file(Path(path).name) from None

    def submit(self, scene: Scene, *, idempotency_key: str | None = None, wait: int | None = None, **options: Unpack[JobOptions]) -> Job:
        """Submits a job.

        Args:
            scene: what `upload` gave, its hash, a path to upload, or a scene itself, as a dictionary or as XML that begins with `<`.
            idempotency_key: by which the coordinator knows the job again; the same key later, from another process too, gives the same job.
                One is made for each call, so that a request that is sent again never makes a second job.
            wait: answers when the job has ended, but after so many seconds at most, up to 60.
            options: `method`, `parameters`, `stop` (`{"passes": 64}`), `scene_changes`, `cut`, `seed`, `name`, `tags`, `priority`, `light_groups`.
        """
        return submitted(self.connection, "/v1/jobs", self._submission(scene, options), idempotency_key, wait)

    def submit_sequence(
        self,
        scene: Scene,
        frames: tuple[int, int] | Frames | Mapping[str, Any],
        *,
        at_once: int | None = None,
        idempotency_key: str | None = None,
        **options: Unpack[JobOptions],
    ) -> FrameSequence:
        """Submits many pictures of one scene in which things move, or of which the camera goes along a path.

        Args:
            scene: as for `submit`.
            frames: the first and the last frame, or more of what docs/REST.md says of `frames`.
            at_once: how many frames are rendered at the same time, 1 to 100; 2 by default.
            idempotency_key: as for `submit`.
            options: what all frames have in common, as for `submit`.
        """
        wanted = {"first": frames[0], "last": frames[1]} if isinstance(frames, tuple) else frames
        fields = given(frames=wanted, at_once=at_once) | {"job": self._submission(scene, options)}
        # With a key, a request whose answer was lost can be sent again and makes no second sequence.
        headers = {"Idempotency-Key": idempotency_key or str(uuid.uuid4())}
        request = Request("POST", "/v1/sequences", headers=headers, is_repeatable=True, patience=UPLOAD_PATIENCE)
        return FrameSequence(self.connection, self.connection.ask(SequenceStatus, request.with_json(fields)))

    def sequence(self, id: str) -> FrameSequence:
        """A sequence that is there."""
        if not id.startswith("seq-") or not id.removeprefix("seq-").isalnum():
            raise found_here("bad-address", f"\"{id}\" is not a sequence's id", "take one that sequences() lists")
        return FrameSequence(self.connection, self._get(SequenceStatus, f"/v1/sequences/{id}"))

    def sequences(self) -> list[FrameSequence]:
        """Sequences, oldest first."""
        found = self._get(SequenceList, "/v1/sequences")
        return [FrameSequence(self.connection, known) for known in found.sequences]

    def validate(self, scene: Scene, **options: Unpack[JobOptions]) -> Validation:
        """Tells what would become of a job, or what is wrong with it. No job is made; a path is uploaded."""
        request = Request("POST", "/v1/jobs/validate", is_repeatable=True, patience=UPLOAD_PATIENCE)
        return self.connection.ask(Validation, request.with_json(self._submission(scene, options)))

    def job(self, id: str) -> Job:
        """A job that is there."""
        if not id.isalnum():
            raise found_here("bad-address", f"\"{id}\" is not a job's id", "take one that jobs() lists")
        return Job(self.connection, self._get(JobView, f"/v1/jobs/{id}"))

    def jobs(self, *, state: JobState | None = None, tag: str | None = None, name: str | None = None, owner: str | None = None) -> list[Job]:
        """Jobs, oldest first, all or those that are asked for."""
        found = self._get(JobList, "/v1/jobs", state=state, tag=tag, name=name, owner=owner)
        return [Job(self.connection, view) for view in found.jobs]

    def events(self, last_event_id: str | None = None) -> Iterator[FarmEvent]:
        """Each job that there is, and then each that changes, without an end. What is missed while a stream is broken comes afterwards."""
        for event in follow(self.connection, "/v1/events", last_event_id):
            yield self._farm_event(event)

    def methods(self) -> list[MethodView]:
        """The methods and their parameters."""
        return self._get(MethodList, "/v1/methods").methods

    def workers(self) -> list[WorkerStatus]:
        """The workers."""
        return self._get(WorkerList, "/v1/workers").workers

    def drain(self, worker: WorkerStatus | str) -> WorkerStatus:
        """Gives a worker no further work: it delivers what it holds and leaves. For admins."""
        id = worker if isinstance(worker, str) else worker.id
        return self.connection.ask(WorkerStatus, Request("POST", f"/v1/workers/{id}/drain", is_repeatable=True))

    def scenes(self) -> Sequence[SceneSummary]:
        """The scenes that were uploaded."""
        return self._get(SceneList, "/v1/scenes").scenes

    def delete_scene(self, hash: str) -> None:
        """Deletes a scene that no job refers to."""
        self.call("DELETE", f"/v1/scenes/{hash}")

    def journal(self, *, after: int = 0, job: str | None = None) -> list[JournalLine]:
        """What happened, oldest first: at most 1000 lines after the one with the number `after`."""
        return self._get(Journal, "/v1/journal", after=after, job=job).lines

    def limits(self) -> Limits:
        """What is accepted here."""
        return self._get(Limits, "/v1/limits")

    def me(self) -> Me:
        """Who one is."""
        return self._get(Me, "/v1/me")

    def call(self, method: str, path: str, body: object = None) -> Any:
        """The JSON answer of any address, for what has no method here: users, tokens, webhooks."""
        request = Request(method, path, is_repeatable=method == "GET")
        answer = self.connection.bytes(request if body is None else request.with_json(body))
        return json.loads(answer) if answer else None

    def _get(self, model: type[Model], path: str, **query: object) -> Model:
        return self.connection.ask(model, Request("GET", path, query, is_repeatable=True))

    def _submission(self, scene: Scene, options: JobOptions) -> dict[str, object]:
        fields = given(**options)
        if isinstance(scene, Mapping) or (isinstance(scene, str) and scene.lstrip().startswith("<")):
            return fields | {"scene_inline": scene}
        if isinstance(scene, SceneSummary):
            return fields | {"scene": scene.hash}
        if isinstance(scene, str) and is_hash(scene) and not Path(scene).exists():
            return fields | {"scene": scene}
        return fields | {"scene": self.upload(scene).hash}

    def _farm_event(self, event: ServerEvent) -> FarmEvent:
        match event.name:
            case "status":
                view = self.connection.read(JobView, event.data)
                return FarmEvent(event.name, view.id, view, event.id)
            case "deleted":
                return FarmEvent(event.name, self.connection.read(DeletedJob, event.data).id, None, event.id)
            case _:
                return FarmEvent(event.name, None, None, event.id)


def token_of_environment() -> str | None:
    """The token in the file that PHOTONFARM_TOKEN_FILE names, or in PHOTONFARM_TOKEN."""
    file = os.environ.get("PHOTONFARM_TOKEN_FILE")
    if not file:
        return os.environ.get("PHOTONFARM_TOKEN") or None
    try:
        return Path(file).read_text().strip()
    except OSError as problem:
        raise found_here("bad-file", f"{file}: {problem.strerror}", "give a readable file with a token") from problem


def is_hash(text: str) -> bool:
    """Whether a text has the form of a scene's hash."""
    return len(text) == 64 and set(text) <= set("0123456789abcdef")
