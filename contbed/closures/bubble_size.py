"""Bubbles of a fluidized bed: size at the start and how it grows.

u_excess is the superficial velocity less that at minimum fluidization, u - u_mf.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.bubbles import GRAVITY
from contbed.closures.registry import Value, closure

_INF = float("inf")
_MORI_WEN = "Mori, Wen 1975, AIChE J. 21, 109-115, doi:10.1002/aic.690210114"
_HORIO = "Horio, Nonaka 1987, AIChE J. 33, 1865-1872, doi:10.1002/aic.690331113"
_DARTON = (
    "Darton, LaNauze, Davidson, Harrison 1977, Trans. Inst. Chem. Eng. 55, 274-280"
)
_MIWA = "Miwa, Mori, Kato, Muchi 1972, Int. Chem. Eng. 12, 181-187"


@closure(
    kind="bubble_size",
    ranges={"D_bed": (0.3, 1.3), "u_excess": (0.0, 0.48)},
    source=_MORI_WEN,
    bounds={"d_b0": "(0, inf)"},
)
def bubble_size_mori_wen(z: Value, d_b0: Value, u_excess: Value, D_bed: Value) -> Value:
    """Mori and Wen (1975): growth of bubbles from the distributor to a largest size.

        d_b = d_bm - (d_bm - d_b0) exp(-0.3 z / D_bed),  d_bm = 1.64 (A u_excess)^0.4,  A = pi D_bed^2 / 4

    d_b0 : [m] diameter at the distributor; a perforated plate with N orifices per area
        gives 1.30 g^-0.2 (u_excess/N)^0.4 as long as bubbles do not touch, a porous
        plate 2.78 u_excess^2 / g

    Fitted to: data of several authors, u_mf 5 to 200 mm/s, particles of 60 to 450 um
    Limits: z -> 0: d_b0. z -> inf: d_bm.
    Source: In SI, d_bm = 2.59 (A u_excess / sqrt(g))^0.4 of Kunii and Levenspiel 1991,
        Eq. 5.19; range quoted from secondary sources.

    >>> round(float(bubble_size_mori_wen(z=0.5, d_b0=0.01, u_excess=0.3, D_bed=1.0)), 6)
    0.136774
    """
    d_bm = 2.59 * (0.25 * np.pi * D_bed**2 * u_excess / GRAVITY**0.5) ** 0.4
    return d_bm - (d_bm - d_b0) * np.exp(-0.3 * z / D_bed)


@closure(
    kind="bubble_growth",
    ranges={"D_bed": (0.3, 1.3), "u_excess": (0.0, 0.48)},
    source=_MORI_WEN,
)
def bubble_growth_mori_wen(d_b: Value, u_excess: Value, D_bed: Value) -> Value:
    """Mori and Wen (1975): slope of bubble_size_mori_wen over the height, at the excess
    of gas there.

        d d_b / dz = 0.3 (d_bm - d_b) / D_bed,  d_bm = 1.64 (A u_excess)^0.4,  A = pi D_bed^2 / 4

    Fitted to: data of several authors, u_mf 5 to 200 mm/s, particles of 60 to 450 um
    Limits: d_b -> d_bm: 0; larger bubbles shrink.

    >>> round(float(bubble_growth_mori_wen(d_b=0.1, u_excess=0.3, D_bed=1.0)), 6)
    0.24604
    """
    d_bm = 2.59 * (0.25 * np.pi * D_bed**2 * u_excess / GRAVITY**0.5) ** 0.4
    return 0.3 * (d_bm - d_b) / D_bed


@closure(
    kind="bubble_growth",
    ranges={"D_bed": (0.05, 1.3), "u_excess": (0.0, 1.0)},
    source=_HORIO,
)
def bubble_growth_horio_nonaka(
    d_b: Value, u_excess: Value, u_mf: Value, D_bed: Value
) -> Value:
    """Horio and Nonaka (1987): coalescence and splitting.

        d d_b / dz = 0.3 (d_bm - d_b - gamma (D_bed d_b)^(1/2)) / D_bed
        gamma = 0.0256 (D_bed / g)^(1/2) / u_mf,  d_bm = 1.64 (A u_excess)^0.4

    Fitted to: beds of fine and coarse particles; the bounds of the data have not been
        seen
    Limits: u_mf -> inf: bubble_growth_mori_wen.
    Source: As quoted in the documentation of a process simulator.

    >>> round(float(bubble_growth_horio_nonaka(d_b=0.1, u_excess=0.3, u_mf=0.1, D_bed=1.0)), 6)
    0.238286
    """
    d_bm = 2.59 * (0.25 * np.pi * D_bed**2 * u_excess / GRAVITY**0.5) ** 0.4
    gamma = 0.0256 * (D_bed / GRAVITY) ** 0.5 / u_mf
    return 0.3 * (d_bm - d_b - gamma * (D_bed * d_b) ** 0.5) / D_bed


@closure(
    kind="bubble_growth",
    ranges={"u_excess": (0.0, _INF), "d_b/D_bed": (0.0, 0.3)},
    source=_DARTON,
)
def bubble_growth_darton(d_b: Value, u_excess: Value, D_bed: Value) -> Value:
    """Darton et al. (1977): pairwise coalescence without end.

        d_b = 0.54 u_excess^0.4 (z + z_0)^0.8 / g^0.2,  hence  d d_b / dz = 0.8 d_b / (z + z_0)

    d_b : [m] diameter of the bubbles, from which z + z_0 follows
    D_bed : [m] diameter of the bed; enters the range only

    Fitted to: freely bubbling beds of many authors; wider bubbles are slugs
    Limits: d_b -> 0: infinite, as d_b^(-1/4).

    >>> round(float(bubble_growth_darton(d_b=0.1, u_excess=0.3, D_bed=1.0)), 6)
    0.20381
    """
    height = (d_b * GRAVITY**0.2 / (0.54 * u_excess**0.4)) ** 1.25
    return 0.8 * d_b / height


@closure(
    kind="bubble_start",
    ranges={"u_excess": (0.0, _INF)},
    source=_MORI_WEN,
    bounds={"factor": "(0, inf)"},
)
def bubble_start_porous_plate(u_excess: Value, factor: float = 2.78) -> Value:
    """Mori and Wen (1975): diameter of bubbles above a porous plate.

        d_b0 = factor u_excess^2 / g

    factor : [-] 2.78; others print 3.685 and 3.77

    Fitted to: data of others on porous plates
    Limits: u_excess -> 0: 0.
    Source: As Kunii and Levenspiel 1991, Eq. 5.19.

    >>> round(float(bubble_start_porous_plate(u_excess=0.3)), 6)
    0.025505
    """
    return factor * u_excess**2 / GRAVITY


@closure(kind="bubble_start", ranges={"u_excess": (0.0, _INF)}, source=_MIWA)
def bubble_start_orifices(u_excess: Value, area: Value) -> Value:
    """Miwa et al. (1972): diameter of bubbles above a perforated plate.

        d_b0 = 1.30 g^-0.2 (u_excess area)^0.4

    Fitted to: plates whose bubbles do not touch, d_b0 below the pitch area^(1/2); above
        that the porous plate's equation holds
    Limits: u_excess -> 0: 0.
    Source: As Kunii and Levenspiel 1991, Eq. 5.15.

    >>> round(float(bubble_start_orifices(u_excess=0.3, area=1e-3)), 6)
    0.032097
    """
    return 1.30 * GRAVITY**-0.2 * (u_excess * area) ** 0.4


@closure(kind="bubble_start", ranges={"u_excess": (0.0, _INF)}, source=_DARTON)
def bubble_start_darton(u_excess: Value, area: Value) -> Value:
    """Darton et al. (1977): diameter of bubbles above the distributor.

        d_b0 = 0.54 u_excess^0.4 (4 area^(1/2))^0.8 / g^0.2

    area : [m2] of plate for one orifice; 56e-6 for a porous plate

    Fitted to: freely bubbling beds of many authors
    Limits: u_excess -> 0: 0.

    >>> round(float(bubble_start_darton(u_excess=0.3, area=1e-3)), 6)
    0.040416
    """
    return 0.54 * u_excess**0.4 * (4.0 * area**0.5) ** 0.8 / GRAVITY**0.2
