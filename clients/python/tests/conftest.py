"""What tests share: the program that they run, and a coordinator with one worker."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from photonfarm import Farm, LocalFarm


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--program", required=True, help="the photonfarm to test with")


@pytest.fixture(scope="session")
def program(request: pytest.FixtureRequest) -> Path:
    return Path(str(request.config.getoption("--program"))).resolve()


@pytest.fixture(scope="session")
def farm(program: Path) -> Iterator[Farm]:
    """A coordinator for all tests that need no other: with one worker of one thread."""
    with LocalFarm(workers=1, threads=1, program=program) as farm:
        yield farm
