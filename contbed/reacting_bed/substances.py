"""Species of the gas and constituents of the solids, with their data, from a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contbed.closures.reactions import stoichiometry
from contbed.errors import SceneError
from contbed.materials.common import nearest
from contbed.materials.composition import mole_fractions, names_in
from contbed.materials.elements import elements_of, molar_mass_of
from contbed.materials.mixture import GasTransport, Mechanism, dippr102, fuller_pair
from contbed.materials.thermo import (
    T_STANDARD,
    ConstantHeatCapacity,
    Shomate,
    Thermo,
    species_of,
)
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import CompositionSeries
from contbed.reacting_bed.laws import LAWS_WITH_EQUATION
from contbed.scene.mechanism import find_mechanism

# [J/mol/K] of a species without data in an isothermal bed, where it has no meaning
INERT_CAPACITY = 1.0
# coefficients after which F, the constant of the enthalpy, follows
FORMATION_SHOMATE = 5


@dataclass(frozen=True)
class Equation:
    """Moles of each species made per mole of a reaction, and whether it is
    reversible.
    """

    stoichiometry: Mapping[str, float]
    reversible: bool

    @classmethod
    def of(cls, text: str) -> Equation:
        """Read "CH4 + 12 Fe2O3 -> 8 Fe3O4 + CO2 + 2 H2O"; SceneError says what is
        wrong.
        """
        if text.replace("<->", "->").count("->") != 1:
            raise SceneError(
                'needs one arrow: "CO + H2O <-> CO2 + H2", or -> where it does not run '
                "back"
            )
        try:
            found = stoichiometry(text)
        except ValueError as error:
            raise SceneError(
                f"cannot be read ({error}); write numbers before names, with spaces"
            ) from None
        if any(not name or " " in name for name in found):
            raise SceneError(
                'cannot be read; write it like "CH4 + 2 O2 -> CO2 + 2 H2O", with '
                "spaces around +"
            )
        return cls(
            {name: count for name, count in found.items() if count}, "<->" in text
        )


def equations_of(name: str, reaction: s.Reaction) -> dict[str, Equation]:
    """Return the equations that a table of a reaction stands for, by name; a law
    with stages has several.
    """
    if reaction.equation is not None:
        return {name: Equation.of(reaction.equation)}
    found = LAWS_WITH_EQUATION.get(reaction.law or "") or LAWS_WITH_EQUATION.get(
        f"{name}.{reaction.law}"
    )
    if found is None:
        raise SceneError("the equation is missing")
    if isinstance(found, str):
        return {name: Equation.of(found)}
    return {f"{name}_{k + 1}": Equation.of(text) for k, text in enumerate(found)}


@dataclass(frozen=True)
class Species:
    """Gases, and the constituents of the solids of one place, by name."""

    gases: dict[str, Thermo]
    solids: dict[str, Thermo]

    @property
    def all(self) -> dict[str, Thermo]:
        """Gases and solids by name."""
        return self.gases | self.solids

    @property
    def enthalpies(self) -> dict[str, Any]:
        """Enthalpies of gases and solids by name, functions of T [K]."""
        return {name: item.enthalpy for name, item in self.all.items()}


@dataclass(frozen=True)
class PhaseSpecies(Species):
    """Species of one solid phase.

    suffix : ends names of its constituents in the whole bed; "" for the only phase
    fed : mass fractions where its particles enter
    densities : of constituents without pores [kg/m3]
    """

    suffix: str
    fed: dict[str, float]
    densities: dict[str, float]

    def full(self, name: str) -> str:
        """Return the name in the whole bed of a constituent or reaction of this
        phase.
        """
        return name + self.suffix


@dataclass(frozen=True)
class Substances(Species):
    """All species of a scene; `solids` with the suffix of their phase.

    transport : properties of the gas; None where they are not known
    phases : species of each solid phase
    """

    transport: GasTransport | None
    phases: Mapping[str, PhaseSpecies]

    @property
    def molar_masses(self) -> dict[str, float]:
        """Molar masses of the gases by name [kg/mol]."""
        return {name: item.molar_mass for name, item in self.gases.items()}

    @property
    def plain(self) -> Species:
        """The same species, constituents by their names without a suffix."""
        return Species(
            self.gases,
            {
                name: item
                for each in self.phases.values()
                for name, item in each.solids.items()
            },
        )


def fed_to(table: s.Solid) -> dict[str, float]:
    """Return the mass fractions of a solid phase where it enters."""
    return {} if table.composition is None else mole_fractions(table.composition)


def phases_named(table: s.Reaction) -> tuple[str, ...]:
    """Return the solid phases that a reaction names."""
    return (table.solid,) if isinstance(table.solid, str) else table.solid or ()


def constituents_of(phases: Mapping[str, s.Solid]) -> dict[str, s.Substance]:
    """Return the data of constituents by name, which hold in all solid phases."""
    return {
        name: data
        for table in phases.values()
        for name, data in table.constituent.items()
    }


def mechanism_of(scene: s.ReactingScene) -> Mechanism | None:
    """Return the mechanism that a scene takes its gases from."""
    gas = scene.gas
    if not isinstance(gas, s.GasCantera):
        return None
    return Mechanism.read(find_mechanism(gas.mechanism, scene.origin.base))


def species_without_phases(
    scene: s.ReactingScene,
) -> tuple[Species, GasTransport | None]:
    """Return the species of a scene, those that enter and those that reactions name,
    and properties of the gas.

    Raises
    ------
    SceneError : data of a species are missing
    """
    mechanism = mechanism_of(scene)
    gas_names, solid_names = _names(scene, mechanism)
    needs_heat = scene.heat is not None
    gases = {name: _gas(name, scene.gas, mechanism, needs_heat) for name in gas_names}
    data = constituents_of(scene.solids)
    solids = {
        name: _constituent(name, data.get(name), needs_heat) for name in solid_names
    }
    return Species(gases, solids), _transport(scene, gases, mechanism)


def _names(
    scene: s.ReactingScene, mechanism: Mechanism | None
) -> tuple[list[str], list[str]]:
    """Return the names of gases and of constituents of solids.

    Raises
    ------
    SceneError : a species is neither
    """
    gas, phases = scene.gas, scene.solids
    fed = dict.fromkeys(name for table in phases.values() for name in fed_to(table))
    equations = [
        e
        for name, table in scene.reactions.items()
        for e in equations_of(name, table).values()
    ]
    named = {name for equation in equations for name in equation.stoichiometry}
    named |= {name for table in scene.reactions.values() for name in table.orders or {}}
    known_solids = set(fed) | set(constituents_of(phases))
    solids = [name for name in [*fed, *sorted(named)] if name in known_solids]
    gases: list[str] = []
    tables = condensed_names() if fed else ()
    at_start = None if scene.time is None else scene.initial.gas.composition
    filling = [] if at_start is None else mole_fractions(at_start)
    columns = _gases_of_file(scene)
    for name in [*entering_gases(scene), *filling, *columns, *sorted(named)]:
        if name in solids or name in gases:
            continue
        if name in gas.species or (mechanism is not None and name in mechanism.names):
            gases.append(name)
        elif name in tables:
            solids.append(name)
        else:
            there = [
                *gas.species,
                *known_solids,
                *(mechanism.names if mechanism else ()),
            ]
            text = _unknown(name, there, mechanism)
            if name in columns:
                from contbed.reacting_bed.initial_rows import located

                raise located(scene, f"{columns[name]}: {text}")
            raise SceneError(text)
    return gases, list(dict.fromkeys(solids))


def _unknown(name: str, there: list[str], mechanism: Mechanism | None) -> str:
    """Return the message for a species without data."""
    where = "the mechanism or [gas.species]" if mechanism else "[gas.species]"
    return (
        f"{name} is neither a gas of {where} nor a constituent of the "
        f"solids{nearest(name, there)}; give its "
        f"thermodynamics in [gas.species.{name}] or [solids.NAME.constituent.{name}]"
    )


def _gases_of_file(scene: s.ReactingScene) -> dict[str, str]:
    """Return the gases of the file that a run begins with, and where it names them."""
    if scene.time is None or scene.initial.file is None:
        return {}
    from contbed.reacting_bed.initial_rows import gases_in, located

    try:
        return gases_in(scene.initial, scene.origin.base)
    except SceneError as error:
        raise located(scene, error) from None


def _compositions_of(gas: s.Mixture, boundary: Mapping[str, s.Boundary]) -> list[Any]:
    """Return all compositions of the gas that enters: of [gas], and of boundaries,
    where they may change with time.
    """
    given = [
        table.gas.composition for table in boundary.values() if table.gas is not None
    ]
    return [each for each in (gas.composition, *given) if each is not None]


def entering_gases(scene: s.ReactingScene) -> list[str]:
    """Return the names of all gases that enter, also those that enter later.

    Raises
    ------
    SceneError : a composition or its file cannot be used
    """
    return _gases_in(scene.gas, scene.boundary, scene.origin.base, mole_fractions)


def gases_named(
    gas: s.Mixture, boundary: Mapping[str, s.Boundary], base: Path
) -> list[str]:
    """Return all gases that compositions of what enters name, those of amount 0
    included.

    Raises
    ------
    SceneError : a composition, or its file in the folder `base`, cannot be used
    """
    return _gases_in(gas, boundary, base, names_in)


def _gases_in(
    gas: s.Mixture,
    boundary: Mapping[str, s.Boundary],
    base: Path,
    read: Callable[[str], Iterable[str]],
) -> list[str]:
    """Return the gases of all compositions; `read` gives those of a text."""
    found: list[str] = []
    for composition in _compositions_of(gas, boundary):
        series = isinstance(composition, CompositionSeries)
        found += composition.fractions(base)[0] if series else read(composition)
    return list(dict.fromkeys(found))


def condensed_names() -> tuple[str, ...]:
    """Return names of solids that Cantera's tables hold."""
    try:
        return tuple(_condensed())
    except ImportError:
        return ()


def _condensed() -> dict[str, Any]:
    """Return the solids of Cantera's tables by formula; the form that is stable at
    the lowest temperature.
    """
    import cantera

    out: dict[str, Any] = {}
    for item in cantera.Species.list_from_file("nasa_condensed.yaml"):
        name = (
            item.name.split("(")[0]
            if item.name.endswith(")") and not item.name.endswith("(L)")
            else item.name
        )
        if name not in out or item.thermo.min_temp < out[name].thermo.min_temp:
            out[name] = item
    return out


def _elements(name: str, table: s.Substance | None) -> dict[str, float]:
    return (
        dict(table.elements)
        if table is not None and table.elements
        else elements_of(name)
    )


def _from_table(name: str, table: s.Substance, needs_heat: bool) -> Thermo | None:
    """Return a species from the data of its table, None where they give no
    thermodynamics.
    """
    elements = _elements(name, table)
    mass = table.molar_mass or molar_mass_of(elements)
    if table.shomate is not None:
        given = list(table.shomate)
        if table.enthalpy is not None or len(given) == FORMATION_SHOMATE:
            if table.enthalpy is None:
                raise SceneError(
                    f"{name}: shomate has no F; give F, or the enthalpy of formation "
                    "as `enthalpy`"
                )
            zero = Shomate(name, elements, mass, (*given[:FORMATION_SHOMATE], 0.0))
            F = (table.enthalpy - float(zero.enthalpy(T_STANDARD))) * 1e-3
            given[FORMATION_SHOMATE : FORMATION_SHOMATE + 1] = [F]
        return Shomate(name, elements, mass, tuple(given[:7]))
    if table.heat_capacity is not None or (not needs_heat and table.enthalpy is None):
        cp = table.heat_capacity or INERT_CAPACITY
        return ConstantHeatCapacity(
            name, elements, mass, cp, table.enthalpy or 0.0, table.entropy
        )
    return None


def _gas(
    name: str, given: s.Mixture, mechanism: Mechanism | None, needs_heat: bool
) -> Thermo:
    table = given.species.get(name)
    if table is not None and (
        mechanism is None
        or table.shomate is not None
        or table.heat_capacity is not None
    ):
        found = _from_table(name, table, needs_heat)
        if found is not None:
            return found
    if mechanism is not None and name in mechanism.names:
        return mechanism.species(name)
    raise SceneError(
        f"{name} has no thermodynamics: give shomate, or heat_capacity and enthalpy, "
        f"in [gas.species.{name}]"
    )


def _constituent(name: str, table: s.Substance | None, needs_heat: bool) -> Thermo:
    if table is not None:
        found = _from_table(name, table, needs_heat)
        if found is not None:
            return found
    tables = _condensed()
    if name in tables:
        elements = _elements(name, table)
        mass = (table.molar_mass if table is not None else None) or molar_mass_of(
            elements
        )
        return species_of(name, tables[name], mass, with_jumps=True)
    table_name = f"[solids.NAME.constituent.{name}]"
    raise SceneError(
        f"{name} has no thermodynamics: give shomate, or heat_capacity and enthalpy, "
        f"in {table_name}"
    )


def _transport(
    scene: s.ReactingScene, gases: dict[str, Thermo], mechanism: Mechanism | None
) -> GasTransport | None:
    """Return the transport properties that are given, or those of the mechanism;
    None where there are none.
    """
    gas, names = scene.gas, list(gases)

    def of_each(key: str) -> Any:
        constant = getattr(gas, key)
        if constant is not None:
            return float(constant)
        out = []
        for name in names:
            table = gas.species.get(name)
            given = None if table is None else getattr(table, key)
            if given is not None:
                out.append(
                    dippr102(given if isinstance(given, tuple) else (given, 0.0))
                )
            elif mechanism is not None and name in mechanism.names:
                out.append(getattr(mechanism, key)(name))
            else:
                return None
        return tuple(out)

    viscosity, conductivity = of_each("viscosity"), of_each("conductivity")
    given = gas.diffusivity
    pairs: Any = None
    if isinstance(given, float):
        pairs = given
    elif given == "fuller" or (given is None and mechanism is None):
        try:
            pairs = {
                (k, j): fuller_pair(gases[names[k]], gases[names[j]])
                for k in range(len(names))
                for j in range(k + 1, len(names))
            }
        except SceneError:
            if given == "fuller":
                raise
    elif mechanism is not None:
        pairs = {
            (k, j): mechanism.pair(names[k], names[j])
            for k in range(len(names))
            for j in range(k + 1, len(names))
        }
    if pairs is not None and not isinstance(pairs, float) and len(names) == 1:
        pairs = 0.0
    masses = tuple(gases[name].molar_mass for name in names)
    rule = "mathur" if mechanism is not None else "wassiljewa"
    return GasTransport(
        masses, viscosity, conductivity, pairs, gas.viscosity_rule, rule
    )
