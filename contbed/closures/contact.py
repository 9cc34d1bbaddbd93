"""Rough solids that touch in a gas: conductance of the asperities, distance of the
mean planes, temperature jump.
"""

from __future__ import annotations

from contbed.closures.registry import Value, closure

_COOPER = (
    "Cooper, Mikic, Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279-300, "
    "doi:10.1016/0017-9310(69)90011-8; "
    "constants of Yovanovich 2005, IEEE Trans. Compon. Packag. Technol. 28, 182-206, "
    "doi:10.1109/TCAPT.2005.848483"
)
_SEPARATION = (
    "Yovanovich 2005, IEEE Trans. Compon. Packag. Technol. 28, 182-206, "
    "doi:10.1109/TCAPT.2005.848483"
)
_KENNARD = "Kennard 1938, Kinetic Theory of Gases, McGraw-Hill, New York, pp. 311-327"


@closure(
    kind="contact",
    ranges={"pressure/hardness": (1e-6, 0.2)},
    source=_COOPER,
)
def contact_cooper_mikic_yovanovich(
    k_solid: Value, roughness: Value, slope: Value, pressure: Value, hardness: Value
) -> Value:
    """Cooper, Mikic and Yovanovich (1969): conductance of plastically deformed
    asperities in a nominally flat contact.

        h = 1.25 k_solid slope/roughness (pressure/hardness)^0.95

    k_solid : [W/m/K] harmonic mean of both solids, 2 k_1 k_2/(k_1 + k_2)

    Fitted to: the theory of plastic contact of Gaussian surfaces, within 1.5 %; the
        authors print no bounds
    Limits: pressure -> 0: 0. roughness -> 0: infinite, a perfect contact. For isotropic
        Gaussian roughness without films of oxide; a first loading, a second one
        conducts better

    >>> round(float(contact_cooper_mikic_yovanovich(
    ...     k_solid=42.0, roughness=27e-9, slope=0.079, pressure=2.4e8, hardness=3e9)))
    13943061
    """
    return 1.25 * k_solid * slope / roughness * (pressure / hardness) ** 0.95


@closure(
    kind="contact_separation",
    ranges={"pressure/hardness": (1e-5, 2e-2)},
    source=_SEPARATION,
)
def contact_separation_yovanovich(
    roughness: Value, pressure: Value, hardness: Value
) -> Value:
    """Yovanovich (2005): distance of the mean planes of two rough surfaces in contact.

        Y = 1.53 roughness (pressure/hardness)^(-0.097)

    Fitted to: the exact inverse error function of plastic contact of Gaussian surfaces
    Limits: pressure -> 0: grows without bound, slowly. Above the range, up to 0.2, it
        exceeds the exact separation by up to 1 roughness

    >>> round(float(contact_separation_yovanovich(roughness=27e-9, pressure=3e7, hardness=3e9)) * 1e9, 3)
    64.574
    """
    return 1.53 * roughness * (pressure / hardness) ** (-0.097)


@closure(
    kind="temperature_jump",
    ranges={"accommodation": (0.01, 1.0)},
    source=_KENNARD,
)
def temperature_jump_kennard(
    mean_free_path: Value, accommodation: Value, gamma: Value, Pr: Value
) -> Value:
    """Kennard (1938): temperature jumps at both faces of a gap (Smoluchowski effect),
    as a length of gas added to it.

        M = 2 (2 - accommodation)/accommodation 2 gamma/(gamma + 1)/Pr mean_free_path

    Fitted to: nothing: kinetic theory with a thermal accommodation coefficient, the
        same at both faces
    Limits: mean_free_path -> 0: 0. Exact to first order in the Knudsen number; a gap
        below a mean free path is joined to free molecules within some percent

    >>> M = temperature_jump_kennard(mean_free_path=68e-9, accommodation=0.7, gamma=1.4, Pr=0.71)
    >>> round(float(M) * 1e9, 2)
    415.02
    """
    return (
        2.0
        * (2.0 - accommodation)
        / accommodation
        * 2.0
        * gamma
        / (gamma + 1.0)
        / Pr
        * mean_free_path
    )
