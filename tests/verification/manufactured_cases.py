"""Exact fields, meshes and coefficients that the tests with manufactured solutions
share.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import skfem

from contbed.fem import stabilisation
from contbed.fem.ad.dual import Components
from contbed.fem.skfem import Ops, System
from contbed.packed_bed.equations import porous_flow, two_energy
from contbed.radiation.equations import p1 as radiation
from studies._exact.manufactured import Manufactured, exact

POROSITY = 0.4


def mesh(shape: str, n: int) -> skfem.Mesh:
    """The unit interval, square or cube with n cells a side and smoothly moved inner
    nodes.
    """
    nodes = np.linspace(0.0, 1.0, n + 1)
    kind = {
        "line": skfem.MeshLine,
        "triangle": skfem.MeshTri,
        "quadrilateral": skfem.MeshQuad,
        "tetrahedron": skfem.MeshTet,
        "hexahedron": skfem.MeshHex,
    }[shape]
    made = kind.init_tensor(*[nodes] * kind.elem.refdom.dim())
    bump = 0.12 * np.prod(np.sin(np.pi * made.p), axis=0)
    x = made.p + bump * np.array([[1.0], [-0.7], [0.4]])[: len(made.p)]
    m = kind(x, made.t)
    return m.with_boundaries(
        {
            "right": lambda x: x[0] > 1 - 1e-9,
            "rest": lambda x: x[0] <= 1 - 1e-9,
            "all": m.boundary_facets(),
            "off_axis": lambda x: x[0] > 1e-9,
        }
    )


# exact fields by dimension; in (r, z) they are even or odd in r, as smooth fields are
FLUID = {
    1: lambda x: 2.0 + np.sin(2 * x),
    2: lambda x, y: 2.0 + np.sin(2 * x) * np.cos(1.5 * y) + 0.2 * y,
    3: lambda x, y, z: 2.0 + np.sin(2 * x) * np.cos(1.5 * y) + 0.5 * np.sin(z + x),
}
SOLID = {
    1: lambda x: 1.5 + np.cos(1.7 * x),
    2: lambda x, y: 1.5 + np.cos(1.7 * x + y),
    3: lambda x, y, z: 1.5 + np.cos(1.7 * x + y - 0.8 * z),
}
VELOCITY = {
    1: lambda x: (1.2 + 0.0 * x,),
    2: lambda x, y: (1.2 + 0.3 * np.sin(2 * y), 0.4 + 0.3 * np.cos(2 * x)),
    3: lambda x, y, z: (
        1.2 + 0.3 * np.sin(3 * y),
        0.4 + 0.2 * np.cos(3 * z),
        0.3 + 0.2 * np.sin(3 * x),
    ),
}
PRESSURE = {
    2: lambda x, y: np.cos(2 * x) * np.sin(1.3 * y),
    3: lambda x, y, z: 3 * np.cos(2 * x) * np.sin(1.3 * y + z),
}
ROUND_FLUID = lambda r, z: 2.0 + np.cos(1.5 * r) * np.sin(2 * z)  # noqa: E731
ROUND_SOLID = lambda r, z: 1.5 + np.cos(1.2 * r) + 0.3 * np.cos(z)  # noqa: E731
ROUND_VELOCITY = lambda r, z: (  # noqa: E731
    -0.3 * r * np.cos(2 * r) * np.cos(3 * z),
    1.2 + 0.2 * (np.cos(2 * r) - r * np.sin(2 * r)) * np.sin(3 * z),
)
ROUND_PRESSURE = lambda r, z: np.cos(1.4 * r) * np.cos(2 * z)  # noqa: E731


@dataclass(frozen=True)
class Heat:
    """Two-energy equations: mesh sizes, degree and terms."""

    shape: str
    sizes: tuple[int, ...]
    degree: int
    stabilised: bool = True
    computed: bool = False  # velocity known at nodes, with the divergence correction
    nonlinear: bool = False
    axisymmetric: bool = False
    uniform: bool = False  # velocity
    conductivity: float = 0.3

    @property
    def expected(self) -> dict[str, float]:
        """Orders."""
        return dict.fromkeys(two_energy.FIELDS, self.degree + 1)

    @property
    def linear(self) -> bool:
        """Whether one solve is enough."""
        return not self.nonlinear

    def fields(self, dim: int) -> dict[str, Any]:
        """Exact temperatures."""
        pair = (
            (ROUND_FLUID, ROUND_SOLID)
            if self.axisymmetric
            else (FLUID[dim], SOLID[dim])
        )
        return dict(zip(two_energy.FIELDS, pair, strict=True))

    def velocity(self, dim: int) -> Any:
        """Superficial velocity of the fluid, without divergence."""
        if self.uniform:
            uniform = (0.0, 1.2) if self.axisymmetric else (1.2, 0.4, 0.3)[:dim]
            return lambda *x: uniform
        return ROUND_VELOCITY if self.axisymmetric else VELOCITY[dim]

    def system(self, m: skfem.Mesh, order: int) -> System:
        """Both temperatures on a mesh."""
        return System(
            m,
            dict.fromkeys(two_energy.FIELDS, (self.degree, 0)),
            order,
            axisymmetric=self.axisymmetric,
        )

    def manufactured(self, n: int) -> tuple[Manufactured, dict[str, Any]]:
        """The case on a mesh and the facets with prescribed values; a stream leaves
        on the right.
        """
        m = mesh(self.shape, n)
        system = self.system(
            m, 2 * self.degree + self.axisymmetric + 2 * self.nonlinear
        )
        forms: list[Any] = [
            (two_energy.residual, system.cells, self.coefficients(system, system.cells))
        ]
        for part in system.boundary("right"):
            c = self.coefficients(system, part)
            for name, phase in (("T_fluid", c.fluid), ("T_solid", c.solid)):
                wall = two_energy.BoundaryTerms(
                    name,
                    phase.mass_flux,
                    phase.enthalpy,
                    None,
                    0.0,
                    lambda unknowns: 0.3,
                    1.0,
                )
                forms.append((two_energy.boundary, part, wall))
        rest = np.setdiff1d(m.boundary_facets(), m.boundaries["right"])
        return Manufactured(system, self.fields(m.dim()), forms), dict.fromkeys(
            two_energy.FIELDS, rest
        )

    def coefficients(self, system: System, where: Any) -> two_energy.Coefficients:
        """Convection, conduction, exchange, dispersion, tortuosity and sources of
        comparable size.
        """
        m, o = system.mesh, Ops(where)
        function = self.velocity(m.dim())
        velocity = exact(function, m, where)
        if self.computed:
            nodal = System(m, {"u": (2, m.dim())}, system.order).fields["u"][0]
            velocity = system.known(where, nodal, np.array(function(*nodal.points)))
        solid = (
            Components([0.3, -0.2, 0.1][: m.dim()])
            if not self.axisymmetric
            else Components([0.0, -0.4])
        )
        slope = 0.3 if self.nonlinear else 0.0
        phases = {}
        for name, u, k in (
            ("fluid", velocity, self.conductivity),
            ("solid", solid, 2 * self.conductivity),
        ):
            speed = np.sqrt(o.dot(u, u))
            tau = stabilisation.tau(speed, k, 3.0, 1.0, where.h, self.degree)
            phases[name] = two_energy.Phase(
                mass_flux=u,
                divergence=o.div(u) if self.computed and name == "fluid" else None,
                enthalpy=lambda T: T + 0.5 * slope * T**2 + 0.2,
                heat_capacity=lambda T: 1.0 + slope * T,
                capacity=1.0,
                offset=0.2,
                conductivity=lambda T, k=k: k * (1.0 + slope * T),
                dispersion=(0.3 * k, k, u / speed) if name == "fluid" else None,
                content=lambda T: T + 0.5 * slope * T**2,
                source=0.7,
                tau=tau if self.stabilised else None,
            )
        return two_energy.Coefficients(
            fluid=phases["fluid"],
            solid=phases["solid"],
            exchange=lambda fluid, solid: 3.0 + 2 * slope * fluid,
            cross=lambda T: 0.3 * self.conductivity * (1.0 + slope * T),
        )


INCIDENT = {
    2: lambda x, y: 2e5 + 1e5 * np.sin(1.4 * x - y),
    3: lambda x, y, z: 2e5 + 1e5 * np.sin(2.5 * x) * np.cos(2 * y + 1.5 * z),
}
ROUND_INCIDENT = lambda r, z: 2e5 + 1e5 * np.cos(1.3 * r) * np.sin(z)  # noqa: E731
OPTICS = radiation.Coefficients(
    absorption={"T_solid": 0.3},
    diffusion=0.25,
    emission=0.1 * radiation.emitted(900.0) + 0.05 * radiation.emitted(1200.0),
    passive=0.15,
)
SURFACES = {"right": radiation.Surface(0.6, 7e4), "rest": radiation.Surface(1.0, 3e4)}
# times the exact fields of order one: temperatures at which a bed radiates
KELVIN = 300.0


@dataclass(frozen=True)
class Radiating(Heat):
    """Two-energy equations, and the incident radiation of the solid and of two species
    of given temperature. All its boundaries radiate: a gray wall on the right,
    elsewhere an opening. Conduction and radiation are of comparable size.
    """

    conductivity: float = 30.0

    @property
    def expected(self) -> dict[str, float]:
        """Orders."""
        return dict.fromkeys((*two_energy.FIELDS, *radiation.FIELDS), self.degree + 1)

    @property
    def linear(self) -> bool:
        """The solid emits with the fourth power of its temperature."""
        return False

    def fields(self, dim: int) -> dict[str, Any]:
        """Exact temperatures and incident radiation."""
        hot = {
            name: lambda *x, f=f: KELVIN * f(*x)
            for name, f in super().fields(dim).items()
        }
        return hot | {"G": ROUND_INCIDENT if self.axisymmetric else INCIDENT[dim]}

    def system(self, m: skfem.Mesh, order: int) -> System:
        """Temperatures and incident radiation on a mesh."""
        return System(
            m,
            dict.fromkeys(self.expected, (self.degree, 0)),
            order,
            axisymmetric=self.axisymmetric,
        )

    def coefficients(self, system: System, where: Any) -> two_energy.Coefficients:
        """Those without radiation, and what the solid takes up."""
        absorption = OPTICS.absorption["T_solid"]
        return replace(
            super().coefficients(system, where),
            radiated=lambda unknowns: radiation.absorbed(
                unknowns.T_solid, unknowns.G, absorption
            ),
        )

    def manufactured(self, n: int) -> tuple[Manufactured, dict[str, Any]]:
        """The case on a mesh; temperatures are prescribed as without radiation, G
        nowhere.
        """
        made, fixed = super().manufactured(n)
        return replace(made, forms=[*made.forms, *self.radiation(made.system)]), fixed

    def radiation(self, system: System) -> list[tuple[Any, Any, Any]]:
        """Forms of the incident radiation."""
        forms = [(radiation.residual, system.cells, OPTICS)]
        for name, surface in SURFACES.items():
            forms += [
                (radiation.boundary, part, surface) for part in system.boundary(name)
            ]
        return forms


@dataclass(frozen=True)
class Flow:
    """Brinkman-Forchheimer flow: mesh sizes."""

    shape: str
    sizes: tuple[int, ...]
    axisymmetric: bool = False
    linear: bool = False

    @property
    def expected(self) -> dict[str, float]:
        """Orders."""
        return {"u": 3, "p": 2}

    def fields(self, dim: int) -> dict[str, Any]:
        """Exact velocity and pressure."""
        if self.axisymmetric:
            return {"u": ROUND_VELOCITY, "p": ROUND_PRESSURE}
        return {"u": VELOCITY[dim], "p": PRESSURE[dim]}

    def system(self, m: skfem.Mesh, order: int) -> System:
        """Velocity and pressure on a mesh."""
        return System(
            m, {"u": (2, m.dim()), "p": (1, 0)}, order, axisymmetric=self.axisymmetric
        )

    def coefficients(self, dim: int) -> porous_flow.Coefficients:
        """Inertia, viscosity and drag of comparable size around a moving bed."""
        solid = (
            Components([0.0, -0.4])
            if self.axisymmetric
            else Components([0.3, -0.2, 0.1][:dim])
        )
        return porous_flow.Coefficients(1.0, 1.0, POROSITY, 0.5, 0.6, solid, 1.0)

    def manufactured(self, n: int) -> tuple[Manufactured, dict[str, Any]]:
        """The case on a mesh and the facets with prescribed values; the right end is
        open.
        """
        m = mesh(self.shape, n)
        system = self.system(m, 5)
        rest = np.setdiff1d(m.boundary_facets(), m.boundaries["right"])
        forms = [(porous_flow.residual, system.cells, self.coefficients(m.dim()))]
        return Manufactured(system, self.fields(m.dim()), forms), {"u": rest}
