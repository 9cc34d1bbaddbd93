"""What is wrong with the scene of a bubbling bed although every single value is right; see `scene.checks`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches

from contbed.bubbling import settings as b
from contbed.scene import settings as s
from contbed.scene.checks import Mistakes, See

RESERVED = ("emulsion", "bubble", "distributor")
SUM = 1e-9  # by which shares may miss one
Kinds = Mapping[str, b.Species]


def shares_sum_to_one(species: Kinds) -> Mistakes:
    if not species:
        yield ("species",), "a bed needs particles; give [species.NAME]"
        return
    total = sum(item.volume_fraction for item in species.values())
    if abs(total - 1.0) > SUM:
        yield ("species",), f"the shares volume_fraction of the solids sum to {total:.10g}, not to 1"


def names_are_free(species: Kinds) -> Mistakes:
    for name in species:
        if name in RESERVED:
            yield ("species", name), f"is a name of the model; others than {', '.join(RESERVED)} are free"
        elif not name.isascii() or not name.isidentifier():
            yield ("species", name), "a name of a species has ASCII letters, digits and _ only"


def pairs_are_given_once(species: Kinds) -> Mistakes:
    for name, item in species.items():
        for other in item.exchange:
            path = ("species", name, "exchange", other)
            if other == name:
                yield path, "a species does not exchange heat with itself"
            elif other not in species:
                near = get_close_matches(other, species, n=1)
                hint = f"; did you mean '{near[0]}'?" if near else f"; there are {', '.join(species)}"
                yield path, f"no such species{hint}"
            elif name in species[other].exchange and name > other:
                yield path, f"this pair stands also at species.{other}.exchange; give it once"


def feeds_lie_in_the_bed(bubbling_bed: b.BubblingBed, species: Kinds, see: See) -> Mistakes:
    for name, item in species.items():
        if item.feed is not None and item.feed.height > bubbling_bed.height:
            text = f"above the bed, {bubbling_bed.height:g} m; see {see('bubbling_bed.height')}"
            yield ("species", name, "feed", "height"), text


def absent_species_do_nothing(species: Kinds, see: See) -> Mistakes:
    for name, item in species.items():
        if item.volume_fraction == 0:
            for key in ("feed", "release"):
                if getattr(item, key) is not None:
                    text = f"there is none of this species; see {see(f'species.{name}.volume_fraction')}"
                    yield ("species", name, key), text


def bubbles_carry_their_gas(bubbles: b.Bubbles | None, see: See) -> Mistakes:
    if bubbles is not None and bubbles.fraction == 0 and bubbles.capacity_flow > 0:
        yield ("bubbles", "capacity_flow"), f"there are no bubbles to carry it; see {see('bubbles.fraction')}"
    if bubbles is not None and bubbles.fraction > 0 and bubbles.capacity_flow == 0 and bubbles.exchange == 0:
        yield ("bubbles", "exchange"), "bubbles that neither flow nor exchange heat have no temperature"


def radiation_has_its_emissivities(
    radiation: b.Radiation, species: Kinds, freeboard: b.Freeboard | None, see: See
) -> Mistakes:
    level = radiation.level
    if level == "none":
        return
    for name, item in species.items():
        if item.volume_fraction > 0 and item.emissivity is None:
            yield ("species", name, "emissivity"), f"missing; radiation needs it; see {see('radiation')}"
    if level == "paper" and radiation.correction == "close_packed":
        yield ("radiation", "correction"), "exchange at one place is that of the surfaces: independent, or leave it out"
    if level == "two_flux" and radiation.anisotropy:
        yield ("radiation", "anisotropy"), f"the two-flux method ignores it; see {see('radiation.level')}"


def something_fixes_the_plate(
    distributor: b.Distributor | None, gas: b.Gas, bubbles: b.Bubbles | None, radiation: b.Radiation
) -> Mistakes:
    if distributor is None:
        return
    flow = gas.capacity_flow + (bubbles.capacity_flow if bubbles is not None else 0.0)
    radiates = radiation.level in ("p1", "two_flux") and distributor.emissivity is not None
    if not distributor.coefficient and not distributor.preheat_NTU * flow and not radiates:
        text = "nothing exchanges heat with it: give coefficient or preheat_NTU, or leave out the table"
        yield ("distributor", "coefficient"), text


def something_fixes_the_temperatures(
    gas: b.Gas, bubbles: b.Bubbles | None, species: Kinds, tubes: b.Surface | None, walls: b.Surface | None
) -> Mistakes:
    flows = [item.feed.capacity_flow for item in species.values() if item.feed is not None]
    flows += [gas.capacity_flow, bubbles.capacity_flow if bubbles is not None else 0.0]
    surfaces = [item.coefficient for item in (tubes, walls) if item is not None]
    if not any(flows) and not any(surfaces):
        yield ("gas", "capacity_flow"), "no stream and no surface carries heat away: no steady state is determined"


def positions_lie_in_the_bed(bubbling_bed: b.BubblingBed, output: s.Output, see: See) -> Mistakes:
    for index, position in enumerate(output.positions):
        if not 0 <= position <= bubbling_bed.height:
            text = f"outside of the bed, 0 to {bubbling_bed.height:g} m; see {see('bubbling_bed.height')}"
            yield ("output", "positions", index), text


CHECKS: tuple[Callable[..., Mistakes], ...] = (
    shares_sum_to_one,
    names_are_free,
    pairs_are_given_once,
    feeds_lie_in_the_bed,
    absent_species_do_nothing,
    bubbles_carry_their_gas,
    radiation_has_its_emissivities,
    something_fixes_the_plate,
    something_fixes_the_temperatures,
    positions_lie_in_the_bed,
)
