"""The state of a two-fluid bed: a value, from which a step makes another one.

All arrays are in the order of the grid, for nc cells, nf faces and dim directions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.fv.halo import Halo
from contbed.two_fluid.rheology import Rheology

Value = TypeVar("Value")


class Fluxes(NamedTuple):
    """Volume fluxes [m3/s] through faces (nf,), and rates [1/s] at which the velocity
    of a phase empties cells (nc,).

    solid, total : of the solids and of both phases together, with which the next step
        starts
    moved : of the solids, with which the last step moved them after limits
    outflow_gas, outflow_solid : for the Courant numbers
    """

    solid: Array
    total: Array
    moved: Array
    outflow_gas: Array
    outflow_solid: Array


class ForceGradients(NamedTuple):
    """Gradients (nc, dim) of p, of kinetic pressure over rho_s, and of the potential at
    rest; zero on orthogonal grids.

    The potential at rest is h + p/rho_s - gravity . x, uniform where particles rest on
    each other.
    """

    p: Array
    kinetic: Array
    rest: Array


class Memory(NamedTuple):
    """Rates, accelerations and gradients of the last step that the next step uses.

    rate_gas, rate_solid (nc, dim) [m/s2], rate_eps_s (nc, 1) [1/s], rate_theta (nc,
    1) [m2/s3] : rates of change
        without convection, for the predictor of half a step
    force_gas, force_solid (nc, dim) [m/s2] : accelerations by pressure, drag and
        gravity
    face_residual (nf,) [m/s] : normal velocity of the gas less the interpolated cell
        velocity, as in Rhie-Chow
    gradients : of the forces, with which the next step extrapolates boundary values
    heating_rate [1/s] : 1 over the longest step that is stable with the heat of
        compression and shear
    """

    rate_gas: Array
    rate_solid: Array
    rate_eps_s: Array
    rate_theta: Array
    force_gas: Array
    force_solid: Array
    face_residual: Array
    gradients: ForceGradients
    heating_rate: float


class Properties(NamedTuple):
    """Closures at one state.

    K = beta/eps_s (nc,) [kg/m3/s], the rheology of the particles, and the frictional
    viscosity (nc,) [Pa s].
    """

    drag: Array
    rheology: Rheology
    mu_friction: Array


class Account(NamedTuple):
    """Volumes [m3] of solids and gas that came in and went out."""

    solid_in: float = 0.0
    solid_out: float = 0.0
    gas_in: float = 0.0
    gas_out: float = 0.0


class HeatAccount(NamedTuple):
    """Heat [J] that came in and went out with the phases and through walls; gas [kg]
    that came in and went out.
    """

    heat_in: float = 0.0
    heat_out: float = 0.0
    walls: float = 0.0
    gas_in: float = 0.0
    gas_out: float = 0.0


class Counters(NamedTuple):
    """How often limiters and guards acted."""

    limited_faces: int = 0
    limited_steps: int = 0
    limiter_rounds: int = 0
    packing_rounds: int = 0
    theta_upwind_cells: int = 0
    theta_clipped_cells: int = 0

    def add(self, **more: int) -> Counters:
        """Return these counters and some more."""
        return self._replace(
            **{name: getattr(self, name) + number for name, number in more.items()}
        )


class WallMemory(NamedTuple):
    """What walls have done since the start.

    heat, heat_if_mixed (nf,) [J] : into the bed, and as it were if all that enters the
        cell beside a wall mixed with the layer there at once
    layers, mixed (nc, columns) [K] : temperatures of both, see heat.wall_layer; None
        without walls of a given temperature
    """

    heat: Array
    heat_if_mixed: Array
    layers: Array | None
    mixed: Array | None


NOTHING, NO_HEAT, NEVER = Account(), HeatAccount(), Counters()


@dataclass(frozen=True)
class Energy:
    """Temperatures of both phases and what belongs to them.

    T_gas, T_solid (nc,) [K]
    mass (nc,) [kg/m3] : of the gas per volume of the bed
    rate_gas, rate_solid (nc, 1) [K/s] : rates of change without convection
    rho_ratio (nc,) : density of the gas over the usual one
    expansion (nc,) [1/s] : source of gas volume
    closing [s] : time in which what mass, temperature and volume leave open goes with
        it: a step or, after a much longer one, what is left of that, as hurry would
        make the next step shorter still
    p0 [Pa] : thermodynamic pressure
    walls : None in a bed without walls that heat or cool
    """

    T_gas: Array
    T_solid: Array
    mass: Array
    rate_gas: Array
    rate_solid: Array
    rho_ratio: Array
    expansion: Array
    closing: float
    p0: float
    walls: WallMemory | None = None
    account: HeatAccount = NO_HEAT


@dataclass(frozen=True)
class State:
    """Fields of a bed, and everything else that the next step depends on.

    eps_s, theta [m2/s2], p [Pa] (nc,), u_gas, u_solid (nc, dim) [m/s] : fields
    properties : closures of the last step, with its rheology
    energy : None for an isothermal bed
    wall_force_gas, wall_force_solid [N] : of the walls on each phase along the last
        axis in the last step
    time, dt [s], steps : now, the last step, and their number; dt_wanted : the step
    that the last one was cut from
    account, counters : what crossed the boundary; how often limiters acted
    """

    eps_s: Array
    u_gas: Array
    u_solid: Array
    theta: Array
    p: Array
    fluxes: Fluxes
    memory: Memory
    properties: Properties
    energy: Energy | None = None
    wall_force_gas: float = 0.0
    wall_force_solid: float = 0.0
    time: float = 0.0
    dt: float = 0.0
    dt_wanted: float = 0.0
    steps: int = 0
    account: Account = NOTHING
    counters: Counters = NEVER

    def fields(self) -> dict[str, Array]:
        """Fields by name."""
        found = {
            "eps_s": self.eps_s,
            "u_gas": self.u_gas,
            "u_solid": self.u_solid,
            "theta": self.theta,
            "p": self.p,
        }
        return (
            found
            if self.energy is None
            else found | {"T_gas": self.energy.T_gas, "T_solid": self.energy.T_solid}
        )

    def with_fields(self, given: Mapping[str, Any]) -> State:
        """Return the same state with other fields, arrays or numbers by name."""
        known = self.fields()
        new = known | {name: np.empty_like(known[name]) for name in given}
        for name, values in given.items():
            new[name][...] = values
        energy = (
            None
            if self.energy is None
            else replace(self.energy, T_gas=new["T_gas"], T_solid=new["T_solid"])
        )
        eps_s, u_gas, u_solid, theta, p = (
            new[name] for name in ("eps_s", "u_gas", "u_solid", "theta", "p")
        )
        return replace(
            self,
            eps_s=eps_s,
            u_gas=u_gas,
            u_solid=u_solid,
            theta=theta,
            p=p,
            energy=energy,
        )


def fastest_gas(state: State, halo: Halo) -> float:
    """Return the largest rate [1/s] at which the velocity of the gas empties a cell."""
    outflow = state.fluxes.outflow_gas[halo.cells]
    return halo.max(float(np.max(outflow, initial=0.0)))


def booked(
    account: Value, dt: float, crossing: Sequence[Array | float], grid: Grid
) -> Value:
    """Return an account with what comes in and what goes out in `dt` [s] by outward
    fluxes (nf,) of the faces of the boundary; numbers among them are added.
    """
    more: list[float] = []
    for flux in crossing:
        if isinstance(flux, np.ndarray):
            outward = flux[grid.interior :][grid.halo.edges]
            more.append(-dt * float(np.sum(outward, where=outward < 0)))
            more.append(dt * float(np.sum(outward, where=outward > 0)))
        else:
            more.append(flux)
    before: Any = account
    crossed = zip(before, grid.halo.sum(*more), strict=True)
    return type(account)(*(one + other for one, other in crossed))


def zero_state(grid: Grid) -> State:
    """State of an empty vessel without motion."""
    nc, nf, dim = len(grid.cells), grid.face_count, grid.dimension

    def scalar() -> Array:
        return np.zeros(nc)

    def vector() -> Array:
        return np.zeros((nc, dim), order=grid.order)

    gradients = ForceGradients(vector(), vector(), vector())
    rates = np.zeros((nc, 1)), np.zeros((nc, 1))
    memory = Memory(
        vector(), vector(), *rates, vector(), vector(), np.zeros(nf), gradients, 0.0
    )
    fluxes = Fluxes(np.zeros(nf), np.zeros(nf), np.zeros(nf), scalar(), scalar())
    properties = Properties(
        scalar(), Rheology(*(scalar() for _ in Rheology._fields)), scalar()
    )
    return State(
        scalar(), vector(), vector(), scalar(), scalar(), fluxes, memory, properties
    )


def check_finite(state: State, grid: Grid) -> None:
    """Check all fields.

    Raises
    ------
    ConvergenceError : a field is not finite; with its name, the cell and its place
    """
    halo, message = grid.halo, ""
    for name, everywhere in state.fields().items():
        values = everywhere[halo.cells]
        if (
            not message
            and not np.isfinite(values.sum())
            and (wrong := ~np.isfinite(values)).any()
        ):
            cell = int(np.flatnonzero(wrong.reshape(len(values), -1).any(axis=1))[0])
            place = ", ".join(f"{v:.4g}" for v in grid.centres[cell])
            message = (
                f"t = {state.time:.6g} s, step {state.steps}: {name} is not finite in "
                f"cell {int(grid.cells[cell])} at "
                f"({place}) m; reduce the Courant number, or look at the closures and "
                "boundaries there"
            )
    if message := halo.first(message):
        raise ConvergenceError(message)


def flatten(value: Any, name: str = "state") -> dict[str, Any]:
    """Arrays and numbers of a state by dotted names, for a checkpoint; None is left
    out.
    """
    found: dict[str, Any] = {}
    for key, part in _parts(value).items():
        if _parts(part):
            found |= flatten(part, f"{name}.{key}")
        elif part is not None:
            found[f"{name}.{key}"] = part
    return found


def rebuild(like: Value, saved: Mapping[str, Any], name: str = "state") -> Value:
    """Return the state that was flattened into `saved`, bit for bit; `like` is any
    state of the same model.
    """
    parts = _parts(like)
    if parts:
        return type(like)(
            **{
                key: rebuild(part, saved, f"{name}.{key}")
                for key, part in parts.items()
            }
        )
    if like is None:
        return like
    if isinstance(like, np.ndarray):
        return np.asarray(saved[name])  # type: ignore[return-value]
    return type(like)(saved[name])  # type: ignore[call-arg]


def _parts(value: Any) -> dict[str, Any]:
    if is_dataclass(value) and not isinstance(value, type):
        return {part.name: getattr(value, part.name) for part in fields(value)}
    return value._asdict() if hasattr(value, "_asdict") else {}
