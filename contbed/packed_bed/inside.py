"""Level of intraparticle conduction of a bed: lumped particles, a corrected film, or
temperatures inside.

With Bi = h R/k_s lumped particles follow the fluid through the external film only, or
by 1/h_eff = 1/h + R/((s+2) k_s), s = 3 for spheres and 2 for rods; points inside cost
one unknown each. The error of each level in what leaves is predicted from the exact
solutions of `particle.uptake`: that of a step at the inlet of a transient, the steady
moving bed, and fluid that passes the particles of a steady bed at rest, where h_eff is
exact. Where the level is "auto" the plan takes, of those within solver.accuracy, the
one of fewest unknowns, and of equal cost the one of least error.

Conduction along the bed and dispersion are left out of these solutions: in time they
smooth what levels miss, in a steady bed that moves they shift what leaves; errors there
were up to 2.4 times the predicted ones (`studies/levels_by_error`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.packed_bed import scene as s
from contbed.packed_bed.medium import Medium
from contbed.particle.interior import interior
from contbed.particle.level import SHAPES, Passage
from contbed.plan_text import percent

# temperatures inside that are tried where inside.points is absent
POINTS = (2, 3, 4, 6, 8, 12)
USUAL_POINTS = 3  # where temperatures inside are asked for and their number is not
# transfer units for which errors are predicted where the length or the flow is not
# known
USUAL_UNITS = 20.0
NAMES = {
    "lumped": "lumped particles, external film only",
    "effective": "lumped particles, film coefficient corrected for intraparticle "
    "conduction",
    "interior": "{points} intraparticle temperatures",
}


@dataclass(frozen=True)
class Candidate:
    """A level, its number of temperatures inside besides the surface, and its
    predicted error over the span.
    """

    level: str
    points: int
    error: float

    @property
    def unknowns(self) -> int:
        """Unknowns at each node of the bed: two temperatures, and those inside."""
        return 2 + self.points

    def __str__(self) -> str:
        return f"{self.name} {percent(self.error)}"

    @property
    def name(self) -> str:
        """The level, with its number of intraparticle temperatures."""
        return f"{self.level} with {self.points} points" if self.points else self.level

    @property
    def keys(self) -> str:
        """The keys of a scene that ask for this level."""
        points = f", inside.points = {self.points}" if self.points else ""
        return f'inside.heat = "{self.level}"{points}'


@dataclass(frozen=True)
class Inside:
    """Level and the numbers that chose it.

    passage : at the temperature of the inlet
    chosen : the level that is taken; candidates : all that this scene may take, from
        few unknowns to many
    accuracy : largest predicted error that the plan accepts
    """

    passage: Passage
    chosen: Candidate
    candidates: tuple[Candidate, ...]
    accuracy: float

    @property
    def level(self) -> str:
        """Name of the level that is taken."""
        return self.chosen.level

    @property
    def adequate(self) -> Candidate:
        """The level that "auto" takes."""
        return cheapest(self.candidates, self.accuracy)

    def __str__(self) -> str:
        model = NAMES[self.level].format(points=self.chosen.points)
        fourier = self.passage.fourier
        residence = "" if fourier is None else f", Fo = {fourier:.3g}"
        within = self.chosen.error <= self.accuracy
        sentences = [
            f"{model} (Bi = {self.passage.biot:.3g}{residence})",
            f"Predicted outlet error {percent(self.chosen.error)}, "
            f"{'within' if within else 'above'} "
            f"solver.accuracy = {100.0 * self.accuracy:g} %",
        ]
        named = {self.chosen} if within else {self.chosen, self.adequate}
        others = [
            each
            for each in self.candidates
            if each.unknowns <= self.chosen.unknowns and each not in named
        ]
        if others:
            sentences.append(
                "Predicted without more unknowns: "
                f"{', '.join(str(each) for each in others)}"
            )
        if not within:
            sentences.append(self._remedy())
        return ". ".join(sentences)

    def _remedy(self) -> str:
        better = self.adequate
        more = better.unknowns - self.chosen.unknowns
        cost = (
            f"{more} more unknowns at each node"
            if more > 0
            else "same cost"
            if more == 0
            else "fewer unknowns"
        )
        if better.error <= self.accuracy:
            return f"Set {better.keys} ({cost}, error {percent(better.error)})"
        if better == self.chosen:
            return "No other level is more accurate"
        return (
            f"The most accurate level is {better.keys} ({cost}, error "
            f"{percent(better.error)})"
        )


def cheapest(candidates: tuple[Candidate, ...], accuracy: float) -> Candidate:
    """Return the candidate of fewest unknowns within the accuracy, the better one of
    equal cost; else the best.
    """
    within = [each for each in candidates if each.error <= accuracy]
    if within:
        return min(within, key=lambda each: (each.unknowns, each.error))
    return min(candidates, key=lambda each: each.error)


def inside_of(
    scene: s.Scene, medium: Medium, velocity: Any, velocity_solid: Any
) -> Inside | None:
    """Return the level for a scene whose film is not corrected; None without two phases
    or without exchange.

    `velocity` and `velocity_solid` are vectors on the mesh [m/s].
    """
    if scene.heat is None or medium.solid is None:
        return None
    T = medium.T_fluid_in
    exchange = float(
        medium.exchange(T, medium.relative_speed(velocity, velocity_solid))
    )
    if exchange <= 0.0:
        return None
    radius, conductivity = 0.5 * scene.diameter, float(medium.solid.conductivity(T))
    biot = exchange / medium.area * radius / conductivity
    of_fluid, capacity = medium.capacities
    heat_fluid = of_fluid * float(np.linalg.norm(velocity))
    speed = float(np.linalg.norm(velocity_solid))
    length = getattr(scene.mesh, "length", None)
    units = (
        USUAL_UNITS
        if length is None or heat_fluid == 0.0
        else exchange * length / heat_fluid
    )
    fourier, gamma = None, 0.0
    solid_share = 1.0 - scene.packed_bed.porosity
    if speed > 0.0 and length is not None:
        fourier = (
            conductivity / capacity * length * solid_share / (speed * radius * radius)
        )
        if heat_fluid > 0.0:
            sign = np.sign(np.dot(velocity, velocity_solid)) or 1.0
            gamma = float(sign) * capacity * speed / heat_fluid
    last = np.inf
    if scene.time is not None:
        last = scene.time.end * exchange / (solid_share * capacity) / units

    passage = Passage(
        biot,
        units,
        SHAPES[scene.solid.shape],
        fourier,
        gamma,
        last,
        steady=scene.time is None,
    )
    wanted = scene.solid.inside
    stated: str = "lumped" if wanted is None else wanted.heat
    asked = None if wanted is None else wanted.points
    tried = (asked,) if asked else (USUAL_POINTS,) if stated == "interior" else POINTS
    found = [
        Candidate("lumped", 0, passage.error("lumped")),
        Candidate("effective", 0, passage.error("effective")),
    ]
    if scene.radiation is None:
        found += [
            Candidate("interior", points, passage.error(points)) for points in tried
        ]
    candidates, accuracy = tuple(found), scene.solver.accuracy
    named = tuple(each for each in candidates if stated in ("auto", each.level))
    return Inside(passage, cheapest(named, accuracy), candidates, accuracy)


def resolved(scene: s.Scene, inside: Inside | None) -> s.Scene:
    """Return the scene with the level and the points that were chosen in place of
    those left to the plan.
    """
    wanted = scene.solid.inside
    if inside is None or wanted is None:
        return scene
    changes: dict[str, Any] = {"heat": inside.level}
    if inside.level == "interior":
        changes["points"] = inside.chosen.points
    return scene.with_inside(wanted.model_copy(update=changes))


@dataclass(frozen=True)
class Mode:
    """One mode of conduction inside, as its share of the temperature at the surface.

    (1 - eps) rho c dT_m/dt = -decay T_m + gain (heat taken up through the surface per
    bed volume)
    """

    name: str
    decay: float  # [W/m3/K] for a conductivity of 1 W/m/K
    gain: float
    centre: float  # at the centre over that at the surface


def modes(scene: s.Scene) -> tuple[Mode, ...]:
    """Return the modes of the particles of a scene with temperatures inside; none
    for other levels.
    """
    wanted = scene.solid.inside
    if wanted is None or wanted.heat != "interior":
        return ()
    radius = 0.5 * scene.diameter
    inside = interior(wanted.points or USUAL_POINTS, SHAPES[scene.solid.shape])
    rates, vectors = inside.modes()
    middle = inside.at_centre() @ vectors
    scale = (1.0 - scene.packed_bed.porosity) / (radius * radius)
    return tuple(
        Mode(
            f"T_inside_{m}",
            scale * float(rates[m]),
            float(vectors[-1, m] ** 2),
            float(middle[m] / vectors[-1, m]),
        )
        for m in range(1, len(rates))
    )
