"""The reacting part of a bubbling bed from its scene: unknown gases and solids,
feeds, enthalpies.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.bubbling_bed.chemistry import reactions as cr
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.equations import species as model
from contbed.bubbling_bed.solids import Solid
from contbed.chemistry import devolatilisation as dv
from contbed.chemistry import kinetics
from contbed.chemistry.elements import ATOMIC_WEIGHTS
from contbed.chemistry.laws import species_named
from contbed.chemistry.species import Species
from contbed.chemistry.thermo import R_GAS, T_STANDARD, Thermo
from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.scene.mechanism import find_mechanism
from contbed.scene.reactions import Reaction

CP_VOLATILES = 1500.0  # [J/kg/K]
CP_INERT = 1000.0  # of what is not CaCO3 in limestone [J/kg/K]
LEAST = 1e-6  # surface that a fuel has even when there is none of it [m2/m]


@dataclass(frozen=True)
class FuelData:
    """The constituents of a fuel and their amounts."""

    rate: float  # dry, ash-free [kg/s]
    carbon: float  # fixed [mol/s]
    volatile: float  # [kg/s]
    moisture: float  # [mol/s]
    ash: float  # [kg/s]
    volatiles: dv.Volatiles | None
    heating_value: float  # higher, dry [J/kg]
    # lower, of what is fed per kg of dry, ash-free fuel, moisture not counted [J/kg]
    lower: float
    enthalpy: float  # of formation of the volatile matter [J/kg]
    elements: dict[str, float]  # dry, ash-free [mol/s]

    @property
    def oxygen(self) -> float:
        """Oxygen that burns it completely [mol/s]."""
        n = self.elements
        return n["C"] + 0.25 * n["H"] + n["S"] - 0.5 * n["O"]


def fuel_data(solid: Solid) -> FuelData:
    """Return the amounts fed, the products of the volatile matter and its heat of
    formation.
    """
    fuel, feed = solid.fuel, solid.feed
    assert fuel is not None and feed is not None and feed.mass_flow is not None
    dry = fuel.ultimate.model_dump()
    received = feed.mass_flow
    rate = received * (1.0 - fuel.moisture) * (1.0 - fuel.ash)
    daf = {name: share / (1.0 - fuel.ash) for name, share in dry.items()}
    total = sum(daf.values())
    daf = {name: share / total for name, share in daf.items()}
    higher = fuel.heating_value or dv.heating_value_channiwala(dry, fuel.ash)
    amounts = {name: share / ATOMIC_WEIGHTS[name] for name, share in daf.items()}
    species, T0 = thermo.table(), T_STANDARD
    burnt = {"CO2": amounts["C"], "H2O(l)": 0.5 * amounts["H"], "SO2": amounts["S"]}
    formation = sum(
        n * float(species[name].enthalpy(T0)) for name, n in burnt.items()
    ) + higher / (1.0 - fuel.ash)
    vapour = float(species["H2O"].enthalpy(T0) - species["H2O(l)"].enthalpy(T0))
    V = fuel.volatile_matter
    return FuelData(
        rate,
        rate * (1.0 - V) / ATOMIC_WEIGHTS["C"],
        rate * V,
        received * fuel.moisture / species["H2O"].molar_mass,
        solid.fed_solids,
        dv.volatiles(daf, V) if V else None,
        higher,
        higher / (1.0 - fuel.ash) - 0.5 * amounts["H"] * vapour,
        formation / V if V else 0.0,
        {name: rate * n for name, n in amounts.items()},
    )


def gas_reactions(scene: Any) -> list[cr.OfGases]:
    """Return the reactions of gases that the scene switches on.

    Raises
    ------
    SceneError : data of a gas are missing, or it is not clear in which particles a
        reaction runs
    """
    tables: dict[str, Reaction] = scene.reactions.of_gases
    found = []
    for name, table in tables.items():
        named = sorted(species_named(name, table))
        gases = {each: species_of(scene, each) for each in named}
        for reaction in kinetics.reactions_of(name, table, Species(gases, {})):
            place = _place(scene, name, table) if reaction.site == "particle" else None
            found.append(
                cr.OfGases(
                    reaction,
                    scene.bubbling_bed.mixing_time,
                    1.0 - scene.bubbling_bed.solids_fraction,
                    place,
                )
            )
    return found


def species_of(scene: Any, name: str) -> Thermo:
    """Return the thermodynamics of a gas of the scene.

    Raises
    ------
    SceneError : there are none
    """
    return thermo.gas(name, find_mechanism(scene.mixture.mechanism, scene.origin.base))


def _place(scene: Any, name: str, table: Reaction) -> cr.Place:
    """Return the particles in which a reaction of gases runs."""
    phase = table.solid if isinstance(table.solid, str) else None
    if phase is None and len(scene.present) == 1:
        phase = next(iter(scene.present))
    if phase is None or phase not in scene.present:
        raise SceneError(
            f"{scene.origin.at(('reactions', name))}: reactions.{name}.solid: it runs "
            f"in particles; name one phase, of {', '.join(scene.present)}"
        )
    solid = scene.solids[phase]
    return cr.Place(phase, solid.volume_share, solid.diameter, solid.density)


def reactions_of(scene: Any, data: FuelData | None) -> tuple[Any, ...]:
    """Return all reactions that the scene switches on."""
    table = scene.reactions
    out: list[Any] = list(gas_reactions(scene))
    if (name := scene.fuel) is not None and data is not None:
        fuel = scene.solids[name].fuel
        if table.drying is not None and data.moisture:
            yields: Mapping[str, float] = {"H2O": 1.0}
            time = table.drying.time
            out.append(cr.Release("drying", name, "moisture", time, yields))
        if table.devolatilisation is not None and data.volatiles is not None:
            yields, time = data.volatiles.yields, table.devolatilisation.time
            out.append(cr.Release("devolatilisation", name, "volatiles", time, yields))
        if table.of_char:
            diameter = fuel.char_diameter or scene.solids[name].diameter
            laws = {
                key: (cr.law_of(key, item), item) for key, item in table.of_char.items()
            }
            out.append(
                cr.Char(
                    name,
                    diameter,
                    fuel.char_density,
                    fuel.char_model,
                    fuel.sherwood,
                    laws,
                )
            )
    if (stone := scene.limestone) is not None:
        item = scene.solids[stone]
        taking, giving = table.sulphation, table.sulphate_reduction
        out.append(
            cr.Lime(
                stone,
                item.diameter,
                item.density,
                table.calcination and table.calcination.factor,
                taking and taking.factor,
                taking.maximum_conversion if taking else 1.0,
                giving and giving.rate_constant,
            )
        )
    return tuple(out)


def gases_of(
    reactions: tuple[Any, ...], inlet: dict[str, float]
) -> tuple[tuple[str, ...], tuple[Any, ...]]:
    """Return the gases that enter or are made, and the reactions whose reactants are
    all present.
    """
    there, running = set(inlet), []
    while True:
        found = [
            item
            for item in reactions
            if item not in running and getattr(item, "needs", set()) <= there
        ]
        if not found:
            break
        running += found
        for item in found:
            there |= item.makes
    known = [name for name in thermo.GASES if name in there]
    others = sorted(there - set(known))
    return (*known, *others), tuple(item for item in reactions if item in running)


@dataclass(eq=False)
class Mixture:
    """Gas of the local composition; viscosity and conductivity are those of the
    entering gas.
    """

    entering: Any
    molar_mass: Any
    mole: Mapping[str, Any]  # moles per kg of mixture
    gases: Mapping[str, Thermo]

    @classmethod
    def of(
        cls, entering: Any, moles: Mapping[str, Any], gases: Mapping[str, Thermo]
    ) -> Mixture:
        """Return the gas of these moles, or of these flows of moles."""
        mass = sum(gases[name].molar_mass * n for name, n in moles.items())
        per_kg = {name: n / mass for name, n in moles.items()}
        return cls(entering, mass / sum(moles.values()), per_kg, gases)

    @property
    def pressure(self) -> float:
        """Pressure [Pa]."""
        return float(self.entering.pressure)

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3]."""
        return self.pressure * self.molar_mass / (R_GAS * T)

    def viscosity(self, T: Any) -> Any:
        """Return the viscosity [Pa s]."""
        return self.entering.viscosity(T)

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K]."""
        return self.entering.conductivity(T)

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K]."""
        gases = self.gases
        return sum(n * gases[name].heat_capacity(T) for name, n in self.mole.items())

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy, heat of formation included [J/kg]."""
        gases = self.gases
        return sum(n * gases[name].enthalpy(T) for name, n in self.mole.items())


@dataclass(frozen=True)
class Chemistry:
    """The `Part` of a scene that reacts, with its gases, feeds and reactions."""

    part: model.Species
    data: FuelData | None
    reactions: tuple[Any, ...]
    idle: tuple[str, ...]  # reactions of the scene that lack a reactant
    height: float
    inlet_flow: float  # of all gas [mol/s]

    def start(self, T: float, z: Any, flows: dict[str, float]) -> dict[str, Any]:
        """Return the first guess of all fields for one temperature [K] and mass
        `flows` of the phases [kg/s].
        """
        part, out = self.part, {}
        mean = part.inlet_molar_mass
        for phase in part.phases:
            for name in part.gases:
                out[f"N_{name}_{phase}"] = (
                    flows[phase] / mean * part.inlet.get(name, 0.0)
                )
        for name, solid in part.solids.items():
            out[f"n_{name}"] = solid.typical + 0.0 * z
        return out

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the reactions that run."""
        return tuple(name for item in self.reactions for name in item.names)

    @property
    def sizes(self) -> dict[str, float]:
        """Typical values of the unknown fields."""
        flows = {
            f"N_{name}_{phase}": self.inlet_flow
            for phase in self.part.phases
            for name in self.part.gases
        }
        return flows | {
            f"n_{name}": solid.typical for name, solid in self.part.solids.items()
        }

    def surfaces(self, u: Any) -> dict[str, Any]:
        """Return the surface of the fuel per height [m2/m]: char at any burnout, and
        fuel not yet char.
        """
        out: dict[str, Any] = {}
        for item in self.reactions:
            if isinstance(item, cr.Char):
                out[item.species] = LEAST + item.surface * u.n_char
                if "volatiles" in self.part.solids:
                    out[item.species] = (
                        out[item.species]
                        + 6.0 / (item.diameter * item.density) * u.n_volatiles
                    )
        return out

    def mixtures(self, u: Any, entering: Any) -> dict[str, Mixture]:
        """Return the gas of each phase; the entering gas where mole flows are not
        known.
        """
        part = self.part
        known = part.known(u)
        return {
            phase: Mixture.of(
                entering, part.flow(u, phase) if known else part.inlet, part.gases
            )
            for phase in part.phases
        }


def chemistry(scene: Any, mixing: dict[str, Any], exchange: Any) -> Chemistry:
    """Build the reacting part of a scene; `mixing` and `exchange` are functions of
    the bed's local coefficients.
    """
    inlet = mole_fractions(scene.mixture.composition)
    data = fuel_data(scene.solids[scene.fuel]) if scene.fuel is not None else None
    wanted = reactions_of(scene, data)
    names, running = gases_of(wanted, inlet)
    idle = tuple(
        item.name
        for item in wanted
        if isinstance(item, cr.OfGases) and item not in running
    )
    gases = {name: species_of(scene, name) for name in names}
    bed = scene.bubbling_bed
    drain = bed.drain
    velocity = (
        0.0
        if drain is None
        else bed.height / drain.time * (1.0 if drain.end == "top" else -1.0)
    )
    mean = sum(gases[name].molar_mass * x for name, x in inlet.items())
    moles = scene.gas_flow / mean
    solids, ash = _solids(scene, data, running, inlet)
    part = model.Species(
        gases,
        ("emulsion", "bubble") if bed.bubbling else ("emulsion",),
        inlet,
        scene.mixture.pressure,
        bed.section,
        1.0 - bed.solids_fraction,
        solids,
        ash,
        velocity,
        mixing,
        running,
        exchange,
        scene.solver.degree,
    )
    return Chemistry(part, data, running, idle, bed.height, moles)


def _solids(
    scene: Any,
    data: FuelData | None,
    running: tuple[Any, ...],
    inlet: dict[str, float],
) -> tuple[dict[str, model.Solid], tuple[model.Ash, ...]]:
    """Return the constituents of fuel and limestone, and the ash of both."""
    bed, species = scene.bubbling_bed, thermo.table()
    kept = np.inf if bed.drain is None else bed.drain.time
    solids: dict[str, model.Solid] = {}
    ash: list[model.Ash] = []

    def fed(phase: str, rate: float) -> Callable[[Any], Any]:
        share, _ = scene.solids[phase].feed.shares(bed.height)
        return lambda z: rate * share(z)

    def add(
        phase: str, name: str, enthalpy: Any, rate: float, held: float, scale: float
    ) -> None:
        solids[name] = model.Solid(
            phase,
            enthalpy,
            fed(phase, rate) if rate else None,
            scene.solids[phase].feed.temperature,
            scale,
            held / bed.height,
        )

    def add_ash(phase: str, rate: float, heat_capacity: float) -> None:
        if rate:
            T = scene.solids[phase].feed.temperature
            enthalpy = _linear(0.0, heat_capacity)
            ash.append(model.Ash(phase, fed(phase, rate), T, enthalpy))

    if (fuel := scene.fuel) is not None and data is not None:
        times = {
            item.constituent: item.time
            for item in running
            if isinstance(item, cr.Release)
        }
        times["char"] = min(_burnout(scene, running, inlet), kept)
        matter = _linear(data.enthalpy, CP_VOLATILES)
        for name, enthalpy, rate, scale in (
            ("moisture", species["H2O(l)"].enthalpy, data.moisture, 1.0),
            ("volatiles", matter, data.volatile, 40.0),
            ("char", species["C"].enthalpy, data.carbon, 1.0),
        ):
            if rate:
                add(fuel, name, enthalpy, rate, rate * times.get(name, kept), scale)
        add_ash(fuel, data.ash, scene.solids[fuel].fuel.ash_heat_capacity)
    if (stone := scene.limestone) is not None:
        flow = scene.solids[stone].feed.mass_flow
        purity = scene.solids[stone].limestone.purity
        rate = flow * purity / species["CaCO3"].molar_mass
        for name, part in (("CaCO3", 0.1), ("CaO", 0.7), ("CaSO4", 0.2)):
            enters = rate if name == "CaCO3" else 0.0
            add(stone, name, species[name].enthalpy, enters, part * rate * kept, 1.0)
        add_ash(stone, flow * (1.0 - purity), CP_INERT)
    return solids, tuple(ash)


def _linear(formation: float, heat_capacity: float) -> Callable[[Any], Any]:
    return lambda T: formation + heat_capacity * (T - T_STANDARD)


def _burnout(scene: Any, running: tuple[Any, ...], inlet: dict[str, float]) -> float:
    """Return the burnout time of char [s] in a half exhausted gas at the temperature of
    the guess.

    It is only used for the first guess of the inventory.
    """
    T, p = scene.initial.temperature, scene.mixture.pressure
    for item in running:
        if isinstance(item, cr.Char):
            rate = 0.0
            if "char_combustion" in item.reactions and "O2" in inlet:
                rate += float(
                    item.combustion_rate(T, T, 0.5 * inlet["O2"] * p / (R_GAS * T), p)
                )
            x = dict.fromkeys(thermo.GASES, 0.0) | {"H2O": 0.1, "CO2": 0.1}
            rate += sum(
                max(float(item.gasification_rate(name, T, T, x, p)), 0.0)
                for name in item.reactions
                if name != "char_combustion"
            )
            return 1.0 / max(rate, 1e-5)
    return 1e3
