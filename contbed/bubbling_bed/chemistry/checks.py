"""Checks of the tables of a reacting bed: mistakes that remain although every single value is valid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any

from contbed.bubbling_bed.chemistry import scene as t
from contbed.closures.reactions import LAWS
from contbed.closures.reactions_solid import CHAR_LAWS
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See

SUM = 2e-3  # by which shares of an analysis, printed with three digits, may miss one
HOT = 0.5  # relative distance of a heating value from the correlation that is a mistake


def reactions_have_what_they_need(
    reactions: t.Reactions | None, fuel: t.Fuel | None, limestone: t.Limestone | None, gas: Any, see: See
) -> Mistakes:
    """Check that reactions have a mass flow of gas, the fuel or limestone, and a rate law."""
    if reactions is None:
        for key, table in (("fuel", fuel), ("limestone", limestone)):
            if table is not None:
                yield (key,), "has no use without [reactions]"
        return
    if gas.mass_flow is None:
        yield ("reactions",), f"need gas.mass_flow and gas.composition; see {see('gas.capacity_flow')}"
    for name in ("drying", "devolatilisation", *reactions.of_char):
        if getattr(reactions, name) is not None and fuel is None:
            yield ("reactions", name), "there is no [fuel]"
    if reactions.sulphate_reduction is not None and reactions.sulphation is None:
        yield ("reactions", "sulphate_reduction"), "there is no sulphate without reactions.sulphation"
    for name in ("calcination", "sulphation", "sulphate_reduction"):
        if getattr(reactions, name) is not None and limestone is None:
            yield ("reactions", name), "there is no [limestone]"
    for name, laws in (LAWS | CHAR_LAWS).items():
        table = getattr(reactions, name)
        if table is not None and table.law is not None and table.law not in laws:
            near = get_close_matches(table.law, laws, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            yield ("reactions", name, "law"), f"unknown rate law; there are {', '.join(laws)}{hint}"


def the_fuel_is_whole(fuel: t.Fuel | None) -> Mistakes:
    """Check that the analysis of the fuel sums to one and fits volatile matter and heating value."""
    if fuel is None:
        return
    from contbed.closures import devolatilisation as dv

    dry = fuel.ultimate.model_dump()
    total = sum(dry.values()) + fuel.ash
    if abs(total - 1.0) > SUM:
        yield ("fuel", "ultimate"), f"C, H, O, N, S and ash of the dry fuel sum to {total:.6g}, not to 1"
        return
    daf = sum(dry.values())
    try:
        if fuel.volatile_matter:
            dv.volatiles({name: share / daf for name, share in dry.items()}, fuel.volatile_matter)
        elif dry["C"] < daf * (1.0 - SUM):
            yield ("fuel", "volatile_matter"), "fixed carbon is pure carbon, but there are other elements"
    except SceneError as error:
        yield ("fuel", "volatile_matter"), str(error)
    if fuel.heating_value is not None:
        expected = dv.heating_value_channiwala(dry, fuel.ash)
        if abs(fuel.heating_value / expected - 1.0) > HOT:
            yield ("fuel", "heating_value"), f"far from the {expected:.4g} J/kg that the analysis gives"


def what_is_fed_leaves(
    reactions: t.Reactions | None, fuel: t.Fuel | None, limestone: t.Limestone | None, drain: t.Drain | None
) -> Mistakes:
    """Check that each constituent that is fed reacts or is drained."""
    if reactions is None:
        return
    if limestone is not None and drain is None:
        yield ("limestone",), "never leaves the bed: give [drain]"
    if fuel is None or drain is not None:
        return
    for there, name, what in (
        (fuel.moisture, "drying", "moisture"),
        (fuel.volatile_matter, "devolatilisation", "volatile matter"),
    ):
        if there and getattr(reactions, name) is None:
            yield ("fuel",), f"its {what} never leaves the bed: give [reactions.{name}] or [drain]"
    if fuel.volatile_matter < 1 and not reactions.of_char:
        yield ("fuel",), "its char never leaves the bed: give [reactions.char_combustion] or another, or [drain]"


def fed_species_are_there(
    fuel: t.Fuel | None, limestone: t.Limestone | None, species: Mapping[str, Any], bubbling_bed: Any, see: See
) -> Mistakes:
    """Check that fuel and limestone become existing species that can carry them."""
    tables = [(key, table) for key, table in (("fuel", fuel), ("limestone", limestone)) if table is not None]
    for key, table in tables:
        item = species.get(table.species)
        if item is None or not item.volume_fraction:
            near = get_close_matches(table.species, species, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else f"; there are {', '.join(species)}"
            yield (key, "species"), f"no such species{hint}"
            continue
        if item.feed is not None:
            yield (key, "species"), f"{table.species} has a feed of its own; see {see(f'species.{table.species}.feed')}"
        if item.conductivity == 0:
            yield (key, "species"), f"must mix along the height; see {see(f'species.{table.species}.conductivity')}"
        if table.feed.height > bubbling_bed.height:
            yield (key, "feed", "height"), f"above the bed, {bubbling_bed.height:g} m; see {see('bubbling_bed.height')}"
    if fuel is not None and limestone is not None and fuel.species == limestone.species:
        yield ("limestone", "species"), f"is the fuel already; see {see('fuel.species')}"


def gases_react(reactions: t.Reactions | None, gas: Any) -> Mistakes:
    """Check that the reactions know the gases that enter."""
    if reactions is None or gas.composition is None:
        return
    from contbed.bubbling_bed.chemistry.thermo import GASES
    from contbed.materials.composition import mole_fractions

    try:
        unknown = [name for name in mole_fractions(gas.composition) if name not in GASES]
    except SceneError:
        return  # reported by another check
    for name in unknown:
        yield ("gas", "composition"), f"reactions know no {name}; they know {', '.join(GASES)}"


CHECKS: tuple[Callable[..., Mistakes], ...] = (
    reactions_have_what_they_need,
    the_fuel_is_whole,
    what_is_fed_leaves,
    fed_species_are_there,
    gases_react,
)
