"""What the equations of a bubbling bed read at a point: streams, species, surfaces,
coefficients, and further parts.

Symbols and units are those of `equations.bed`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from contbed.radiation.equations.p1 import emitted


def capacity_flow_enthalpy(T: Any) -> Any:
    """Return the enthalpy of a stream whose flow is a capacity flow."""
    return T


def unit_heat_capacity(T: Any) -> Any:
    """Return the heat capacity of a stream whose flow is a capacity flow."""
    return 1.0


@dataclass(frozen=True)
class Stream:
    """One phase with a temperature field; its functions work on pointwise values."""

    # W, function of z [kg/s, or W/K where the enthalpy is T]; None for a gas of
    # computed flow
    flow: Any = None
    fed: Any = None  # W', function of z; None without feed
    feed_temperature: float = 0.0  # [K]
    conduction: float = 0.0  # A k [W m/K]
    release: Any = None  # Q, function of (z, T) [W/m]; None without
    enthalpy: Any = capacity_flow_enthalpy  # of particles, function of T [J/kg]
    heat_capacity: Any = unit_heat_capacity  # [J/kg/K]


@dataclass(frozen=True)
class Species:
    """One kind of particle."""

    stream: Stream
    gas: float  # a_m h_gm [W/m3/K]
    share: float  # f_m [1]
    absorption: float = 0.0  # K_a,m [1/m]
    emissivity: float = 1.0


@dataclass(frozen=True)
class Surface:
    """Tubes or walls."""

    perimeter: float  # [m]
    coefficient: float  # [W/m2/K]
    temperature: float  # [K]
    emissivity: float  # effective [1]; 0 for a mirror
    field: str | None = None  # unknown temperature, in place of the given one

    def surface_temperature(self, u: Any) -> Any:
        """Return the temperature of the surface [K]."""
        return self.temperature if self.field is None else getattr(u, self.field)

    def radiated(self, u: Any, G: Any) -> Any:
        """Return the radiation into the surface in a field G [W/m]."""
        return (
            0.25
            * self.perimeter
            * self.emissivity
            * (G - emitted(self.surface_temperature(u)))
        )


@dataclass(frozen=True)
class Plate:
    """The distributor."""

    coefficient: float  # h_d [W/m2/K]
    effectiveness: float  # 1 - exp(-NTU) [1]
    emissivity: float  # [1]; 0 for a mirror


@dataclass
class Local:
    """Coefficients at the points of one domain: numbers, arrays, or functions of the
    unknowns as dual numbers.
    """

    delta: Any
    gas: dict[str, Any]  # a_m h_gm [W/m3/K]
    conduction: dict[str, Any]  # A k_m [W m/K]
    pairs: dict[tuple[str, str], Any]  # H_mn [W/m3/K]
    exchange: Any  # H_be [W/m3/K]
    contact: dict[str, Any]  # h_x [W/m2/K]
    flows: dict[str, Any]  # W of the gases
    slopes: dict[str, Any]  # W' of the gases
    crossing: Any = None  # X; None where gas cannot pass
    # of the gases, functions of T [J/kg]; absent: T
    enthalpy: dict[str, Any] = field(default_factory=dict)
    heat_capacity: dict[str, Any] = field(default_factory=dict)  # [J/kg/K]
    gas_flow: Any = None  # bubbling_flow.Local; None where no flow is an unknown
    # velocities, properties: what parts may build upon
    state: dict[str, Any] = field(default_factory=dict)
    # (W h)' at constant T of gases whose composition changes
    changes: dict[str, Any] = field(default_factory=dict)
    # surface of species over that which absorption is for
    shares: dict[str, Any] = field(default_factory=dict)

    def h(self, name: str, T: Any) -> Any:
        """Return the enthalpy of a gas [J/kg]."""
        return self.enthalpy.get(name, capacity_flow_enthalpy)(T)

    def changed(self, name: str, T: Any) -> Any:
        """Return W' h of a gas [W/m], or (W h)' at constant T where its composition
        changes.
        """
        return (
            self.changes[name](T)
            if name in self.changes
            else self.slopes[name] * self.h(name, T)
        )


class Part:
    """Physics added to the bed: its own unknown fields, and its source terms in the
    balances of the bed.

    `fields` are the names of the unknowns along the height. `scalars`, if there are
    any, are unknowns of one number each.
    """

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the unknowns along the height."""
        raise NotImplementedError

    def gains(self, u: Any, c: Any, local: Local, o: Any) -> dict[str, Any]:
        """Return the heat per height [W/m] by the field of the phase; gas that is
        made brings its enthalpy.
        """
        return {}

    def residual(self, u: Any, tests: Any, c: Any, local: Local, o: Any) -> Any:
        """Return the weak form of the part's balances along the height."""

    def bottom(self, u: Any, tests: Any, c: Any, local: Local, o: Any) -> Any:
        """Return the weak form of its conditions at the distributor."""

    def top(self, u: Any, tests: Any, c: Any, local: Local, o: Any) -> Any:
        """Return the weak form of its conditions at the surface of the bed."""

    def content(self, u: Any, tests: Any, c: Any, o: Any) -> Any:
        """Return the tested content of the part, by which a steady state is
        approached in time.
        """


@dataclass(frozen=True)
class Coefficients:
    """The coefficients of the whole bed.

    `bubbles` and `plate` are None where absent. `level` is "none", "paper", "pairwise",
    or "field" where G is an unknown with diffusion coefficient `diffusion` [m]. With
    `computed`, a function of (unknowns, ops) that returns `Local`, the numbers of the
    same name only serve to grade the mesh.
    """

    section: float  # A [m2]
    delta: float
    inlet: float  # T_in [K]
    species: dict[str, Species]
    pairs: dict[tuple[str, str], float]  # H_mn [W/m3/K]
    emulsion: Stream
    bubbles: Stream | None
    exchange: float  # H_be [W/m3/K]
    surfaces: dict[str, Surface]
    plate: Plate | None
    level: str
    diffusion: float = 0.0
    radiosity: float | None = None  # J; None for a mirror
    degree: int = 2
    computed: Any = None
    albedo: float | None = None  # of the emulsion; None where nothing radiates
    extra: tuple[str, ...] = ()  # fields of bubbling_flow
    parts: tuple[Part, ...] = ()

    @property
    def chemistry(self) -> Any:
        """The reacting part, None where nothing reacts."""
        return getattr(self.computed, "chemistry", None)

    @property
    def above(self) -> Any:
        """The freeboard, None where none is solved for."""
        return getattr(self.computed, "above", None)

    @property
    def scalars(self) -> tuple[str, ...]:
        """Unknowns that are one number each."""
        plate = ("T_distributor",) if self.plate is not None else ()
        return (
            *plate,
            *(name for part in self.parts for name in getattr(part, "scalars", ())),
        )

    def at(self, u: Any, o: Any) -> Local:
        """Return the coefficients at the points of a domain."""
        if self.computed is not None:
            local: Local = self.computed(u, o)
            return local
        gases = {name: self.streams[name].flow(o.x[0]) for name in self.gases}
        return Local(
            self.delta,
            {name: item.gas for name, item in self.species.items()},
            {name: item.stream.conduction for name, item in self.species.items()},
            self.pairs,
            self.exchange,
            {name: x.coefficient for name, x in self.surfaces.items()},
            gases,
            dict.fromkeys(gases, 0.0),
        )

    def volume(self, local: Local) -> Any:
        """Return the emulsion volume per height, A (1 - delta) [m2]."""
        return self.section * (1.0 - local.delta)

    @property
    def streams(self) -> dict[str, Stream]:
        """All phases by the name of their field."""
        out = {f"T_{name}": item.stream for name, item in self.species.items()} | {
            "T_emulsion": self.emulsion
        }
        return out if self.bubbles is None else out | {"T_bubble": self.bubbles}

    @property
    def gases(self) -> tuple[str, ...]:
        """Fields of the streams that enter through the distributor."""
        return ("T_emulsion",) if self.bubbles is None else ("T_emulsion", "T_bubble")

    @property
    def fields(self) -> tuple[str, ...]:
        """All fields along the height."""
        radiation = ("G",) if self.level == "field" else ()
        return (
            *self.streams,
            *radiation,
            *self.extra,
            *(name for part in self.parts for name in part.fields),
        )
