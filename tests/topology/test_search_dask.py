"""A search on a Dask cluster, one of whose workers is killed while it works, gives the answer of a search at home."""

from __future__ import annotations

import os
import signal

import pytest

from posreal.errors import BadInput
from posreal.specification.named import problem
from posreal.topology.search import search

distributed = pytest.importorskip("distributed")


@pytest.fixture
def cluster():
    with distributed.LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as running:
        yield running


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")  # the cluster's own, on losing a worker
def test_a_killed_worker_changes_nothing(cluster):
    posed = problem("vertical-comfort")
    killed: list[int] = []
    with distributed.Client(cluster.scheduler_address, set_as_default=False) as watcher:
        pids = watcher.run(os.getpid)

        def kill(line: str) -> None:
            busy = [address for address, tasks in watcher.processing().items() if tasks]
            if line.startswith("4 elements") and busy and not killed:
                killed.append(pids[busy[0]])
                os.kill(killed[0], signal.SIGKILL)

        scheduler = cluster.scheduler_address
        away = search(posed, 4, seed=3, starts=4, backend="dask", scheduler=scheduler, progress=kill)
    home = search(posed, 4, seed=3, starts=4)
    assert len(killed) == 1
    assert [point.to_dict() for point in away.front] == [point.to_dict() for point in home.front]
    assert away.tallies == home.tallies


@pytest.mark.long
def test_a_scheduler_that_is_not_there_is_refused():
    with pytest.raises(BadInput, match="no Dask scheduler answers"):
        search(problem("quarter-car"), 1, backend="dask", scheduler="tcp://127.0.0.1:9")
