"""Checks of the scene of a bubbling bed: mistakes that remain although every single
value is valid.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from types import SimpleNamespace

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.chemistry import checks as chemistry_checks
from contbed.bubbling_bed.closures import (
    BUBBLES,
    CONDUCTIVITY,
    EXPANSION,
    FREEBOARD,
    MINIMUM_FLUIDIZATION,
    Use,
    gives,
    uses,
)
from contbed.bubbling_bed.surface_checks import (
    Solids,
    particles_pass_between_the_tubes,
    radiation_has_its_emissivities,
    tubes_fit_in_the_section,
    two_flux_is_low,
)
from contbed.bubbling_bed.tables import BubblingBed
from contbed.closures.binding import bind, named
from contbed.errors import SceneError
from contbed.materials.constants import mixture_of
from contbed.scene.checking import Mistakes, See
from contbed.scene.continuation import parameter_varies
from contbed.scene.gas import GasCantera
from contbed.scene.mesh_checks import positions_outside
from contbed.scene.quantities import Table
from contbed.scene.tables import Output
from contbed.scene.toml_lines import KeyPath, Origin

RESERVED = (
    "emulsion",
    "bubble",
    "distributor",
    "freeboard",
    "tubes",
    "walls",
    "up",
    "down",
)
SUM = 1e-9  # by which shares may miss one
SHARES = 1e-6  # by which mole fractions may, which people round
BOTTOM: KeyPath = ("boundary", "bottom", "gas")
CAPACITY_FLOW = "boundary.bottom.gas.capacity_flow"
MASS_FLOW = "boundary.bottom.gas.mass_flow"


def shares_sum_to_one(solids: Solids) -> Mistakes:
    """Check that there are particles and that their volume shares sum to one."""
    if not solids:
        yield ("solids",), "a bed needs particles; give [solids.NAME]"
        return
    total = sum(item.volume_share for item in solids.values())
    if abs(total - 1.0) > SUM:
        yield ("solids",), f"the shares volume_share sum to {total:.10g}, not to 1"


def names_are_free(solids: Solids) -> Mistakes:
    """Check that the names of solid phases are valid and not used by the model."""
    for name in solids:
        if name in RESERVED:
            text = f"is a name of the model; others than {', '.join(RESERVED)} are free"
            yield ("solids", name), text
        elif not name.isascii() or not name.isidentifier():
            text = "the name of a solid phase has ASCII letters, digits and _ only"
            yield ("solids", name), text


def pairs_are_given_once(solids: Solids) -> Mistakes:
    """Check that exchange is given once for each pair of existing solid phases."""
    for name, item in solids.items():
        for other in item.exchange:
            path = ("solids", name, "exchange", other)
            if other == name:
                yield path, "a solid phase does not exchange heat with itself"
            elif other not in solids:
                near = get_close_matches(other, solids, n=1)
                known = f"there are {', '.join(solids)}"
                hint = f"did you mean '{near[0]}'?" if near else known
                yield path, f"no such solid phase; {hint}"
            elif name in solids[other].exchange and name > other:
                text = f"this pair stands also at solids.{other}.exchange; give it once"
                yield path, text


def feeds_lie_in_the_bed(
    bubbling_bed: BubblingBed, solids: Solids, see: See
) -> Mistakes:
    """Check that particles are fed below the surface of the bed."""
    for name, item in solids.items():
        if item.feed is not None and item.feed.height > bubbling_bed.height:
            height = see("bubbling_bed.height")
            text = f"above the bed, {bubbling_bed.height:g} m; see {height}"
            yield ("solids", name, "feed", "height"), text


def absent_phases_do_nothing(solids: Solids, see: See) -> Mistakes:
    """Check that a solid phase without volume has neither feed nor heat release."""
    for name, item in solids.items():
        if item.volume_share > 0:
            continue
        for key in ("feed", "release", "fuel", "limestone"):
            if getattr(item, key) is not None:
                share = see(f"solids.{name}.volume_share")
                text = f"there are no particles of this solid phase; see {share}"
                yield ("solids", name, key), text


def bubbles_carry_their_gas(bubbling_bed: BubblingBed, see: See) -> Mistakes:
    """Check that bubbles with gas have a volume, and that their temperature is
    determined.
    """
    bubbles = bubbling_bed.bubbles
    if bubbles is None or (not bubbles.capacity_flow and bubbles.fraction == 0):
        return
    if bubbles.fraction == 0:
        fraction = see("bubbling_bed.bubbles.fraction")
        text = f"there are no bubbles to carry it; see {fraction}"
        yield (*BUBBLES, "capacity_flow"), text
    elif bubbles.capacity_flow == 0 and bubbles.exchange == 0:
        text = "bubbles that neither flow nor exchange heat have no temperature"
        yield (*BUBBLES, "exchange"), text


def the_gas_fits_its_flow(
    gas: GasCantera | None, boundary: b.Boundary, see: See
) -> Mistakes:
    """Check that a mass flow has a [gas], and a capacity flow none."""
    computed = boundary.bottom.gas.computed
    if computed and gas is None:
        text = "this table is missing; its composition gives the properties of the gas"
        yield ("gas",), f"{text}; see {see(MASS_FLOW)}"
    if not computed and gas is not None:
        text = "has no use where coefficients are frozen"
        yield ("gas",), f"{text}; see {see(CAPACITY_FLOW)}"


def coefficients_fit_the_gas(
    boundary: b.Boundary,
    bubbling_bed: BubblingBed,
    solids: Solids,
    closures: b.Closures,
    origin: Origin,
    see: See,
) -> Mistakes:
    """Check that coefficients suit the way in which the gas is given.

    With a capacity flow all are numbers. With a mass flow closures exist and have the
    properties that they need.
    """
    computed = boundary.bottom.gas.computed
    freeboard = bubbling_bed.freeboard
    if not computed and freeboard is not None and freeboard.height is not None:
        text = f"a freeboard needs the properties of the gas: give {MASS_FLOW}"
        yield (*FREEBOARD, "height"), f"{text}; see {see(CAPACITY_FLOW)}"
        return
    tables = SimpleNamespace(
        bubbling_bed=bubbling_bed, solids=solids, closures=closures
    )
    if computed:
        yield from _closures_can_be_bound(uses(tables), bubbling_bed.bubbling, origin)
    else:
        yield from _coefficients_are_numbers(uses(tables), bubbling_bed, closures, see)
    yield from _flows_fit_the_gas(computed, bubbling_bed, solids, see)


def _closures_can_be_bound(
    places: Iterable[Use], bubbling: bool, origin: Origin
) -> Mistakes:
    """Check that closures exist and have the properties that they need."""
    for path, spec, kind in places:
        if not named(spec):
            continue
        try:
            bind(spec, kind, gives(path, kind, bubbling), origin.base)
        except SceneError as error:
            yield path, str(error)


def _coefficients_are_numbers(
    places: Iterable[Use], bubbling_bed: BubblingBed, closures: b.Closures, see: See
) -> Mistakes:
    """Check that frozen coefficients are numbers, and that none is given without
    use.
    """
    which = f"see {see(CAPACITY_FLOW)}"
    for path, spec, _ in places:
        table: Table | None = bubbling_bed
        if path == MINIMUM_FLUIDIZATION:
            unused, table = True, closures
        elif path[:-1] == BUBBLES:
            unused = path[-1] not in ("fraction", "exchange")
            table = bubbling_bed.bubbles
        else:
            unused = path == CONDUCTIVITY
        if unused:
            if table is not None and path[-1] in table.model_fields_set:
                yield path, f"has no use where coefficients are frozen; {which}"
        elif named(spec):
            yield (
                path,
                "a closure needs the properties of the gas: give a number, or "
                f"{MASS_FLOW}; {which}",
            )


def _flows_fit_the_gas(
    computed: bool, bubbling_bed: BubblingBed, solids: Solids, see: See
) -> Mistakes:
    """Check that streams are mass flows or capacity flows as that of the gas is."""
    bubbles = bubbling_bed.bubbles
    which = f"see {see(MASS_FLOW if computed else CAPACITY_FLOW)}"
    if bubbles is not None and computed == (bubbles.capacity_flow is not None):
        wanted = "missing; allowed: a number >= 0 W/K"
        if computed:
            wanted = "follows from the closures; leave it out"
        yield (*BUBBLES, "capacity_flow"), f"{wanted}; {which}"
    right, wrong = "capacity_flow", "mass_flow"
    if computed:
        right, wrong = wrong, right
    for name, item in solids.items():
        for key in ("density", "heat_capacity"):
            if computed and item.volume_share > 0 and getattr(item, key) is None:
                text = f"missing; {MASS_FLOW} needs it; {which}"
                yield ("solids", name, key), text
        if item.feed is None:
            continue
        missing = getattr(item.feed, right) is None
        if missing or getattr(item.feed, wrong) is not None:
            yield ("solids", name, "feed"), f"give {right}, not {wrong}; {which}"


def particles_exchange_heat_with_the_gas(
    solids: Solids, closures: b.Closures
) -> Mistakes:
    """Check that each solid phase has a coefficient of heat transfer to the gas."""
    for name, item in solids.items():
        known = (item.nusselt, item.gas_coefficient, closures.nusselt)
        if all(value is None for value in known):
            yield (
                ("solids", name),
                "gives no heat transfer to the gas: give nusselt, gas_coefficient, or "
                "closures.nusselt",
            )


def settling_has_what_it_needs(
    boundary: b.Boundary,
    bubbling_bed: BubblingBed,
    closures: b.Closures,
    solids: Solids,
    see: See,
) -> Mistakes:
    """Check the keys from which the height of the bed and the sizes of its particles
    follow.
    """
    settles = bubbling_bed.settled_height is not None
    if settles and not boundary.bottom.gas.computed:
        text = f"needs the properties of the gas; see {see(CAPACITY_FLOW)}"
        yield ("bubbling_bed", "settled_height"), text
    if closures.expansion is not None and not settles:
        height = see("bubbling_bed.height")
        yield EXPANSION, f"has no use where the height is given; see {height}"
    freeboard = bubbling_bed.freeboard
    for name, item in solids.items():
        if item.sizes is None or item.sizes.feed is None:
            continue
        path = ("solids", name, "sizes")
        if freeboard is None or freeboard.height is None:
            table = "[bubbling_bed.freeboard]"
            yield (
                path,
                "the inventory of particles that the gas carries away needs "
                f"{table} with a height; add it, or give the share in the bed by "
                "`bed`",
            )
        feed = item.inert_feed
        if feed is None or not feed.mass_flow:
            yield (
                path,
                f"needs the inflow solids.{name}.feed.mass_flow; add it, or give "
                "the share in the bed by `bed`",
            )


def the_gas_is_known(
    gas: GasCantera | None, boundary: b.Boundary, solids: Solids, origin: Origin
) -> Mistakes:
    """Check that the composition of the gas is valid and that its species are known."""
    if gas is None:
        return
    from contbed.materials.composition import _pairs

    try:
        amounts = [float(amount) for _, amount in _pairs(gas.composition)]
        known = mixture_of(gas, origin.base)
    except (SceneError, ValueError) as error:
        yield ("gas", "composition"), str(error)
        return
    if abs(sum(amounts) - 1.0) > SHARES:
        text = f"mole fractions sum to {sum(amounts):.8g}, not to 1"
        yield ("gas", "composition"), text
    hottest = known.T_range[1]
    entering: list[tuple[KeyPath, float]] = [
        ((*BOTTOM, "temperature"), boundary.bottom.gas.temperature)
    ]
    for name, item in solids.items():
        feed = item.inert_feed
        if feed is not None:
            entering.append((("solids", name, "feed", "temperature"), feed.temperature))
    for path, T in entering:
        if hottest < T:
            yield (
                path,
                "is above the highest temperature of the gas properties in "
                f"{gas.mechanism}, {hottest:g} K; lower it, or name a "
                "mechanism with a wider range",
            )


def something_fixes_the_plate(
    bubbling_bed: BubblingBed, boundary: b.Boundary, radiation: b.Radiation
) -> Mistakes:
    """Check that the temperature of the distributor is determined."""
    plate, bubbles = bubbling_bed.distributor, bubbling_bed.bubbles
    if plate is None:
        return
    gas = boundary.bottom.gas
    flow = gas.mass_flow or gas.capacity_flow or gas.velocity
    if not flow and bubbles is not None:
        flow = bubbles.capacity_flow
    radiates = radiation.level in ("p1", "two_flux") and plate.emissivity is not None
    if not plate.coefficient and not plate.preheat_NTU * (flow or 0.0) and not radiates:
        text = (
            "nothing exchanges heat with it: give coefficient or preheat_NTU, or "
            "leave out the table"
        )
        yield ("bubbling_bed", "distributor", "coefficient"), text


def something_fixes_the_temperatures(
    boundary: b.Boundary, bubbling_bed: BubblingBed, solids: Solids
) -> Mistakes:
    """Check that a stream or a surface carries heat away."""
    gas, bubbles = boundary.bottom.gas, bubbling_bed.bubbles
    feeds = [item.inert_feed for item in solids.values()]
    flows = [feed.capacity_flow or feed.mass_flow for feed in feeds if feed is not None]
    flows += [gas.capacity_flow, gas.mass_flow, gas.velocity]
    flows += [bubbles.capacity_flow] if bubbles is not None else []
    surfaces = [item.coefficient for item in bubbling_bed.surfaces.values()]
    if not any(flows) and not any(surfaces):
        yield (
            (*BOTTOM, "capacity_flow"),
            "no stream and no surface carries heat away: no steady state is determined",
        )


def positions_lie_in_the_bed(
    bubbling_bed: BubblingBed, output: Output, see: See
) -> Mistakes:
    """Check that the output positions lie in the bed."""
    where = see("bubbling_bed.height")
    yield from positions_outside(output, bubbling_bed.height, where)


def the_parameter_is_a_number(
    continuation: b.Continuation,
    bubbling_bed: BubblingBed,
    boundary: b.Boundary,
    gas: GasCantera | None,
    solids: Solids,
) -> Mistakes:
    """Check that the parameter of the continuation is a number of the scene that may
    vary.
    """
    tables = {
        "bubbling_bed": bubbling_bed,
        "boundary": boundary,
        "gas": gas,
        "solids": solids,
    }
    key = continuation.parameter
    fixed = key.startswith("bubbling_bed.height") or "diameter" in key
    examples = (
        f"boundary.bottom.gas.temperature, {MASS_FLOW}, "
        "bubbling_bed.walls.coefficient, solids.NAME.feed.temperature"
    )
    yield from parameter_varies(continuation, tables, fixed, examples)


CHECKS: tuple[Callable[..., Mistakes], ...] = (
    shares_sum_to_one,
    names_are_free,
    pairs_are_given_once,
    feeds_lie_in_the_bed,
    absent_phases_do_nothing,
    bubbles_carry_their_gas,
    the_gas_fits_its_flow,
    coefficients_fit_the_gas,
    particles_exchange_heat_with_the_gas,
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


WARNINGS: tuple[Callable[..., Mistakes], ...] = (
    tubes_fit_in_the_section,
    two_flux_is_low,
)
