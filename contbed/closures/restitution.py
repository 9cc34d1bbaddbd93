"""Restitution of particles that rub when they collide: what their fluctuations lose by
friction too.

    e [-] restitution of two particles, normal to the contact
    sliding_friction [-] mu, Coulomb's coefficient of two particles

The kinetic theory of smooth spheres loses (1 - e^2) of the normal part of the energy in
a collision. Friction takes from the tangential part as well, and gives some to the
spin. An effective restitution e_eff stands for all that in the dissipation, 1 - e_eff^2
in place of 1 - e^2; pressure, viscosity and conductivity keep e.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_CHIALVO = "Chialvo, Sundaresan 2013, Phys. Fluids 25, 070603, doi:10.1063/1.4812804"
_JENKINS = "Jenkins, Zhang 2002, Phys. Fluids 14, 1228-1235, doi:10.1063/1.1448334"


@closure(
    kind="effective_restitution",
    ranges={"e": (0.7, 1.0), "sliding_friction": (0.0, 1.0)},
    source=_CHIALVO,
)
def effective_restitution_chialvo_sundaresan(
    e: Value, sliding_friction: Value
) -> Value:
    """Chialvo and Sundaresan (2013): effective restitution, for the dissipation alone.

    e_eff = e - 3/2 mu exp(-3 mu)

    Fitted to: discrete elements in simple shear, linear springs. As two public programs
        have it (twoPhaseEulerFoamPU of CFDEM-PRINCETON, an older sedFoam); the range of
        the data is not in their text, that declared here is ours
    Limits: mu = 0: e. Least at mu = 1/3, then it rises again as particles roll rather
        than slide in shear. Their factor of the shear stress with friction is left out:
        the two programs differ in its exponent.

    >>> round(float(effective_restitution_chialvo_sundaresan(e=0.97, sliding_friction=0.1)), 6)
    0.858877
    """
    return e - 1.5 * sliding_friction * np.exp(-3.0 * sliding_friction)


@closure(
    kind="effective_restitution",
    ranges={"e": (0.9, 1.0), "sliding_friction": (0.0, 1.0)},
    source=_JENKINS,
    bounds={"tangential_restitution": "(-1, 1]"},
)
def effective_restitution_jenkins_zhang(
    e: Value, sliding_friction: Value, tangential_restitution: float = 0.0
) -> Value:
    """Jenkins and Zhang (2002): effective restitution, with the spin at the balance of
    gain and loss.

    e_eff = e - (a1 - a2 ratio)/2 a1 = 2 mu [B + C (1 - 2 r)] a2 = 5/2 mu [B + C
    (1 - mu0^2)/(1 + mu0^2)] ratio = 2 r C/(B + C) B = pi/2 - atan(mu0),
    C = mu0/(1 + mu0^2),  r = mu/mu0,  mu0 = 7/2 mu (1 + e)/(1 + beta0)

    collisions slide where tangential over normal velocity exceeds mu0, else they stick
    with the tangential restitution beta0; ratio is the temperature of the spin over
    theta. Printed with b1/b2 for ratio.

    tangential_restitution : [-] beta0 of a contact that sticks

    Fitted to: kinetic theory of nearly elastic spheres, linear in the temperature of
        the spin. As sedFoam has it, with beta0 = 0. Integrals over collisions of
        Maxwell's distributions agree to the second order of mu; without linearisations
        they give 0.845 for the example
    Limits: mu = 0: e. Small mu: e - pi/2 mu.

    >>> round(float(effective_restitution_jenkins_zhang(e=0.97, sliding_friction=0.1)), 6)
    0.853495
    """
    mu, r = sliding_friction, (1.0 + tangential_restitution) / (3.5 * (1.0 + e))
    mu0 = mu / r
    B, C = 0.5 * np.pi - np.arctan(mu0), mu0 / (1.0 + mu0**2)
    a1 = 2.0 * mu * (B + C * (1.0 - 2.0 * r))
    a2 = 2.5 * mu * (B + C * (1.0 - mu0**2) / (1.0 + mu0**2))
    return e - 0.5 * (a1 - a2 * 2.0 * r * C / (B + C))
