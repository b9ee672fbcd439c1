"""A network that fails: it stands between the client and a real coordinator, and breaks connections."""

from __future__ import annotations

import functools
import socket
import threading
from collections.abc import Callable
from types import TracebackType
from urllib.parse import urlsplit

PATIENCE = 30.0
ENOUGH = 1 << 40


class LossyProxy:
    """Passes bytes on. Of the first answers it passes only as many bytes as `budgets` says, one number for each, and then closes the connection."""

    def __init__(self, coordinator: str, budgets: list[int]) -> None:
        parts = urlsplit(coordinator)
        self._target = (parts.hostname or "", parts.port or 0)
        self._budgets = budgets
        self.broken = 0
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._lock = threading.Lock()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def __enter__(self) -> LossyProxy:
        in_background(self._accept)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            in_background(functools.partial(self._serve, client))

    def _serve(self, client: socket.socket) -> None:
        with client, socket.create_connection(self._target, PATIENCE) as server:
            client.settimeout(PATIENCE)
            in_background(lambda: copy(client, server, ENOUGH))
            with self._lock:
                budget = self._budgets.pop(0) if self._budgets else ENOUGH
            copy(server, client, budget)
            self.broken += budget < ENOUGH


def copy(source: socket.socket, sink: socket.socket, budget: int) -> None:
    """Passes bytes on until the end, an error, or more than so many."""
    try:
        while data := source.recv(1 << 16):
            sink.sendall(data[:budget])
            budget -= len(data)
            if budget <= 0:
                break
        sink.shutdown(socket.SHUT_RDWR)
    except OSError:
        return


def in_background(work: Callable[[], None]) -> None:
    threading.Thread(target=work, daemon=True).start()
