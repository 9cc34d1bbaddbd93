"""Fluidized beds: volume of bubbles, gas through the emulsion, heat transfer, mixing
of the solids, expansion.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_INF = float("inf")
_KL = (
    "Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, "
    "Butterworth-Heinemann, Boston"
)
_SOUZA = (
    "Souza-Santos 2010, Solid Fuels Combustion and Gasification, 2nd edition, CRC "
    "Press, Boca Raton"
)
_TOOMEY = "Toomey, Johnstone 1952, Chem. Eng. Prog. 48, 220-226"


@closure(
    kind="bubble_fraction",
    ranges={"u/u_mf": (1.0, _INF)},
    source=_KL,
    bounds={"u": "(0, inf)"},
)
def bubble_fraction_kunii_levenspiel(
    u: Value, u_mf: Value, u_b: Value, eps_mf: Value
) -> Value:
    """Kunii and Levenspiel (1991): volume of bubbles, by how fast they rise past the
    gas of the emulsion.

        delta = (1 - w) (u - u_mf) / (u_b + s u_mf) + w u / u_b,  r = u_b eps_mf / u_mf
        s = 2 - S(r, 1) - S(r, 3) - S(r, 5),  w = S(r, 10),  S(r, c) = r^4 / (r^4 + c^4)

    Fitted to: nothing: balances of gas. The book switches s from 2 to 1, 0, -1 at
        r = 1, 3, 5 and to u / u_b at 10, which jumps; here the same limits join
        smoothly, each over a factor of 1.7 in r
    Limits: r -> 0: (u - u_mf) / (u_b + 2 u_mf). r -> inf: u / u_b.
    Source: Eqs. 6.26 to 6.29.

    >>> round(float(bubble_fraction_kunii_levenspiel(u=1.0, u_mf=0.2, u_b=1.8, eps_mf=0.45)), 6)
    0.450544
    """
    r4 = (u_b * eps_mf / u_mf) ** 4
    s = 2.0 - r4 / (r4 + 1.0) - r4 / (r4 + 3.0**4) - r4 / (r4 + 5.0**4)
    vigorous = r4 / (r4 + 10.0**4)
    return (1.0 - vigorous) * (u - u_mf) / (u_b + s * u_mf) + vigorous * u / u_b


@closure(
    kind="bubble_fraction",
    ranges={"u/u_mf": (1.0, _INF)},
    source=_TOOMEY,
    bounds={"u": "(0, inf)"},
)
def bubble_fraction_two_phase(u: Value, u_mf: Value, u_b: Value) -> Value:
    """Toomey and Johnstone (1952): all gas beyond minimum fluidization flows as
    bubbles.

        delta = (u - u_mf) / u_b

    Fitted to: nothing: the two-phase theory, which gives bubbles somewhat too much gas
    Limits: u -> u_mf: 0.

    >>> round(float(bubble_fraction_two_phase(u=1.0, u_mf=0.2, u_b=1.6)), 6)
    0.5
    """
    return (u - u_mf) / u_b


@closure(kind="emulsion_gas", ranges={"u_mf": (0, _INF)}, source=_TOOMEY)
def emulsion_gas_two_phase(u_mf: Value) -> Value:
    """Toomey and Johnstone (1952): the emulsion stays at minimum fluidization.

        u_e = u_mf

    Fitted to: nothing: the two-phase theory
    Limits: none

    >>> emulsion_gas_two_phase(u_mf=0.2)
    0.2
    """
    return 1.0 * u_mf


@closure(
    kind="emulsion_gas",
    ranges={"delta": (0.0, 0.7), "wake": (0.0, 0.5)},
    source=_KL,
)
def emulsion_gas_kunii_levenspiel(
    u_mf: Value, eps_mf: Value, delta: Value, u_b: Value, wake: float = 0.2
) -> Value:
    """Kunii and Levenspiel (1991): the gas rises through particles that sink to make
    good for those in wakes.

        u_e = u_mf - eps_mf wake delta u_b / (1 - delta - wake delta)

    Result: gas through the emulsion, per section of emulsion; below zero it flows down,
        which beds refuse
    Fitted to: nothing: balances of gas and solids
    Limits: delta -> 0: u_mf.
    Source: Eqs. 6.39 and 6.40.

    >>> round(float(emulsion_gas_kunii_levenspiel(u_mf=0.3, eps_mf=0.45, delta=0.2, u_b=1.0, wake=0.2)), 6)
    0.276316
    """
    return u_mf - eps_mf * wake * delta * u_b / (1.0 - delta - wake * delta)


@closure(kind="nusselt", ranges={"Re": (0.1, 100.0)}, source=_KL)
def nusselt_kunii_levenspiel(Re: Value) -> Value:
    """Kunii and Levenspiel (1969): fine particles of a fluidized bed, as measured by
    plug flow of the gas.

        Nu = 0.03 Re^1.3

    Result: Nusselt number on d_p and the conductivity of the gas
    Fitted to: data of many authors; below one since gas that bypasses in bubbles is
        counted. With bubbles as a phase of their own nusselt_gunn or
        nusselt_ranz_marshall is the choice
    Limits: Re -> 0: 0.
    Source: Fig. 11.6. Range read from secondary sources.

    >>> round(float(nusselt_kunii_levenspiel(Re=10.0)), 6)
    0.598579
    """
    return 0.03 * Re**1.3


@closure(
    kind="solids_mixing",
    ranges={"delta": (0.0, 0.7), "wake": (0.0, 0.5)},
    source=_KL,
)
def solids_mixing_kunii_levenspiel(
    delta: Value, u_b: Value, d_b: Value, u_mf: Value, eps_mf: Value, wake: float = 0.2
) -> Value:
    """Kunii and Levenspiel (1969): vertical mixing of the solids by the wakes that
    bubbles carry up.

        D_s = wake^2 eps_mf delta d_b u_b^2 / (3 u_mf)

    Fitted to: nothing: the counter-current flow model with exchange between wake and
        emulsion; an order of magnitude
    Limits: delta -> 0: 0.
    Source: Chapter 6. Quoted from secondary sources.

    >>> round(float(solids_mixing_kunii_levenspiel(delta=0.3, u_b=1.0, d_b=0.1, u_mf=0.2, eps_mf=0.45)), 6)
    0.0009
    """
    return wake**2 * eps_mf * delta * d_b * u_b**2 / (3.0 * u_mf)


@closure(
    kind="expansion",
    ranges={"u_excess": (0.0, _INF), "d_p": (5e-5, 5e-3)},
    source=_SOUZA,
)
def expansion_souza_santos(
    u_excess: Value, u_mf: Value, d_p: Value, rho_solid: Value, rho_gas: Value
) -> Value:
    """Souza-Santos (2010): height of a bed wider than 64 mm over its height at minimum
    fluidization. In SI.

        R = 1 + 14.314 u_excess^0.738 d_p^1.006 rho_solid^0.376 / (rho_gas^0.126 u_mf^0.937)

    Fitted to: beds of many authors, by Babu, Shah and Talwalkar (1978); the bounds of
        the data have not been seen
    Limits: u_excess -> 0: 1.
    Source: Eq. 14.8.

    >>> round(float(expansion_souza_santos(u_excess=0.5, u_mf=0.2, d_p=7e-4, rho_solid=2600.0, rho_gas=0.3)), 6)
    1.58159
    """
    return 1.0 + 14.314 * u_excess**0.738 * d_p**1.006 * rho_solid**0.376 / (
        rho_gas**0.126 * u_mf**0.937
    )
