"""How fast a porous particle reacts when diffusion inside slows the reaction down.

    eta = mean rate in the particle / rate at the state of its surface,    first order, isothermal:

    sphere    3 (phi coth phi - 1)/phi^2        R the radius, not volume over surface

    phi = R sqrt(k/D)     Thiele modulus, k [1/s] per volume of particle, D [m2/s] effective diffusivity in the particle

Source: Thiele, Ind. Eng. Chem. 31 (1939) 916, doi:10.1021/ie50355a027; Aris, Chem. Eng.
    Sci. 6 (1957) 262,
doi:10.1016/0009-2509(57)85028-3.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.materials.common import polynomial

# phi coth phi = sum_n B_2n (2 phi)^2n/(2n)!, B the Bernoulli numbers; eta from n = 1
# on, in powers of phi^2
SPHERE_SERIES = (
    1.0, -1.0 / 15.0, 2.0 / 315.0, -1.0 / 1575.0, 2.0 / 31185.0, -1382.0 * 3.0 / 638512875.0, 12.0 / 18243225.0,
)  # fmt: skip
# phi below which the first seven terms are exact to 1e-14 and the closed form loses
# digits
SERIES_UP_TO = 0.15


def effectiveness_of(radius: Any, rate_constant: Any, diffusivity: Any) -> Any:
    """Effectiveness of a sphere [-] from R [m], k [1/s] per volume of particle and
    D [m2/s], smooth down to k = 0.

    Where k < 0, as between two steps of an iteration, the series is continued.

    >>> round(float(effectiveness_of(2e-3, 9.0, 4e-6)), 11)
    0.67163648998
    """
    square = radius * radius * rate_constant / diffusivity
    small = square < SERIES_UP_TO**2
    safe = np.where(small, 1.0, square)
    phi = np.sqrt(safe)
    return np.where(
        small,
        polynomial(SPHERE_SERIES, square),
        3.0 * (phi / np.tanh(phi) - 1.0) / safe,
    )
