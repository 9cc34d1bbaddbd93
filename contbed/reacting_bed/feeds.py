"""Feeds of which particles adsorb nearly all, so that little gas moves on.

At one temperature and pressure such a feed displaces the gas that filled the pores,
ahead of a front that leaves q behind it,

    u = u_in eps c/(eps c + rho_b q)      rho_b the mass of particles per volume of bed

Gas that follows at once displaces nothing: it has no flux left where all of it is
adsorbed. It is stored instead. Ahead of a front that is shorter than a cell the flux
is a small difference of large ones, which polynomials turn back. The upwind
equations of cells with one value have a solution whose amounts and flux are above zero.
"""

from __future__ import annotations

from dataclasses import replace

from contbed.course.schedule import Schedule
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.problem import Problem

# mole fraction of what is not adsorbed in a feed, below which little is left to move on
LITTLE = 0.05
ROUNDING = 1e-9
STORAGE = ("packed_bed", "gas_storage")


def least_left(scene: s.ReactingScene, problem: Problem, schedule: Schedule) -> float:
    """Return the least mole fraction, in time, of what enters and is not adsorbed."""
    adsorbed = {name for table in scene.solids.values() for name in table.adsorption}
    if not adsorbed:
        return 1.0
    shares = []
    for at in problem.at_moments(scene, schedule):
        gas = at.streams.gas
        left = sum(moles for name, moles in gas.items() if name not in adsorbed)
        shares.append(left / at.streams.moles)
    return float(min(shares))


def require_gas_left(
    scene: s.ReactingScene, problem: Problem, schedule: Schedule
) -> None:
    """Refuse a gas that follows at once where all of what enters is adsorbed.

    Raises
    ------
    SceneError : names the key
    """
    if scene.time is None or scene.initial.gas.composition is None:
        return
    if scene.packed_bed.gas_storage != "quasi_steady":
        return
    if least_left(scene, problem, schedule) < ROUNDING:
        raise SceneError(
            f"{scene.origin.at(STORAGE)}: packed_bed.gas_storage: all of the gas that "
            "enters is adsorbed, and a gas that follows at once displaces nothing: "
            'no gas would flow ahead of the front; give "stored", or leave it out'
        )


def with_cells_of_one_value(problem: Problem) -> Problem:
    """Return the problem with one value a cell, unless its scene gives a degree."""
    if problem.scene.solver.degree is not None:
        return problem
    return replace(problem, line=replace(problem.line, degree=0))
