"""A closure for the conductivity of a whole bed at rest, its fluid included, beside the conductivity of that fluid."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from contbed.closures.binding import bind, is_phase, named
from contbed.scene.checking import Mistakes


def fluid_conducts_twice(table: str, solid: object, fluid: object, gives: Iterable[str], base: Path) -> Mistakes:
    """Yield the conductivity of the solid in a table of a scene where it holds that of the fluid, which is added.

    Parameters
    ----------
    table : its name, such as "heat"
    solid, fluid : values of its keys `conductivity_solid` and `conductivity_fluid`
    gives : arguments that the physics gives closures of conductivities
    base : folder of the scene
    """
    if not named(solid) or is_phase(solid) or not named(fluid):
        return
    if "k_fluid" in bind(solid, "conductivity", gives, base).takes:
        what = "eps k_fluid" if is_phase(fluid) else f"{table}.conductivity_fluid"
        yield (
            (table, "conductivity_solid"),
            f"is that of the whole bed at rest, its fluid included, and {what} is added: the fluid conducts twice; "
            f"give {table}.conductivity_fluid = 0",
        )
