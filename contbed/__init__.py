"""Finite-element continuum models for packed, moving and fluidized bed reactors.

>>> import contbed as cb
>>> result = cb.run(cb.load("scene.toml"))  # doctest: +SKIP

`load` reads and checks a scene, `plan` says what will be built, `run` solves it and
returns a `Result`; `gradient` returns derivatives of results with respect to keys.
Their errors, SceneError and others, are kinds of `ContbedError`.
Everything heavy is imported when it is first used.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from contbed.compiled.cache import choose_cache

__version__ = "0.2.0"
__all__ = [
    "BalanceError",
    "ClosureRangeError",
    "ContbedError",
    "ConvergenceError",
    "EngineError",
    "Plan",
    "Result",
    "Scene",
    "SceneError",
    "UnlikeError",
    "gradient",
    "load",
    "plan",
    "run",
]

_HOMES = {
    "Scene": "packed_bed.scene",
    "load": "loading",
    "Plan": "packed_bed.plan",
    "plan": "models",
    "Result": "result",
    "run": "runner",
    "gradient": "many.derivatives.gradients",
    "BalanceError": "errors",
    "ClosureRangeError": "errors",
    "ContbedError": "errors",
    "ConvergenceError": "errors",
    "EngineError": "errors",
    "SceneError": "errors",
    "UnlikeError": "errors",
}

if TYPE_CHECKING:
    from contbed.errors import (
        BalanceError,
        ClosureRangeError,
        ContbedError,
        ConvergenceError,
        EngineError,
        SceneError,
        UnlikeError,
    )
    from contbed.loading import load
    from contbed.many.derivatives.gradients import gradient
    from contbed.models import plan
    from contbed.packed_bed.plan import Plan
    from contbed.packed_bed.scene import Scene
    from contbed.result import Result
    from contbed.runner import run


if os.name == "nt":
    raise ImportError(
        "contbed locks files and yields cores by calls of POSIX: on Windows, run it in "
        "WSL"
    )
choose_cache()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'contbed' has no attribute {name!r}")
    return getattr(import_module(f"contbed.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
