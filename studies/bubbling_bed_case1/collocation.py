"""The balances of a bubbling bed in strong form, by collocation on panels: an
independent reference for the elements.

Unknown are the values of all fields at the Chebyshev-Lobatto points of each panel, and
the distributor. Equations hold at inner points; fields of second order are continuous
with their slopes where panels meet, gases are continuous. Only the numbers of a scene
are shared with contbed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve
from scipy.special import erf

from contbed import load
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SCENES = ("none", "paper_closure", "two_flux", "p1")
SIGMA = 5.670374419e-8
# from each end [m]
PANELS = np.array([0.0, 0.6e-3, 1.5e-3, 3e-3, 6e-3, 12e-3, 25e-3, 50e-3, 100e-3])


def differentiation(n):
    """Chebyshev-Lobatto points on [-1, 1] upward, and the matrix of the derivative
    there.
    """
    x = -np.cos(np.pi * np.arange(n + 1) / n)
    c = np.where(np.arange(n + 1) % n == 0, 2.0, 1.0) * (-1.0) ** np.arange(n + 1)
    D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(n + 1))
    return x, D - np.diag(D.sum(axis=1))


class Collocation:
    """One scene on panels of degree `n`."""

    def __init__(self, scene, n=14):
        self.scene, H = scene, scene.bubbling_bed.height
        self.edges = np.concatenate(
            [PANELS, np.linspace(0.1, H - 0.1, 7)[1:-1], (H - PANELS)[::-1]]
        )
        x, D = differentiation(n)
        half = np.diff(self.edges) / 2
        self.n, self.count = n, len(half)
        self.z = (self.edges[:-1, None] + half[:, None] * (x + 1)).ravel()
        size = self.z.size
        self.D = np.zeros((size, size))
        for k in range(self.count):
            part = slice(k * (n + 1), (k + 1) * (n + 1))
            self.D[part, part] = D / half[k]
        kinds = list(scene.solids.values())
        solids = scene.bubbling_bed.solids_fraction
        self.kappa = np.array(
            [1.5 * solids * s.volume_share / s.diameter for s in kinds]
        )
        emissivity = np.array([s.emissivity for s in kinds])
        self.Ka, self.beta = emissivity * self.kappa, self.kappa.sum()
        s = np.sqrt(self.Ka.sum() / self.beta)
        bed = 2 * s / (1 + s)
        surfaces = scene.bubbling_bed.surfaces.values()
        self.h_tube, self.h_wall = (
            1 / (1 / bed + 1 / each.emissivity - 1) / 4 for each in surfaces
        )
        self.level = scene.radiation.level
        self.m = len(kinds)
        self.fields = self.m + 2 + (self.level in ("p1", "two_flux"))

    def flow(self, z):
        """Share of the feed that entered below z, and its derivative."""
        feed, H = self.scene.solids["char"].feed, self.scene.bubbling_bed.height
        low, high = (
            erf((end - feed.height) / feed.width / np.sqrt(2)) for end in (0.0, H)
        )
        share = (erf((z - feed.height) / feed.width / np.sqrt(2)) - low) / (high - low)
        peak = (
            np.exp(-((z - feed.height) ** 2) / (2 * feed.width**2))
            / feed.width
            * np.sqrt(2 / np.pi)
            / (high - low)
        )
        return share, peak

    def sources(self, u):
        """What each balance holds besides derivatives, [W/m], from all fields at all
        points.
        """
        sc, z, m = self.scene, self.z, self.m
        A, delta = sc.bubbling_bed.section, sc.bubbling_bed.bubbles.fraction
        V, T, Te, Tb = A * (1 - delta), u[:m], u[m], u[m + 1]
        kinds, names = list(sc.solids.values()), list(sc.solids)
        _, peak = self.flow(z)
        out = 0.0 * u
        share = self.kappa / self.kappa.sum()
        for i, s in enumerate(kinds):
            passed = V * 4 * self.kappa[i] * s.gas_coefficient * (T[i] - Te)
            out[i] -= passed
            out[m] += passed
            for name, value in s.exchange.items():
                j = names.index(name)
                out[i] -= V * value * (T[i] - T[j])
                out[j] -= V * value * (T[j] - T[i])
            for x in sc.bubbling_bed.surfaces.values():
                out[i] -= (
                    x.perimeter * x.coefficient * share[i] * (T[i] - x.temperature)
                )
            if s.feed is not None:
                out[i] -= s.feed.capacity_flow * peak * (T[i] - s.feed.temperature)
            if s.release is not None:
                r = s.release
                rate = A * r.rate * (np.exp(-z / r.length) if r.length else 1.0)
                out[i] += rate * (
                    np.exp(-r.activation * (1 / T[i] - 1 / r.reference))
                    if r.activation
                    else 1.0
                )
        mixed = A * delta * sc.bubbling_bed.bubbles.exchange * (Tb - Te)
        out[m] += mixed + A * sc.bubbling_bed.release.rate * np.exp(
            -z / sc.bubbling_bed.release.length
        )
        out[m + 1] -= mixed
        if self.level == "none":
            return out
        E4 = 4 * SIGMA * T**4
        surfaces = [
            (x.perimeter * h, 4 * SIGMA * x.temperature**4)
            for x, h in zip(
                sc.bubbling_bed.surfaces.values(),
                (self.h_tube, self.h_wall),
                strict=True,
            )
        ]
        if self.level == "paper":
            G = (self.Ka[:, None] * E4).sum(axis=0) / self.Ka.sum()
            for h, cold in surfaces:
                out[:m] -= self.Ka[:, None] / self.Ka.sum() * h * (E4 - cold)
        else:
            G = u[m + 2]
            out[m + 2] = V * (self.Ka[:, None] * (E4 - G)).sum(axis=0) - sum(
                h * (G - cold) for h, cold in surfaces
            )
        out[:m] -= V * self.Ka[:, None] * (E4 - G)
        return out

    def residual(self, u, Td):
        """All equations for fields (nfields, npoints) and the distributor."""
        sc, m, n = self.scene, self.m, self.n
        A, D = sc.bubbling_bed.section, self.D
        up, share = u @ D.T, self.kappa / self.kappa.sum()
        flow, _ = self.flow(self.z)
        R = self.sources(u)
        first, last = (
            np.arange(self.count) * (n + 1),
            np.arange(self.count) * (n + 1) + n,
        )
        distributor, T_in = sc.bubbling_bed.distributor, sc.inlet.temperature
        Tg = T_in + (1 - np.exp(-distributor.preheat_NTU)) * (Td - T_in)
        capacity = [sc.inlet.capacity_flow, sc.bubbling_bed.bubbles.capacity_flow]
        mixing = [A * s.mixing_conductivity for s in sc.solids.values()]
        if self.fields > m + 2:
            mixing += [0.0, 0.0, A / ((3 if self.level == "p1" else 4) * self.beta)]
        h_d, eps = distributor.coefficient, distributor.emissivity
        plate = A * h_d * (share * (u[:m, 0] - Td)).sum() - sum(capacity) * (Tg - T_in)
        for i in [*range(m), *range(m + 2, self.fields)]:
            R[i] += mixing[i] * (up[i] @ D.T)
            if i < m and list(sc.solids.values())[i].feed is not None:
                R[i] -= list(sc.solids.values())[i].feed.capacity_flow * flow * up[i]
            R[i, last[:-1]] = (u[i, first[1:]] - u[i, last[:-1]]) * mixing[i] * 1e3
            R[i, first[1:]] = mixing[i] * (up[i, first[1:]] - up[i, last[:-1]])
            if i < m:
                R[i, 0] = mixing[i] * up[i, 0] + A * h_d * share[i] * (Td - u[i, 0])
                R[i, -1] = mixing[i] * up[i, -1]
            else:
                into = A * eps / (2 * (2 - eps)) * (4 * SIGMA * Td**4 - u[i, 0])
                R[i, 0] = mixing[i] * up[i, 0] + into
                R[i, -1] = -mixing[i] * up[i, -1] + A / 2 * (
                    4 * sc.bubbling_bed.freeboard.radiosity - u[i, -1]
                )
                plate = plate - into
        for i, W in zip((m, m + 1), capacity, strict=True):
            R[i] -= W * up[i]
            R[i, first[1:]] = W * 1e3 * (u[i, last[:-1]] - u[i, first[1:]])
            R[i, 0] = W * 1e3 * (Tg - u[i, 0])
        return R, plate

    def solve(self, guess=1150.0, cap=200.0):
        """Newton with steps of `cap` kelvin at most."""
        size, k = self.z.size, self.fields
        u, Td = np.full((k, size), guess), 400.0
        if k > self.m + 2:
            u[-1] = 4 * SIGMA * guess**4
        for _ in range(60):
            R, plate = self.residual(u, Td)
            J = self._jacobian(u, Td)
            rhs = np.append(R.ravel(), plate)
            rows = np.abs(J).max(axis=1)
            columns = np.ones(k * size + 1)
            if k > self.m + 2:
                columns[(k - 1) * size : -1] = 300.0
            step = columns * spsolve(
                csc_matrix(J / rows[:, None] * columns), -rhs / rows
            )
            damp = min(
                1.0,
                cap / np.abs(np.append(step[: (self.m + 2) * size], step[-1])).max(),
            )
            u, Td = u + damp * step[:-1].reshape(k, size), Td + damp * step[-1]
            if damp == 1.0 and np.abs(step / columns).max() < 1e-6:
                return u, Td
        raise RuntimeError("collocation did not converge")

    def _jacobian(self, u, Td):
        """Exact by complex steps: the equations are a linear function of derivatives
        plus one of local values.
        """
        size, k = self.z.size, self.fields
        J = np.zeros((k * size + 1, k * size + 1))
        e = 1e-30
        for j in range(k):
            shifted = u + 0j
            shifted[j] += 1j * e
            local = np.imag(self.sources(shifted)) / e
            for i in range(k):
                J[i * size + np.arange(size), j * size + np.arange(size)] = local[i]
        # derivatives, joints and ends act on one field at a time: one column of every
        # panel together, for each field
        at = np.arange(self.count) * (self.n + 1)
        for colour in range(2):
            for p in range(self.n + 1):
                touched = (at + p)[colour::2]
                for j in range(k):
                    shifted = u + 0j
                    shifted[j, touched] += 1j * e
                    R, plate = self.residual(shifted, Td + 0j)
                    change = np.imag(R) / e
                    for panel in touched // (self.n + 1):
                        low, high = panel * (self.n + 1), (panel + 1) * (self.n + 1)
                        rows = np.arange(max(low - 1, 0), min(high + 1, size))
                        column = j * size + panel * (self.n + 1) + p
                        for i in range(k):
                            J[i * size + rows, column] = change[i, rows]
                    if touched[0] == p:
                        J[-1, j * size + p] = np.imag(plate) / e
        R, plate = self.residual(u + 0j, Td + 1j * e)
        J[:-1, -1], J[-1, -1] = np.imag(R).ravel() / e, np.imag(plate) / e
        return J

    def results(self, u, Td):
        """The named results of contbed from a solution."""
        sc, m = self.scene, self.m
        x, w = np.polynomial.legendre.leggauss(24)
        half = np.diff(self.edges) / 2
        points = self.edges[:-1, None] + half[:, None] * (x + 1)

        def at(values, panel, z):
            own = slice(panel * (self.n + 1), (panel + 1) * (self.n + 1))
            nodes = (self.z[own] - self.edges[panel]) / half[panel] - 1
            fit = np.polynomial.chebyshev.chebfit(nodes, values[own], self.n)
            return np.polynomial.chebyshev.chebval(
                (z - self.edges[panel]) / half[panel] - 1, fit
            )

        def total(values):
            return sum(
                half[p] * (w * at(values, p, points[p])).sum()
                for p in range(self.count)
            )

        middle = sc.bubbling_bed.height / 2
        panel = int(np.searchsorted(self.edges, middle, side="right") - 1)
        share = self.kappa / self.kappa.sum()
        out = {"T_distributor_K": Td}
        out |= {
            f"T_{name}_mid_K": float(at(u[i], panel, middle))
            for i, name in enumerate(sc.solids)
        }
        out |= {"T_emulsion_top_K": u[m, -1], "T_bubble_top_K": u[m + 1, -1]}
        T4 = 4 * SIGMA * u[:m] ** 4
        G = (
            u[-1]
            if self.fields > m + 2
            else (self.Ka[:, None] * T4).sum(axis=0) / self.Ka.sum()
        )
        for (name, x_), h in zip(
            sc.bubbling_bed.surfaces.items(), (self.h_tube, self.h_wall), strict=True
        ):
            mean = (share[:, None] * u[:m]).sum(axis=0)
            out[f"{name}_convection_W"] = total(
                x_.perimeter * x_.coefficient * (mean - x_.temperature)
            )
            cold = 4 * SIGMA * x_.temperature**4
            out[f"{name}_radiation_W"] = (
                0.0 if self.level == "none" else total(x_.perimeter * h * (G - cold))
            )
        leaves = self.fields > m + 2
        out["top_radiation_W"] = (
            sc.bubbling_bed.section
            / 2
            * (u[-1, -1] - 4 * sc.bubbling_bed.freeboard.radiosity)
            if leaves
            else 0.0
        )
        return {name: float(value) for name, value in out.items()}


def reference(name: str) -> dict[str, float]:
    """Named results of a scene of this folder."""
    solver = Collocation(load(HERE / f"{name}.toml"), n=12)
    return solver.results(*solver.solve())


def compute() -> Tables:
    """The named results of all scenes."""
    found = {name: reference(name) for name in SCENES}
    rows = [(key, *(found[name][key] for name in SCENES)) for key in found[SCENES[0]]]
    return {"reference": Table({"result": "", **dict.fromkeys(SCENES, ".6f")}, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Nothing: study.py draws."""
    return {}
