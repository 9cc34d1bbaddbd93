"""Closures: published correlations as pure functions with their range, unit and source
    as data.

Use one from a script, on numbers or arrays of any shape that broadcasts:

    >>> import numpy as np
    >>> from contbed import closures
    >>> Re = np.array([50.0, 400.0])
    >>> closures.nusselt_wakao_kaguei(Re=Re, Pr=0.7).round(3)
    array([12.213, 37.563])

Or by name, as a scene does, and ask what was used outside of the declared range (bounds
are inclusive):

    >>> nusselt = closures.get("nusselt_gunn", kind="nusselt")
    >>> use = closures.usage(nusselt, Re=Re, Pr=0.7, eps=np.array([0.3, 0.4]))
    >>> use.arguments["eps"]
    ArgumentUse(declared=(0.35, 1.0), used=(0.3, 0.4), share_outside=0.5)

`closures.names(kind)` lists them and `print(closures.data_sheet(name))` shows one.
Kinds: nusselt [-], nusselt_cylinder [-], conductivity [W/m/K], tortuosity [-],
dispersion [W/m/K], permeability [m2], forchheimer [-], pressure_gradient [Pa/m],
radiation [W/m/K or -], wall [W/m2/K]; of rough solids that touch contact [W/m2/K],
contact_separation [m], temperature_jump [m]; of fluidized beds
minimum_fluidization [-], drag [kg/m3/s], bubble_size [m], bubble_rise [m/s],
gas_exchange [1/s], bubble_heat [W/m3/K]; of granular flow radial_distribution,
granular_pressure, granular_viscosity, granular_bulk_viscosity, granular_conductivity,
granular_dissipation, granular_production, effective_restitution, without units,
granular_friction [Pa] and granular_friction_viscosity [Pa s]; of cells that do not
resolve clusters wall_drag, wall_pressure and wall_viscosity; of turbulent gas
eddy_viscosity [m2/s].
"""

from __future__ import annotations

from typing import Any

from contbed.closures.ranges import RangeUse as RangeUse
from contbed.closures.ranges import usage as usage
from contbed.closures.registry import DispersionPair as DispersionPair
from contbed.closures.registry import closure as closure
from contbed.closures.registry import data_sheet as data_sheet
from contbed.closures.registry import dispersion_pair as dispersion_pair
from contbed.closures.registry import get as get
from contbed.closures.registry import names as names
from contbed.closures.registry import sheet as sheet
from contbed.closures.sheet import Sheet as Sheet

_TOOLS = tuple(
    name
    for name in globals()
    if not name.startswith("_") and name not in ("annotations", "Any")
)


def __getattr__(name: str) -> Any:
    """Return a closure by its name; the modules that hold closures are imported when
    the first one is asked for.
    """
    if name == "__all__":
        return __dir__()
    if not name.startswith("__") and name in names():
        return get(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted((*_TOOLS, *names()))
