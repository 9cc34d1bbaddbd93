"""Water in a gas that would condense at a temperature of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.scene.checking import Mistakes
from contbed.scene.humid_air import dew_point, saturation_pressure
from contbed.scene.physical import numbers_of

WHERE = ("boundary", "initial")  # tables whose temperatures are those of a bed


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
