"""Checks of temperatures that a packed bed gives: the properties at them exist; see
`scene.checking`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from contbed.errors import SceneError
from contbed.materials.common import FAR
from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import (
    key_of,
)
from contbed.packed_bed.schedule import KELVIN, PHASES
from contbed.packed_bed.schedule_checks import (
    Boundaries,
    at_each_time,
)
from contbed.scene.checking import Mistakes, See
from contbed.scene.gas import Gas, GasCoolProp
from contbed.scene.series import ProfileFile
from contbed.scene.toml_lines import KeyPath, dotted


@at_each_time
def temperatures_lie_in_the_table(
    gas: Gas, boundary: Boundaries, initial: s.Initial, see: See
) -> Mistakes:
    """Check that the gas's temperatures lie in the range of its table."""
    if not isinstance(gas, GasCoolProp):
        return
    low, high = gas.T_range
    for path, temperature in _temperatures(["fluid"], boundary, initial):
        if low < high and not low <= temperature <= high:
            yield (
                path,
                f"outside of the gas's table, {low:g} to {high:g} K; see "
                f"{see('gas.T_range')}",
            )


@at_each_time
def polynomials_stay_positive(
    solids: Mapping[str, s.Solid], boundary: Boundaries, initial: s.Initial
) -> Mistakes:
    """Check that properties of the solid are positive at the temperatures of the
    scene.
    """
    polynomials = [
        (name, key, coefficients)
        for name, solid in s.that_fill_the_bed(solids).items()
        for key in ("heat_capacity", "conductivity")
        if isinstance(coefficients := getattr(solid, key), tuple)
    ]
    for name, key, coefficients in polynomials:
        for path, temperature in _temperatures(PHASES, boundary, initial):
            value = sum(a * temperature**power for power, a in enumerate(coefficients))
            if not value > 0:
                yield (
                    ("solids", name, key),
                    f"is {value:.4g} at {dotted(path)} = {temperature:g} K; it must be "
                    "above 0",
                )
                break


def require_properties(fluid: Any, scene: s.Scene) -> None:
    """Refuse temperatures so far from the data of the gas that no property is left.

    Raises
    ------
    SceneError : a property is not positive there, or the data are too far away
    """
    low, high = fluid.T_range
    for path, T in _temperatures(["fluid"], scene.boundary, scene.initial):
        of = (fluid.heat_capacity, fluid.viscosity, fluid.conductivity)
        if low - FAR > T or not all(each(T) > 0.0 for each in of):
            raise SceneError(
                f"{scene.origin.place(path)}: {T:g} K is too far from the "
                f"data of {fluid.name}, {low:g} to {high:g} K"
            )


def _temperatures(
    phases: Iterable[str], boundary: Boundaries, initial: s.Initial
) -> Iterator[tuple[KeyPath, float]]:
    """Yield the key and value of every temperature that the scene gives for these
    phases; none of a file.
    """
    for phase in phases:
        for name, table in boundary.items():
            condition = table.condition(phase)
            for key in KELVIN:
                value = getattr(condition, key, None)
                if value is not None:
                    yield key_of(boundary, name, phase, key), value
        given = initial.given(phase)
        if given is not None and not isinstance(given, ProfileFile):
            yield initial.key(phase), given
