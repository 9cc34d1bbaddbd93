"""Checks of a scene of one particle: mistakes that remain although every single
value is valid.
"""

from __future__ import annotations

from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions, require_sum
from contbed.scene.checking import Mistakes
from contbed.scene.names import nearest
from contbed.scene.series_checks import series_are_usable
from contbed.single_particle import scene as p

SLACK = 1e-6  # of a sum of mass fractions, for their rounding


def masses_add_up(solids: dict[str, p.Solid]) -> Mistakes:
    """Check that the fresh particle is complete, of constituents with data."""
    for name, solid in solids.items():
        path = ("solids", name, "composition")
        try:
            require_sum(solid.composition, SLACK, in_moles=False)
            fresh = mole_fractions(solid.composition)
        except SceneError as error:
            yield path, str(error)
            continue
        for each in fresh:
            if each not in solid.constituent:
                there = nearest(each, list(solid.constituent))
                yield (
                    path,
                    f"{each!r} has no data; give solids.{name}.constituent.{each}, "
                    f"{there}",
                )


def reactions_name_constituents(
    solids: dict[str, p.Solid], reactions: dict[str, p.Reaction]
) -> Mistakes:
    """Check that reactions turn constituents into constituents and make no mass."""
    constituents = [name for solid in solids.values() for name in solid.constituent]
    for name, reaction in reactions.items():
        for key, made in (
            ("of", reaction.of),
            *(("yields", made) for made in reaction.yields),
        ):
            if made not in constituents:
                path = (
                    ("reactions", name, key)
                    if key == "of"
                    else ("reactions", name, key, made)
                )
                yield (
                    path,
                    f"there is no constituent {made!r}; {nearest(made, constituents)}",
                )
        total = sum(reaction.yields.values())
        if total > 1.0 + SLACK:
            yield (
                ("reactions", name, "yields"),
                f"{total:.6g} kg of solids come from 1 kg; yields sum to 1 at most",
            )
        if reaction.of in reaction.yields:
            yield (
                ("reactions", name, "yields", reaction.of),
                "what reacts is among what is made; leave it out",
            )


def the_surface_is_the_boundary(boundary: dict[str, p.Boundary]) -> Mistakes:
    """Check that there is one boundary, the surface."""
    for name in boundary:
        if name != p.SURFACE:
            yield (
                ("boundary", name),
                f"a particle has no such boundary; {nearest(name, [p.SURFACE])}",
            )
    if p.SURFACE not in boundary:
        yield (
            ("boundary", p.SURFACE),
            "missing; give fixed_temperature, or ambient with coefficient or emissivity",
        )


CHECKS = (
    masses_add_up,
    reactions_name_constituents,
    the_surface_is_the_boundary,
    series_are_usable,
)
WARNINGS = ()
