"""Checks of the scene of a bubbling bed: mistakes that remain although every single value is valid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from types import SimpleNamespace

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.chemistry import checks as chemistry_checks
from contbed.bubbling_bed.closures import gives, is_bubbling, uses
from contbed.bubbling_bed.coefficients import mixture
from contbed.closures.binding import bind, named
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.mechanism import find_mechanism
from contbed.scene.tables import Output
from contbed.scene.toml_lines import KeyPath, Origin

RESERVED = ("emulsion", "bubble", "distributor", "freeboard", "tubes", "walls", "up", "down")
SUM = 1e-9  # by which shares may miss one
SHARES = 1e-6  # by which mole fractions may, which people round
LEAST_TUBE = 0.0127  # [m] outside, half an inch: smaller ones are not used in beds
DENSEST = 0.9069  # share of a section that circles fill, pi/(2 sqrt 3)
Kinds = Mapping[str, b.Species]


def shares_sum_to_one(species: Kinds) -> Mistakes:
    """Check that there are particles and that their volume fractions sum to one."""
    if not species:
        yield ("species",), "a bed needs particles; give [species.NAME]"
        return
    total = sum(item.volume_fraction for item in species.values())
    if abs(total - 1.0) > SUM:
        yield ("species",), f"the shares volume_fraction of the solids sum to {total:.10g}, not to 1"


def names_are_free(species: Kinds) -> Mistakes:
    """Check that the names of species are valid and not used by the model."""
    for name in species:
        if name in RESERVED:
            yield ("species", name), f"is a name of the model; others than {', '.join(RESERVED)} are free"
        elif not name.isascii() or not name.isidentifier():
            yield ("species", name), "a name of a species has ASCII letters, digits and _ only"


def pairs_are_given_once(species: Kinds) -> Mistakes:
    """Check that exchange is given once for each pair of existing species."""
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
    """Check that particles are fed below the surface of the bed."""
    for name, item in species.items():
        if item.feed is not None and item.feed.height > bubbling_bed.height:
            text = f"above the bed, {bubbling_bed.height:g} m; see {see('bubbling_bed.height')}"
            yield ("species", name, "feed", "height"), text


def absent_species_do_nothing(species: Kinds, see: See) -> Mistakes:
    """Check that a species without volume has neither feed nor heat release."""
    for name, item in species.items():
        if item.volume_fraction == 0:
            for key in ("feed", "release"):
                if getattr(item, key) is not None:
                    text = f"there is none of this species; see {see(f'species.{name}.volume_fraction')}"
                    yield ("species", name, key), text


def bubbles_carry_their_gas(bubbles: b.Bubbles | None, see: See) -> Mistakes:
    """Check that bubbles with gas have a volume, and that their temperature is determined."""
    if bubbles is None or (not bubbles.capacity_flow and bubbles.fraction == 0):
        return
    if bubbles.fraction == 0:
        yield ("bubbles", "capacity_flow"), f"there are no bubbles to carry it; see {see('bubbles.fraction')}"
    elif bubbles.capacity_flow == 0 and bubbles.exchange == 0:
        yield ("bubbles", "exchange"), "bubbles that neither flow nor exchange heat have no temperature"


def coefficients_fit_the_gas(
    gas: b.Gas,
    bubbling_bed: b.BubblingBed,
    bubbles: b.Bubbles | None,
    species: Kinds,
    tubes: b.Surface | None,
    walls: b.Surface | None,
    freeboard: b.Freeboard | None,
    origin: Origin,
    see: See,
) -> Mistakes:
    """Check that coefficients suit the way in which the gas is given.

    With a capacity flow all are numbers. With a mass flow closures exist and have the properties that they need.
    """
    computed = gas.mass_flow is not None
    which = f"see {see('gas.mass_flow' if computed else 'gas.capacity_flow')}"
    tables = SimpleNamespace(
        bubbling_bed=bubbling_bed, bubbles=bubbles, species=species, tubes=tubes, walls=walls, freeboard=freeboard
    )
    if not computed and freeboard is not None and freeboard.height is not None:
        yield ("freeboard", "height"), f"a freeboard needs the properties of the gas: give gas.mass_flow; {which}"
        return
    for path, spec, kind in uses(tables):
        table = {"bubbles": bubbles, "bubbling_bed": bubbling_bed}.get(str(path[0]))
        idle = table is not None and path[-1] not in ("fraction", "exchange", "expansion")
        if not computed and idle:
            if path[-1] in table.model_fields_set:  # type: ignore[union-attr]
                yield path, f"has no use where coefficients are frozen; {which}"
        elif not computed and named(spec):
            yield path, f"a closure needs the properties of the gas: give a number, or gas.mass_flow; {which}"
        elif named(spec):
            try:
                bind(spec, kind, gives(path, kind, is_bubbling(bubbles)), origin.base)
            except SceneError as error:
                yield path, str(error)
    if bubbles is not None and computed == (bubbles.capacity_flow is not None):
        wanted = "follows from the closures; leave it out" if computed else "missing; allowed: a number >= 0 W/K"
        yield ("bubbles", "capacity_flow"), f"{wanted}; {which}"
    for name, item in species.items():
        for key in ("density", "heat_capacity") if computed and item.volume_fraction > 0 else ():
            if getattr(item, key) is None:
                yield ("species", name, key), f"missing; gas.mass_flow needs it; {which}"
        right, wrong = ("mass_flow", "capacity_flow") if computed else ("capacity_flow", "mass_flow")
        if item.feed is not None and (getattr(item.feed, right) is None or getattr(item.feed, wrong) is not None):
            yield ("species", name, "feed"), f"give {right}, not {wrong}; {which}"


def settling_has_what_it_needs(
    gas: b.Gas, bubbling_bed: b.BubblingBed, species: Kinds, freeboard: b.Freeboard | None, see: See
) -> Mistakes:
    """Check the keys from which the height of the bed and the sizes of its particles follow."""
    if gas.mass_flow is None and bubbling_bed.settled_height is not None:
        yield ("bubbling_bed", "settled_height"), f"needs the properties of the gas; see {see('gas.capacity_flow')}"
    if bubbling_bed.expansion is not None and bubbling_bed.settled_height is None:
        yield ("bubbling_bed", "expansion"), f"has no use where the height is given; see {see('bubbling_bed.height')}"
    for name, item in species.items():
        if item.sizes is None or item.sizes.feed is None:
            continue
        if freeboard is None or freeboard.height is None:
            yield ("species", name, "sizes"), "what is carried away needs [freeboard] with a height; or give bed"
        if item.feed is None or not item.feed.mass_flow:
            yield ("species", name, "sizes"), f"needs species.{name}.feed with a mass_flow; or give bed"


def the_gas_is_known(gas: b.Gas, species: Kinds, origin: Origin) -> Mistakes:
    """Check that the composition of the gas is valid and that its species are known."""
    if gas.composition is None:
        return
    from contbed.materials.composition import _pairs

    try:
        amounts = [float(amount) for _, amount in _pairs(gas.composition)]
        known = mixture(gas.composition, gas.pressure, find_mechanism(gas.mechanism, origin.base))
    except (SceneError, ValueError) as error:
        yield ("gas", "composition"), str(error)
        return
    if abs(sum(amounts) - 1.0) > SHARES:
        yield ("gas", "composition"), f"mole fractions sum to {sum(amounts):.8g}, not to 1"
    hottest = known.T_range[1]
    entering: list[tuple[KeyPath, float]] = [(("gas", "temperature"), gas.temperature)]
    entering += [
        (("species", name, "feed", "temperature"), item.feed.temperature)
        for name, item in species.items()
        if item.feed is not None
    ]
    for path, T in entering:
        if hottest < T:
            yield path, f"hotter than the properties of the gas hold, {hottest:g} K by {gas.mechanism}"


def radiation_has_its_emissivities(
    radiation: b.Radiation, species: Kinds, freeboard: b.Freeboard | None, see: See
) -> Mistakes:
    """Check that radiating particles have an emissivity, and the keys of the level."""
    level = radiation.level
    if level == "none":
        return
    for name, item in species.items():
        if item.volume_fraction > 0 and item.emissivity is None:
            yield ("species", name, "emissivity"), f"missing; radiation needs it; see {see('radiation')}"
    if level in ("paper", "pairwise") and radiation.correction == "close_packed":
        yield ("radiation", "correction"), "exchange at one place is that of the surfaces: independent, or leave it out"
    if level == "two_flux" and radiation.anisotropy:
        yield ("radiation", "anisotropy"), f"the two-flux method ignores it; see {see('radiation.level')}"


def something_fixes_the_plate(
    distributor: b.Distributor | None, gas: b.Gas, bubbles: b.Bubbles | None, radiation: b.Radiation
) -> Mistakes:
    """Check that the temperature of the distributor is determined."""
    if distributor is None:
        return
    flow = gas.mass_flow or gas.capacity_flow or (bubbles is not None and bubbles.capacity_flow) or 0.0
    radiates = radiation.level in ("p1", "two_flux") and distributor.emissivity is not None
    if not distributor.coefficient and not distributor.preheat_NTU * flow and not radiates:
        text = "nothing exchanges heat with it: give coefficient or preheat_NTU, or leave out the table"
        yield ("distributor", "coefficient"), text


def something_fixes_the_temperatures(
    gas: b.Gas, bubbles: b.Bubbles | None, species: Kinds, tubes: b.Surface | None, walls: b.Surface | None
) -> Mistakes:
    """Check that a stream or a surface carries heat away."""
    flows = [item.feed.capacity_flow or item.feed.mass_flow for item in species.values() if item.feed is not None]
    flows += [gas.capacity_flow, gas.mass_flow, bubbles.capacity_flow if bubbles is not None else 0.0]
    surfaces = [item.coefficient for item in (tubes, walls) if item is not None]
    if not any(flows) and not any(surfaces):
        yield ("gas", "capacity_flow"), "no stream and no surface carries heat away: no steady state is determined"


def positions_lie_in_the_bed(bubbling_bed: b.BubblingBed, output: Output, see: See) -> Mistakes:
    """Check that the output positions lie in the bed."""
    for index, position in enumerate(output.positions):
        if not 0 <= position <= bubbling_bed.height:
            text = f"outside of the bed, 0 to {bubbling_bed.height:g} m; see {see('bubbling_bed.height')}"
            yield ("output", "positions", index), text


def the_parameter_is_a_number(
    continuation: b.Continuation | None,
    bubbling_bed: b.BubblingBed,
    gas: b.Gas,
    bubbles: b.Bubbles | None,
    species: Kinds,
    tubes: b.Surface | None,
    walls: b.Surface | None,
    distributor: b.Distributor | None,
    freeboard: b.Freeboard | None,
) -> Mistakes:
    """Check that the parameter of the continuation is a number of the scene that may vary."""
    if continuation is None:
        return
    from contbed.scene.values import value_at

    tables = {
        "bubbling_bed": bubbling_bed,
        "gas": gas,
        "bubbles": bubbles,
        "species": species,
        "tubes": tubes,
        "walls": walls,
        "distributor": distributor,
        "freeboard": freeboard,
    }
    found = value_at(tables, continuation.parameter)
    fixed = continuation.parameter.startswith("bubbling_bed.height") or "diameter" in continuation.parameter
    if not isinstance(found, float) or fixed:
        text = "no number of this scene can be varied under this key; allowed: keys such as gas.temperature, "
        yield ("continuation", "parameter"), text + "gas.mass_flow, walls.coefficient, species.NAME.feed.temperature"
    elif found == continuation.to:
        yield ("continuation", "to"), "is the value that the scene has"
    elif continuation.back_to is not None and (continuation.back_to - found) * (continuation.to - found) > 0:
        yield ("continuation", "back_to"), f"lies on the same side of the value in the scene, {found:g}, as `to`"


def particles_pass_between_the_tubes(
    bubbling_bed: b.BubblingBed, species: Kinds, tubes: b.Surface | None, see: See
) -> Mistakes:
    """Check that particles are smaller than 2 A/p, the width of slits whose walls have the surface of the tubes."""
    largest = max((item.diameter for item in species.values() if item.volume_fraction > 0), default=0.0)
    if tubes is not None and 2.0 * bubbling_bed.section < largest * tubes.perimeter:
        yield (
            ("tubes", "perimeter"),
            f"leaves {2.0 * bubbling_bed.section / tubes.perimeter:.3g} m between surfaces, less than particles of "
            f"{largest:.3g} m; allowed: below {2.0 * bubbling_bed.section / largest:.4g} m, see "
            f"{see('bubbling_bed.section')}",
        )


CHECKS: tuple[Callable[..., Mistakes], ...] = (
    shares_sum_to_one,
    names_are_free,
    pairs_are_given_once,
    feeds_lie_in_the_bed,
    absent_species_do_nothing,
    bubbles_carry_their_gas,
    coefficients_fit_the_gas,
    the_gas_is_known,
    settling_has_what_it_needs,
    radiation_has_its_emissivities,
    something_fixes_the_plate,
    something_fixes_the_temperatures,
    positions_lie_in_the_bed,
    particles_pass_between_the_tubes,
    the_parameter_is_a_number,
    *chemistry_checks.CHECKS,
)


def tubes_fit_in_the_section(
    bubbling_bed: b.BubblingBed, tubes: b.Surface | None, freeboard: b.Freeboard | None, see: See
) -> Mistakes:
    """Look for more surface than tubes have that touch each other, even those of the least diameter."""
    most = 4.0 * DENSEST / LEAST_TUBE * bubbling_bed.section
    above = None if freeboard is None else freeboard.tubes
    given: list[tuple[KeyPath, b.Surface | b.FreeboardSurface | None]] = [(("tubes",), tubes)]
    for path, table in [*given, (("freeboard", "tubes"), above)]:
        if table is not None and table.perimeter > most:
            yield (
                (*path, "perimeter"),
                f"tubes of {1e3 * LEAST_TUBE:g} mm that touch each other have {most:.4g} m in "
                f"{bubbling_bed.section:g} m2; give less, or see {see('bubbling_bed.section')}",
            )


WARNINGS: tuple[Callable[..., Mistakes], ...] = (tubes_fit_in_the_section,)
