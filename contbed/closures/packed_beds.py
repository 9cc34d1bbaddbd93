"""Closures of packed beds, with species and without: the arguments that a bed gives
them, and what is wrong with those that a scene names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from contbed.closures.binding import bind, is_phase, named
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes
from contbed.scene.tables import Closure
from contbed.scene.toml_lines import KeyPath, dotted

# surface over volume of particles, times their diameter
SURFACE: Mapping[str, float] = {"spheres": 6.0, "rods": 4.0}
_OF_RODS = ("permeability_kuwahara", "permeability_pivem")
_PACKING = ("eps", "d_p")
_STREAM = (*_PACKING, "Re", "Pr", "Pe", "T", "k_fluid", "D_bed")
GIVES: Mapping[str, tuple[str, ...]] = {
    "permeability": _PACKING,
    "forchheimer": _PACKING,
    "nusselt": _STREAM,
    "dispersion": _STREAM,
    "conductivity": (*_PACKING, "k_fluid", "k_solid", "T"),
    "wall": (*_STREAM, "k_stagnant"),
    "tortuosity": ("eps", "k_fluid", "k_solid"),
    "sherwood": (*_PACKING, "Re", "Sc"),
    "mass_dispersion": (*_PACKING, "v", "D_gas"),
}


def comoving_velocity(velocity_solid: Any, porosity: float) -> Any:
    """Return the superficial velocity of a gas that moves with the particles [m/s].

    `velocity_solid` is theirs, superficial too: u/eps = velocity_solid/(1 - eps).
    """
    return porosity * velocity_solid / (1.0 - porosity)


def surface_diameter(diameter: float, shape: str) -> float:
    """Return six volumes of a particle over its surface [m]."""
    return diameter * (6.0 / SURFACE[shape])


class Packing(NamedTuple):
    """What a bed gives a permeability: its porosity and the diameter of its particles
    [m].
    """

    eps: float
    d_p: float

    @classmethod
    def of(cls, closure: str, eps: float, rod: float, surface: float) -> Packing:
        """Return the packing for a closure: those of arrays of rods take the diameter
        of a rod [m], all others six volumes over the surface [m].
        """
        return cls(eps, rod if closure in _OF_RODS else surface)


def unusable(
    places: Iterable[tuple[KeyPath, Any, str]],
    bound: Callable[[KeyPath, Any, str], object],
) -> Mistakes:
    """Check that closures are known, with their parameters, and get their arguments.

    Parameters
    ----------
    places : key, value and kind of each place that may name a closure
    bound : returns the closure of a place
    """
    for path, spec, kind in places:
        if not named(spec):
            continue
        if kind == "conductivity" and is_phase(spec):
            if isinstance(spec, Closure) and spec.model_extra:
                yield path, f"{spec.name} has no parameters"
            continue
        try:
            bound(path, spec, kind)
        except SceneError as error:
            yield path, str(error)


RADIATES_TWICE = (
    "contains the radiation between the particles, which [radiation] adds a second "
    "time; leave out [radiation], or give emissivity = 0 here"
)


def radiates_in(spec: Any, base: Path) -> bool:
    """Return whether a conductivity of a scene is a closure that contains radiation,
    and can be called; `base` is the folder of the scene.
    """
    if not named(spec) or is_phase(spec):
        return False
    try:
        found = bind(spec, "conductivity", GIVES["conductivity"], base)
    except SceneError:
        return False
    given = dict.fromkeys(found.takes, 1.0) | dict(found.parameters)
    return bool(given.get("emissivity", 0.0))


def gas_conducts_twice(path: KeyPath, table: Any, base: Path) -> Mistakes:
    """Look in a table for a closure of the whole bed at rest, its gas included, beside
    the conductivity of that gas, which is added.

    Parameters
    ----------
    path : key of the table
    base : folder of the scene
    """
    solids, gas = table.conductivity_solids, table.conductivity_gas
    if not named(solids) or is_phase(solids) or not named(gas):
        return
    if "k_fluid" in bind(solids, "conductivity", GIVES["conductivity"], base).takes:
        key = dotted((*path, "conductivity_gas"))
        what = "eps k_gas" if is_phase(gas) else key
        yield (
            (*path, "conductivity_solids"),
            f"holds for the whole stationary bed with its gas, and {what} "
            f"adds the conductivity of the gas a second time; give {key} = 0",
        )
