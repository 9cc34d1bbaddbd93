"""Why a bubbling bed has no solution: what the last state says, where, and what to
change.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.bubbling_bed.closures import BUBBLES
from contbed.chemistry.elements import ATOMIC_WEIGHTS

BARELY = 0.05  # excess gas over u_mf below which a place counts as barely fluidized
WIDE = 2.0  # diameter of bubbles over that of the bed beyond which the run warns
# temperatures are looked at this many kelvin beyond the properties of the gas
SHOWN = 20.0


def explain(problem: Any, states: list[Any]) -> str:
    """Return a sentence on states [K and other unknowns] at which Newton's method
    has failed: the first known cause.
    """
    for x in states:
        for cause in (temperatures, fluidization, char):
            if (text := cause(problem, x)) is not None:
                return text
    return _residual(problem, states[-1])


def temperatures(problem: Any, x: Any) -> str | None:
    """Say where a temperature has left the properties of the gas; None where none
    has.
    """
    if problem.c.computed is None:
        return None
    z = problem.space.points[0]
    low, high = problem.c.computed.gas.T_range
    for name in problem.c.streams:
        T = problem.system.part(x, name)
        for k, beyond in (
            (int(np.argmax(T)), T.max() > high + SHOWN),
            (int(np.argmin(T)), T.min() < low - SHOWN),
        ):
            if beyond:
                more = (
                    "less heat release, or more cooling or gas"
                    if T[k] > high
                    else "hotter gas, or less cooling"
                )
                return (
                    f"{name} reaches {T[k]:.4g} K at {z[k]:.3g} m, beyond the "
                    f"properties of the gas, {low:g} to "
                    f"{high:g} K: {more}"
                )
    return None


def fluidization(problem: Any, x: Any) -> str | None:
    """Say where gas flows down through the emulsion, or barely fluidizes the bed;
    None where it does neither.
    """
    computed = problem.c.computed
    if computed is None or not computed.bubbling:
        return None
    z, state = problem.space.points[0], problem._state(x)
    values: dict[str, Any] = {
        name: problem.system.part(state, name) for name in problem.c.fields
    }
    values |= {
        name: float(problem.system.part(state, name)[0]) for name in problem.c.scalars
    }
    with np.errstate(all="ignore"):
        found = computed.recorded(values, z)[0].state
    if (
        text := flows_down(
            problem.plan.scene, np.broadcast_to(found["u_emulsion_closure"], z.shape), z
        )
    ) is not None:
        return text
    D, d_b = computed.D_bed, np.broadcast_to(found["d_b"], z.shape)
    if (widest := float(np.nanmax(d_b))) > WIDE * D:
        return (
            f"bubbles of {widest:.3g} m at {z[int(np.nanargmax(d_b))]:.3g} m do not "
            f"fit into a bed of {D:.3g} m: they "
            "are slugs, for which the closures do not hold; give less gas.mass_flow, "
            "or bubbles.size as a number"
        )
    u_mf = np.broadcast_to(found["u_mf"], z.shape)
    excess = np.broadcast_to(found["u_excess"], z.shape) / u_mf
    if not np.any(bare := excess < BARELY):
        return None
    k = int(np.argmin(np.where(np.isfinite(excess), excess, np.inf)))
    T = float(np.broadcast_to(found["T"], z.shape)[k])
    return (
        "boundary.bottom.gas.mass_flow barely fluidizes the bed or not at all between "
        f"{z[bare].min():.3g} and {z[bare].max():.3g} m: at {z[k]:.3g} m u_mf is "
        f"{u_mf[k]:.3g} m/s in particles "
        f"of {T:.4g} K, and mixing by bubbles vanishes; give "
        "more gas, hotter gas, a smaller bubbling_bed.distributor.coefficient, or a "
        "bubbling_bed.conductivity of the "
        "resting emulsion"
    )


def char(problem: Any, x: Any) -> str | None:
    """Say that char piles up, as no oxygen is left where it is; None where it does
    not.
    """
    scene, chemistry = problem.plan.scene, problem.chemistry
    if scene.fuel is None or "n_char" not in problem.c.fields:
        return None
    part, fuel = chemistry.part, scene.solids[scene.fuel].fuel
    volume = problem.system.part(x, "n_char").max() * ATOMIC_WEIGHTS["C"]
    share = volume / fuel.char_density / (part.section * (1.0 - part.voidage))
    if not share > 1.0:
        return None
    text = (
        f"char piles up to {share:.3g} times the volume of all particles, as it burns "
        "more slowly than it is fed"
    )
    bubbles = ""
    if "bubble" in part.phases and "O2" in part.gases:
        N = problem.system.part(x, "N_O2_bubble")
        entering = part.inlet["O2"] * chemistry.inlet_flow
        passing = N[np.argmax(problem.space.points[0])] / entering
        text += f" (bubbles carry {100 * passing:.3g} % of the oxygen through the bed)"
        bubbles = (
            "smaller bubbles (bubbling_bed.bubbles.size as a number), a faster "
            "bubbles.gas_exchange, "
        )
    return f"{text}: give {bubbles}less fuel, more oxygen, or a bubbling_bed.drain"


def flows_down(scene: Any, u_e: Any, z: Any) -> str | None:
    """Say where a closure lets gas flow down, by `u_e` [m/s] in the emulsion at
    heights `z` [m]; None where nowhere.
    """
    if not np.any(u_e <= 0):
        return None
    k, key = int(np.nanargmin(u_e)), (*BUBBLES, "emulsion_gas")
    return (
        f"{scene.origin.place(key)}: the gas would flow down through the "
        "emulsion "
        f"between {z[u_e <= 0].min():.3g} and {z[u_e <= 0].max():.3g} m, {u_e[k]:.3g} "
        f"m/s at {z[k]:.3g} m, "
        "which the model does not hold for; take another closure, a smaller wake, a "
        "number, or less gas"
    )


def _residual(problem: Any, x: Any) -> str:
    """Name the field and height whose equation is missed most."""
    z = problem.space.points[0]
    with np.errstate(all="ignore"):
        residual, matrix = problem.steady(x, True)
    terms = abs(matrix) @ np.abs(x)
    share = {
        name: np.abs(problem.system.part(residual, name))
        / np.maximum(problem.system.part(terms, name), 1e-300)
        for name in problem.c.fields
    }
    worst = max(share, key=lambda name: float(np.nanmax(share[name], initial=0.0)))
    k = int(np.nanargmax(np.nan_to_num(share[worst])))
    bubbles = ""
    if problem.c.computed is not None and problem.c.computed.grows:
        bubbles = "bubbling_bed.bubbles.size as a number, "
    return (
        f"the balance of {worst} is missed most, at {z[k]:.3g} m; give another "
        f"initial.temperature, {bubbles}or a finer mesh by mesh.refine = "
        f"{problem.plan.scene.mesh.refine + 1}"
    )
