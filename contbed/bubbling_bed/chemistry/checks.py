"""Checks of the tables of a reacting bed: mistakes that remain although every single
value is valid.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from contbed.bubbling_bed.chemistry import scene as t
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.solids import Fuel, Solid
from contbed.bubbling_bed.tables import BubblingBed
from contbed.chemistry.char_and_lime import CHAR_LAWS
from contbed.chemistry.checks import reaction_is_whole
from contbed.chemistry.laws import equations_of, find_law, laws_of
from contbed.chemistry.laws.gases import BY_REACTION
from contbed.chemistry.mixture import Mechanism
from contbed.chemistry.species import condensed_names
from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.scene.checking import Mistakes, See
from contbed.scene.gas import GasCantera
from contbed.scene.mechanism import find_mechanism
from contbed.scene.names import nearest
from contbed.scene.toml_lines import KeyPath, Origin

SUM = 2e-3  # by which shares of an analysis, printed with three digits, may miss one
HOT = 0.5  # relative distance of a heating value from the correlation that is a mistake
Solids = Mapping[str, Solid]


def reactions_have_what_they_need(
    reactions: t.Reactions | None,
    solids: Solids,
    gas: GasCantera | None,
    bubbling_bed: BubblingBed,
) -> Mistakes:
    """Check that reactions have a gas, the fuel or limestone, and a rate law."""
    if reactions is None:
        for name, item in solids.items():
            for key in ("fuel", "limestone"):
                if getattr(item, key) is not None:
                    yield ("solids", name, key), "has no use without [reactions]"
        if "mixing_time" in bubbling_bed.model_fields_set:
            text = "has no use without [reactions]"
            yield ("bubbling_bed", "mixing_time"), text
        return
    if gas is None:
        yield ("reactions",), "need [gas] and boundary.bottom.gas.mass_flow"
    fuel = any(item.fuel for item in solids.values())
    limestone = any(item.limestone for item in solids.values())
    for name in ("drying", "devolatilisation", *reactions.of_char):
        if getattr(reactions, name) is not None and not fuel:
            yield ("reactions", name), "there is no [solids.NAME.fuel]"
    if reactions.sulphate_reduction is not None and reactions.sulphation is None:
        text = "there is no sulphate without reactions.sulphation"
        yield ("reactions", "sulphate_reduction"), text
    for name in ("calcination", "sulphation", "sulphate_reduction"):
        if getattr(reactions, name) is not None and not limestone:
            yield ("reactions", name), "there is no [solids.NAME.limestone]"
    yield from _laws_are_known(reactions)


def _laws_are_known(reactions: t.Reactions) -> Mistakes:
    """Check the names of rate laws of char."""
    for name, laws in CHAR_LAWS.items():
        table = getattr(reactions, name)
        if table is not None and table.law is not None and table.law not in laws:
            text = f"unknown rate law; {nearest(table.law, list(laws))}"
            yield ("reactions", name, "law"), text


def gas_reactions_are_whole(
    reactions: t.Reactions | None,
    gas: GasCantera | None,
    solids: Solids,
    origin: Origin,
) -> Mistakes:
    """Check that reactions of gases have equations that balance, laws and a place."""
    if reactions is None or gas is None:
        return
    mechanism = find_mechanism(gas.mechanism, origin.base)

    def atoms(name: str) -> Mapping[str, float]:
        return thermo.gas(name, mechanism).composition

    for name, table in reactions.of_gases.items():
        path = ("reactions", name)
        if table.model_fields_set <= {"factor"} and not laws_of(name):
            known = [*t.Reactions.model_fields, *BY_REACTION]
            text = f"unknown reaction without an equation; {nearest(name, known)}"
            yield path, text
            continue
        if table.surface is not None:
            yield (*path, "surface"), "surface mechanisms run in packed beds alone"
            continue
        yield from reaction_is_whole(name, table, atoms)
        law = find_law(name, table)
        if law is not None and law.of_solids:
            yield (
                (*path, "law"),
                "is a rate law of reacting solids, which bubbling_bed does not "
                "have; use a law of gases, or model = 'packed_bed'",
            )
        if table.diffusivity is not None:
            text = "bubbling_bed resolves no pores; give a factor, or remove it"
            yield (*path, "diffusivity"), text
        if table.basis == "bed":
            yield (*path, "basis"), "give gas, or catalyst or particle with a solid"
        if table.solid is not None and table.solid not in solids:
            yield (
                (*path, "solid"),
                f"no such phase; {nearest(str(table.solid), list(solids))}",
            )


def only_gases_react(
    reactions: t.Reactions | None, gas: GasCantera | None, origin: Origin
) -> Mistakes:
    """Check that no reaction takes a solid, which has the name of a vapour.

    What Cantera knows as a solid, or no mechanism as a gas, has to enter or to be
    made.
    """
    if reactions is None or gas is None:
        return
    usual = set(Mechanism.read(find_mechanism(gas.mechanism, origin.base)).names)
    there = (usual - {*condensed_names()}).union(thermo.GASES)
    there |= mole_fractions(gas.composition).keys()
    waiting: list[tuple[str, Mapping[str, float]]] = []
    for name, table in reactions.of_gases.items():
        try:
            equations = equations_of(name, table).values()
        except SceneError:
            continue  # see `gas_reactions_are_whole`
        waiting += [(name, each.stoichiometry) for each in equations]
    before = -1
    while before != len(there):
        before = len(there)
        for _, moles in waiting:
            if not _missing(moles, there):
                there |= moles.keys()
    for name, moles in waiting:
        if missing := _missing(moles, there):
            yield (
                ("reactions", name),
                f"no gas called {' or '.join(missing)} enters or is made, and solids of "
                "bubbling_bed do not react, but fuel and limestone; name gases of "
                "gas.composition, or take model = 'packed_bed' for a solid that reacts",
            )


def _missing(moles: Mapping[str, float], there: set[str]) -> list[str]:
    """Return the species that a reaction takes and that are not there."""
    return [name for name, count in moles.items() if count < 0.0 and name not in there]


def the_fuel_is_whole(solids: Solids) -> Mistakes:
    """Check that the analysis of the fuel sums to one and fits volatile matter and
    heating value.
    """
    for name, item in solids.items():
        if item.fuel is not None:
            yield from _analysis(("solids", name, "fuel"), item.fuel)


def _analysis(path: KeyPath, fuel: Fuel) -> Mistakes:
    """Check the analysis of one fuel."""
    from contbed.chemistry import devolatilisation as dv

    dry = fuel.ultimate.model_dump()
    total = sum(dry.values()) + fuel.ash
    if abs(total - 1.0) > SUM:
        text = f"C, H, O, N, S and ash of the dry fuel sum to {total:.6g}, not to 1"
        yield (*path, "ultimate"), text
        return
    daf = sum(dry.values())
    volatile = (*path, "volatile_matter")
    try:
        if fuel.volatile_matter:
            shares = {name: share / daf for name, share in dry.items()}
            dv.volatiles(shares, fuel.volatile_matter)
        elif dry["C"] < daf * (1.0 - SUM):
            yield (
                volatile,
                "0 leaves only fixed carbon, but ultimate has other elements "
                "than C; raise it, or correct ultimate",
            )
    except SceneError as error:
        yield volatile, str(error)
    expected = dv.heating_value_channiwala(dry, fuel.ash)
    holds = fuel.ash <= dv.MOST_ASH and expected >= dv.LEAST_HEAT
    if fuel.heating_value is None and not holds:
        yield (
            (*path, "heating_value"),
            "missing; the formula that gives it from the analysis holds from "
            f"{dv.LEAST_HEAT:.2g} J/kg and up to {dv.MOST_ASH:.0%} of ash",
        )
    given = expected if fuel.heating_value is None else fuel.heating_value
    if holds and abs(given / expected - 1.0) > HOT:
        text = f"far from the {expected:.4g} J/kg that the analysis gives"
        yield (*path, "heating_value"), text


def what_is_fed_leaves(
    reactions: t.Reactions | None, solids: Solids, bubbling_bed: BubblingBed
) -> Mistakes:
    """Check that each constituent that is fed reacts or is drained."""
    if reactions is None or bubbling_bed.drain is not None:
        return
    for name, item in solids.items():
        if item.limestone is not None:
            text = "nothing removes it, so that no steady state exists: add [bubbling_bed.drain]"
            yield ("solids", name, "limestone"), text
        if item.fuel is not None:
            yield from _constituents_leave(
                ("solids", name, "fuel"), item.fuel, reactions
            )


def _constituents_leave(path: KeyPath, fuel: Fuel, reactions: t.Reactions) -> Mistakes:
    """Check that moisture, volatile matter and char of a fuel react."""
    for amount, reaction, constituent in (
        (fuel.moisture, "drying", "moisture"),
        (fuel.volatile_matter, "devolatilisation", "volatile matter"),
    ):
        if amount and getattr(reactions, reaction) is None:
            yield (
                path,
                f"nothing consumes or removes its {constituent}, so that no steady "
                f"state exists: add [reactions.{reaction}] or [bubbling_bed.drain]",
            )
    if fuel.volatile_matter < 1 and not reactions.of_char:
        yield (
            path,
            "nothing consumes or removes its char, so that no steady state exists: add "
            "[reactions.char_combustion] or another reaction of char, or "
            "[bubbling_bed.drain]",
        )


def fuel_and_limestone_are_fed(solids: Solids, see: See) -> Mistakes:
    """Check that fuel and limestone are fed and mix, and that there is one of each."""
    first: dict[str, str] = {}
    for name, item in solids.items():
        for key in ("fuel", "limestone"):
            if getattr(item, key) is None:
                continue
            path = ("solids", name, key)
            if key in first:
                other = see(f"solids.{first[key]}.{key}")
                yield (
                    path,
                    (f"one solid phase may have it, and {other} is given; remove one"),
                )
            first.setdefault(key, name)
            if item.feed is None or not item.feed.mass_flow:
                yield path, f"needs solids.{name}.feed with a mass_flow"
            elif "drain" in item.feed.model_fields_set:
                text = "has no use for fuel and limestone; see bubbling_bed.drain.end"
                yield ("solids", name, "feed", "drain"), text
            if item.mixing_conductivity == 0:
                mixing = see(f"solids.{name}.mixing_conductivity")
                yield (
                    path,
                    f"a reacting phase must mix along the height: raise {mixing} "
                    "above 0",
                )
        if item.fuel is not None and item.limestone is not None:
            fuel = see(f"solids.{name}.fuel")
            yield (
                ("solids", name, "limestone"),
                f"one phase cannot be fuel and limestone; see {fuel}; give the "
                "limestone a phase of its own",
            )


CHECKS: tuple[Callable[..., Mistakes], ...] = (
    reactions_have_what_they_need,
    the_fuel_is_whole,
    what_is_fed_leaves,
    fuel_and_limestone_are_fed,
    gas_reactions_are_whole,
    only_gases_react,
)
