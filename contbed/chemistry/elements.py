"""Elements of a chemical formula, and molar masses from them."""

from __future__ import annotations

import re
from collections.abc import Mapping

from contbed.errors import SceneError

# standard atomic weights [kg/mol] of all elements that have one, abridged: IUPAC 2021,
# doi:10.1515/pac-2019-0603
ATOMIC_WEIGHTS: dict[str, float] = {
    "H": 1.008e-3, "He": 4.0026e-3, "Li": 6.94e-3, "Be": 9.0122e-3, "B": 10.81e-3, "C": 12.011e-3,
    "N": 14.007e-3, "O": 15.999e-3, "F": 18.998e-3, "Ne": 20.180e-3, "Na": 22.990e-3, "Mg": 24.305e-3,
    "Al": 26.982e-3, "Si": 28.085e-3, "P": 30.974e-3, "S": 32.06e-3, "Cl": 35.45e-3, "Ar": 39.95e-3,
    "K": 39.098e-3, "Ca": 40.078e-3, "Sc": 44.956e-3, "Ti": 47.867e-3, "V": 50.942e-3, "Cr": 51.996e-3,
    "Mn": 54.938e-3, "Fe": 55.845e-3, "Co": 58.933e-3, "Ni": 58.693e-3, "Cu": 63.546e-3, "Zn": 65.38e-3,
    "Ga": 69.723e-3, "Ge": 72.630e-3, "As": 74.922e-3, "Se": 78.971e-3, "Br": 79.904e-3, "Kr": 83.798e-3,
    "Rb": 85.468e-3, "Sr": 87.620e-3, "Y": 88.906e-3, "Zr": 91.224e-3, "Nb": 92.906e-3, "Mo": 95.95e-3,
    "Ru": 101.07e-3, "Rh": 102.91e-3, "Pd": 106.42e-3, "Ag": 107.87e-3, "Cd": 112.41e-3, "In": 114.82e-3,
    "Sn": 118.71e-3, "Sb": 121.76e-3, "Te": 127.60e-3, "I": 126.90e-3, "Xe": 131.29e-3, "Cs": 132.91e-3,
    "Ba": 137.33e-3, "La": 138.91e-3, "Ce": 140.12e-3, "Pr": 140.91e-3, "Nd": 144.24e-3, "Sm": 150.36e-3,
    "Eu": 151.96e-3, "Gd": 157.25e-3, "Tb": 158.93e-3, "Dy": 162.50e-3, "Ho": 164.93e-3, "Er": 167.26e-3,
    "Tm": 168.93e-3, "Yb": 173.05e-3, "Lu": 174.97e-3, "Hf": 178.49e-3, "Ta": 180.95e-3, "W": 183.84e-3,
    "Re": 186.21e-3, "Os": 190.23e-3, "Ir": 192.22e-3, "Pt": 195.08e-3, "Au": 196.97e-3, "Hg": 200.59e-3,
    "Tl": 204.38e-3, "Pb": 207.20e-3, "Bi": 208.98e-3, "Th": 232.04e-3, "Pa": 231.04e-3, "U": 238.03e-3,
}  # fmt: skip
_PART = re.compile(r"([A-Z][a-z]?)(\d*\.?\d*)|(\()|(\))(\d*\.?\d*)")
_PHASE = re.compile(r"\((?:s|l|g|gr|cr|a|b|c|L|solid|liquid)\)$")


def elements_of(formula: str) -> dict[str, float]:
    """Return the number of atoms of each element in a formula such as "CH4",
    "Fe0.947O", "Ca(OH)2" or "C(gr)".

    Raises
    ------
    SceneError : the text is no formula of known elements
    """
    text = _PHASE.sub("", formula)
    stack: list[dict[str, float]] = [{}]
    position = 0
    while position < len(text):
        found = _PART.match(text, position)
        if (
            found is None
            or (found[1] and found[1] not in ATOMIC_WEIGHTS)
            or (found[4] and len(stack) == 1)
        ):
            raise SceneError(
                f"{formula!r} is no chemical formula of known elements; give its "
                f"`elements`, such as {{C = 1, H = 4}}"
            )
        if found[1]:
            stack[-1][found[1]] = stack[-1].get(found[1], 0.0) + float(found[2] or 1)
        elif found[3]:
            stack.append({})
        else:
            inner, count = stack.pop(), float(found[5] or 1)
            for element, number in inner.items():
                stack[-1][element] = stack[-1].get(element, 0.0) + count * number
        position = found.end()
    if len(stack) != 1 or not stack[0]:
        raise SceneError(
            f"{formula!r} is no chemical formula; give its `elements`, such as {{C = "
            f"1, H = 4}}"
        )
    return stack[0]


def molar_mass_of(elements: Mapping[str, float]) -> float:
    """Return the molar mass [kg/mol] of a species with these atoms; SceneError names
    an element without weight.
    """
    unknown = [name for name in elements if name not in ATOMIC_WEIGHTS]
    if unknown:
        raise SceneError(
            f"no atomic weight of {', '.join(unknown)} is known; give `molar_mass`"
        )
    return sum(count * ATOMIC_WEIGHTS[name] for name, count in elements.items())
