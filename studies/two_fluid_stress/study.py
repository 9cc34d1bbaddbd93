"""How hard the two-fluid model can be pushed: small beds in every corner, watched
after each step.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import ContbedError
from contbed.loading import from_dict
from contbed.two_fluid import plan as planning
from studies import _gallery as gallery
from studies._gallery import Table, Tables, merged

HERE = Path(__file__).parent
STEPS = 20000  # in which a case must be done
# of particles [m/s], several times what any case gives them: more is noise
SPEED = 20.0
NOT_COMPARED = ("end s", "steps", "eps_s min", "eps_s max", "room", "theta min", "theta max", "speed max m/s",
                "speed end m/s", "mass error", "CPU s", "remark")  # fmt: skip
SLOW = 1e-3  # [m/s] smallest speed of the picture
REST = 1e-10  # [m/s] largest speed of a level bed at the end
DENSE = 1e-6  # fraction of particles below which their speed says nothing
COLUMNS = ("group", "case", "passed", "end s", "steps", "eps_s min", "eps_s max", "room", "theta min", "theta max",
           "speed max m/s", "speed end m/s", "mass error", "CPU s", "remark")  # fmt: skip
BASE = {
    "mesh": {"type": "rectangle", "length": 0.1, "height": 0.3, "cells": [12, 36]},
    "two_fluid": {},
    "gas": {"density": 1.2, "viscosity": 1.8e-5},
    "solids": {"beads": {"diameter": 275e-6, "density": 2500.0}},
    "initial": {"solids": {"beads": {"granular_temperature": 1e-4}}},
    "boundary": {
        "bottom": {"type": "inlet", "gas": {"velocity": 0.4}},
        "top": {"type": "outlet"},
        "left": {"type": "wall"},
        "right": {"type": "wall"},
    },
    "time": {},
}
WALL = {"type": "wall"}
ROUGH = WALL | {
    "solids": {
        "beads": {"wall": "johnson_jackson", "specularity": 0.05, "restitution": 0.9}
    }
}
WALLS = {
    "no-slip": WALL,
    "slip": WALL | {"gas": {"wall": "slip"}, "solids": {"beads": {"wall": "slip"}}},
    "Johnson-Jackson": ROUGH,
    "mirror-smooth": merged(
        ROUGH, {"solids": {"beads": {"specularity": 1e-4, "restitution": 1.0}}}
    ),
    "rough": merged(
        ROUGH, {"solids": {"beads": {"specularity": 1.0, "restitution": 0.1}}}
    ),
}
# velocity of the gas [m/s]
SIZES = {"50 um": 0.03, "150 um": 0.15, "500 um": 0.6, "3 mm": 2.0}
PAIRS = {  # density of particles and fluid, viscosity, velocity
    1.1: (1100.0, 1000.0, 1e-3, 0.005),
    2.5: (2500.0, 1000.0, 1e-3, 0.02),
    100: (2500.0, 25.0, 1.8e-5, 0.3),
    2000: (2500.0, 1.25, 1.8e-5, 0.4),
    10000: (2500.0, 0.25, 1.8e-5, 0.4),
}
COURANT = (0.1, 0.5, 0.9, 1.0)


@dataclass(frozen=True)
class Case:
    """One bed: what its scene has besides BASE, how long, and what happens to it.

    random : start from random fields; then : changes of the scene after half the time
    """

    group: str
    name: str
    end: float
    changes: dict
    random: bool = False
    then: dict | None = None


def layer(start, end, eps_s, velocity=0.0):
    """Particles between two heights, which move with the gas."""
    beads = {"volume_fraction": eps_s, "velocity": velocity}
    one = {
        "start": start,
        "end": end,
        "gas": {"velocity": velocity},
        "solids": {"beads": beads},
    }
    return {"initial": {"layer": [one]}}


def sides(wall):
    """Both sides alike."""
    return {"boundary": {"left": wall, "right": wall}}


BED = layer(-1.0, 0.12, 0.58)
CLOSED = {"boundary": {"bottom": WALL}}
BOX = {"boundary": {"bottom": WALL, "top": WALL}}
RANDOM = {"boundary": {"bottom": {"type": "inlet", "gas": {"velocity": 0.3}}}}
SCHAEFFER = {"closures": {"friction_viscosity": "friction_viscosity_schaeffer"}}
TRIANGLES = {"mesh": {"shape": "triangle", "cells": [9, 27]}}
ALGEBRAIC = {"two_fluid": {"granular_temperature": "algebraic"}}
UNGUARDED = {"two_fluid": {"guards": False}}
FROZEN = {"two_fluid": {"granular_temperature": "frozen"}}
VARIANTS = {
    "quadrilaterals": {},
    "triangles": TRIANGLES,
    "Schaeffer": SCHAEFFER,
    "Schaeffer, triangles": merged(SCHAEFFER, TRIANGLES),
    "algebraic theta": ALGEBRAIC,
    "theta = 0": {"initial": {"solids": {"beads": {"granular_temperature": 0.0}}}},
    "theta frozen": FROZEN,
    "no guards": UNGUARDED,
    "no friction": {
        "closures": {"friction_pressure": "none", "friction_viscosity": "none"}
    },
    "Syamlal": {
        "closures": {
            "drag": "drag_syamlal_obrien",
            "granular_viscosity": "granular_viscosity_syamlal",
        }
    },
    "Carnahan-Starling": {"closures": {"radial_distribution": "g0_carnahan_starling"}},
}


def all_cases() -> Iterator[Case]:
    """The whole table."""
    for speed in (1.0, 2.0, 5.0):
        thrown = layer(0.1, 0.2, 0.55, velocity=-speed)
        for courant in COURANT:
            step = {"time": {"courant": courant}}
            yield Case(
                "shock",
                f"slug at {speed:g} m/s, Courant {courant}",
                0.3,
                merged(merged(thrown, CLOSED), step),
            )
        for name in (
            "triangles",
            "Schaeffer",
            "algebraic theta",
            "no guards",
        ):
            yield Case(
                "shock",
                f"slug at {speed:g} m/s, {name}",
                0.3,
                merged(merged(thrown, CLOSED), VARIANTS[name]),
            )
    fall = merged(layer(0.15, 0.3, 0.55), BOX)
    for courant in COURANT:
        yield Case(
            "fall",
            f"column in a box, Courant {courant}",
            0.6,
            merged(fall, {"time": {"courant": courant}}),
        )
    for name in ("triangles", "Schaeffer"):
        yield Case(
            "fall", f"column in a box, {name}", 0.6, merged(fall, VARIANTS[name])
        )
    yield Case(
        "fall",
        "3 mm, restitution 1",
        0.6,
        merged(fall, {"solids": {"beads": {"diameter": 3e-3, "restitution": 1.0}}}),
    )

    for name in ("quadrilaterals", "triangles", "no guards"):
        yield Case(
            "inlet", f"gas into an empty box, {name}", 0.5, merged(VARIANTS[name], {})
        )
        for eps_s in (1e-9, 1e-4, 0.3, 0.6):
            inlet = {
                "bottom": {
                    "type": "inlet",
                    "gas": {"velocity": 5.0},
                    "solids": {
                        "beads": {
                            "volume_fraction": eps_s,
                            "velocity": 2.0,
                            "granular_temperature": 0.1,
                        }
                    },
                }
            }
            yield Case(
                "inlet",
                f"particles into nothing, eps_s {eps_s:g}, {name}",
                0.4,
                merged(VARIANTS[name], {"boundary": inlet}),
            )
    inlet = {
        "bottom": {
            "type": "inlet",
            "gas": {"velocity": 5.0},
            "solids": {
                "beads": {
                    "volume_fraction": 0.6,
                    "velocity": 2.0,
                    "granular_temperature": 0.1,
                }
            },
        }
    }
    yield Case(
        "inlet",
        "particles into nothing, eps_s 0.6, slip walls",
        0.4,
        merged({"boundary": inlet}, sides(WALLS["slip"])),
    )
    inlet = {
        "boundary": {
            "bottom": {
                "type": "inlet",
                "solids": {"beads": {"volume_fraction": 0.3, "velocity": 1.0}},
            },
            "top": WALL,
            "right": {"type": "outlet"},
        }
    }
    for name, wall in (("no-slip", WALL), ("slip", WALLS["slip"])):
        sideways = merged(inlet, {"boundary": {"left": wall}})
        yield Case(
            "inlet", f"particles thrown up to a wall, {name} side", 0.5, sideways
        )

    for e in (0.5, 0.8, 0.9, 0.99, 1.0):
        yield Case(
            "restitution",
            f"bed, e {e}",
            1.0,
            merged(BED, {"solids": {"beads": {"restitution": e}}}),
        )
        yield Case(
            "restitution",
            f"random, e {e}",
            0.3,
            merged(RANDOM, {"solids": {"beads": {"restitution": e}}}),
            random=True,
        )
    for name, speed in SIZES.items():
        changes = {
            "solids": {"beads": {"diameter": name}},
            "boundary": {"bottom": {"gas": {"velocity": speed}}},
        }
        yield Case("size", f"bed of {name}", 1.0, merged(BED, changes))
        yield Case("size", f"random, {name}", 0.3, changes, random=True)
    for ratio, (rho_s, rho, mu, speed) in PAIRS.items():
        changes = {
            "solids": {"beads": {"density": rho_s, "diameter": 500e-6}},
            "gas": {"density": rho, "viscosity": mu},
            "boundary": {"bottom": {"gas": {"velocity": speed}}},
        }
        yield Case("density", f"bed, {ratio:g}", 1.0, merged(BED, changes))
        yield Case("density", f"random, {ratio:g}", 0.3, changes, random=True)
    for courant in COURANT:
        step = {"time": {"courant": courant}}
        yield Case("Courant", f"bed, {courant}", 1.0, merged(BED, step))
        yield Case(
            "Courant", f"random, {courant}", 0.3, merged(RANDOM, step), random=True
        )
    for name, wall in WALLS.items():
        yield Case("walls", f"bed, {name}", 1.0, merged(BED, sides(wall)))
        yield Case(
            "walls",
            f"random in a box, {name}",
            0.3,
            merged(BOX, sides(wall)),
            random=True,
        )
    for name, changes in VARIANTS.items():
        yield Case("model", f"bed, {name}", 1.0, merged(BED, changes))
        yield Case(
            "model", f"random, {name}", 0.3, merged(RANDOM, changes), random=True
        )

    for name in ("quadrilaterals", "triangles", "Schaeffer"):
        changes = merged(merged(BED, VARIANTS[name]), sides(ROUGH))
        off = merged(changes, {"boundary": {"bottom": {"gas": {"velocity": 0.0}}}})
        yield Case("shut-off", f"bubbling bed, {name}", 2.0, changes, then=off)
        level = merged(off, {"closures": {"drag": "drag_gidaspow"}})
        yield Case("rest", f"level bed, {name}", 10.0, level)


def start(case, bed):
    """Random fields."""
    random, cells = np.random.default_rng(1), bed.state.eps_s.shape
    velocity = (*cells, bed.model.grid.dimension)
    bed.start(
        eps_s=random.uniform(0.0, 0.6, cells),
        theta=random.uniform(0.0, 1.0, cells),
        u_gas=random.uniform(-1.0, 1.0, velocity),
        u_solid=random.uniform(-1.0, 1.0, velocity),
    )


def solids(bed):
    """Volume of particles that are here or went out, less what came in [m3], and the
    volume that it is a part of.
    """
    here, account = (
        float(bed.state.eps_s @ bed.model.grid.geometry.volume),
        bed.state.account,
    )
    return here + account.solid_out - account.solid_in, here + account.solid_out


class Failed(Exception):
    """The fields are nonsense."""


class Watch:
    """What the fields reach in the course of a run."""

    def __init__(self):
        self.low, self.high, self.cold, self.hot, self.fast, self.steps = (
            np.inf,
            -np.inf,
            np.inf,
            0.0,
            0.0,
            0,
        )

    def __call__(self, bed):
        dense = bed.state.eps_s > DENSE
        self.low, self.high = (
            min(self.low, bed.state.eps_s.min()),
            max(self.high, bed.state.eps_s.max()),
        )
        self.cold = min(self.cold, bed.state.theta.min())
        self.hot = max(self.hot, bed.state.theta.max(where=dense, initial=0.0))
        self.fast = max(self.fast, speed(bed))
        if bed.state.steps > STEPS:
            raise Failed(f"{STEPS} steps")
        if self.fast > SPEED:
            raise Failed(f"{self.fast:.0f} m/s")


def speed(bed):
    """Largest speed of particles, where there are some."""
    return float(
        np.sqrt((bed.state.u_solid**2).sum(axis=1)).max(
            where=bed.state.eps_s > DENSE, initial=0.0
        )
    )


def run(case):
    """One row of the table."""
    begin, watch, remark = gallery.user_time(), Watch(), ""
    scene = from_dict(merged(merged(BASE, case.changes), {"time": {"end": case.end}}))
    bed, _ = planning.plan(scene).bed()
    if case.random:
        start(case, bed)
    before, _ = solids(bed)
    try:
        if case.then is not None:
            bed.advance(0.5 * case.end, watch)
            after = from_dict(
                merged(merged(BASE, case.then), {"time": {"end": case.end}})
            )
            bed.impose(planning.conditions(after, bed.model.grid))
            bed.find_fluxes(bed.state.dt)
        bed.advance(case.end, watch)
    except (
        ContbedError,
        Failed,
        RuntimeWarning,
        FloatingPointError,
        ZeroDivisionError,
    ) as error:
        remark = str(error)
    if case.group == "rest" and speed(bed) > REST:
        remark = "moves"
    now, scale = solids(bed)
    mass, packing = abs(now - before) / max(scale, 1e-300), bed.model.materials.eps_max
    passed = (
        not remark
        and watch.low >= 0.0
        and watch.high <= packing
        and watch.cold >= 0.0
        and mass <= 1e-12
    )
    return [
        case.group,
        case.name,
        bool(passed),
        f"{bed.state.time:.3g}",
        bed.state.steps,
        f"{watch.low:.3g}",
        f"{watch.high:.6f}",
        f"{packing - watch.high:.2g}",
        f"{watch.cold:.3g}",
        f"{watch.hot:.3g}",
        f"{watch.fast:.3g}",
        f"{speed(bed):.3g}",
        f"{mass:.1e}",
        f"{gallery.user_time() - begin:.1f}",
        remark,
    ]


def reference() -> dict[str, float]:
    """Bounds that hold in every cell after every step, and the largest error of
    mass.
    """
    return {"eps_s min": 0.0, "theta min": 0.0, "mass error": 1e-12}


def compute(cases: Sequence[str] = ()) -> Tables:
    """All cases, or the groups that are named."""
    found = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for case in all_cases():
            if not cases or case.group in cases:
                found.append(run(case))
                print(*found[-1], sep="  ", flush=True)
    table = Table(dict.fromkeys(COLUMNS, ""), found)
    return {
        "results": Table.read(HERE / "results.csv").updated(table, ["group", "case"])
        if cases
        else table
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Largest fraction and speed of particles in every case; hollow where it failed."""
    table = tables["results"]
    figure, axes = gallery.figure(size=(8, 5))
    for group, colour in zip(
        table.values("group"),
        gallery.shades(len(table.values("group")), "turbo"),
        strict=True,
    ):
        for passed, face in (("True", colour), ("False", "none")):
            mine = table.where({"group": group, "passed": passed})
            if len(mine):
                label = group if passed == "True" else None
                where = mine["eps_s max"], np.maximum(mine["speed max m/s"], SLOW)
                axes.scatter(
                    *where, s=22, facecolor=face, edgecolor=colour, label=label
                )
    axes.set(
        yscale="log",
        ylim=(SLOW, 1e2),
        xlabel="largest fraction of particles",
        ylabel="largest speed of particles [m/s]",
    )
    figure.legend(loc="outside right upper")
    return {"extremes": figure}
