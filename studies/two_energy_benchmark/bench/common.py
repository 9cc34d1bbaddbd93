"""What the programs of this benchmark share: processor time of a call, the
coefficients of a scene, the output line.
"""

import json
import resource
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

LINE = Path(__file__).parents[2] / "pivem_2012" / "slip_0.50.toml"


def processor_time() -> float:
    """User time of this process [s]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def timed(
    call: Callable[[], Any], samples: int = 3, shortest: float = 0.2
) -> tuple[float, Any]:
    """Median user time of a call [s] over `samples` of at least `shortest` seconds,
    after one call to warm up.
    """
    result, times = call(), []
    for _ in range(samples):
        start, count = processor_time(), 0
        while (spent := processor_time() - start) < shortest:
            result, count = call(), count + 1
        times.append(spent / count)
    return statistics.median(times), result


def report(unknowns: int, error: float, seconds: float) -> None:
    """One point of a curve on standard output."""
    print(
        json.dumps({"unknowns": unknowns, "error": error, "seconds": seconds}),
        flush=True,
    )


def coefficients() -> dict[str, float]:
    """Arguments of `finite_length` for the slip row, and
    the height of its channel.
    """
    import contbed
    from studies._exact.of_plan import closed_form_arguments

    plan = contbed.plan(contbed.load(LINE))
    return closed_form_arguments(plan) | {"height": plan.scene.mesh.height}


def largest_error(x: Any, fluid: Any, solid: Any, c: dict[str, float]) -> float:
    """Largest error of both temperatures of the slip row at positions x, against the
    closed form.
    """
    from studies._exact.finite_length import finite_length

    exact = finite_length(
        x, **{name: value for name, value in c.items() if name != "height"}
    )
    return max(
        float(np.abs(a - b).max()) for a, b in zip((fluid, solid), exact, strict=True)
    )
