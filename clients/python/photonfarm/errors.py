"""The one exception of this package."""

from __future__ import annotations

from .generated.models import Problem

FARM_PREFIX = "urn:photonfarm:problem:"
CLIENT_PREFIX = "urn:photonfarm:client:"


class FarmError(Exception):
    """Why something could not be done: what the coordinator answers as problem+json, or what this package found itself.

    `type` is `urn:photonfarm:problem:…` for what the coordinator says (docs/REST.md lists these) and `urn:photonfarm:client:…` for what is found
    here: `unreachable`, `not-a-coordinator`, `bad-file`, `bad-address`, `bad-wait`,
    `job-failed`, `job-cancelled`, `too-late`, `program-failed`.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(sentence(problem))
        self.type = problem.type
        self.title = problem.title
        self.status = problem.status
        """The HTTP status; 0 where no coordinator was asked."""
        self.detail = problem.detail
        self.remedy = problem.remedy
        self.place = problem.place
        """Where it stands in what was sent: file, line and path of a scene, or line and column of a JSON body."""
        self.retry_after = problem.retry_after
        """Seconds after which the same may succeed."""

        self._problem = problem

    def in_file(self, name: str) -> FarmError:
        """The same of a scene that was sent without its file's name: the coordinator calls it `scene`."""
        rest = (self.place or "").removeprefix("scene")
        is_unnamed = self.place is not None and rest != self.place and not rest[:1].isalnum() and rest[:1] != "."
        return FarmError(self._problem.model_copy(update={"place": name + rest})) if is_unnamed else self

    @property
    def kind(self) -> str:
        """The last word of the type, for example `unknown-job`; it stays the same between versions."""
        return self.type.rsplit(":", 1)[-1]


def found_here(kind: str, detail: str, remedy: str | None = None, status: int = 0) -> FarmError:
    """An error that no coordinator told."""
    return FarmError(Problem(type=CLIENT_PREFIX + kind, title=kind.replace("-", " "), status=status, detail=detail, remedy=remedy))


def sentence(problem: Problem) -> str:
    """Place, problem and remedy, as the command line prints them."""
    place = f"{problem.place}: " if problem.place else ""
    remedy = f"; {problem.remedy}" if problem.remedy else ""
    return f"{place}{problem.detail}{remedy}"
