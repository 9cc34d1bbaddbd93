"""Whether the inside of catalyst pellets is resolved: what their diffusion changes in
the bed, judged without it.

    E = max_k | int sum_j nu_kj (R_j - r_j) dx | / max_k | int sum_j nu_kj r_j dx |

r_j are the rates of the bed in which nothing resists inside of the pellets, along its
steady state, and R_j those of resolved pellets at its compositions and temperatures.
Where a rate falls the less is used up the more is left for the pellets behind, so that
E is more than what diffusion changes in what leaves, as long as reactions do not speed
up as they proceed.
"""

from __future__ import annotations

from dataclasses import dataclass

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.particle.pellets import Pellets, runs_in_pellets
from contbed.plan_text import percent
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.phases import species_of
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.solve import Report, steady
from contbed.reacting_bed.substances import Substances


@dataclass(frozen=True)
class PelletLevel:
    """Whether pellets are resolved, and the share E of what reacts that chose it;
    None where it could not be found.
    """

    resolved: bool
    error: float | None
    why: str = ""

    def __str__(self) -> str:
        if self.error is None:
            return self.why
        side = "above" if self.resolved else "within"
        change = percent(self.error)
        return (
            "neglecting intrapellet diffusion changes the reacted amounts by "
            f"{change}, {side} solver.accuracy"
        )


def decided(
    scene: s.ReactingScene, vertices: Array
) -> tuple[s.ReactingScene, PelletLevel | None]:
    """Return a scene with solids.NAME.inside.mass = "auto" decided, and why; None where
    it is no question.

    `vertices` are the cells to judge it on. A run in time has no one state to judge it
    by: its pellets are resolved.
    """
    if not any(
        table.inside.mass == "auto" for table in _with_diffusivities(scene).values()
    ):
        return scene, None
    if scene.time is not None:
        return scene, PelletLevel(True, None, "always resolved in transients")
    level = _judged(_with(scene, "none"), vertices)
    return _with(scene, "interior" if level.resolved else "none"), level


def _with(scene: s.ReactingScene, mass: str) -> s.ReactingScene:
    """Return the scene with a level in place of "auto"."""
    solids = dict(scene.solids)
    for name, table in solids.items():
        if table.inside.mass == "auto":
            inside = table.inside.model_copy(update={"mass": mass})
            solids[name] = table.model_copy(update={"inside": inside})
    return scene.model_copy(update={"solids": solids})


def _with_diffusivities(scene: s.ReactingScene) -> dict[str, s.Solid]:
    """Return the solid phases that have diffusivities of gases."""
    return {
        name: table for name, table in scene.solids.items() if table.inside.diffusivity
    }


def _judged(scene: s.ReactingScene, vertices: Array) -> PelletLevel:
    species = species_of(scene)
    try:
        error = missed(scene, Problem.of(scene, vertices, species), species)
    except ContbedError as found:
        return PelletLevel(
            True,
            None,
            "resolved, as the bed without intrapellet diffusion has no steady state "
            f"({found})",
        )
    return PelletLevel(error > scene.solver.accuracy, error)


def missed(scene: s.ReactingScene, problem: Problem, species: Substances) -> float:
    """Return E of a bed without resistance inside of its pellets."""
    problem, u = steady(problem, Report())
    bed = problem.bed
    state = bed.state(problem.at_all_points(u))
    values = bed.medium.at(state)
    free = {
        r.name: problem.integral(rate)
        for r, rate in zip(problem.reactions, bed.rates(state, values), strict=True)
    }
    held: dict[str, float] = {}
    for phase, table in _with_diffusivities(scene).items():
        gases = species.gases
        inside = [r for r in problem.reactions if r.phase == phase]
        chosen = [
            r
            for r in inside
            if runs_in_pellets(r.site, r.own_film, r.stoichiometry, gases)
        ]
        solids = bed.phases[phase].medium.solids
        means = Pellets.of(chosen, table.inside.diffusivity, solids)(
            problem.local(state, chosen[0])
        )
        pairs = zip(chosen, means, strict=True)
        held |= {r.name: problem.integral(mean) for r, mean in pairs}

    def largest(extents: dict[str, float]) -> float:
        made = dict.fromkeys(species.all, 0.0)
        for reaction in problem.reactions:
            for name, n in reaction.stoichiometry.items():
                made[name] += n * extents.get(reaction.name, 0.0)
        return max(map(abs, made.values()))

    whole = largest(free)
    return (
        largest({name: value - free[name] for name, value in held.items()}) / whole
        if whole
        else 0.0
    )
