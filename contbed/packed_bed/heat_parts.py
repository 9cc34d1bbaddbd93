"""What the plan of a packed bed says about heat: what is built, what is left out and
why.
"""

from __future__ import annotations

from collections.abc import Iterator

from contbed.course.schedule import Schedule
from contbed.packed_bed import scene as s
from contbed.packed_bed.inside import Inside
from contbed.packed_bed.medium import Medium
from contbed.packed_bed.radiation import described_level

# Nusselt numbers that hold with the dispersion that the same data were evaluated with:
# without, fronts are too steep
TAKEN_TOGETHER = {"nusselt_wakao_kaguei": "dispersion_wakao_kaguei"}


def parts_of_heat(
    scene: s.Scene,
    medium: Medium,
    schedule: Schedule,
    inside: Inside | None,
    fronts: bool,
) -> Iterator[tuple[str, str, bool]]:
    """Yield each part, its description, and whether it is built.

    Parameters
    ----------
    scene : as it is solved
    inside : how the level of intraparticle conduction was chosen, None without heat
    fronts : whether fronts stay sharp, by a closed form
    """
    if scene.heat is None:
        yield "two-energy", "no [heat] table", False
        return
    yield "two-energy", _how_heat(scene, medium, fronts), True
    if inside is not None:
        why = "no table solids.NAME.inside: " if scene.solid.inside is None else ""
        yield "intraparticle conduction", f"{why}{inside}", inside.level != "lumped"
    if scene.closures.dispersion is None:
        yield "dispersion", _why_no_dispersion(scene.closures), False
    if scene.closures.tortuosity is None:
        yield "cross conduction", "no closures.tortuosity", False
    if medium.constant:
        yield "Newton for temperatures", "constant properties: linear", False
    if scene.time is None:
        yield "time stepping", "no [time] table", False
    elif not fronts:
        from contbed.course.described import described_steps

        yield "steps", described_steps(scene.time, schedule), True
    if scene.time is not None and schedule:
        parts = len(schedule.cuts(scene.time.end)) - 1
        yield (
            "schedule",
            f"{len(schedule.samples)} series, {parts} parts without jump or kink",
            True,
        )
    yield (*described_level(scene), scene.radiation is not None)


def _why_no_dispersion(closures: s.Closures) -> str:
    """Return why there is none, and whether the Nusselt number was taken from data
    together with one.
    """
    nusselt = closures.nusselt
    name = nusselt if isinstance(nusselt, str) else getattr(nusselt, "name", "")
    together = TAKEN_TOGETHER.get(f"nusselt_{str(name).removeprefix('nusselt_')}")
    return "no closures.dispersion" + (
        f"; {name} was taken from data together with {together}" if together else ""
    )


def _how_heat(scene: s.Scene, medium: Medium, fronts: bool) -> str:
    if fronts:
        return "no conduction in a bed at rest: closed form of Schumann"
    time = "steady" if scene.time is None else "transient, TR-BDF2"
    form = "linear" if medium.constant else "temperature-dependent"
    return (
        f"{time}, {form}, degree "
        f"{scene.solver.degree}{', SUPG' if scene.solver.stabilisation else ''}"
    )
