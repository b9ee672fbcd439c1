"""Server-sent events, also after the connection broke."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from urllib3.exceptions import HTTPError

from .connection import Connection, Request
from .errors import found_here

# The coordinator says something every 15 seconds, so longer silence is a broken connection.
SILENCE = 40.0
RECONNECT_PAUSE = 0.5
# How often in a row a stream may end before it says anything.
EMPTY_STREAMS = 10


@dataclass(frozen=True)
class ServerEvent:
    """One event as it was sent."""

    name: str
    data: str
    id: str | None


def follow(connection: Connection, path: str, last_event_id: str | None = None) -> Iterator[ServerEvent]:
    """Events of a stream that is opened again whenever it ends, from where it stood. Whoever reads decides when to stop."""
    empty_streams = 0
    while True:
        headers = {"Accept": "text/event-stream"} | ({"Last-Event-ID": last_event_id} if last_event_id else {})
        request = Request("GET", path, headers=headers, is_repeatable=True, patience=SILENCE, is_stream=True)
        empty_streams += 1
        for event in one_stream(connection, request):
            empty_streams = 0
            last_event_id = event.id or last_event_id
            yield event
        if empty_streams >= EMPTY_STREAMS:
            raise found_here("unreachable", f"{connection.address} ends the events of {path} too early", "try again")
        time.sleep(RECONNECT_PAUSE)


def one_stream(connection: Connection, request: Request) -> Iterator[ServerEvent]:
    """Events until the stream ends or breaks."""
    answer = connection.send(request)
    try:
        yield from parse(answer.stream())
    except HTTPError:
        # A coordinator that stops or a network that fails: the next stream tells what was missed.
        return
    finally:
        # What is left unread would hold the connection.
        answer.close()


def parse(chunks: Iterable[bytes]) -> Iterator[ServerEvent]:
    """Events from the bytes of a stream. One that breaks off in the middle of an event loses that event."""
    name, data, identifier = "", list[str](), None
    for line in lines(chunks):
        key, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if not line:
            if data:
                yield ServerEvent(name or "message", "\n".join(data), identifier)
            name, data, identifier = "", [], None
        elif key == "event":
            name = value
        elif key == "data":
            data.append(value)
        elif key == "id":
            identifier = value


def lines(chunks: Iterable[bytes]) -> Iterator[str]:
    """Complete lines without their ends."""
    rest = b""
    for chunk in chunks:
        *complete, rest = (rest + chunk).split(b"\n")
        for line in complete:
            yield line.removesuffix(b"\r").decode()
