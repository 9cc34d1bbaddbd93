"""Char, limestone and inert in a hot bubbling bed: the radiation of Rabi and de
Souza-Santos and the full models.

Along the height z of a bed of section A, bubble fraction delta, species m, emulsion gas
e and bubble gas b:

    -(A k_m T_m')' + W_m T_m' + w_m' (T_m - T_feed) = A Q_m - A (1-delta) [a_m h_m (T_m - T_e)
        + sum_n H_mn (T_m - T_n) + K_a,m (4 E_m - G)] - f_m [p_t h_t (T_m - T_t) + p_w h_w (T_m - T_w)]
    W_e T_e' = A (1-delta) sum_m a_m h_m (T_m - T_e) + A delta H (T_b - T_e) + A Q_g,   W_b T_b' = A delta H (T_e - T_b)
    -A (D G')' + A (1-delta) sum_m K_a,m (G - 4 E_m) + sum_x p_x eps_x/4 (G - 4 E_x) = 0          x: tubes and walls
    D dG/dn = [eps/(2 (2-eps))] (4 E_d - G) on the distributor, (4 J - G)/2 at the top

E = sigma T^4, a_m = 4 kappa_m, f_m = kappa_m / sum kappa, w_m the share of the feed
below z. "two_flux" has D = 1/(4 beta), "p1" D = 1/(3 beta). "closure" is eq. 34, G = 4
sum K_a,m E_m / K_a: nothing is left to transport, and what tubes and walls take is
shared in proportion to K_a,m. The distributor's own temperature follows from its
balance.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import scipy.sparse as sp
from scipy.special import ndtr

from contbed.closures import optics as closures
from contbed.closures.optics import SIGMA
from contbed.fem.skfem import System
from contbed.mesh.build import build
from contbed.mesh.grading import graded
from contbed.scene.mesh import MeshLine
from contbed.solvers.linear import Policy, Solver
from contbed.solvers.newton import Options, newton

HERE = Path(__file__).parent
NAMES = ("char", "limestone", "inert")
SOLIDS, GASES = ("T_char", "T_limestone", "T_inert"), ("T_emulsion", "T_bubble")
LEVELS = {"closure": None, "two_flux": 1 / 4, "p1": 1 / 3}  # D beta
START = 1150.0  # [K]


def power(T):
    """sigma T^4 [W/m2]."""
    return SIGMA * T**4


class Bed:
    """One level of radiation in the bed of data/bed.toml; the state is all fields, then
    the distributor's temperature.

    `ends` false: distributor and top are mirrors. `mixing` is a factor on the axial
    dispersion of the solids.
    """

    def __init__(self, level: str, ends: bool = True, mixing: float = 1.0):
        data = tomllib.loads((HERE / "data" / "bed.toml").read_text(encoding="ascii"))
        self.level, self.data = level, data
        self.conduction = mixing * np.array(data["solids"]["k_axial_W_mK"])
        solids, self.H, self.A = data["solids"], data["height_m"], data["section_m2"]
        self.emulsion = self.A * (1 - data["bubble_fraction"])
        self.gas, self.plate, self.release = (
            data[key] for key in ("gas", "distributor", "heat_release")
        )
        fractions = (
            np.array(solids["volume_fraction_of_solids"])
            * data["emulsion_solids_fraction"]
        )
        columns = zip(
            NAMES, fractions, solids["diameter_m"], solids["emissivity"], strict=True
        )
        found = closures.optics(
            [closures.Species(*column) for column in columns], "independent"
        )
        self.absorption, self.beta = found.absorption, found.extinction
        kappa = found.absorption + found.scattering
        self.share = kappa / kappa.sum()
        self.exchange = 4 * kappa * solids["h_gas_W_m2K"]
        eps_bed = closures.radiation_emissivity_half_space(albedo=found.albedo)
        self.sinks = []
        for name in ("tubes", "wall"):
            part = data[name]
            sees = closures.emissivity_immersed(eps_bed, part["emissivity"]) / 4
            self.sinks.append(
                SimpleNamespace(
                    name=name,
                    p=part["perimeter_m"],
                    h=part["h_W_m2K"],
                    T=part["temperature_K"],
                    sees=sees,
                )
            )
        self.m_plate, self.m_top = (
            (closures.marshak(self.plate["emissivity"]), 0.5) if ends else (0.0, 0.0)
        )
        self.J_top = data["top"]["radiosity_W_m2"] * power(
            data["top"]["radiosity_reference_K"]
        )
        self.diffusion = None if LEVELS[level] is None else LEVELS[level] / self.beta
        self._mesh()

    def _mesh(self) -> None:
        layer = 0.5 / np.sqrt(self.absorption.sum() * self.beta)
        nodes = graded(self.H, [(0.0, layer), (self.H, layer)], scale=0.25)
        self.mesh = build(MeshLine(type="line", length=self.H), [nodes]).skfem
        fields = (*SOLIDS, *GASES) + (("G",) if self.diffusion else ())
        self.system = System(self.mesh, dict.fromkeys(fields, (3, 0)), 9)
        points = self.system.fields["T_char"][0].points[0]
        self.z, self.order = np.sort(points), np.argsort(points)
        self.bottom, self.top = (
            {f: self.system.offset[f, 0] + node for f in fields}
            for node in (np.argmin(points), np.argmax(points))
        )

    def emitted(self, T):
        """4 sum K_a,m E_m [W/m3 of emulsion]."""
        return sum(4 * K * power(t) for K, t in zip(self.absorption, T, strict=True))

    def radiated(self, T, G):
        """E_R,m, what each species gives to the radiation [W/m of height]."""
        return [
            self.emulsion * K * (4 * power(t) - G)
            for K, t in zip(self.absorption, T, strict=True)
        ]

    def drawn(self, sink, G):
        """Radiation that tubes or walls take from the field [W/m of height]."""
        return sink.p * sink.sees * (G - 4 * power(sink.T))

    def _field(self, unknowns, T):
        return unknowns.G if self.diffusion else self.emitted(T) / self.absorption.sum()

    def form(self, unknowns, tests, c, o):
        """All balances along the height."""
        solids, gas, release, z = self.data["solids"], self.gas, self.release, o.x[0]
        T = [getattr(unknowns, name) for name in SOLIDS]
        T_e, T_b, G = unknowns.T_emulsion, unknowns.T_bubble, self._field(unknowns, T)
        lost = self.radiated(T, G)
        at = (z - solids["feed_height_m"]) / solids["feed_width_m"]
        low, high = (
            ndtr((end - solids["feed_height_m"]) / solids["feed_width_m"])
            for end in (0.0, self.H)
        )
        below = (ndtr(at) - low) / (high - low)
        density = np.exp(-(at**2) / 2) / (
            np.sqrt(2 * np.pi) * solids["feed_width_m"] * (high - low)
        )
        burning = release["Qc_W_m3"] * np.exp(-z / release["L_m"])
        hotter = np.exp(release["ER_K"] * (1 / release["Tref_K"] - 1 / T[0]))
        source = [burning * hotter, release["Ql_W_m3"], 0.0]
        total, given = 0.0, 0.0
        for m, name in enumerate(SOLIDS):
            test, here = getattr(tests, name), T[m]
            to_gas = self.emulsion * self.exchange[m] * (here - T_e)
            W = solids["net_flow_capacity_W_K"][m]
            row = to_gas + lost[m] - self.A * source[m]
            row = (
                row
                + W * below * o.grad(here)[0]
                + W * density * (here - solids["feed_temperature_K"][m])
            )
            for n, H_mn in enumerate(solids["H_solid_solid_W_m3K"][m]):
                if n != m:
                    row = row + self.emulsion * H_mn * (here - T[n])
            for sink in self.sinks:
                row = row + self.share[m] * sink.p * sink.h * (here - sink.T)
                if not self.diffusion:
                    part = self.absorption[m] / self.absorption.sum()
                    row = row + part * 4 * sink.p * sink.sees * (
                        power(here) - power(sink.T)
                    )
            total = (
                total
                + self.A * self.conduction[m] * o.dot(o.grad(here), o.grad(test))
                + row * test
            )
            given = given + to_gas
        between = (
            self.A * self.data["bubble_fraction"] * gas["exchange_W_m3K"] * (T_b - T_e)
        )
        heat = self.A * release["Qg_W_m3"] * np.exp(-z / release["L_m"])
        row = (
            gas["emulsion_capacity_flow_W_K"] * o.grad(T_e)[0] - given - between - heat
        )
        total = total + row * tests.T_emulsion
        total = (
            total
            + (gas["bubble_capacity_flow_W_K"] * o.grad(T_b)[0] + between)
            * tests.T_bubble
        )
        if self.diffusion:
            taken = sum(self.drawn(sink, G) for sink in self.sinks) - sum(lost)
            total = (
                total
                + self.A * self.diffusion * o.dot(o.grad(G), o.grad(tests.G))
                + taken * tests.G
            )
        return total

    def ends(self, state):
        """What enters at nodes of the bed's ends, as (row, value [W], {column:
        derivative}); T_d is the last column.
        """
        d, A, h, m_d = self.system.size, self.A, self.plate["h_W_m2K"], self.m_plate
        T_d, out = state[d], []
        for name, f in zip(SOLIDS, self.share, strict=True):
            row = self.bottom[name]
            out.append(
                (row, A * h * f * (T_d - state[row]), {d: A * h * f, row: -A * h * f})
            )
        if self.diffusion:
            row, last = self.bottom["G"], self.top["G"]
            slope = {d: 16 * A * m_d * SIGMA * T_d**3, row: -A * m_d}
            out.append((row, A * m_d * (4 * power(T_d) - state[row]), slope))
            out.append(
                (
                    last,
                    A * self.m_top * (4 * self.J_top - state[last]),
                    {last: -A * self.m_top},
                )
            )
        entering = [part for part in out if part[0] != self.top.get("G")]
        carried = sum(
            self.gas[f"{name}_capacity_flow_W_K"] for name in ("emulsion", "bubble")
        )
        warmed = carried * (1 - np.exp(-self.plate["gas_preheat_NTU"]))
        to_plate = sum(value for _, value, _ in entering) + warmed * (
            T_d - self.gas["inlet_temperature_K"]
        )
        slope = {d: warmed}
        for _, _, derivative in entering:
            slope = {
                key: slope.get(key, 0.0) + derivative.get(key, 0.0)
                for key in slope | derivative
            }
        return [
            *out,
            (d, -to_plate, slope | {key: -value for key, value in slope.items()}),
        ]

    def assemble(self, state, jacobian):
        """Residual and Jacobian of bed, ends and distributor; the first rows of both
        gases hold their inlet.
        """
        size, T_in = self.system.size, self.gas["inlet_temperature_K"]
        inner, matrix = self.system.assemble(
            [(self.form, self.system.cells, None)], state[:size], jacobian
        )
        residual = np.append(inner, 0.0)
        preheat = 1 - np.exp(-self.plate["gas_preheat_NTU"])
        inlets = [self.bottom[name] for name in GASES]
        entries = []
        for row, value, slopes in self.ends(state):
            residual[row] -= value
            entries += [(row, column, -slope) for column, slope in slopes.items()]
        for row in inlets:
            residual[row] = state[row] - T_in - preheat * (state[size] - T_in)
            entries += [(row, row, 1.0), (row, size, -preheat)]
        if not jacobian:
            return residual, None
        keep = np.ones(size + 1)
        keep[inlets] = 0.0
        rows, columns, values = zip(*entries, strict=True)
        ends = sp.coo_matrix((values, (rows, columns)), shape=(size + 1, size + 1))
        whole = sp.block_diag([matrix, sp.csc_matrix((1, 1))])
        return residual, sp.csc_matrix(sp.diags(keep) @ whole + ends)

    def solve(self):
        """State from a bed of uniform temperature."""
        state = np.full(self.system.size + 1, START)
        if self.diffusion:
            self.system.part(state, "G")[:] = 4 * power(START)
        none = np.empty(0, dtype=np.int64)
        options = Options(iterations=60, lower=0.0, what="bed")
        state, _ = newton(self.assemble, state, none, Policy(1), options)
        # steps with the matrix of the solution itself close the balances to round-off
        for _ in range(3):
            residual, matrix = self.assemble(state, True)
            state = state - Solver(matrix, Policy(1))(residual)
        return state

    def results(self, state):
        """Profiles over z, G and the flux q included, temperature of the distributor
        and the heat of each part [W].
        """
        profiles = {
            name: self.system.part(state, name)[self.order]
            for name in (*SOLIDS, *GASES)
        }
        T = [profiles[name] for name in SOLIDS]
        cells, heat = [self.system.cells], {}
        black = self.emitted(T) / self.absorption.sum()
        profiles["G"] = (
            self.system.part(state, "G")[self.order] if self.diffusion else black
        )

        def integral(expression):
            def at_points(u, o):
                return expression(u, [getattr(u, name) for name in SOLIDS])

            return self.system.integrate(at_points, cells, state)

        heat["species"] = [
            integral(lambda u, T, m=m: self.radiated(T, self._field(u, T))[m])
            for m in range(3)
        ]
        for sink in self.sinks:
            heat[sink.name] = integral(
                lambda u, T, s=sink: self.drawn(s, self._field(u, T))
            )
        if self.diffusion:
            heat["distributor"] = (
                -self.A
                * self.m_plate
                * (4 * power(state[-1]) - state[self.bottom["G"]])
            )
            heat["top"] = -self.A * self.m_top * (4 * self.J_top - state[self.top["G"]])
        return SimpleNamespace(z=self.z, T_d=float(state[-1]), heat=heat, **profiles)

    def flux(self, found):
        """q along the height [W/m2]: -D dG/dz of a full model, pi (I+ - I-) of the
        closure by `forward`.
        """
        if self.diffusion:
            return -self.diffusion * np.gradient(found.G, found.z)
        return self.forward(found)

    def forward(self, found):
        """q = 2 (pi I+ - E) of eqs. 29 and 34, dI+/dz = -2 beta (I+ - E/pi), upwards
        from the distributor (eq. 37).
        """
        E = sum(
            K * power(getattr(found, name))
            for K, name in zip(self.absorption, SOLIDS, strict=True)
        )
        E = E / self.absorption.sum()
        eps, rate = self.plate["emissivity"], 2 * self.beta
        q = [2 * eps / (2 - eps) * (power(found.T_d) - E[0])]
        for step, rise in zip(np.diff(found.z), np.diff(E), strict=True):
            lag = rise / step / self.beta  # E is linear in between
            q.append((q[-1] + lag) * np.exp(-rate * step) - lag)
        return np.array(q)


def solved(level, **options):
    """Results at one level; `options` of the bed."""
    bed = Bed(level, **options)
    return bed.results(bed.solve())


def open_balance(level, found):
    """Share of the radiation of the species that reaches neither tubes, walls,
    distributor nor top [1].
    """
    to = [
        found.heat[name]
        for name in ("tubes", "wall", "distributor", "top")
        if name in found.heat
    ]
    species = found.heat["species"]
    if LEVELS[level] is None:
        return sum(species) / max(map(abs, species))
    return (sum(species) - sum(to)) / max(map(abs, (*species, *to)))
