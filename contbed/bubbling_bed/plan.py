"""Plan of a bubbling bed: coefficients from the scene, a graded line, what is solved
and what is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import skfem

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.equations import coefficients as model
from contbed.bubbling_bed.solids import Solid
from contbed.bubbling_bed.tables import Freeboard, Release
from contbed.closures import optics
from contbed.errors import SceneError
from contbed.mesh.grading import equidistributed, graded
from contbed.mesh.mesh import Mesh, refine
from contbed.plan_text import Rows, built_and_skipped, plan_text
from contbed.scene.mechanism import find_mechanism
from contbed.scene.mesh import REGION
from contbed.solvers.linear import Policy

COARSE = 16  # cells of an automatic mesh away from layers
# relative error of temperatures on a mesh of grading scale 1, by degree
ERROR = {1: 3e-3, 2: 1e-4, 3: 1e-5}
# temperature at which layers are predicted where the scene gives lower ones [K]
HOT = 1000.0
THIN = 1e-9  # share of the height below which a layer is not resolved
FLOW = ("boundary", "bottom", "gas", "mass_flow")  # key of the gas that enters
# share of the least diameter of particles to which thinner layers are resolved: no
# continuum is finer
CONTINUUM = 1e-2


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
    layers = predicted_layers(c, scene.bubbling_bed.height, _hot(scene), finest)
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


def coefficients(
    scene: b.BubblingScene, typical: dict[str, Any] | None = None
) -> model.Coefficients:
    """Return the coefficients of the model, and the albedo of the emulsion where it
    radiates.

    `typical` are known numbers in place of those that layers are predicted from, where
    coefficients follow the state.
    """
    bed, present, level = scene.bubbling_bed, scene.present, scene.radiation.level
    surface = scene.surface_of_particles
    absorption, diffusion, albedo, eps_bed = np.zeros(len(present)), 0.0, None, 0.0
    if level != "none":
        found = optics_of(scene.radiation, scene.solids, bed.solids_fraction)
        absorption, albedo = found.absorption, float(found.albedo)
        eps_bed = float(optics.radiation_emissivity_half_space(albedo))
        if level in ("p1", "two_flux"):
            diffusion = float(found.diffusion(level))
    section = bed.section
    computed = _computed(scene)
    if computed is None:
        number = _frozen(scene)
    elif typical is not None:
        number = typical
    else:
        _fluidized(scene, computed)
        number = typical_numbers(scene, computed)
    species = {
        name: model.Species(
            _solids(
                name, item, bed.height, section, number["conduction"][name], computed
            ),
            number["gas"][name],
            surface[name] / sum(surface.values()),
            float(absorption[k]),
            item.emissivity or 1.0,
        )
        for k, (name, item) in enumerate(present.items())
    }
    surfaces = {
        name: model.Surface(
            item.perimeter,
            number["contact"][name],
            HOT if item.temperature is None else item.temperature,
            float(optics.emissivity_immersed(eps_bed, item.emissivity))
            if eps_bed and item.emissivity
            else 0.0,
            None if item.steam is None else f"T_{name}",
        )
        for name, item in bed.surfaces.items()
    }
    plate = None
    if (table := bed.distributor) is not None:
        plate = model.Plate(
            table.coefficient,
            float(-np.expm1(-table.preheat_NTU)),
            table.emissivity or 0.0,
        )
    gases = {
        name: model.Stream(constant(flow)) for name, flow in number["flows"].items()
    }
    emulsion = replace(gases["T_emulsion"], release=_release(bed.release, section))
    return model.Coefficients(
        section,
        number["delta"],
        scene.inlet.temperature,
        species,
        number["pairs"],
        emulsion,
        gases.get("T_bubble"),
        number["exchange"],
        surfaces,
        plate,
        level if level not in ("p1", "two_flux") else "field",
        diffusion,
        _radiosity(bed.freeboard),
        scene.solver.degree,
        computed,
        albedo,
        computed.fields if computed is not None else (),
        (computed.parts if computed is not None else ()) + _water(scene),
    )


def typical_numbers(scene: b.BubblingScene, computed: Any) -> dict[str, Any]:
    """Return coefficients that follow the state at the highest temperature that the
    scene gives.
    """
    from contbed.bubbling_bed.frozen import frozen

    found: dict[str, Any] = frozen(computed, _hot(scene), scene.bubbling_bed.height)
    return found


def _water(scene: b.BubblingScene) -> tuple[Any, ...]:
    """Return the water sides of surfaces."""
    surfaces = scene.bubbling_bed.surfaces
    if all(item.steam is None for item in surfaces.values()):
        return ()
    from contbed.bubbling_bed.equations.steam import Steam
    from contbed.materials.steam import steam

    out = []
    for name, item in surfaces.items():
        table = item.steam
        if table is None:
            continue
        water = steam(table.pressure)
        conductance = item.perimeter * table.coefficient
        out.append(
            Steam(
                name,
                table.mass_flow,
                water.enthalpy(table.temperature),
                conductance,
                water.temperature,
                table.direction == "up",
            )
        )
    return tuple(out)


def _computed(scene: b.BubblingScene) -> Any:
    """Return the coefficients as functions of the state; None where the scene gives
    frozen ones.
    """
    if not scene.computed:
        return None
    from contbed.bubbling_bed.coefficients import Computed, mixture

    gas = scene.mixture
    mechanism = find_mechanism(gas.mechanism, scene.origin.base)
    return Computed(scene, mixture(gas.composition, gas.pressure, mechanism))


def _fluidized(scene: b.BubblingScene, computed: Any) -> None:
    """Raise SceneError if the gas does not fluidize the bed at the temperature where
    Newton's method starts.
    """
    T, flow = scene.initial.temperature, computed.flow
    state, _ = computed.state(
        SimpleNamespace(**{f"T_{name}": T for name in scene.present}), flow
    )
    needed = float(state["rho_gas"] * state["u_mf"]) * scene.bubbling_bed.section
    if scene.bubbling_bed.bubbles is not None and flow <= needed:
        raise SceneError(
            f"{scene.origin.place(FLOW)} = {flow:g}: below minimum "
            "fluidization, "
            f"{needed:.4g} kg/s at {T:g} K, where the search for its temperatures "
            "begins; allowed: more, no [bubbling_bed.bubbles] or, if the bed is hotter, "
            "initial.temperature near to its own"
        )


def _frozen(scene: b.BubblingScene) -> dict[str, Any]:
    """Return the coefficients of a scene that gives them all as numbers."""
    present: dict[str, Any] = scene.present
    bed, bubbles = scene.bubbling_bed, scene.bubbling_bed.bubbles
    if bubbles is not None and bubbles.fraction == 0:
        bubbles = None
    return {
        "delta": bubbles.fraction if bubbles else 0.0,
        "gas": {
            name: surface * present[name].gas_coefficient
            for name, surface in scene.surface_of_particles.items()
        },
        "conduction": {
            name: bed.section * item.mixing_conductivity
            for name, item in present.items()
        },
        "pairs": {
            (name, other): value
            for name, item in present.items()
            for other, value in item.exchange.items()
            if other in present
        },
        "exchange": bubbles.exchange if bubbles else 0.0,
        "contact": {name: item.coefficient for name, item in bed.surfaces.items()},
        "flows": {"T_emulsion": scene.inlet.capacity_flow}
        | ({"T_bubble": bubbles.capacity_flow} if bubbles else {}),
    }


def optics_of(
    radiation: b.Radiation, solids: Mapping[str, Solid], solids_fraction: float
) -> optics.Optics:
    """Return the optical coefficients of the emulsion, which holds a volume fraction of
    solids.
    """
    particles = [
        optics.Species(
            name,
            solids_fraction * item.volume_share,
            item.diameter,
            float(item.emissivity or 0.0),
        )
        for name, item in solids.items()
        if item.volume_share > 0.0
    ]
    exchanges = radiation.level in ("paper", "pairwise")
    default = "independent" if exchanges else "close_packed"
    return optics.optics(
        particles, radiation.correction or default, radiation.anisotropy
    )


def constant(value: float) -> Any:
    """Return a constant function of height."""
    return lambda z: value + 0.0 * z


def _solids(
    name: str,
    item: Solid,
    height: float,
    section: float,
    conduction: float,
    computed: Any,
) -> model.Stream:
    heat: dict[str, Any] = {
        "conduction": conduction,
        "release": _release(item.release, section),
    }
    if computed is not None:
        heat |= {
            "enthalpy": partial(computed.enthalpy, name),
            "heat_capacity": partial(computed.heat_capacity, name),
        }
    feed = item.inert_feed
    flow = 0.0 if feed is None else feed.capacity_flow or feed.mass_flow
    if feed is None or not flow:
        return model.Stream(constant(0.0), **heat)
    share, below = feed.shares(height)
    drained = flow if feed.drain == "bottom" else 0.0
    return model.Stream(
        lambda z: flow * below(z) - drained,
        lambda z: flow * share(z),
        feed.temperature,
        **heat,
    )


def _release(table: Release | None, section: float) -> Any:
    if table is None or not table.rate:
        return None

    def release(z: Any, T: Any) -> Any:
        rate = (
            section
            * table.rate
            * (1.0 if table.length is None else np.exp(-z / table.length))
            + 0.0 * z
        )
        if table.activation is None or table.reference is None:
            return rate
        return rate * np.exp(-table.activation * (1.0 / T - 1.0 / table.reference))

    return release


def _radiosity(table: Freeboard | None) -> float | None:
    if table is None or table.height is not None:
        return None
    return (
        table.radiosity
        if table.temperature is None
        else optics.SIGMA * table.temperature**4
    )


def _hot(scene: b.BubblingScene) -> float:
    """Return the highest temperature that the scene gives [K]."""
    given = [scene.inlet.temperature]
    given += [item.temperature or 0.0 for item in scene.bubbling_bed.surfaces.values()]
    feeds = [item.inert_feed for item in scene.present.values()]
    given += [feed.temperature for feed in feeds if feed is not None]
    return max(*given, HOT)


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
