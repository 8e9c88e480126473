"""One thread for what must come out the same wherever it is computed.

Examples
--------
>>> import torch
>>> from dexterity.networks.threads import one_thread
>>> with one_thread():
...     torch.get_num_threads()
1
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch

__all__ = ["one_thread"]


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread, for the same sums whoever else is at work, and then as many as before."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
