"""Work on many poses in pieces: on threads, with progress, and with an end to it by Ctrl-C.

Examples
--------
>>> import torch
>>> from dexterity.reach.work import in_pieces
>>> done = []
>>> in_pieces(torch.arange(5), lambda at: at.sum(), lambda at, total: done.append(int(total)), size=2)
True
>>> done
[1, 5, 4]
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeAlias, TypeVar

import torch
from torch import Tensor
from tqdm import tqdm

from dexterity import checks

__all__ = ["Progress", "counted", "in_pieces"]

_Part = TypeVar("_Part")

Progress: TypeAlias = bool | Callable[[int, int], object]
"""True for a bar with the remaining time, or a function of how many are done and how many there are."""


@contextlib.contextmanager
def counted(progress: Progress, total: int, what: str) -> Iterator[Callable[[int], None]]:
    """Return a function that adds to what is done, and shows it."""
    if not callable(progress):
        checks.flag(progress, "progress")
    if callable(progress):
        done = 0

        def add(count: int) -> None:
            nonlocal done
            done += count
            progress(done, total)

        yield add
    else:
        with tqdm(total=total, desc=what, unit="pose", unit_scale=True, disable=not progress) as bar:
            yield bar.update


def in_pieces(
    at: Tensor,
    work: Callable[[Tensor], _Part],
    keep: Callable[[Tensor, _Part], object],
    *,
    size: int,
    threads: int = 1,
    add: Callable[[int], None] = lambda _: None,
) -> bool:
    """Work on rows in pieces, and keep each result; by Ctrl-C the rest is left undone.

    Parameters
    ----------
    at
        (k,) rows.
    work
        Called for each piece, on several threads.
    keep
        Called with each piece and its result, one after the other.
    size
        Rows of a piece.
    threads
        Pieces that are worked on at the same time.
    add
        Called with the length of each piece that is done.

    Returns
    -------
    Whether all is done. After a KeyboardInterrupt it is not, and what was done is kept.
    """
    pieces = list(at.split(size)) if len(at) else []
    pool = ThreadPoolExecutor(threads, initializer=torch.set_num_threads, initargs=(torch.get_num_threads(),))
    futures: list[tuple[Tensor, Future[_Part]]] = []
    kept = 0
    try:
        futures = [(piece, pool.submit(work, piece)) for piece in pieces]
        for piece, future in futures:
            result = future.result()
            keep(piece, result)
            kept += 1
            add(len(piece))
    except KeyboardInterrupt:
        for _, future in futures:
            future.cancel()
        return False
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return True
