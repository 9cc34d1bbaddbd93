"""Thermal dispersion [W/m/K]: what the tortuous flow adds to the stagnant conductivity,
along and across the flow.

`Pe = Re Pr`, superficial velocity relative to the solid times d_p over the thermal
diffusivity of the fluid; Pe >= 0. Each correlation is a pair NAME_axial and
NAME_transverse; `registry.dispersion_pair` looks both up by the common stem.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_WAKAO = "Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds, Gordon and Breach"
_VDI = "VDI Heat Atlas 2010, section M7, Springer, doi:10.1007/978-3-540-77877-6"


@closure(kind="dispersion", ranges={"Pe": (0, 1e4)}, source=_WAKAO)
def dispersion_wakao_kaguei_axial(Pe: Value, k_fluid: Value) -> Value:
    """Wakao and Kaguei (1982): axial dispersion in packed beds.

        k = 0.5 Pe k_fluid

    Result: dispersion conductivity along the flow
    Fitted to: packed-bed data of many authors; the upper bound is that of the heat
        transfer data used with it (Re < 8500)
    Limits: Pe -> 0: 0. Linear in Pe throughout, although the data fall below the line
        for Pe < 10.
    Source: As quoted by Pivem and de Lemos 2012, eq. 35.

    >>> round(dispersion_wakao_kaguei_axial(Pe=100.0, k_fluid=0.025), 6)
    1.25
    """
    return 0.5 * Pe * k_fluid


@closure(kind="dispersion", ranges={"Pe": (0, 1e4)}, source=_WAKAO)
def dispersion_wakao_kaguei_transverse(Pe: Value, k_fluid: Value) -> Value:
    """Wakao and Kaguei (1982): transverse dispersion in packed beds.

        k = 0.1 Pe k_fluid

    Result: dispersion conductivity across the flow
    Fitted to: packed-bed data of many authors; the upper bound is that of the heat
        transfer data used with it (Re < 8500)
    Limits: Pe -> 0: 0.
    Source: The factor 0.1 is quoted from secondary sources.

    >>> round(dispersion_wakao_kaguei_transverse(Pe=100.0, k_fluid=0.025), 6)
    0.25
    """
    return 0.1 * Pe * k_fluid


@closure(kind="dispersion", ranges={"Pe": (0, 1e4)}, source=_VDI)
def dispersion_vdi_axial(Pe: Value, k_fluid: Value) -> Value:
    """VDI Heat Atlas (2010): axial dispersion in packed beds.

        k = Pe k_fluid / 2

    Result: dispersion conductivity along the flow
    Fitted to: packed-bed data; the atlas prints no bound, this one is the reach of the
        usual data
    Limits: Pe -> 0: 0.
    Source: Quoted from secondary sources.

    >>> round(dispersion_vdi_axial(Pe=100.0, k_fluid=0.025), 6)
    1.25
    """
    return 0.5 * Pe * k_fluid


@closure(
    kind="dispersion",
    ranges={"Pe": (0, 1e4), "d_p/D_bed": (0, 0.25)},
    source=_VDI,
)
def dispersion_vdi_transverse(
    Pe: Value, k_fluid: Value, d_p: Value, D_bed: Value
) -> Value:
    """VDI Heat Atlas (2010): transverse dispersion in a packed tube, uniform over the
    cross-section.

        k = Pe k_fluid / (7 (2 - (1 - 2 d_p / D_bed)^2))

    Result: dispersion conductivity across the flow
    Fitted to: heat transfer through the walls of packed tubes, to be used with a wall
        coefficient. The atlas prints no bounds; beyond d_p / D_bed = 1/4 the formula
        still holds formally but a continuum does not
    Limits: Pe -> 0: 0. d_p / D_bed -> 0: Pe k_fluid / 7.
    Source: Quoted from secondary sources.

    >>> round(dispersion_vdi_transverse(Pe=100.0, k_fluid=0.025, d_p=0.005, D_bed=0.05), 6)
    0.262605
    """
    return Pe * k_fluid / (7 * (2 - (1 - 2 * d_p / D_bed) ** 2))
