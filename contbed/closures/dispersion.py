"""Thermal dispersion [W/m/K]: what the tortuous flow adds to the stagnant conductivity, along and across the flow.

`Pe = Re Pr`, superficial velocity relative to the solid times d_p over the thermal diffusivity of the fluid; Pe >= 0.
Each correlation is a pair NAME_axial and NAME_transverse; `dispersion_pair` looks both up by the common stem.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from contbed.closures import registry
from contbed.closures.registry import closure

_WAKAO = "Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds, Gordon and Breach"
_VDI = "VDI Heat Atlas 2010, section M7, Springer, doi:10.1007/978-3-540-77877-6"


class DispersionPair(NamedTuple):
    """The two closures of one correlation."""

    axial: Callable[..., Any]
    transverse: Callable[..., Any]


def dispersion_pair(stem: str) -> DispersionPair:
    """The axial and the transverse closure whose names begin with `stem`; SceneError names the nearest stems."""
    known = [name.removesuffix("_axial") for name in registry.names("dispersion") if name.endswith("_axial")]
    if stem not in known:
        raise registry.unknown(stem, known, "dispersion")
    return DispersionPair(registry.get(f"{stem}_axial"), registry.get(f"{stem}_transverse"))


@closure(kind="dispersion", unit="W/m/K", ranges={"Pe": (0, 1e4)}, source=_WAKAO)
def dispersion_wakao_kaguei_axial(Pe, k_fluid):
    """Wakao and Kaguei (1982): axial dispersion in packed beds.

        k = 0.5 Pe k_fluid

    Parameters
    ----------
    Pe : [-] superficial Peclet number on d_p
    k_fluid : [W/m/K] conductivity of the fluid

    Returns
    -------
    [W/m/K] dispersion conductivity along the flow

    Range
    -----
    Pe : 0 to 1e4

    Fitted to
    ---------
    packed-bed data of many authors; the upper bound is that of the heat transfer data used with it (Re < 8500)

    Limits
    ------
    Pe -> 0: 0. Linear in Pe throughout, although the data fall below the line for Pe < 10.

    Example
    -------
    >>> round(dispersion_wakao_kaguei_axial(Pe=100.0, k_fluid=0.025), 6)
    1.25

    Source
    ------
    Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds, Gordon and Breach.
    As quoted by Pivem and de Lemos 2012, eq. 35.
    """
    return 0.5 * Pe * k_fluid


@closure(kind="dispersion", unit="W/m/K", ranges={"Pe": (0, 1e4)}, source=_WAKAO)
def dispersion_wakao_kaguei_transverse(Pe, k_fluid):
    """Wakao and Kaguei (1982): transverse dispersion in packed beds.

        k = 0.1 Pe k_fluid

    Parameters
    ----------
    Pe : [-] superficial Peclet number on d_p
    k_fluid : [W/m/K] conductivity of the fluid

    Returns
    -------
    [W/m/K] dispersion conductivity across the flow

    Range
    -----
    Pe : 0 to 1e4

    Fitted to
    ---------
    packed-bed data of many authors; the upper bound is that of the heat transfer data used with it (Re < 8500)

    Limits
    ------
    Pe -> 0: 0.

    Example
    -------
    >>> round(dispersion_wakao_kaguei_transverse(Pe=100.0, k_fluid=0.025), 6)
    0.25

    Source
    ------
    Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds, Gordon and Breach.
    The factor 0.1 is quoted from secondary sources.
    """
    return 0.1 * Pe * k_fluid


@closure(kind="dispersion", unit="W/m/K", ranges={"Pe": (0, 1e4)}, source=_VDI)
def dispersion_vdi_axial(Pe, k_fluid):
    """VDI Heat Atlas (2010): axial dispersion in packed beds.

        k = Pe k_fluid / 2

    Parameters
    ----------
    Pe : [-] superficial Peclet number on d_p
    k_fluid : [W/m/K] conductivity of the fluid

    Returns
    -------
    [W/m/K] dispersion conductivity along the flow

    Range
    -----
    Pe : 0 to 1e4

    Fitted to
    ---------
    packed-bed data; the atlas prints no bound, this one is the reach of the usual data

    Limits
    ------
    Pe -> 0: 0.

    Example
    -------
    >>> round(dispersion_vdi_axial(Pe=100.0, k_fluid=0.025), 6)
    1.25

    Source
    ------
    VDI Heat Atlas 2010, section M7, Springer, doi:10.1007/978-3-540-77877-6; quoted from secondary sources.
    """
    return 0.5 * Pe * k_fluid


@closure(kind="dispersion", unit="W/m/K", ranges={"Pe": (0, 1e4), "d_p/D_bed": (0, 0.25)}, source=_VDI)
def dispersion_vdi_transverse(Pe, k_fluid, d_p, D_bed):
    """VDI Heat Atlas (2010): transverse dispersion in a packed tube, uniform over the cross-section.

        k = Pe k_fluid / (7 (2 - (1 - 2 d_p / D_bed)^2))

    Parameters
    ----------
    Pe : [-] superficial Peclet number on d_p
    k_fluid : [W/m/K] conductivity of the fluid
    d_p : [m] particle diameter
    D_bed : [m] diameter of the bed

    Returns
    -------
    [W/m/K] dispersion conductivity across the flow

    Range
    -----
    Pe : 0 to 1e4
    d_p/D_bed : 0 to 0.25

    Fitted to
    ---------
    heat transfer through the walls of packed tubes, to be used with a wall coefficient. The atlas prints no bounds;
    beyond d_p / D_bed = 1/4 the formula still holds formally but a continuum does not

    Limits
    ------
    Pe -> 0: 0. d_p / D_bed -> 0: Pe k_fluid / 7.

    Example
    -------
    >>> round(dispersion_vdi_transverse(Pe=100.0, k_fluid=0.025, d_p=0.005, D_bed=0.05), 6)
    0.262605

    Source
    ------
    VDI Heat Atlas 2010, section M7, Springer, doi:10.1007/978-3-540-77877-6; quoted from secondary sources.
    """
    return Pe * k_fluid / (7 * (2 - (1 - 2 * d_p / D_bed) ** 2))
