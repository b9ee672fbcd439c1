"""Progress for people who look at a terminal."""

from __future__ import annotations

import sys

from .generated.models import JobView, SequenceStatus


class Line:
    """One line on standard error that is written again and again; where that is no terminal, a line for each change."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, view: JobView | SequenceStatus) -> None:
        text = sentence(view) if isinstance(view, JobView) else frames(view)
        if text == self._last:
            return
        if sys.stderr.isatty():
            is_last = view.state in ("done", "failed", "cancelled")
            print("\r" + text.ljust(len(self._last)), end="\n" if is_last else "", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)
        self._last = text


def sentence(view: JobView) -> str:
    """How a job is doing, in one line."""
    parts = [f"{view.passes_done} of {view.passes_total} passes" if view.passes_total else f"{view.passes_done} passes"]
    if view.estimated_error is not None:
        parts.append(f"relMSE {view.estimated_error.relmse:.2g}")
    if view.seconds_left is not None and view.state == "running":
        parts.append(f"{view.seconds_left:.0f} s left")
    if view.paused:
        parts.append(view.paused)
    return f"{view.id} {view.state}: " + ", ".join(parts)


def frames(status: SequenceStatus) -> str:
    """How a sequence is doing, in one line."""
    parts = [f"{status.frames_done} of {status.frames_total} frames", f"{100 * status.progress:.0f} %"]
    if status.seconds_left is not None:
        parts.append(f"{status.seconds_left:.0f} s left")
    if status.waiting:
        parts.append(f"waiting: {status.waiting}")
    return f"{status.id} {status.state}: " + ", ".join(parts)
