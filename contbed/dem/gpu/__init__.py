"""Particles on a GPU from NVIDIA: laws and steps are those of processors, compiled
by numba-cuda where asked for.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from contbed.errors import EngineError

MISSING = (
    "the engine cuda needs numba-cuda, which is not installed; install it with: "
    "pip install 'contbed[cuda]'"
)
REASON = 2  # lines of numba-cuda's message that are reported: where it failed, and why


def on_gpu(plan: Any) -> Any:
    """Return the plan of a run that moves particles on a GPU.

    Raises
    ------
    EngineError : the scene moves no particles, or there is no GPU
    """
    move = getattr(plan, "on_gpu", None)
    if move is None:
        raise EngineError(
            f"{plan.scene.origin.name}: --engine cuda moves particles; this scene of "
            f"kind {plan.scene.kind} has none, "
            "leave the option out"
        )
    moved = move()
    require_gpu()
    return moved


def require_gpu() -> None:
    """See to it that there is a GPU that can be used.

    Raises
    ------
    EngineError : numba-cuda is not installed, or finds no GPU, with its reason
    """
    if find_spec("numba_cuda") is None:
        raise EngineError(MISSING)
    from contbed.dem.gpu.arrays import cuda

    try:
        cuda.current_context()
    except Exception as error:  # of numba-cuda's own and of the driver's classes
        lines = [line.strip(" :") for line in str(error).splitlines()]
        reason = (
            "; ".join([line for line in lines if line][:REASON]) or type(error).__name__
        )
        raise EngineError(
            f"the engine cuda finds no GPU that it can use: {reason}"
        ) from None
