"""Gases and solids that enter and leave a reacting bubbling bed, and the heat that they
carry.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from contbed.bubbling_bed.chemistry.problem import Chemistry


@dataclass(frozen=True)
class Streams:
    """Flows through both ends of a bed [mol/s]; of volatiles [kg/s].

    entering, leaving : of each gas by phase; what leaves a freeboard is one phase
    fed, drained : of each solid
    T : of each phase that leaves, and of each solid phase where it is drained [K]
    """

    entering: dict[str, dict[str, float]]
    leaving: dict[str, dict[str, float]]
    fed: dict[str, float]
    drained: dict[str, float]
    T: dict[str, float]


def streams_of(problem: Any, chemistry: Chemistry, state: Any) -> Streams:
    """Return the streams of a solved bed."""
    part, c = chemistry.part, problem.c
    end = problem.top if part.velocity > 0 else problem.bottom

    def value(name: str, end: Any) -> float:
        return float(problem.at(lambda u, o: getattr(u, name), end, state))

    def entering(phase: str) -> dict[str, float]:
        flow = problem.at(
            lambda u, o: c.at(u, o).state["entering"][f"T_{phase}"],
            problem.bottom,
            state,
        )
        return part.as_entering(flow)

    # a freeboard is upside down
    outlets = (
        dict.fromkeys(part.phases, problem.top)
        if problem.above is None
        else {"freeboard": problem.bottom}
    )
    places = dict(outlets)
    places |= {solid.species: end for solid in part.solids.values()}
    return Streams(
        {phase: entering(phase) for phase in part.phases},
        {
            phase: {name: value(f"N_{name}_{phase}", outlet) for name in part.gases}
            for phase, outlet in outlets.items()
        },
        {
            name: problem.total(lambda u, o, s=solid: s.fed(o.x[0]), state)
            for name, solid in part.solids.items()
            if solid.fed is not None
        },
        {name: abs(part.velocity) * value(f"n_{name}", end) for name in part.solids},
        {name: value(f"T_{name}", place) for name, place in places.items()},
    )


def carried(
    problem: Any, chemistry: Chemistry, state: Any
) -> dict[str, tuple[float, float]]:
    """Return the enthalpy, heat of formation included, that each stream brings and
    takes away [W].
    """
    part, streams = chemistry.part, streams_of(problem, chemistry, state)

    def heat(flows: dict[str, float], T: float) -> float:
        return float(sum(n * part.gases[k].enthalpy(T) for k, n in flows.items()))

    out = {}
    for phase in part.phases:
        taken = 0.0  # a freeboard takes it further
        if problem.above is None:
            taken = heat(streams.leaving[phase], streams.T[phase])
        out[f"T_{phase}"] = heat(streams.entering[phase], problem.c.inlet), taken
    for name, solid in part.solids.items():
        brought = streams.fed.get(name, 0.0) * solid.enthalpy(solid.feed_temperature)
        taken = streams.drained[name] * solid.enthalpy(streams.T[solid.species])
        out[name] = (float(brought), float(taken))
    for k, ash in enumerate(part.ash):
        enthalpy = ash.enthalpy(ash.feed_temperature)
        brought = problem.total(
            lambda u, o, a=ash, h=enthalpy: a.fed(o.x[0]) * h, state
        )
        taken = problem.total(
            lambda u, o, a=ash: (
                a.fed(o.x[0]) * a.enthalpy(getattr(u, f"T_{a.species}"))
            ),
            state,
        )
        out[f"ash {k}"] = (brought, taken)
    return out
