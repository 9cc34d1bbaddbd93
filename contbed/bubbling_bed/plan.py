"""Plan of a bubbling bed: coefficients from the scene, a graded line, what is solved
and what is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.equations import coefficients as model
from contbed.bubbling_bed.scene_coefficients import coefficients, hottest
from contbed.closures import optics
from contbed.errors import SceneError
from contbed.mesh.grading import equidistributed, graded
from contbed.mesh.mesh import Mesh, refine
from contbed.plan_text import Rows, built_and_skipped, plan_text
from contbed.scene.mesh import REGION
from contbed.solvers.linear import Policy

COARSE = 16  # cells of an automatic mesh away from layers
# relative error of temperatures on a mesh of grading scale 1, by degree
ERROR = {1: 3e-3, 2: 1e-4, 3: 1e-5}
THIN = 1e-9  # share of the height below which a layer is not resolved
# share of the least diameter of particles to which thinner layers are resolved: no
# continuum is finer
CONTINUUM = 1e-2
BURNING = 0.01  # [s] of gases above the bed, over which automatic meshes resolve them


@dataclass(frozen=True)
class BubblingPlan:
    """The scene, mesh, coefficients and skipped physics that a run uses."""

    scene: b.BubblingScene
    coefficients: model.Coefficients
    mesh: Mesh
    built: Rows
    skipped: Rows
    steps: bool = False

    @property
    def policy(self) -> Policy:
        """Choice of the linear solver."""
        from contbed.fem import policy

        return policy(self.mesh, self.scene.solver.memory_GB)

    @property
    def fields(self) -> dict[str, tuple[int, int]]:
        """Degree and components of each unknown field; the distributor is one
        number.
        """
        along: dict[str, tuple[int, int]] = dict.fromkeys(
            self.coefficients.fields, (self.scene.solver.degree, 0)
        )
        return along | dict.fromkeys(self.coefficients.scalars, (0, 0))

    @property
    def guesses(self) -> int:
        """Number of guesses that are solved from: a cold and a hot one as well where
        several states are possible.
        """
        items: tuple[Any, ...] = (self.scene.bubbling_bed, *self.scene.present.values())
        return (
            3
            if any(
                item.release is not None and item.release.activation for item in items
            )
            else 1
        )

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns of each part that is solved."""
        size = self.scene.solver.degree * self.mesh.skfem.nelements + 1
        out = {
            "heat": len(self.coefficients.streams) * size
            + (self.coefficients.plate is not None)
        }
        out |= {"radiation": size} if self.coefficients.level == "field" else {}
        others = (
            len(self.coefficients.fields)
            - len(self.coefficients.streams)
            - (self.coefficients.level == "field")
        )
        return out | ({"gas flow": others * size} if others else {})

    def __str__(self) -> str:
        return plan_text(self)


def plan(scene: b.BubblingScene) -> BubblingPlan:
    """Decide what a scene needs and build its mesh."""
    c = coefficients(scene)
    finest = (
        CONTINUUM * min(item.diameter for item in scene.present.values())
        if c.computed is not None
        else 0.0
    )
    layers = predicted_layers(c, scene.bubbling_bed.height, hottest(scene), finest)
    layers += _narrow_feeds(scene, c)
    layers += _flame(scene, c)
    mesh = _mesh(scene, layers)
    return BubblingPlan(
        scene, c, mesh, *built_and_skipped(_parts(scene, c, mesh, len(layers)))
    )


def _parts(
    scene: b.BubblingScene, c: model.Coefficients, mesh: Mesh, layers: int
) -> Iterator[tuple[str, str, bool]]:
    """Yield the parts of a bed, see `built_and_skipped`."""
    cells = f"{mesh.skfem.nelements} cells, graded to {layers} layers"
    yield "mesh, 1-D", cells, True
    for name in c.species:
        yield f"solids {name}", f"degree {scene.solver.degree}", True
    for name in scene.solids:
        if name not in c.species:
            yield f"solids {name}", "volume_share is 0", False
    levels = {
        "paper": "among the solid phases at one height, algebraic",
        "pairwise": "between pairs of solid phases at one height",
        "field": f"{'two-flux' if scene.radiation.level == 'two_flux' else 'P1'}, one "
        "field",
    }
    for there, what, how, why in (
        (
            c.computed is not None,
            "closures",
            "coefficients by the local state",
            "coefficients are numbers",
        ),
        (
            c.bubbles is not None,
            "bubble gas",
            "exchange with the emulsion gas",
            "no bubbles",
        ),
        (
            c.plate is not None,
            "distributor",
            "one temperature",
            "no [bubbling_bed.distributor] table",
        ),
        (
            bool(c.surfaces),
            "immersed surfaces",
            ", ".join(c.surfaces),
            "no [bubbling_bed.tubes], no [bubbling_bed.walls]",
        ),
        (
            c.above is not None,
            "freeboard",
            "gas, particles, radiation",
            "no [bubbling_bed.freeboard] with a height",
        ),
        (c.level != "none", "radiation", levels.get(c.level, ""), "level none"),
    ):
        yield what, how if there else why, there
    if c.chemistry is None:
        yield "reactions", "no [reactions] table", False
        return
    yield "gases", ", ".join(c.chemistry.part.gases), True
    if c.chemistry.names:
        yield "reactions", ", ".join(c.chemistry.names), True


def predicted_layers(
    c: model.Coefficients, height: float, hot: float, finest: float = 0.0
) -> list[tuple[float, float]]:
    """Return position and width [m], `finest` at least, of the modes exp(rate z) of the
    equations at a temperature.

    (-K rate^2 + W rate + S) x = 0 for temperatures scaled with 16 sigma T^3 where G
    takes part; modes that decay upward start at the distributor, the others at the top.
    """
    from scipy.linalg import eig

    names = [*c.streams, *(["G"] if c.level == "field" else [])]
    place = {name: k for k, name in enumerate(names)}
    K, W, S = (np.zeros((len(names), len(names))) for _ in range(3))

    def couple(one: str, other: str | None, value: float) -> None:
        i = place[one]
        S[i, i] += value
        if other is not None:
            j = place[other]
            S[j, j] += value
            S[i, j] -= value
            S[j, i] -= value

    power = 16.0 * optics.SIGMA * hot**3
    for name, stream in c.streams.items():
        K[place[name], place[name]] = stream.conduction
        fastest = float(np.max(np.abs(stream.flow(np.linspace(0.0, height, 65)))))
        W[place[name], place[name]] = fastest * float(stream.heat_capacity(hot))
    volume = c.section * (1.0 - c.delta)
    for name, item in c.species.items():
        couple(f"T_{name}", "T_emulsion", volume * item.gas)
        for x in c.surfaces.values():
            couple(f"T_{name}", None, x.perimeter * x.coefficient * item.share)
        if c.level == "field":
            couple(f"T_{name}", "G", volume * item.absorption * power)
    for (one, other), value in c.pairs.items():
        couple(f"T_{one}", f"T_{other}", volume * value)
    if c.bubbles is not None:
        couple("T_bubble", "T_emulsion", c.section * c.delta * c.exchange)
    if c.level == "field":
        K[place["G"], place["G"]] = c.section * c.diffusion * power
    unit, zero = np.eye(len(names)), np.zeros_like(S)
    alpha, beta = eig(
        np.block([[zero, unit], [S, W]]),
        np.block([[unit, zero], [zero, K]]),
        right=False,
        homogeneous_eigvals=True,
    )
    finite = np.abs(beta) > 1e-14 * np.abs(alpha)
    rates = np.real(alpha[finite] / beta[finite])
    kept = [rate for rate in rates if 1.0 < abs(rate) * height < 1.0 / THIN]
    return [
        (0.0 if rate < 0 else height, max(1.0 / abs(rate), finest)) for rate in kept
    ]


def _narrow_feeds(
    scene: b.BubblingScene, c: model.Coefficients
) -> list[tuple[float, float]]:
    """Return position and width [m] of the feeds that mixing over their width does not
    even out.
    """
    hot, height, found = hottest(scene), scene.bubbling_bed.height, []
    for name, item in scene.present.items():
        feed, stream = item.feed, c.streams.get(f"T_{name}")
        if feed is None or stream is None:
            continue
        fastest = float(np.max(np.abs(stream.flow(np.linspace(0.0, height, 65)))))
        carried = fastest * float(stream.heat_capacity(hot))
        if stream.conduction < carried * feed.width:
            found.append((min(feed.height, height), feed.width))
    return found


def _flame(scene: b.BubblingScene, c: model.Coefficients) -> list[tuple[float, float]]:
    """Return position and width [m] of the layer above the surface in which gases
    burn, on the mesh of the bed.
    """
    if c.above is None or not c.above.reacts:
        return []
    gas = c.computed.gas
    velocity = c.computed.flow / (gas.density(hottest(scene)) * c.section)
    return [(scene.bubbling_bed.height, velocity * BURNING / c.above.part.stretch)]


def _mesh(scene: b.BubblingScene, layers: list[tuple[float, float]]) -> Mesh:
    height, options = scene.bubbling_bed.height, scene.solver
    if scene.mesh.cells is not None:
        nodes = equidistributed(height, layers, scene.mesh.cells, options.degree)
    else:
        scale = min(
            1.0,
            (options.tolerance / ERROR[options.degree]) ** (1.0 / (options.degree + 1)),
        )
        nodes = graded(height, layers, coarse=height / COARSE, scale=scale)
    if not np.all(np.diff(nodes) > 0):
        raise SceneError(
            f"{scene.origin.name}: mesh: a thermal boundary layer is too thin "
            "for the mesh; look for a heat transfer coefficient that is far "
            "too large, or give mesh.cells"
        )
    return refine(line(nodes), scene.mesh.refine)


def line(nodes: Any) -> Mesh:
    """Build a mesh between the distributor and the surface of the bed."""
    ends = {"bottom": lambda x: x[0] == nodes[0], "top": lambda x: x[0] == nodes[-1]}
    named = skfem.MeshLine.init_tensor(nodes).with_boundaries(ends)
    return Mesh(named.with_subdomains({REGION: lambda x: np.full(x.shape[-1], True)}))
