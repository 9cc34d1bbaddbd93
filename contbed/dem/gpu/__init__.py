"""Particles on a GPU from NVIDIA: laws and steps are those of processors, compiled by numba-cuda where asked for."""

from __future__ import annotations

from contbed.errors import EngineError

MISSING = "the engine cuda needs numba-cuda, which is not installed; install it with: pip install 'contbed[cuda]'"


def require_gpu() -> None:
    """See to it that there is a GPU that can be used.

    Raises
    ------
    EngineError : numba-cuda is not installed, or finds no GPU, with its reason
    """
    from importlib.util import find_spec

    if find_spec("numba_cuda") is None:
        raise EngineError(MISSING)
    from numba import cuda

    try:
        cuda.current_context()
    except Exception as error:  # of numba-cuda's own and of the driver's classes
        reason = next((line for line in str(error).splitlines() if line.strip(": \n")), type(error).__name__)
        raise EngineError(f"the engine cuda finds no GPU that it can use: {reason.strip()}") from None
