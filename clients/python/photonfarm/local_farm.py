"""A farm on this machine that lives as long as a `with` block."""

from __future__ import annotations

import atexit
import os
import subprocess
import threading
from collections import deque
from collections.abc import Sequence
from os import PathLike, fspath
from types import TracebackType
from typing import IO

from .errors import found_here
from .farm import Farm

# What `photonfarm serve` prints on standard error before the address at which it listens.
LISTENS_AT = "photonfarm listens at "
START_PATIENCE = 60.0
# It waits up to a minute for what is being traced.
STOP_PATIENCE = 90.0
KEPT_LINES = 20


class LocalFarm:
    """Starts `photonfarm serve` with workers at a free port of this machine, and stops it at the block's end.

    with LocalFarm(workers=2) as farm:
        job = farm.submit("scene.xml")
    """

    def __init__(
        self,
        workers: int = 1,
        *,
        threads: int | None = None,
        program: str | PathLike[str] = "photonfarm",
        data: str | PathLike[str] | None = None,
        listen: str = "127.0.0.1:0",
        token: str | None = None,
        options: Sequence[str] = (),
    ) -> None:
        """Starts nothing yet.

        Args:
            workers: how many workers work in the process.
            threads: threads of each; by default they share all processors.
            program: the photonfarm to run.
            data: folder in which scenes, jobs and pictures are kept; by default all is gone at the block's end.
            listen: address to listen at; port 0 takes any free one.
            token: for a farm that has users.
            options: further options of `photonfarm serve`.
        """
        threads_option = [] if threads is None else ["--threads", str(threads)]
        kept = "none" if data is None else fspath(data)
        self._command = [fspath(program), "serve", "--workers", str(workers), *threads_option, "--listen", listen, "--data", kept, *options]
        self._token = token or ""
        self._started: Started | None = None

    def __enter__(self) -> Farm:
        return self.start()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.stop()

    def start(self) -> Farm:
        """Starts it and waits until it listens. Without a block, it is stopped by `stop()` or when Python ends."""
        if self._started is not None:
            raise found_here("program-failed", "this farm runs already", "stop it first, or make another LocalFarm")
        self._started = Started(self._command)
        atexit.register(self.stop)
        address, said = self._started.address(), self._started.said()
        if address is None:
            self.stop()
            raise found_here("program-failed", f"\"{self._command[0]}\" does not listen: {said}", "run it by hand to see more")
        # Authorities and tokens of the environment are for another farm.
        return Farm(address, self._token)

    def stop(self) -> None:
        """Lets it end what is being traced, and waits for its end."""
        if self._started is not None:
            self._started.stop()
            self._started = None
            atexit.unregister(self.stop)


class Started:
    """The running process."""

    def __init__(self, command: Sequence[str]) -> None:
        # What the environment says of stores and tokens is for another coordinator.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PHOTONFARM_")}
        try:
            # In a session of its own: Ctrl-C in a terminal is for this program, which then stops the other in order.
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="replace", env=environment, start_new_session=True
            )
        except OSError as problem:
            remedy = "install photonfarm, or say where it is with program="
            raise found_here("program-failed", f"cannot start \"{command[0]}\": {problem.strerror}", remedy) from problem
        self._address: str | None = None
        self._is_told = threading.Event()
        self._last_lines = deque[str](maxlen=KEPT_LINES)
        self._reader = threading.Thread(target=self._read_lines, args=(self._process.stderr,), daemon=True)
        self._reader.start()

    def address(self) -> str | None:
        """Where it listens, as soon as it says so."""
        self._is_told.wait(START_PATIENCE)
        return self._address

    def said(self) -> str:
        """What it said last."""
        return "\n".join(self._last_lines) or "it says nothing"

    def stop(self) -> None:
        """Asks it to end, and ends it when it does not."""
        self._process.terminate()
        try:
            self._process.wait(STOP_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join()

    def _read_lines(self, lines: IO[str]) -> None:
        """Reads all that it says, so that it never waits for a reader."""
        with lines:
            for line in lines:
                self._last_lines.append(line.rstrip())
                if line.startswith(LISTENS_AT):
                    self._address = line.removeprefix(LISTENS_AT).strip()
                    self._is_told.set()
        self._is_told.set()
