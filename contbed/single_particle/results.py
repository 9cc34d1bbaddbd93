"""Results of one particle: balances of mass and heat, what is left and how hot it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from contbed.balance import Balance
from contbed.fields import header
from contbed.materials.common import share_outside
from contbed.result import Result
from contbed.scene.property_table import range_of
from contbed.single_particle.equations import SCALE_HEAT, Sphere
from contbed.single_particle.history import ParticleHistory
from contbed.single_particle.plan import Plan

# of the mass, below which none is lost, and no time in which half of it is
LEAST_LOSS = 1e-9
# of the heat that the outermost shell would conduct to a surface at 0 K: what it does
# conduct is a small difference in a fine particle, whose rounding is 1e-14 of it
CONDUCTED_SHARE = 1e-5
# of the rise by reactions, between neighbouring shells, above which they do not resolve
# a front: three shells across it
THIN_FRONT = 0.33


def balances(
    problem: Sphere, begin: ParticleHistory, history: ParticleHistory, result: Result
) -> None:
    """Fill in the balances of energy and mass."""
    material, n = problem.material, problem.shells
    whole = material.density * np.pi / 6.0 * (2.0 * material.radius) ** 3
    before, content = (
        problem.content(each.state, False)[0][:n] for each in (begin, history)
    )
    stored = SCALE_HEAT * float((content - before).sum())
    conducted, carried, released, left = history.sums
    held = SCALE_HEAT * float(np.abs(content).sum())
    between = problem.conductance(history.state) * history.state[-1] * history.time
    least = max(held, CONDUCTED_SHARE * between)
    parts = [conducted * whole, -carried * whole]
    both_ways = (history.exchanged + abs(carried)) * whole
    result.balances["energy"] = Balance.of_fluxes(
        parts, "J", released * whole, stored * whole, least * whole, both_ways
    ).as_dict()
    gain = problem.left(history.state) - problem.left(begin.state)
    result.balances["mass"] = Balance.of_fluxes(
        [-left * whole], "kg", 0.0, gain * whole, whole
    ).as_dict()


def profiles(
    plan: Plan, problem: Sphere, kept: Mapping[float, Any], result: Result
) -> None:
    """Fill in what is left and temperatures at the output times."""
    n, volume = problem.shells, problem.volume
    states = kept.values()
    masses = np.array([problem.masses(state) @ volume for state in states])
    result.profiles = {
        header("t"): np.array(list(kept)),
        header("mass_fraction"): masses.sum(axis=1),
        header("T_centre"): np.array([problem.centre(state) for state in states]),
        header("T_surface"): np.array([state[-1] for state in states]),
        header("T_mean"): np.array([state[:n] @ volume for state in states]),
    }
    solid = plan.scene.solid
    for k, name in enumerate(solid.constituent):
        result.profiles[f"mass_fraction.{name} [1]"] = masses[:, k]
    capacities = [one.heat_capacity for one in solid.constituent.values()]
    limits = range_of(solid.conductivity, solid.conductivity_product, *capacities)
    T = np.array([state[:n] for state in states])
    if share_outside(T, limits):
        low, high = limits
        result.warnings.append(
            f"data of the particle from {low:g} to {high:g} K are used at "
            f"{T.min():.5g} to {T.max():.5g} K"
        )


def findings(passed: NDArray[np.float64], span: float, result: Result) -> None:
    """Fill in numbers of the whole run; `passed` (n, 5) is that of the history, `span`
    the difference between start and surroundings [K].
    """
    times, mass, centre, above, steepest = passed.T
    if above.max() > span and steepest.max() > THIN_FRONT * above.max():
        result.warnings.append(
            f"reactions heat the particle by {above.max():.4g} K, "
            f"{steepest.max():.4g} K of it from one shell to the next: the front is "
            "thinner than a shell, and its speed and peak depend on "
            "single_particle.cells; raise it until they no longer change"
        )
    hottest = int(np.argmax(centre))
    result.qoi |= {
        "mass_fraction_end": float(mass[-1]),
        "T_centre_max_K": float(centre[hottest]),
        "time_of_T_centre_max_s": float(times[hottest]),
    }
    if mass[0] - mass[-1] > LEAST_LOSS:
        left, middle = PchipInterpolator(times, mass), 0.5 * (mass[0] + mass[-1])
        k = int(np.argmax(mass <= middle))
        result.qoi["half_time_s"] = float(
            brentq(lambda t: left(t) - middle, times[k - 1], times[k])
        )
