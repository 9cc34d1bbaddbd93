"""A closure for the conductivity of a whole bed at rest, its fluid included, beside
the conductivity of that fluid.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from contbed.closures.binding import bind, is_phase, named
from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath, dotted


def fluid_conducts_twice(
    solid: tuple[KeyPath, object],
    fluid: tuple[KeyPath, object],
    gives: Iterable[str],
    base: Path,
) -> Mistakes:
    """Yield the key of the conductivity of the solids where it holds that of the fluid,
    which is added.

    Parameters
    ----------
    solid, fluid : key and value of the conductivity of the solids and of the fluid
    gives : arguments that the model gives closures of conductivities
    base : folder of the scene
    """
    (key, conductivity), (other_key, other) = solid, fluid
    if not named(conductivity) or is_phase(conductivity) or not named(other):
        return
    if "k_fluid" in bind(conductivity, "conductivity", gives, base).takes:
        what = "eps k_gas" if is_phase(other) else dotted(other_key)
        yield (
            key,
            f"is that of the whole bed at rest, its gas included, and {what} is added: "
            "the gas conducts twice; "
            f"give {dotted(other_key)} = 0",
        )
