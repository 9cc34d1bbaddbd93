"""The particles of a cascade: packings, their conductivity and exchange, each computed
once and kept by its content.

Conductivity: the network of resistors over the ratio k_solid/k_fluid. Exchange: gas
    between spheres at rest on cells of
3 by 3 by 1.5 diameters, the mean of the Nusselt numbers that a law gives every sphere
at its own slip and porosity.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from contbed import __version__
from contbed.arrays import Array
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import bed_nusselt
from contbed.closures.binding import bind
from contbed.closures.drag import drag_di_felice
from contbed.dem import extract
from contbed.dem.heat_pair import STATIC, correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.sizes import random_radii, sauter_mean
from contbed.dem.walls import Domain
from contbed.many.cascade.file import AT_PARTICLE, Cascade
from contbed.many.store import KEY, Store, key_of
from contbed.materials.constant import ConstantFluid
from contbed.output.files import atomic

Columns = dict[str, Array]

RATIOS = 7  # of conductivities in a packing
DEGREE = 2  # of the polynomial of logarithms that is fitted to them
SPEEDS = 5  # of the gas in a packing
# factor by which the range of a closure is wider than what the first run visits
MARGIN = 1.3
# diameters below the surface where particles are held at a temperature; one at the
# floor
RIM = 2.0
HEADROOM = 1.3  # height of the gas over that of the bed
AIR = (1.2, 1005.0, 1.8e-5)  # kg/m3, J/kg/K, Pa s: only Re and Pr count


@dataclass(frozen=True)
class Ensemble:
    """Packings of a cascade, and the store of what is computed of them."""

    cascade: Cascade
    store: Store
    beds: tuple[extract.Packing, ...]

    @property
    def porosities(self) -> Array:
        """Porosity of each packing, away from floor and surface; between walls that
        of the box.
        """
        return np.array([bed.porosity for bed in self.beds])

    def conduction(self, bed: int, paths: str, ratios: tuple[float, float]) -> Columns:
        """Return porosity, k_solid/k_fluid and k/k_fluid of a packing between two
        ratios.
        """
        packings = self.cascade.settings.packings
        factor = float(correction(packings.simulated, packings.youngs_modulus, STATIC))
        points = np.geomspace(ratios[0] / MARGIN, ratios[1] * MARGIN, RATIOS)
        about = {
            "bed": self._name(bed),
            "paths": paths,
            "ratios": points.tolist(),
            "factor": factor,
        }
        sweep = partial(
            extract.conductivity_sweep,
            [self.beds[bed]],
            points.tolist(),
            1.0,
            factor,
            paths,
        )
        return self._kept("conduction", about, sweep)

    def exchange(
        self, bed: int, law: int, Re: tuple[float, float], Pr: tuple[float, float]
    ) -> Columns:
        """Return Re, Pr and Nu of a packing between two Reynolds and two Prandtl
        numbers.
        """
        chosen = self.cascade.settings.laws.exchange[law]
        bound = bind(chosen, "nusselt", AT_PARTICLE)
        function = (
            partial(bound.function, **bound.parameters)
            if bound.parameters
            else bound.function
        )
        speeds = np.geomspace(Re[0] / MARGIN, Re[1] * MARGIN, SPEEDS)
        fluids = np.unique([Pr[0] / MARGIN, Pr[1] * MARGIN])
        about = {
            "bed": self._name(bed),
            "law": bound.sheet.name,
            "parameters": bound.parameters,
        }
        about |= {"Re": speeds.tolist(), "Pr": fluids.tolist()}
        return self._kept(
            "exchange", about, partial(_exchange, self, bed, function, speeds, fluids)
        )

    def _kept(
        self, what: str, about: dict[str, Any], compute: Callable[[], Columns]
    ) -> Columns:
        """Return columns that belong to `about`, kept or computed."""
        kept = self.store.kept(key_of(__version__, what, about), compute)
        return {name: np.array(values) for name, values in kept.items() if name != KEY}

    def _name(self, bed: int) -> str:
        return key_of(__version__, _about(self.cascade, bed))


def ensemble(cascade: Cascade, folder: Path, told: Callable[[], None]) -> Ensemble:
    """Settle the packings, or take those that are in `folder`; `told` is called after
    each.

    Raises
    ------
    ConvergenceError : a packing does not come to rest
    """
    beds = []
    for number in range(cascade.settings.packings.count):
        beds.append(_packing(cascade, folder / "packings", number))
        told()
    return Ensemble(cascade, Store(folder / "results.jsonl"), tuple(beds))


def _about(cascade: Cascade, number: int) -> dict[str, Any]:
    packings, density = cascade.settings.packings, cascade.reactor.density
    return {
        "diameter": cascade.diameter,
        "spread": packings.spread,
        "particles": packings.particles,
        "width": packings.width,
        "seed": packings.seed + number,
        "simulated": packings.simulated,
        "density": density,
        "friction": packings.friction,
        "walls": packings.walls,
    }


def _packing(cascade: Cascade, folder: Path, number: int) -> extract.Packing:
    about = _about(cascade, number)
    path = folder / f"{key_of(__version__, about)}.npz"
    d = cascade.diameter
    width = about["width"] * d
    try:
        with np.load(path) as kept:
            x = kept["x"]
            R = kept["radius"]
            porosity = float(kept["porosity"])
            surface = float(kept["surface"])
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        R = random_radii(0.5 * d, about["spread"], about["particles"], about["seed"])
        if about["spread"]:  # equal ones keep their last digit
            R *= 0.5 * d / sauter_mean(R)
        bed = pack(
            (width, width), radius=R, seed=about["seed"],
            periodic=(not about["walls"], not about["walls"]), material=Material(
                density=about["density"], youngs_modulus=about["simulated"], sliding_friction=about["friction"]),
        )  # fmt: skip
        porosity = bed.statistics["porosity_box" if about["walls"] else "porosity_core"]
        x, R, surface = bed.position, bed.radius, bed.statistics["surface"]
        text = io.BytesIO()
        np.savez(text, x=x, radius=R, porosity=porosity, surface=surface)
        folder.mkdir(parents=True, exist_ok=True)
        with atomic(path) as temporary:
            temporary.write_bytes(text.getvalue())
    box = (
        None
        if about["walls"]
        else (np.zeros(3), np.array([width, width, (x[:, 2] + R).max()]))
    )
    return extract.Packing(x, R, porosity, d, surface - RIM * d, width**2, box)


def _exchange(
    ensemble: Ensemble, bed: int, law: Any, speeds: Array, fluids: Array
) -> Columns:
    packing, packings = ensemble.beds[bed], ensemble.cascade.settings.packings
    d = ensemble.cascade.diameter
    top = (packing.x[:, 2] + packing.radius).max()
    width = np.sqrt(packing.area)
    across = max(2, round(width / (3.0 * d)))
    along = max(4, round(HEADROOM * top / (1.5 * d)))
    count = (across, across, along)
    grid = Grid(
        np.zeros(3),
        np.array([width, width, HEADROOM * top]) / count,
        count,
        (True, True),
    )
    domain = Domain((0, 0, 0), (width, width, np.inf), (True, True, False))
    density, heat_capacity, viscosity = AIR
    points = []
    for Pr in fluids:
        gas_like = ConstantFluid(
            density, heat_capacity, viscosity, viscosity * heat_capacity / Pr
        )
        for Re in speeds:
            spheres = Particles(packing.x, packing.radius)
            material = Material(1000.0, packings.simulated)
            simulation = Simulation(spheres, [material], (), domain)
            gas = Gas(grid, gas_like, drag_di_felice, law, isothermal=True)
            around = Bed(
                simulation, gas, 0.2 * d * density * d / (Re * viscosity), moving=False
            )
            points.append(
                bed_nusselt(around, Re * viscosity / (density * d), 300.0, Solid(0.0))
            )
    return dict(zip(("Re", "Pr", "Nu"), np.array(points).T, strict=True))
