"""Bubbles of a fluidized bed: rise, exchange of gas and heat with the emulsion per
volume of bubbles.

u_excess is the superficial velocity less that at minimum fluidization, u - u_mf.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

GRAVITY = 9.81  # [m/s2]
_INF = float("inf")
_KL = (
    "Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, "
    "Butterworth-Heinemann, Boston"
)
_SIT_GRACE = "Sit, Grace 1981, Chem. Eng. Sci. 36, 327-335"


@closure(kind="bubble_rise", ranges={"d_b/D_bed": (0.0, 0.125)}, source=_KL)
def bubble_rise_davidson_harrison(d_b: Value, u_excess: Value, D_bed: Value) -> Value:
    """Davidson and Harrison (1963): velocity of a bubble in a bed of bubbles.

        u_b = u_excess + 0.711 sqrt(g d_b)

    D_bed : [m] diameter of the bed; enters the range only

    Fitted to: single bubbles rise as in a liquid; the excess gas adds to that. Beyond
        the range walls slow bubbles down
    Limits: d_b -> 0: u_excess.
    Source: Eqs. 6.7 and 6.8.

    >>> round(float(bubble_rise_davidson_harrison(d_b=0.1, u_excess=0.3, D_bed=1.0)), 6)
    1.004213
    """
    return u_excess + 0.711 * (GRAVITY * d_b) ** 0.5


@closure(
    kind="gas_exchange",
    ranges={"d_b": (0.0, _INF), "eps_mf": (0.0, 1.0)},
    source=_KL,
)
def gas_exchange_kunii_levenspiel(
    d_b: Value, u_mf: Value, D_gas: Value, eps_mf: Value
) -> Value:
    """Kunii and Levenspiel (1968): gas from bubble to cloud and from cloud to emulsion,
    in series.

        1 / K_be = 1 / K_bc + 1 / K_ce
        K_bc = 4.5 u_mf / d_b + 5.85 D_gas^(1/2) g^(1/4) / d_b^(5/4)
        K_ce = 6.77 (eps_mf D_gas 0.711 (g d_b)^(1/2) / d_b^3)^(1/2)

    Fitted to: nothing: Davidson's throughflow and penetration theory; for bubbles that
        rise faster than the gas in the emulsion
    Limits: D_gas -> 0: 0, since the cloud keeps the gas.
    Source: Eqs. 10.27 and 10.34.

    >>> round(float(gas_exchange_kunii_levenspiel(d_b=0.06, u_mf=0.05, D_gas=2e-5, eps_mf=0.45)), 6)
    0.85607
    """
    bubble_cloud = 4.5 * u_mf / d_b + 5.85 * D_gas**0.5 * GRAVITY**0.25 / d_b**1.25
    cloud_emulsion = (
        6.77 * (eps_mf * D_gas * 0.711 * (GRAVITY * d_b) ** 0.5 / d_b**3) ** 0.5
    )
    return 1.0 / (1.0 / bubble_cloud + 1.0 / cloud_emulsion)


@closure(
    kind="gas_exchange",
    ranges={"d_b": (0.0, _INF), "eps_mf": (0.0, 1.0)},
    source=_SIT_GRACE,
)
def gas_exchange_sit_grace(
    d_b: Value, u_mf: Value, D_gas: Value, eps_mf: Value, u_b: Value
) -> Value:
    """Sit and Grace (1981): interacting bubbles, throughflow and diffusion side by
    side.

        K_be = 2 u_mf / d_b + 12 (eps_mf D_gas u_b / pi)^(1/2) / d_b^(3/2)

    Fitted to: pairs of bubbles injected into beds of glass beads; the bounds of the
        data have not been seen
    Limits: D_gas -> 0: 2 u_mf / d_b, by throughflow alone.

    >>> round(float(gas_exchange_sit_grace(d_b=0.06, u_mf=0.05, D_gas=2e-5, eps_mf=0.45, u_b=0.8)), 6)
    2.902744
    """
    return 2.0 * u_mf / d_b + 12.0 * (eps_mf * D_gas * u_b / np.pi) ** 0.5 / d_b**1.5


@closure(kind="bubble_heat", ranges={"d_b": (0.0, _INF)}, source=_KL)
def bubble_heat_kunii_levenspiel(
    d_b: Value, u_mf: Value, rho_gas: Value, cp_gas: Value, k_gas: Value
) -> Value:
    """Kunii and Levenspiel (1968): heat between the gas of bubbles and their clouds.

        H_b = 4.5 u_mf rho_gas cp_gas / d_b + 5.85 (k_gas rho_gas cp_gas)^(1/2) g^(1/4) / d_b^(5/4)

    Fitted to: nothing: the analogue of bubble to cloud exchange of gas; without
        particles in the bubbles
    Limits: k_gas -> 0: 4.5 u_mf rho_gas cp_gas / d_b, by throughflow alone.
    Source: Chapter 11.

    >>> h = bubble_heat_kunii_levenspiel(d_b=0.06, u_mf=0.05, rho_gas=0.3, cp_gas=1150.0, k_gas=0.075)
    >>> round(float(h), 4)
    3067.2216
    """
    content = rho_gas * cp_gas
    return (
        4.5 * u_mf * content / d_b
        + 5.85 * (k_gas * content) ** 0.5 * GRAVITY**0.25 / d_b**1.25
    )


@closure(
    kind="bubble_heat",
    ranges={"d_b": (0.0, _INF), "eps_mf": (0.0, 1.0)},
    source=_SIT_GRACE,
)
def bubble_heat_sit_grace(
    d_b: Value,
    u_mf: Value,
    rho_gas: Value,
    cp_gas: Value,
    k_gas: Value,
    eps_mf: Value,
    u_b: Value,
) -> Value:
    """Sit and Grace (1981): gas_exchange_sit_grace with the diffusivity of heat.

        H_be = rho_gas cp_gas (2 u_mf / d_b + 12 (eps_mf a u_b / pi)^(1/2) / d_b^(3/2)),  a = k_gas / (rho_gas cp_gas)

    Fitted to: exchange of gas, by the analogy of heat
    Limits: k_gas -> 0: 2 u_mf rho_gas cp_gas / d_b, by throughflow alone.

    >>> h = bubble_heat_sit_grace(d_b=0.06, u_mf=0.05, rho_gas=0.3, cp_gas=1150.0, k_gas=0.075, eps_mf=0.45, u_b=0.8)
    >>> round(float(h), 4)
    1980.9532
    """
    content = rho_gas * cp_gas
    diffusivity = k_gas / content
    return content * (
        2.0 * u_mf / d_b + 12.0 * (eps_mf * diffusivity * u_b / np.pi) ** 0.5 / d_b**1.5
    )
