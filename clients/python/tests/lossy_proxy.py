"""A network that fails: it stands between the client and a real coordinator, and breaks connections."""

from __future__ import annotations

import functools
import socket
import threading
from collections.abc import Callable
from types import TracebackType
from urllib.parse import urlsplit

PATIENCE = 30.0


class LossyProxy:
    """Passes bytes on, but loses answers and breaks connections when it is told to."""

    def __init__(self, coordinator: str) -> None:
        parts = urlsplit(coordinator)
        self._target = (parts.hostname or "", parts.port or 0)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._clients: list[socket.socket] = []
        self.answers_to_lose = 0
        self.connections = 0

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def break_all(self) -> None:
        """Breaks all connections that there are."""
        while self._clients:
            shut(self._clients.pop())

    def __enter__(self) -> LossyProxy:
        in_background(self._accept)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._listener.close()
        self.break_all()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            self.connections += 1
            self._clients.append(client)
            in_background(functools.partial(self._serve, client))

    def _serve(self, client: socket.socket) -> None:
        with client, socket.create_connection(self._target, PATIENCE) as server:
            client.settimeout(PATIENCE)
            in_background(functools.partial(self._copy, client, server, is_answer=False))
            self._copy(server, client, is_answer=True)

    def _copy(self, source: socket.socket, sink: socket.socket, *, is_answer: bool) -> None:
        """Passes bytes on until the end, or an answer that is to be lost."""
        try:
            while data := source.recv(1 << 16):
                if is_answer and self.answers_to_lose > 0:
                    self.answers_to_lose -= 1
                    break
                sink.sendall(data)
        except OSError:
            pass
        shut(source)
        shut(sink)


def shut(connection: socket.socket) -> None:
    try:
        connection.shutdown(socket.SHUT_RDWR)
    except OSError:
        return


def in_background(work: Callable[[], None]) -> None:
    threading.Thread(target=work, daemon=True).start()
