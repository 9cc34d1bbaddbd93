"""Results of fluidized beds: minimum fluidization by the drag of the scene, height of
the bed, circulation of the particles.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.two_fluid.boundary import GIVEN
from contbed.two_fluid.closures import ABSENT, bound, constants
from contbed.two_fluid.conditions import Inlet, of_kind
from contbed.two_fluid.vessel import Vessel

if TYPE_CHECKING:
    from contbed.closures.binding import BoundClosure
    from contbed.two_fluid.averages import Averages
    from contbed.two_fluid.scene import TwoFluidScene
    from contbed.two_fluid.simulation import Simulation

DENSE = 0.3  # solids fraction of a bed at the start
FASTEST = 1e3  # [m/s] of the gas between particles
HALVINGS = 60  # of FASTEST
EMPTY = 0.1  # of the solids fraction of the bed, below which the top is a freeboard
TOP = 0.9  # of the height of the vessel, above which the top is
LAYERED = 1.2  # above the solids fraction below, from which the bed is no single layer
LOST = 0.1  # share of the particles
MIDDLE = 0.1  # of the height of the bed, about its middle
SPECTRUM = 64  # rows from which a spectrum is taken
PERIODS = 5.0  # of a signal whose frequency is known to a fifth


def fluidized_findings(
    scene: TwoFluidScene, bed: Simulation, averages: Averages | None
) -> dict[str, float]:
    """Return results of a bed that an inlet of gas fluidizes; none of other scenes."""
    if not is_fluidized(scene):
        return {}
    grid = bed.model.grid
    vessel = Vessel.of(grid)
    geometry = grid.geometry.volume, grid.centres[:, -1]
    means = bed.state.fields() if averages is None else averages.means()
    height = bed_height(means["eps_s"], *geometry, vessel)
    found: dict[str, float] = {}
    eps_s = densest_start(scene)
    if eps_s >= DENSE:
        u_mf = minimum_fluidization(scene, eps_s)
        if u_mf is not None:
            flow = fed(bed) / vessel.section(height)
            found |= {"u_mf_m_s": u_mf, "u_over_u_mf": flow / u_mf}
    if averages is not None and height is not None:
        flux = means["eps_s"] * means["u_solid"][:, -1]
        density = bed.model.materials.rho_solid
        found["bed_height_m"] = height
        found["eps_s_above_over_below"] = layering(means["eps_s"], *geometry)
        if grid.dimension > 1:
            upward = circulation(flux, *geometry, height)
            found["circulation_kg_m2s"] = density * upward
    return found


def is_fluidized(scene: TwoFluidScene) -> bool:
    """Whether an inlet of gas blows through particles that have drag and weight."""
    inlets = of_kind(scene.boundary, Inlet).values()
    blown = any(each.gas.velocity > 0.0 for each in inlets)
    return blown and scene.closures.drag != ABSENT and scene.two_fluid.gravity > 0.0


def is_dense(scene: TwoFluidScene) -> bool:
    """Whether gas fluidizes a bed that is dense at the start."""
    return is_fluidized(scene) and densest_start(scene) >= DENSE


def has_bubbles(scene: TwoFluidScene, dimension: int) -> bool:
    """Whether a run looks for bubbles: in a dense bed that gas fluidizes, with
    averages.
    """
    return is_dense(scene) and dimension > 1 and scene.time.average_from is not None


def densest_start(scene: TwoFluidScene) -> float:
    """Return the largest solids fraction of the start."""
    parts = (each.solid.volume_fraction or 0.0 for each in scene.initial.parts)
    return max(parts, default=0.0)


def judge(
    scene: TwoFluidScene, rows: Mapping[str, Any], qoi: Mapping[str, Any]
) -> list[str]:
    """Return warnings of a fluidized bed: of averages of more than one layer, and of
    rows that are too few for the frequency of the pressure.
    """
    if not is_dense(scene):
        return []
    return [*_layered(scene, qoi), *_unknown_frequency(scene, rows, qoi)]


def _layered(scene: TwoFluidScene, qoi: Mapping[str, Any]) -> list[str]:
    if qoi.get("eps_s_above_over_below", 1.0) <= LAYERED:
        return []
    text = (
        "a denser layer of particles lies on a looser one, so that bed_height_m, that "
        "of a single layer, means nothing; average later, when the bed is at rest"
    )
    return [f"{scene.origin.place(('time', 'average_from'))}: {text}"]


def _unknown_frequency(
    scene: TwoFluidScene, rows: Mapping[str, Any], qoi: Mapping[str, Any]
) -> list[str]:
    start = scene.time.average_from
    if start is None:
        return []
    late = rows["t [s]"] >= start
    span = float(np.ptp(rows["t [s]"][late]))
    frequency = qoi.get("dominant_frequency [Hz]")
    where = scene.origin.place(("time", "average_from"))
    if frequency is None:
        text = (
            f"{int(late.sum())} rows since then are too few for a frequency of the "
            f"pressure; {SPECTRUM} are needed: lower time.sample"
        )
        return [f"{where}: {text}"]
    if frequency * span < PERIODS:
        text = (
            f"dominant_frequency = {frequency:.3g} Hz has only {frequency * span:.3g} "
            f"periods in the averages; average over at least {1.01 * PERIODS / frequency:.3g} s"
        )
        return [f"{where}: {text}"]
    return []


def carried_out(scene: TwoFluidScene, rows: Mapping[str, Any]) -> list[str]:
    """Return a warning of a fluidized bed that has lost many of its particles."""
    if not is_dense(scene):
        return []
    held = rows["solids [kg]"]
    lost = 1.0 - held[-1] / held[0]
    if lost < LOST:
        return []
    return [
        f"{100.0 * lost:.2g} % of the particles have left through outlets: lower the "
        "velocity of the gas, or give the vessel a freeboard"
    ]


def minimum_fluidization(scene: TwoFluidScene, eps_s: float) -> float | None:
    """Return the superficial velocity at which gas carries particles of a solids
    fraction by the drag of the scene [m/s]: beta u/eps = eps_s eps (rho_s - rho_g) g;
    None where none does.
    """
    drag: BoundClosure | None = bound(scene)["drag"]
    fluid, solid, eps = scene.fluid, scene.solid, 1.0 - eps_s
    weight = eps_s * eps * (solid.density - fluid.density) * scene.two_fluid.gravity
    if drag is None or weight <= 0.0:
        return None
    fixed = constants(scene)

    def excess(slip: float) -> float:
        Re = eps * fluid.density * slip * solid.diameter / fluid.viscosity
        beta = drag(**fixed, Re=Re, eps=eps, eps_s=eps_s)
        return float(beta) * slip - weight

    if excess(FASTEST) <= 0.0:
        return None
    low, high = 0.0, FASTEST
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0.0 else (low, middle)
    return eps * high


def fed(bed: Simulation) -> float:
    """Return the volume flow of gas that inlets feed [m3/s]."""
    grid, gas = bed.model.grid, bed.model.edge.gas
    area = grid.geometry.area[grid.interior :]
    entering = np.where(gas.kind == GIVEN, -gas.flux, 0.0)
    return float(area @ np.maximum(entering, 0.0))


def bed_height(eps_s: Any, volume: Any, z: Any, vessel: Vessel) -> float | None:
    """Return the height above the floor [m] that the particles would fill at the mean solids fraction
    below their centre of mass; None where particles are at the top of the vessel.

    Parameters
    ----------
    eps_s, volume, z : mean solids fraction, volume and height of each cell
    vessel : its volume by height
    """
    held = eps_s * volume
    if held.sum() <= 0.0:
        return None
    below = z <= held @ z / held.sum()
    dense = held[below].sum() / volume[below].sum()
    top = z >= z.min() + TOP * np.ptp(z)
    if held[top].sum() > EMPTY * dense * volume[top].sum():
        return None
    return vessel.height_of(held.sum() / dense)


def layering(eps_s: Any, volume: Any, z: Any) -> float:
    """Return the solids fraction that particles above their centre of mass see, over
    that of those below; takes what `bed_height` takes.
    """
    held = eps_s * volume
    below = z <= held @ z / held.sum()
    low, high = (
        held[half] @ eps_s[half] / held[half].sum() for half in (below, ~below)
    )
    return float(high / low)


def circulation(flux: Any, volume: Any, z: Any, height: float) -> float:
    """Return the mean over the section of upward flux, in the middle of a bed of a
    height [m]; downward flux counts as zero.
    """
    above = z - z.min()
    middle = np.abs(above - 0.5 * height) <= MIDDLE * height
    if not middle.any():
        return 0.0
    upward = np.maximum(flux, 0.0)
    return float(upward[middle] @ volume[middle] / volume[middle].sum())
