"""Runs on a dask cluster, past one machine; its workers need this source tree at the same path."""

from __future__ import annotations

from concurrent.futures import Executor

from pytask_parallel import ParallelBackend, registry


def use(scheduler: str) -> None:
    """Let pytask's "custom" backend run tasks on a dask cluster.

    Parameters
    ----------
    scheduler
        Address, such as `"tcp://127.0.0.1:8786"`; empty for a cluster of this machine's cores.
    """

    def executor(n_workers: int) -> Executor:
        from distributed import Client, LocalCluster  # only needed here, and not quick to import

        cluster = scheduler or LocalCluster(n_workers=n_workers, threads_per_worker=1)
        return Client(cluster).get_executor()

    registry.register_parallel_backend(
        ParallelBackend.CUSTOM, executor, worker_type="processes", remote=False
    )
