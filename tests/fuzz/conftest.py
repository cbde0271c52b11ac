"""Seeds and commands for the campaign."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from tests.fuzz.runner import Commands


@dataclass(frozen=True)
class Fuzz:
    """Where the draws begin and how many of each kind there are."""

    seed: int
    size: int

    @property
    def seeds(self) -> range:
        return range(self.seed * 10_000, self.seed * 10_000 + self.size)


@pytest.fixture(scope="session")
def fuzz(request: pytest.FixtureRequest) -> Fuzz:
    return Fuzz(request.config.getoption("--fuzz-seed"), request.config.getoption("--fuzz-size"))


@pytest.fixture(scope="session")
def commands() -> Iterator[Commands]:
    with Commands() as run:
        yield run
