"""Checks of a scene of one particle: mistakes that remain although every single value is valid."""

from __future__ import annotations

from contbed.scene.checking import Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.series import Series
from contbed.scene.series_checks import series_is_usable
from contbed.scene.toml_lines import Origin
from contbed.single_particle import scene as p

SLACK = 1e-6  # of a sum of mass fractions, for their rounding


def masses_add_up(constituent: dict[str, p.Constituent]) -> Mistakes:
    """Check that the fresh particle is complete."""
    total = sum(one.mass_fraction for one in constituent.values())
    if abs(total - 1.0) > SLACK:
        yield ("constituent",), f"mass fractions of the fresh particle sum to {total:.6g}; they must sum to 1"


def reactions_name_constituents(constituent: dict[str, p.Constituent], reactions: dict[str, p.Reaction]) -> Mistakes:
    """Check that reactions turn constituents into constituents and make no mass."""
    for name, reaction in reactions.items():
        for key, made in (("of", reaction.of), *(("yields", made) for made in reaction.yields)):
            if made not in constituent:
                path = ("reactions", name, key) if key == "of" else ("reactions", name, key, made)
                yield path, f"there is no constituent {made!r}; {nearest(made, list(constituent))}"
        total = sum(reaction.yields.values())
        if total > 1.0 + SLACK:
            yield ("reactions", name, "yields"), f"{total:.6g} kg of solids come from 1 kg; yields sum to 1 at most"
        if reaction.of in reaction.yields:
            yield ("reactions", name, "yields", reaction.of), "what reacts is among what is made; leave it out"


def series_are_usable(surroundings: p.Surroundings, time: p.Time, see: See, origin: Origin) -> Mistakes:
    """Check that series can be read and last as long as the run."""
    for key in ("surface", "temperature"):
        series = getattr(surroundings, key)
        if isinstance(series, Series):
            yield from series_is_usable(("surroundings", key), series, time, see, origin)


CHECKS = (masses_add_up, reactions_name_constituents, series_are_usable)
WARNINGS = ()
