"""Species of the gas and constituents of the solids, with their data, from a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

from contbed.chemistry.elements import elements_of
from contbed.chemistry.laws import species_named
from contbed.chemistry.mixture import GasTransport, Mechanism, dippr102, fuller_pair
from contbed.chemistry.species import (
    Species,
    condensed_names,
    gas_species,
    in_other_case,
    solid_species,
)
from contbed.chemistry.thermo import Thermo
from contbed.errors import SceneError
from contbed.materials.common import nearest
from contbed.materials.composition import mole_fractions, names_in
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import CompositionSeries
from contbed.scene.mechanism import find_mechanism


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


def mechanism_of(gas: s.Mixture, base: Path) -> Mechanism | None:
    """Return the mechanism that a scene takes its gases from.

    Raises
    ------
    SceneError : it cannot be read
    """
    if not isinstance(gas, s.GasCantera):
        return None
    return Mechanism.read(find_mechanism(gas.mechanism, base))


def species_without_phases(
    scene: s.ReactingScene,
) -> tuple[Species, GasTransport | None]:
    """Return the species of a scene, those that enter and those that reactions name,
    and properties of the gas.

    Raises
    ------
    SceneError : data of a species are missing
    """
    with scene.origin.blamed("gas", "mechanism"):
        mechanism = mechanism_of(scene.gas, scene.origin.base)
    gas_names, solid_names = _names(scene, mechanism)
    needs_heat = scene.heat is not None
    tables, blamed = scene.gas.species, scene.origin.blamed
    gases, solids = {}, {}
    for name in gas_names:
        with blamed("gas", "species", name):
            gases[name] = gas_species(name, tables.get(name), mechanism, needs_heat)
    data = constituents_of(scene.solids)
    for name in solid_names:
        with blamed("solids"):
            solids[name] = solid_species(name, data.get(name), needs_heat)
    with blamed("gas", "diffusivity"):
        transport = _transport(scene, gases, mechanism)
    return Species(gases, solids), transport


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
    named = {
        name
        for reaction, table in scene.reactions.items()
        for name in species_named(reaction, table)
    }
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
                text = f"{columns[name]}: {text}"
            with scene.origin.blamed(*_namer(scene, name, columns)):
                raise SceneError(text)
    return gases, list(dict.fromkeys(solids))


def _namer(
    scene: s.ReactingScene, species: str, columns: Mapping[str, str]
) -> tuple[str, ...]:
    """Return the key that names a species: the file of the start, a reaction, or the
    composition that enters.
    """
    if species in columns:
        return ("initial", "file")
    for name, table in scene.reactions.items():
        if species in species_named(name, table):
            return ("reactions", name)
    return ("gas", "composition")


def _unknown(name: str, there: list[str], mechanism: Mechanism | None) -> str:
    """Return the message for a species without data."""
    where = "the mechanism or [gas.species]" if mechanism else "[gas.species]"
    text = f"{name} is neither a gas of {where} nor a constituent of the solids"
    if other := in_other_case(name, there):
        if not _has_other_atoms(name, other):
            return f"{text}; write {other}"
        there = [each for each in there if each != other]
    return (
        f"{text}{nearest(name, there)}; give its "
        f"thermodynamics in [gas.species.{name}] or [solids.NAME.constituent.{name}]"
    )


def _has_other_atoms(name: str, other: str) -> bool:
    """Return whether a name is a formula of its own, as CO beside Co."""
    try:
        found = elements_of(name)
    except SceneError:
        return False
    # NIO is seldom meant with iodine, see `atoms_of`
    return not {"I", "U"} & found.keys() and found != elements_of(other)


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


def _with_transport(mechanism: Mechanism | None, needed: bool) -> Mechanism | None:
    """Return the mechanism, None if it has no transport data.

    Raises
    ------
    SceneError : they are `needed`
    """
    try:
        return mechanism if mechanism is not None and mechanism.transport else None
    except SceneError:
        if needed:
            raise
        return None


def _transport(
    scene: s.ReactingScene, gases: dict[str, Thermo], mechanism: Mechanism | None
) -> GasTransport | None:
    """Return the transport properties that are given, or those of the mechanism;
    None where there are none.
    """
    gas, names = scene.gas, list(gases)
    mechanism = _with_transport(mechanism, needed=gas.diffusivity == "cantera")

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

    def of_pairs(pair: Callable[[str, str], Any]) -> dict[tuple[int, int], Any]:
        numbers = combinations(range(len(names)), 2)
        return {(k, j): pair(names[k], names[j]) for k, j in numbers}

    viscosity, conductivity = of_each("viscosity"), of_each("conductivity")
    given = gas.diffusivity
    there = () if mechanism is None else mechanism.names
    unknown = [name for name in names if name not in there]
    pairs: Any = None
    if isinstance(given, float):
        pairs = given
    elif given == "fuller" or (given is None and unknown):
        try:
            pairs = of_pairs(lambda a, b: fuller_pair(gases[a], gases[b]))
        except SceneError:
            if given == "fuller":
                raise
    elif mechanism is not None:
        if unknown:
            raise SceneError(f"the mechanism has no data of {', '.join(unknown)}")
        pairs = of_pairs(mechanism.pair)
    if pairs is not None and not isinstance(pairs, float) and len(names) == 1:
        pairs = 0.0
    masses = tuple(gases[name].molar_mass for name in names)
    rule = "mathur" if mechanism is not None else "wassiljewa"
    return GasTransport(
        masses, viscosity, conductivity, pairs, gas.viscosity_rule, rule
    )
