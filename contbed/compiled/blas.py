"""BLAS and LAPACK on one thread."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)

_controller: ThreadpoolController | None = None


@contextmanager
def single_blas() -> Iterator[None]:
    """Let BLAS and LAPACK, which compute on all cores by default, compute on one thread
    in a block.

    Matrices are sparse, banded or small here, and parts of them too short for several
    threads: these wait for each other longer than they compute. On two cores one thread
    takes 0.2 to 0.65 of the processor time and no longer on the clock, from 98,000
    quadrilaterals to a line. What the environment says of these libraries stays.
    """
    if any(name in os.environ for name in VARIABLES):
        yield
        return
    with _blas().limit(limits=1, user_api="blas"):
        yield


def _blas() -> ThreadpoolController:
    """Return the control of the libraries that are loaded, looked for until scipy
    has loaded its own.
    """
    global _controller
    from threadpoolctl import ThreadpoolController

    if _controller is not None:
        return _controller
    found = ThreadpoolController()
    if "scipy.linalg" in sys.modules:
        _controller = found
    return found
