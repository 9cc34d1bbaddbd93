"""Derivatives of a solved steady scene by its discrete tangent, for every physics that
has a module `tangent`.

That module offers `of(result)`: an object whose `results(below, above)` are the named
results of two scenes that differ a little from the solved one. Its `step` is the
relative step of a key, and its `method` that of the gradient: "tangent", or
"differences" where a transient is repeated with its mesh and time steps.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError, UnlikeError
from contbed.many.derivatives.differences import Slope, Steps, steps
from contbed.many.derivatives.keys import Key
from contbed.models import model_of
from contbed.result import Result
from contbed.scene.tables import SceneBase


def of(result: Result) -> Any | None:
    """Return the tangent of a run; None where its physics has none, or the run has
    no solved state at hand.
    """
    model = model_of(result.scene)
    if (
        result.solved is None
        or not result.engine.tangents
        or find_spec(f"contbed.{model.package}.tangent") is None
    ):
        return None
    return model.find("tangent", "of")(result)


def slope(
    base: Any, scene: SceneBase, key: Key, pick: Callable[[dict[str, Any]], Array]
) -> Slope:
    """Return the derivatives of the results that `pick` takes with respect to a key.

    Raises
    ------
    UnlikeError : the key changes more than numbers
    ContbedError : closures or properties cannot be evaluated beside the value of the
        key
    """
    chosen: Steps = steps(scene, key, base.step)
    ends = [
        key.value + side * chosen.size if side in chosen.sides else key.value
        for side in (-1, 1)
    ]
    try:
        found = [
            pick(one) for one in base.results(*(key.on(scene, value) for value in ends))
        ]
    except UnlikeError:
        raise
    except ContbedError as error:
        text = (
            f"{scene.origin.at(key.path)}: the derivative to {key.name} cannot be "
            f"found at {key.value:.6g}: "
        )
        raise type(error)(f"{text}{error}") from error
    values = (found[1] - found[0]) / (ends[1] - ends[0])
    return Slope(values, np.zeros_like(values), chosen.note)
