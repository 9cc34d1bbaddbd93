"""Water in a gas that would condense, at a temperature of a scene or of its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.scene.checking import Mistakes
from contbed.scene.humid_air import (
    COLDEST,
    P_CRITICAL,
    dew_point,
    saturation_pressure,
)
from contbed.scene.physical import numbers_of

WHERE = ("boundary", "initial")  # tables whose temperatures are those of a bed

# partial pressure over saturation: interactions with the gas leave 0.5 % open
BEYOND = 1.01


def water_condenses(parts: Mapping[str, Any]) -> Mistakes:
    """Look for the lowest temperature of a scene at which the water of its gas would
    condense or freeze, which no model does.
    """
    gas = parts.get("gas")
    composition = getattr(gas, "composition", None)
    if not isinstance(composition, str):
        return
    try:
        share = mole_fractions(composition).get("H2O", 0.0)
    except SceneError:
        return  # the checks of the model say so
    partial = share * float(getattr(gas, "pressure", 101325.0))
    found = [
        pair for name in WHERE for pair in numbers_of("K", parts.get(name), (name,))
    ]
    if not found or partial <= 0.0:
        return
    path, coldest = min(found, key=lambda pair: pair[1])
    if partial > saturation_pressure(coldest):
        dew = dew_point(partial)
        yield (
            path,
            f"water of the gas, {partial:.4g} Pa, condenses or freezes below "
            f"{dew:.5g} K ({dew - 273.15:.4g} degC); it stays vapour in this model",
        )


def above_saturation(gas: str, z: Array, T: Array, partial: Array) -> list[str]:
    """Warn of the place z [m] where water of a partial pressure [Pa] is furthest above
    its saturation at T [K].
    """
    saturation = np.array([saturation_pressure(max(each, COLDEST)) for each in T])
    k = int(np.argmax(partial / saturation))
    if not partial[k] > BEYOND * saturation[k]:
        return []
    dew = dew_point(min(float(partial[k]), P_CRITICAL))
    return [
        f"water in {gas}, {partial[k]:.4g} Pa at {T[k]:.5g} K and {z[k]:.3g} m, condenses "
        f"below {dew:.5g} K; it stays vapour in this model: give more heat or hotter "
        "gas, or less water"
    ]
