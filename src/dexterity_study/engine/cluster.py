"""Runs on a dask cluster, past one machine; its workers need this source tree at the same path."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

from pytask_parallel import ParallelBackend, registry


def use(scheduler: str) -> None:
    """Let pytask's "custom" backend run tasks on a dask cluster.

    Parameters
    ----------
    scheduler
        Address, such as `"tcp://127.0.0.1:8786"`; empty for a cluster of this machine's cores.
    """

    def executor(n_workers: int) -> Executor:
        import distributed  # only needed here, and not quick to import

        dask: Any = distributed
        cluster = scheduler or dask.LocalCluster(n_workers=n_workers, threads_per_worker=1)
        return dask.Client(cluster).get_executor()

    registry.register_parallel_backend(
        ParallelBackend.CUSTOM, executor, worker_type="processes", remote=False
    )
