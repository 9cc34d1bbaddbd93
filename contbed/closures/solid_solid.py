"""Heat between two solid phases by collisions [W/m3/K]."""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_AGU = (
    "Agu, Pfeifer, Eikeland, Tokheim, Moldestad 2019, Energy Fuels 33, 7385, "
    "doi:10.1021/acs.energyfuels.9b01340"
)


@closure(
    kind="solid_exchange",
    ranges={"d_1/d_2": (0.01, 100.0), "slip": (0.0, 5.0)},
    source=_AGU,
)
def solid_exchange_agu(
    f_1: Value,
    f_2: Value,
    d_1: Value,
    d_2: Value,
    rho_1: Value,
    rho_2: Value,
    cp_1: Value,
    cp_2: Value,
    k_1: Value,
    k_2: Value,
    slip: Value,
    D_bed: Value,
    modulus: float = 3e7,
    restitution: float = 0.9,
) -> Value:
    """Agu et al. (2019): collisions of two kinds of spheres, each with the conduction
    of a Hertzian impact.

        H = 4.88 a / b (m / E)^0.6 (R slip)^0.7 (8 pi (w_1 + w_2))^(1/2)
        a = f_1 f_2 (d_1 + d_2)^2,  b = d_1^3 d_2^3 ((rho cp k)_1^(-1/2) + (rho cp k)_2^(-1/2))
        m = m_1 m_2 / (m_1 + m_2),  R = d_1 d_2 / (2 (d_1 + d_2)),  w = 2 slip^2 (d / D_bed)^2 / (15 (1 - restitution))

    Fitted to: nothing: kinetic theory of collisions and the heat of one impact (Sun and
        Chen 1988, 0.91 x 5.36 = 4.88), with moduli of soft spheres. Lasting contacts
        and conduction through the gas between neighbours are not in it
    Limits: slip -> 0: 0.
    Source: Quoted from a public implementation.

    >>> h = solid_exchange_agu(f_1=0.1, f_2=0.4, d_1=1e-3, d_2=7e-4, rho_1=2000.0, rho_2=2600.0, cp_1=1000.0,
    ...                        cp_2=1000.0, k_1=1.0, k_2=2.0, slip=0.5, D_bed=1.0)
    >>> round(float(h), 3)
    34.135
    """
    m_1, m_2 = np.pi / 6.0 * rho_1 * d_1**3, np.pi / 6.0 * rho_2 * d_2**3
    mass, radius = m_1 * m_2 / (m_1 + m_2), d_1 * d_2 / (2.0 * (d_1 + d_2))
    random = 2.0 / 15.0 * slip**2 / (1.0 - restitution) * (d_1**2 + d_2**2) / D_bed**2
    rate = (
        f_1 * f_2 * (d_1 + d_2) ** 2 / (d_1 * d_2) ** 3 * (8.0 * np.pi * random) ** 0.5
    )
    resistance = (rho_1 * cp_1 * k_1) ** -0.5 + (rho_2 * cp_2 * k_2) ** -0.5
    return 4.88 * rate * (mass / modulus) ** 0.6 * (radius * slip) ** 0.7 / resistance
