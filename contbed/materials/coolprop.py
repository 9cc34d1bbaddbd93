"""Real fluids at fixed pressure: CoolProp's equations of state, tabulated once to
smooth piecewise polynomials in T.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import chain
from typing import Any, ClassVar

import numpy as np

from contbed.errors import SceneError

from .common import Range, checked_positive, checked_range, nearest, share_outside
from .pointwise import pointwise

# relative, for every property half way between nodes; nodes are added until it is met
TOLERANCE = 1e-7
# where it cannot be met: near a critical point and at kinks of CoolProp's own
ACCEPTED = 1e-4
# K; intervals below it are not halved: CoolProp's own scatter near a critical point
# shows there
NARROWEST = 0.01
# K; a range may end at the boiling temperature as an error message prints it
ROUNDING = 0.01
INCOMPRESSIBLE = "INCOMP::"  # prefix of names of oils, salts and brines
PROPERTIES = ("density", "heat_capacity", "viscosity", "conductivity")


@dataclass(frozen=True, eq=False)
class RealFluid:
    """A pure fluid in one phase at fixed pressure; made by `real_fluid`.

    Quintic splines, so values are smooth and derivatives are exact. `table_error` is
    the largest relative error of any property half way between nodes: below 1e-7, but
    up to 1e-4 within some 0.01 K of the places where CoolProp itself scatters or has
    kinks (supercritical, near the critical point). Outside T_range each property keeps
    its value at the nearer end, which keeps it positive; `share_outside` reports how
    often that happened.
    """

    constant: ClassVar[bool] = False
    name: str
    T_range: Range
    source: str
    pressure: float
    table_error: float
    _tables: dict[str, tuple[Any, Any]] = field(repr=False)

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3]."""
        return pointwise(*self._tables["density"], T)

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K]."""
        return pointwise(*self._tables["heat_capacity"], T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], exact integral of heat_capacity, CoolProp's at
        the lower end of T_range.
        """
        return pointwise(*self._tables["enthalpy"], T)

    def viscosity(self, T: Any) -> Any:
        """Return the viscosity [Pa s]."""
        return pointwise(*self._tables["viscosity"], T)

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K]."""
        return pointwise(*self._tables["conductivity"], T)

    def compressibility(self, T: float) -> float:
        """Return by how much the density rises with the pressure, over itself [1/Pa]."""
        if _is_incompressible(self.name):
            return 0.0
        CoolProp, state = _state(self.name)
        state.update(CoolProp.PT_INPUTS, self.pressure, np.clip(T, *self.T_range))
        return float(state.isothermal_compressibility())

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range."""
        return share_outside(T, self.T_range)


def real_fluid(
    name: str, pressure: float, T_range: Sequence[float] | None = None
) -> RealFluid:
    """Tabulate a fluid from CoolProp: liquid, gas or supercritical.

    Parameters
    ----------
    name : a CoolProp fluid such as "Water" or "CO2"; "steam" is the gas side of water;
        a thermal oil or brine, "INCOMP::TVP1", "INCOMP::MEG-30%" (by mass); a mixture
        with its mole fractions, "Nitrogen[0.79]&Oxygen[0.21]"
    pressure : [Pa]
    T_range : [K], on one side of the boiling temperature at this pressure; for "steam"
        the default is all of that side

    Source
    ------
    Bell, Wronski, Quoilin and Lemort (2014), Ind. Eng. Chem. Res. 53, 2498, doi:10.1021/ie4033999
    """
    p = checked_positive(pressure, f"{name}: pressure", "Pa")
    CoolProp, state = _state(name)
    pure = not _is_incompressible(name) and "&" not in name
    if _is_incompressible(name):
        limits, phase = _liquid(CoolProp, state, name, p, T_range), ""
    else:
        fluid, boiling = (state.Tmin(), state.Tmax()), _boiling(CoolProp, state, p)
        limits, phase = _one_phase(name, p, T_range, fluid, boiling)
    if pure and limits[0] < (melting := _melting(CoolProp, state, p)):
        raise SceneError(
            f"{name}: {limits[0]:g} K is below Tmelt = {melting:g} K at {p:g} Pa; "
            "narrow T_range"
        )
    if phase:
        state.specify_phase(getattr(CoolProp, f"iphase_{phase}"))

    @cache
    def at(T: float) -> tuple[float, ...]:
        try:
            state.update(CoolProp.PT_INPUTS, p, T)
            return (
                state.rhomass(),
                state.cpmass(),
                state.viscosity(),
                state.conductivity(),
            )
        except ValueError as error:
            raise SceneError(
                f"{name}: CoolProp has no properties at {T:.6g} K and {p:g} Pa "
                f"({error}); narrow T_range, or raise the pressure of a liquid"
            ) from error

    nodes, values, error, worst = _refined(
        lambda T: np.array([at(T_i) for T_i in T.tolist()]), limits
    )
    if error > ACCEPTED:
        raise SceneError(
            f"{name}: CoolProp's properties at {p:g} Pa jump or vary too steeply near "
            f"{worst:.6g} K for the table "
            f"(error {error:.1e}); choose a T_range on one side, or another pressure"
        )
    state.update(CoolProp.PT_INPUTS, p, limits[0])
    return RealFluid(
        name=name,
        T_range=limits,
        source=f"CoolProp {CoolProp.get_global_param_string('version')}, "
        f"{state.fluid_names()[0] if pure else name}",
        pressure=p,
        table_error=error,
        _tables=_tables(nodes, values, state.hmass()),
    )


def _is_incompressible(name: str) -> bool:
    """Return whether a name is one of CoolProp's oils, salts and brines, which are
    liquid in its data.
    """
    return name.upper().startswith(INCOMPRESSIBLE)


def _parts(name: str) -> tuple[str, str, list[float]]:
    """Return backend, components and their fractions of a name; see `real_fluid`."""
    if _is_incompressible(name):
        solution = name[len(INCOMPRESSIBLE) :]
        given = re.fullmatch(r"(.+?)(?:\[([\d.]+)\]|-([\d.]+)%)", solution)
        if given is None:
            return "INCOMP", solution, []
        share = float(given[2]) if given[2] else float(given[3]) / 100.0
        return "INCOMP", given[1], [share]
    components = re.findall(r"([^&\[\]]+)\[([\d.]+)\]", name.removeprefix("HEOS::"))
    if components:
        names, shares = zip(*components, strict=True)
        return "HEOS", "&".join(names), [float(share) for share in shares]
    return "HEOS", "Water" if name.lower() == "steam" else name, []


def _state(name: str) -> tuple[Any, Any]:
    """Return CoolProp and a state of a fluid, see `real_fluid`."""
    try:
        from CoolProp import AbstractState, CoolProp
    except ImportError as error:
        raise SceneError(
            f"{name}: the package CoolProp is needed for real fluids and cannot be "
            f"imported ({error}); "
            "install it (pip install CoolProp) or give the fluid constant properties"
        ) from error
    backend, components, shares = _parts(name)
    try:
        state = AbstractState(backend, components)
        if backend == "INCOMP" and shares:
            state.set_mass_fractions(shares)
        elif shares:
            state.set_mole_fractions(shares)
    except ValueError as error:
        lists = [
            CoolProp.get_global_param_string(f"incompressible_list_{kind}").split(",")
            for kind in ("pure", "solution")
        ]
        known = [
            *CoolProp.FluidsList(),
            "steam",
            "CO2",
            *(f"INCOMP::{fluid}" for fluid in chain(*lists)),
        ]
        raise SceneError(
            f"no real fluid {name!r} in CoolProp{nearest(name, known)}"
        ) from error
    needs_share = backend == "INCOMP" and not shares and _is_solution(components)
    if needs_share or (backend == "HEOS" and shares and abs(sum(shares) - 1.0) > 1e-6):
        text = (
            f"give its mass fraction, such as {INCOMPRESSIBLE}{components}-30%"
            if needs_share
            else f"mole fractions sum to {sum(shares):g}, not to 1"
        )
        raise SceneError(f"{name}: {text}")
    return CoolProp, state


def _is_solution(name: str) -> bool:
    """Return whether an incompressible fluid is a solution, of any fraction."""
    from CoolProp import CoolProp

    solutions = CoolProp.get_global_param_string("incompressible_list_solution")
    return name in solutions.split(",")


def _melting(CoolProp: Any, state: Any, p: float) -> float:
    """Return the melting temperature [K], 0 where it is not known; CoolProp before 8
    gives the ice's side as water.
    """
    if not state.has_melting_line() or p < state.trivial_keyed_output(
        CoolProp.iP_triple
    ):
        return 0.0
    try:
        return float(state.melting_line(CoolProp.iT, CoolProp.iP, p)) - ROUNDING
    except ValueError:  # beyond the ends of the line
        return 0.0


def _boiling(CoolProp: Any, state: Any, p: float) -> Range | None:
    """Return bubble and dew temperature [K], equal for a pure fluid.

    None above the critical and below the triple pressure.
    """
    pure = len(state.fluid_names()) == 1
    if pure and (
        p >= state.p_critical() or p < state.trivial_keyed_output(CoolProp.iP_triple)
    ):
        return None
    ends = []
    for quality in (0.0, 1.0):
        state.update(CoolProp.PQ_INPUTS, p, quality)
        ends.append(state.T())
    return ends[0], ends[1]


def _liquid(
    CoolProp: Any, state: Any, name: str, p: float, T_range: Sequence[float] | None
) -> Range:
    """Return the range of an incompressible fluid, which ends where it boils.

    Raises
    ------
    SceneError : no range, or one that is not all liquid
    """
    from scipy.optimize import bisect

    def excess(T: float) -> float:
        """Vapour pressure less p [Pa]; CoolProp has none at the lowest temperatures."""
        try:
            state.update(CoolProp.QT_INPUTS, 0.0, T)
        except ValueError:
            return -p
        return float(state.p()) - p

    lowest, highest = state.Tmin(), state.Tmax()
    above = excess(highest)
    if above > 0.0:
        # a little below, where CoolProp has properties
        highest = bisect(excess, lowest, highest, xtol=0.1 * ROUNDING) - ROUNDING
        advice = f"{name} boils at {highest:.2f} K at {p:g} Pa; stay below it or raise the pressure"
    elif above > -p:
        advice = f"{name} does not boil at {p:g} Pa"
    else:
        advice = f"CoolProp does not know where {name} boils"
    return _range(name, T_range, (lowest, highest), advice)


def _one_phase(
    name: str,
    p: float,
    T_range: Sequence[float] | None,
    fluid: Range,
    boiling: Range | None,
) -> tuple[Range, str]:
    """Return the range, and 'liquid' or 'gas' where both exist at this pressure;
    SceneError if it holds both.
    """
    steam = name.lower() == "steam"
    if boiling:
        advice = (
            f"{name} boils at {boiling[0]:.2f} K at {p:g} Pa; stay below it for "
            "liquid or above it for gas"
        )
    else:
        advice = f"{name} does not boil at {p:g} Pa"
    if T_range is None and steam and boiling:
        T_range = (boiling[1], fluid[1])
    lo, hi = _range(name, T_range, fluid, advice)
    if boiling is None:
        return (lo, hi), ""
    if lo >= boiling[1] - ROUNDING:
        return (lo, hi), "gas"
    if hi <= boiling[0] + ROUNDING and not steam:
        return (lo, hi), "liquid"
    raise SceneError(
        f"{name}: T_range ({lo:g}, {hi:g}) K "
        f"{'is not all steam' if steam else 'crosses the phase change'}; {advice}; "
        "evaporation is not modelled"
    )


def _range(
    name: str, T_range: Sequence[float] | None, fluid: Range, advice: str
) -> Range:
    """Return the range; SceneError with an advice if it is missing or leaves that of
    the fluid.
    """
    if T_range is None:
        raise SceneError(
            f"{name}: T_range is missing; give it within ({fluid[0]:g}, {fluid[1]:g}) "
            f"K; {advice}"
        )
    lo, hi = checked_range(T_range, name)
    if lo < fluid[0] or hi > fluid[1]:
        raise SceneError(
            f"{name}: T_range ({lo:g}, {hi:g}) K leaves that of CoolProp, "
            f"({fluid[0]:g}, {fluid[1]:g}) K; narrow it; "
            f"{advice}"
        )
    return lo, hi


def _refined(sample: Any, limits: Range) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return nodes, values, the largest relative error half way between nodes, and
    where it is.

    Intervals that miss the tolerance are halved with their neighbours: that resolves a
    heat capacity peak, or the kink where CoolProp switches off the critical enhancement
    of conductivity, without a fine grid elsewhere.
    """
    from scipy.interpolate import make_interp_spline

    T = np.linspace(*limits, 17)
    values = sample(T)
    while True:
        middle = 0.5 * (T[1:] + T[:-1])
        exact = sample(middle)
        errors = np.max(
            np.abs(make_interp_spline(T, values, k=5)(middle) / exact - 1.0), axis=1
        )
        worst = int(np.argmax(errors))
        split = (
            np.convolve(
                (errors > TOLERANCE) & (np.diff(T) > NARROWEST), np.ones(5), "same"
            )
            > 0.0
        )
        done = not split.any()
        if done:  # the last middles are known already: use them
            split[:] = True
        at = np.flatnonzero(split) + 1
        T, values = (
            np.insert(T, at, middle[split]),
            np.insert(values, at, exact[split], axis=0),
        )
        if done:
            return T, values, float(errors[worst]), float(middle[worst])


def _tables(
    T: np.ndarray, values: np.ndarray, h_start: float
) -> dict[str, tuple[Any, Any]]:
    """Return the value and derivative of every property; enthalpy is the integral of
    heat capacity.
    """
    from scipy.interpolate import PPoly, make_interp_spline

    tables = {}
    for i, name in enumerate(PROPERTIES):
        table = PPoly.from_spline(make_interp_spline(T, values[:, i], k=5))
        inside = slice(
            np.searchsorted(table.x, T[0], "right") - 1,
            np.searchsorted(table.x, T[-1], "left"),
        )
        c, x = table.c[:, inside], table.x[inside.start : inside.stop + 1]
        # One constant piece on each side: what lies beyond it is the same constant.
        ends = np.zeros((6, 2))
        ends[-1] = values[0, i], values[-1, i]
        c = np.hstack([ends[:, :1], c, ends[:, 1:]])
        table = PPoly(c, np.concatenate([[T[0] - 1.0], x, [T[-1] + 1.0]]))
        tables[name] = (table, table.derivative())
        if name == "heat_capacity":
            enthalpy = table.antiderivative()
            enthalpy.c[-1] += h_start - float(enthalpy(T[0]))
            tables["enthalpy"] = (enthalpy, table)
    return tables
