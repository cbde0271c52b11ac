"""Work done side by side: joblib on this machine's cores, or on a Dask cluster that is already there.

Results come in the order in which they are finished. On a cluster, what a lost worker was doing is done again by
another: tasks have no side effects and their random numbers depend on the topology only.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

from joblib import Parallel, delayed, parallel_config

from posreal.errors import BadInput, hint, shown

T = TypeVar("T")
BACKENDS = ("loky", "threading", "dask")
_PATIENCE = 10  # seconds for a scheduler to answer


class Workers:
    """Where work is done; use as ``with workers(...) as pool: for result in pool.each(function, tasks)``."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def each(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]]) -> Iterator[T]:
        """``function(*task)`` for every task, as they are finished."""
        if not tasks:
            return
        run = Parallel(n_jobs=self.jobs, return_as="generator_unordered", batch_size=1)
        yield from run(delayed(function)(*task) for task in tasks)


@contextmanager
def workers(jobs: int = 1, backend: str | None = None, scheduler: str | None = None) -> Iterator[Workers]:
    """A place to work.

    Parameters
    ----------
    jobs : int
        Processes on this machine; -1 for all cores. A cluster decides for itself.
    backend : {None, "loky", "threading", "dask"}
        None is joblib's own choice.
    scheduler : str, optional
        Address of a Dask scheduler, such as ``tcp://10.0.0.1:8786``; needed for ``dask``.

    Raises
    ------
    BadInput
        For an unknown backend, a missing or silent scheduler, or if dask.distributed is not installed.
    """
    if jobs == 0 or jobs < -1:
        raise BadInput(f"jobs is {jobs}; give the number of processes, or -1 for all cores")
    if backend is not None and backend not in BACKENDS:
        raise BadInput(f"unknown backend {shown(backend)}; {hint(backend, BACKENDS)}")
    if backend != "dask":
        if scheduler is not None:
            raise BadInput(f"a scheduler ({scheduler}) is for the dask backend; give backend dask too, or leave it out")
        with parallel_config(backend=backend, inner_max_num_threads=1) if backend == "loky" else _as_it_is(backend):
            yield Workers(min(jobs, os.cpu_count() or 1) if jobs > 0 else jobs)
        return
    client = _client(scheduler)
    try:
        with parallel_config(backend="dask", client=client, pure=False):
            yield Workers(-1)
    finally:
        client.close()


@contextmanager
def _as_it_is(backend: str | None) -> Iterator[None]:
    if backend is None:
        yield
    else:
        with parallel_config(backend=backend):
            yield


def _client(scheduler: str | None) -> Any:
    if scheduler is None:
        raise BadInput("the dask backend needs the address of a scheduler, such as tcp://10.0.0.1:8786")
    try:
        Client = import_module("distributed").Client
    except ImportError:
        raise BadInput(
            "the dask backend needs dask.distributed; install it with: pip install 'posreal[dask]'"
        ) from None
    try:
        client = Client(scheduler, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise BadInput(f"no Dask scheduler answers at {scheduler}: {str(error).splitlines()[0]}") from None
    if not client.scheduler_info()["workers"]:
        client.close()
        raise BadInput(f"the Dask scheduler at {scheduler} has no workers; start some with: dask worker {scheduler}")
    return client
