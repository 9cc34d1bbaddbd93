"""Checks of several solid phases in one bed, and the checks of one phase done for each of them."""

from __future__ import annotations

import inspect
import math
import re
from functools import wraps
from typing import Any

from contbed.closures.binding import named
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.medium import bound
from contbed.reacting_bed.phases import phases_named as kinds_named
from contbed.reacting_bed.streams import slowest
from contbed.reacting_bed.substances import constituents_of, fed_to
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.series import Series
from contbed.scene.toml_lines import KeyPath, Origin

Kinds = dict[str, s.SolidKind]
Reactions = dict[str, s.Reaction]
WHOLE = 1e-6  # by which shares of the volume may miss one
NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*")


def _with_solids(check: Check, each: Check) -> Check:
    """Return `each` with the parameters of a check and the solid phases."""
    signature = inspect.signature(check)
    more = inspect.Parameter("solids", inspect.Parameter.KEYWORD_ONLY, annotation=Kinds)
    parameters = [*signature.parameters.values(), more]
    each.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return each


def merged(solids: Kinds) -> s.Solids:
    """Return particles with the constituents of all kinds, for their names and data."""
    names = dict.fromkeys(name for table in solids.values() for name in fed_to(table))
    composition = ", ".join(f"{name}:{1.0 / len(names)!r}" for name in names) if names else None
    return s.Solids(composition=composition, constituent=constituents_of(solids))


def _can_be_read(solids: Kinds) -> bool:
    try:
        return bool(merged(solids))
    except SceneError:
        return False


def of_all_kinds(check: Check) -> Check:
    """Return a check of a scene whose solids are those of all kinds, with the velocity of the slowest that moves."""

    @wraps(check)
    def each(solids: Kinds, **given: Any) -> Mistakes:
        if solids and not _can_be_read(solids):
            return  # `compositions_sum_to_one` says so
        if solids:
            given["solid"] = merged(solids)
            if "flow" in given and not isinstance(given["flow"].velocity_solid, Series):
                speeds = [
                    constant(given["flow"].velocity_solid if v is None else v)
                    for v in (table.velocity_solid for table in solids.values())
                ]
                given["flow"] = _moving(given["flow"], slowest(speeds))
        yield from check(**given)

    return _with_solids(check, each)


def of_one_kind(check: Check) -> Check:
    """Return a check of a scene that is left out where several kinds fill the bed."""

    @wraps(check)
    def each(solids: Kinds, **given: Any) -> Mistakes:
        if not solids:
            yield from check(**given)

    return _with_solids(check, each)


def in_each_kind(check: Check) -> Check:
    """Return a check of a scene that is done for each kind, with its velocity and the reactions that may run in it."""

    @wraps(check)
    def each(solids: Kinds, **given: Any) -> Mistakes:
        if not solids:
            yield from check(**given)
            return
        said = set()
        for kind, table in solids.items():
            own = dict(given)
            if "solid" in given:
                own["solid"] = _alone(solids, kind)
            if "flow" in given and table.velocity_solid is not None:
                own["flow"] = _moving(given["flow"], table.velocity_solid)
            if "reactions" in given:
                running = {k: r for k, r in given["reactions"].items() if not r.solid or kind in kinds_named(r)}
                own["reactions"] = running
            if "adsorption" in given:
                own["adsorption"] = table.adsorption
            for path, text in check(**own):
                path = _of_kind(path, kind)
                mistake = path, text.replace("solid.", f"solids.{kind}.")
                if mistake not in said:
                    said.add(mistake)
                    yield mistake

    return _with_solids(check, each)


def _of_kind(path: KeyPath, kind: str) -> KeyPath:
    """Return where a key of one kind stands among several."""
    if path[0] == "solid":
        return ("solids", kind, *path[1:])
    return ("solids", kind, *path) if path[0] == "adsorption" else path


def _moving(flow: s.Flow, velocity: float) -> s.Flow:
    return flow.model_copy(update={"velocity_solid": velocity})


def _alone(solids: Kinds, kind: str) -> s.Solids:
    """Return a kind with the data of all kinds on the constituents that enter with it."""
    table = solids[kind]
    try:
        fed = fed_to(table)
    except SceneError:
        return table
    data = {name: each for other in solids.values() for name, each in other.constituent.items() if name in fed}
    return table.model_copy(update={"constituent": data})


def particles_have_a_size(solid: s.Solids | None, bed: s.Bed, solids: Kinds, mesh: Any, see: See) -> Mistakes:
    """Check that one solid phase or several fill the bed, each with a diameter below the length of the bed."""
    if solid is not None and solids:
        yield (
            ("solids",),
            f"one kind fills the bed already, {see('solid')}; give a table of [solids] for each kind alone",
        )
    if not solids and bed.particle_diameter is None:
        yield ("bed", "particle_diameter"), "missing"
    if solids and bed.particle_diameter is not None:
        yield ("bed", "particle_diameter"), "each kind of [solids] has its own; remove it"
    sizes: dict[KeyPath, float | None] = {("bed", "particle_diameter"): bed.particle_diameter}
    sizes |= {("solids", kind, "particle_diameter"): table.particle_diameter for kind, table in solids.items()}
    for path, d in sizes.items():
        if d is not None and d > mesh.length:
            yield path, f"{d:g} m is more than the length of the bed, {see('mesh.length')}; is a unit missing?"


def kinds_fill_the_bed(solids: Kinds, origin: Origin) -> Mistakes:
    """Check names and shares of kinds, that each constituent has its data once, and their own closures."""
    if not solids:
        return
    total = sum(table.volume_share for table in solids.values())
    if not math.isclose(total, 1.0, abs_tol=WHOLE):
        yield ("solids",), f"the shares of the volume sum to {total:.6g}, not to 1; correct volume_share"
    seen: dict[str, tuple[str, s.Substance]] = {}
    for kind, table in solids.items():
        if not NAME.fullmatch(kind):
            yield ("solids", kind), "names of results end with it: letters and digits only, beginning with a letter"
        for name, data in table.constituent.items():
            first, other = seen.setdefault(name, (kind, data))
            if other != data:
                yield (
                    ("solids", kind, "constituent", name),
                    f"has other data in solids.{first}; they hold in all kinds: give them once, or another name",
                )
        for key in ("nusselt", "sherwood"):
            if named(getattr(table, key)):
                try:
                    bound(getattr(table, key), key, origin.base)
                except SceneError as error:
                    yield ("solids", kind, key), str(error)


def kinds_have_what_they_give(
    solids: Kinds, flow: s.Flow, heat: s.Heat | None, mass: s.Mass | None, see: See
) -> Mistakes:
    """Check that kinds move one way, and that their own numbers of Nusselt and Sherwood have a meaning."""
    fixed = not isinstance(flow.velocity_solid, Series)
    first = 0.0
    for kind, table in solids.items():
        if table.nusselt is not None and (heat is None or heat.nusselt is None):
            yield (
                ("solids", kind, "nusselt"),
                "has no meaning where gas and particles have one temperature; give heat.nusselt, which the others have",
            )
        if table.sherwood is not None and (mass is None or mass.sherwood is None):
            yield ("solids", kind, "sherwood"), "has no meaning without mass.sherwood, which the others have; give it"
        v = table.velocity_solid
        if v is None and fixed:
            v = constant(flow.velocity_solid)
        if not fixed and table.velocity_solid is not None:
            yield (
                ("solids", kind, "velocity_solid"),
                f"is constant, and that of other kinds changes with time, {see('flow.velocity_solid')}; remove one",
            )
        first = first or (v or 0.0)
        if (v or 0.0) * first < 0.0:
            yield ("solids", kind, "velocity_solid"), "kinds that move go one way; give it the sign of the others"


def reactions_name_kinds(reactions: Reactions, solids: Kinds) -> Mistakes:
    """Check that the kinds exist in which reactions run."""
    for name, table in reactions.items():
        if table.solid is None:
            continue
        path = ("reactions", name, "solid")
        if not solids:
            yield path, "has no meaning where one solid phase fills the bed; remove it, or give [solids.NAME]"
            continue
        for kind in kinds_named(table):
            if kind not in solids:
                yield path, f"there is no kind {kind!r}; {nearest(kind, list(solids))}"
        if table.basis in ("gas", "bed"):
            yield path, f"a rate per m3 of {table.basis} is not that of a kind; give basis = 'catalyst' or 'particle'"


def kinds_tell_what_they_adsorb(solids: Kinds, adsorption: dict[str, s.Adsorption]) -> Mistakes:
    """Check that each of several solid phases states which gases it adsorbs."""
    for gas in adsorption if solids else ():
        yield (
            ("adsorption", gas),
            f"does not say which solid phase adsorbs it; give solids.NAME.adsorption.{gas}, for each that does",
        )


CHECKS: tuple[Check, ...] = (
    particles_have_a_size,
    kinds_fill_the_bed,
    kinds_have_what_they_give,
    reactions_name_kinds,
    kinds_tell_what_they_adsorb,
)
