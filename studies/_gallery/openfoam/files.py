"""The dictionaries of a case: mesh, fields, constants and numerics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from studies._gallery.openfoam.case import (
    AIR,
    GASES,
    SIDE,
    SIDE_FRACTION,
    SOLVER,
    STARTS,
    STIFFNESS,
    Case,
)

THICKNESS = 0.01  # of the one cell across the plane [m]
ZERO = "uniform (0 0 0)"


def text(values: dict[str, Any], indent: str = "") -> str:
    """A dictionary in OpenFOAM's notation; a plain string is one entry, a nested
    dict a block.
    """
    lines = []
    for key, value in values.items():
        if isinstance(value, dict):
            lines.append(
                f"{indent}{key}\n{indent}{{\n{text(value, indent + '    ')}{indent}}}\n"
            )
        else:
            lines.append(f"{indent}{key} {value};\n")
    return "".join(lines)


def put(
    folder: Path, name: str, values: dict[str, Any], kind: str = "dictionary"
) -> None:
    """Write one file with its header."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    header = {
        "FoamFile": {
            "version": "2.0",
            "format": "ascii",
            "class": kind,
            "object": path.name,
        }
    }
    path.write_text(text(header) + text(values))


def fixed(value: Any) -> dict[str, Any]:
    return {"type": "fixedValue", "value": f"uniform {value}"}


def outflow(value: Any) -> dict[str, Any]:
    """Out freely; what comes back has `value`."""
    return {
        "type": "inletOutlet",
        "inletValue": f"uniform {value}",
        "value": f"uniform {value}",
    }


FREE, CALCULATED = (
    {"type": "zeroGradient"},
    {"type": "calculated", "value": "uniform 0"},
)


def mesh(case: Case) -> dict[str, Any]:
    """Blocks stacked along the height; a riser has three, the middle one between the
    two side inlets.
    """
    width, height = case.size
    levels = [0.0, *SIDE, height] if case.riser else [0.0, height]
    cells = [round(4 * case.ny / 350), round(7 * case.ny / 350)] if case.riser else []
    cells.append(case.ny - sum(cells))
    n = 2 * len(levels)  # corners of one side of the plane; the other side follows
    corners = [
        (x, y, z)
        for z in (-THICKNESS / 2, THICKNESS / 2)
        for y in levels
        for x in (0.0, width)
    ]

    def quad(*indices: int) -> str:
        return "(" + " ".join(str(i) for i in indices) + ")"

    def left(k: int) -> str:
        return quad(2 * k, 2 * k + n, 2 * k + 2 + n, 2 * k + 2)

    def right(k: int) -> str:
        return quad(2 * k + 1, 2 * k + 3, 2 * k + 3 + n, 2 * k + 1 + n)

    blocks = [
        f"hex {quad(*(2 * k + i for i in (0, 1, 3, 2)), *(2 * k + n + i for i in (0, 1, 3, 2)))}"
        f" ({case.nx} {count} 1) simpleGrading (1 1 1)"
        for k, count in enumerate(cells)
    ]
    sides = [1] if case.riser else []
    walls = [k for k in range(len(cells)) if k not in sides]
    flat = [
        quad(*(2 * k + s + i for i in (0, 2, 3, 1)))
        for k in range(len(cells))
        for s in (0, n)
    ]

    def patch(kind: str, faces: list[str]) -> dict[str, str]:
        return {"type": kind, "faces": f"({' '.join(faces)})"}

    patches = {"inlet": patch("patch", [quad(0, 1, 1 + n, n)])}
    patches["outlet"] = patch("patch", [quad(n - 2, 2 * n - 2, 2 * n - 1, n - 1)])
    for k in sides:
        patches |= {
            "left": patch("patch", [left(k)]),
            "right": patch("patch", [right(k)]),
        }
    patches["walls"] = patch("wall", [side(k) for k in walls for side in (left, right)])
    patches["plane"] = patch("empty", flat)
    return {
        "scale": 1,
        "vertices": "("
        + " ".join(f"({x:.9g} {y:.9g} {z:.9g})" for x, y, z in corners)
        + ")",
        "blocks": f"({' '.join(blocks)})",
        "edges": "()",
        "boundary": "(\n" + text(patches) + ")",
    }


def fields(case: Case) -> dict[str, tuple[str, str, Any, dict[str, Any]]]:
    """Name -> class, dimensions, initial value, boundary values ("*" for all that
    are not named).
    """
    p = case.particles
    up = f"(0 {case.gas:g} 0)"
    wall = {
        "jj": {
            "type": "JohnsonJacksonParticleSlip",
            "specularityCoefficient": p["specularity"],
            "value": ZERO,
        },
        "noslip": fixed("(0 0 0)"),
        "slip": {"type": "slip"},
    }[case.walls]
    still = fixed("(0 0 0)")
    open_top = {"type": "pressureInletOutletVelocity", "phi": "phi.air", "value": ZERO}
    agitation = {
        "type": "JohnsonJacksonParticleTheta",
        "restitutionCoefficient": p["e_w"],
        "specularityCoefficient": p["specularity"],
        "value": "uniform 1e-4",
    }
    if case.riser:
        inward = (
            case.solids
            * case.size[0]
            / (2 * (SIDE[1] - SIDE[0]) * SIDE_FRACTION * p["rho"])
        )
        feeds = {
            "left": fixed(f"({inward:.9g} 0 0)"),
            "right": fixed(f"({-inward:.9g} 0 0)"),
        }
        share = {
            "inlet": fixed(0),
            "outlet": outflow(0),
            "left": fixed(SIDE_FRACTION),
            "right": fixed(SIDE_FRACTION),
        }
        gas = {"inlet": fixed(up), **feeds}
        particles = {"inlet": still, "outlet": outflow("(0 0 0)"), **feeds}
        fraction, *speeds = case.start or (0.0, 0.0, 0.0)
        start, start_solids = (f"(0 {speed:g} 0)" for speed in speeds)
    else:
        share = {}
        superficial = {
            "type": "interstitialInletVelocity",
            "inletVelocity": f"uniform {up}",
            "alpha": "alpha.air",
        }
        gas = {"inlet": {**superficial, "value": f"uniform {up}"}}
        particles = {"inlet": still, "outlet": still}
        fraction, start, start_solids = 0.0, up, "(0 0 0)"
    if case.column:
        gas["walls"] = wall
    scalar, vector = "volScalarField", "volVectorField"
    none = "[0 0 0 0 0 0 0]"
    temperature = {"*": FREE, "inlet": fixed(300), "outlet": outflow(300)}
    return {
        "alpha.particles": (scalar, none, fraction, {"*": FREE, **share}),
        "U.air": (
            vector,
            "[0 1 -1 0 0 0 0]",
            start,
            {"*": still, "outlet": open_top, **gas},
        ),
        "U.particles": (
            vector,
            "[0 1 -1 0 0 0 0]",
            start_solids,
            {"*": wall, **particles},
        ),
        "Theta.particles": (
            scalar,
            "[0 2 -2 0 0 0 0]",
            1e-4,
            {
                "*": agitation,
                "outlet": FREE,
                **{n: fixed(1e-5) for n in ("inlet", "left", "right")},
            },
        ),
        "T.air": (scalar, "[0 0 0 1 0 0 0]", 300, temperature),
        "T.particles": (scalar, "[0 0 0 1 0 0 0]", 300, temperature),
        "p": (
            scalar,
            "[1 -1 -2 0 0 0 0]",
            1e5,
            {"*": {"type": "calculated", "value": "uniform 1e5"}},
        ),
        "p_rgh": (
            scalar,
            "[1 -1 -2 0 0 0 0]",
            1e5,
            {
                "*": {"type": "fixedFluxPressure", "value": "uniform 1e5"},
                "outlet": {
                    "type": "prghPressure",
                    "p": "uniform 1e5",
                    "value": "uniform 1e5",
                },
            },
        ),
        "nut.particles": (scalar, "[0 2 -1 0 0 0 0]", 0, {"*": CALCULATED}),
        "alphat.particles": (scalar, "[1 -1 -1 0 0 0 0]", 0, {"*": CALCULATED}),
    }


def constants(case: Case) -> dict[str, dict[str, Any]]:
    p = case.particles

    def thermo(density: float, mu: float) -> dict[str, Any]:
        kinds = {
            "type": "heRhoThermo",
            "mixture": "pureMixture",
            "transport": "const",
            "thermo": "hConst",
        }
        kinds |= {
            "equationOfState": "rhoConst",
            "specie": "specie",
            "energy": "sensibleInternalEnergy",
        }
        data = {"specie": {"molWeight": 28.9}, "equationOfState": {"rho": density}}
        return {
            "thermoType": kinds,
            "mixture": {
                **data,
                "thermodynamics": {"Cp": 1000, "Hf": 0},
                "transport": {"mu": mu, "Pr": 0.7},
            },
        }

    kinetic = {
        "equilibrium": "off",
        "e": p["e"],
        "alphaMax": p["max"],
        "alphaMinFriction": 0.5,
        "residualAlpha": 1e-4,
    }
    kinetic |= {
        "viscosityModel": "Gidaspow",
        "conductivityModel": "Syamlal",
        "granularPressureModel": "Lun",
    }
    kinetic |= {
        "frictionalStressModel": "JohnsonJackson",
        "radialModel": "SinclairJackson",
    }
    stiffness = dict(
        zip(
            ("g0", "preAlphaExp", "expMax"),
            STIFFNESS.get(case.kind, (1000, 500, 1000)),
            strict=True,
        )
    )
    fluid, gravity = GASES.get(case.kind, AIR), 0.0 if case.kind == "riemann" else -9.81
    friction = {"Fr": 0.05, "eta": 2, "p": 5, "phi": 28.5, "alphaDeltaMin": 0.05}
    drag = (
        f"{{ type {case.drag}; residualRe 1e-3; residualAlpha 1e-6; swarmCorrection "
        f"{{ type none; }} }}"
    )
    heat = "{ type RanzMarshall; residualAlpha 1e-3; }"
    return {
        "constant/g": {"dimensions": "[0 1 -2 0 0 0 0]", "value": f"(0 {gravity} 0)"},
        "constant/thermophysicalProperties.air": thermo(fluid["rho"], fluid["mu"]),
        "constant/thermophysicalProperties.particles": thermo(p["rho"], 0.0),
        "constant/turbulenceProperties.air": {"simulationType": "laminar"},
        "constant/turbulenceProperties.particles": {
            "simulationType": "RAS",
            "RAS": {
                "RASModel": "phasePressure" if case.column else "kineticTheory",
                "turbulence": "on",
                "printCoeffs": "on",
                "kineticTheoryCoeffs": {**kinetic, "JohnsonJacksonCoeffs": friction},
                "phasePressureCoeffs": {**stiffness, "alphaMax": p["max"]},
            },
        },
        "constant/phaseProperties": {
            "phases": "(particles air)",
            "particles": {
                "diameterModel": "constant",
                "constantCoeffs": {"d": p["d"]},
                "alphaMax": p["max"],
                "residualAlpha": 1e-6,
            },
            "air": {
                "diameterModel": "constant",
                "constantCoeffs": {"d": 1},
                "residualAlpha": 0,
            },
            "blending": {"default": {"type": "none", "continuousPhase": "air"}},
            "sigma": "((particles and air) 0)",
            "aspectRatio": "()",
            "drag": "()" if case.kind == "riemann" else f"((particles in air) {drag})",
            "heatTransfer": f"((particles in air) {heat})",
            **dict.fromkeys(
                ("virtualMass", "phaseTransfer", "lift", "wallLubrication"), "()"
            ),
            "turbulentDispersion": "()",
            "pMin": 10000,
        },
    }


def numerics(case: Case) -> dict[str, dict[str, Any]]:
    fraction, scalar, vector = (
        ("upwind",) * 3
        if case.upwind
        else ("vanLeer", "limitedLinear 1", "limitedLinearV 1")
    )
    stress = "div((((alpha.air*thermo:rho.air)*nuEff.air)*dev2(T(grad(U.air)))))"
    granular = (
        "div((((thermo:rho.particles*nut.particles)*dev2(T(grad(U.particles))))"
        "+(((thermo:rho.particles*lambda.particles)*div(phi.particles))*I)))"
    )
    solver = {"solver": "GAMG", "smoother": "DIC"}
    # without drag GAMG stops at 1000 iterations, short of its tolerance
    if case.kind == "riemann":
        solver = {"solver": "PCG", "preconditioner": "DIC"}
    smooth = {
        "solver": "smoothSolver",
        "smoother": "symGaussSeidel",
        "relTol": 0,
        "minIter": 1,
    }
    means = {
        name: {
            "mean": "on",
            "prime2Mean": "on" if name == "U.particles" else "off",
            "base": "time",
        }
        for name in ("U.particles", "alpha.particles", "Theta.particles", "p")
    }
    every: dict[str, Any] = {
        "executeControl": "timeStep",
        "writeControl": "timeStep",
        "writeFields": "no",
    }
    every["writeInterval"] = 5 if case.column else 50
    whole = {
        "type": "volFieldValue",
        "libs": "(fieldFunctionObjects)",
        "regionType": "all",
        **every,
    }
    return {
        "system/fvSchemes": {
            "ddtSchemes": {"default": "Euler"},
            "gradSchemes": {"default": "Gauss linear"},
            "divSchemes": {
                "default": "none",
                '"div\\(phi,alpha.*\\)"': f"Gauss {fraction}",
                '"div\\(phir,alpha.*\\)"': f"Gauss {fraction}",
                '"div\\(alphaRhoPhi.*,U.*\\)"': f"Gauss {vector}",
                '"div\\(phi.*,U.*\\)"': f"Gauss {vector}",
                '"div\\(alphaRhoPhi.*,(h|e|K|Theta).*\\)"': f"Gauss {scalar}",
                '"div\\(alphaPhi.*,p\\)"': f"Gauss {scalar}",
                stress: "Gauss linear",
                granular: "Gauss linear",
            },
            "laplacianSchemes": {
                "default": "Gauss linear uncorrected",
                "bounded": "Gauss linear uncorrected",
            },
            "interpolationSchemes": {"default": "linear"},
            "snGradSchemes": {"default": "uncorrected", "bounded": "uncorrected"},
        },
        "system/fvSolution": {
            "solvers": {
                '"alpha.*"': {
                    "nAlphaCorr": 1,
                    "nAlphaSubCycles": 2,
                    "smoothLimiter": 0.1,
                    "implicitPhasePressure": "yes",
                    **smooth,
                    "tolerance": 1e-9,
                },
                '"p_rgh.*"': {**solver, "tolerance": 1e-8, "relTol": 0},
                '"U.*"': {**smooth, "tolerance": 1e-5},
                '"(h|e|Theta).*"': {**smooth, "tolerance": 1e-6},
            },
            "PIMPLE": {
                "nOuterCorrectors": 1,
                "nCorrectors": 2,
                "nNonOrthogonalCorrectors": 0,
                "faceMomentum": "yes" if case.on_faces else "no",
            },
            "relaxationFactors": {"equations": {'".*"': 1}},
        },
        "system/controlDict": {
            "application": SOLVER,
            "startFrom": "startTime",
            "startTime": 0,
            "stopAt": "endTime",
            "endTime": case.end,
            "deltaT": case.dt,
            "writeControl": "adjustableRunTime",
            "writeInterval": case.write_every or case.end,
            "writeFormat": "ascii",
            "writePrecision": 9,
            "timePrecision": 8,
            "runTimeModifiable": "no",
            "adjustTimeStep": "no" if case.courant is None else "yes",
            "maxCo": case.courant or 1,
            "maxDeltaT": case.largest_dt,
            "functions": {
                "inventory": {
                    **whole,
                    "fields": "(alpha.particles)",
                    "operation": "volIntegrate",
                },
                "extremes": {
                    **whole,
                    "fields": "(alpha.particles Theta.particles)",
                    "operation": "max",
                },
                "inlet": {
                    "type": "surfaceFieldValue",
                    "libs": "(fieldFunctionObjects)",
                    "fields": "(p)",
                    "operation": "average",
                    "regionType": "patch",
                    "name": "inlet",
                    **every,
                },
                "means": {
                    "type": "fieldAverage",
                    "libs": "(fieldFunctionObjects)",
                    "timeStart": case.average_from,
                    "writeControl": "writeTime",
                    "fields": "(\n" + text(means) + ")",
                },
            },
        },
    }


def write(case: Case, folder: Path) -> None:
    """All files of a case."""
    put(folder, "system/blockMeshDict", mesh(case))
    for name, values in (constants(case) | numerics(case)).items():
        put(
            folder,
            name,
            values,
            "uniformDimensionedVectorField" if name.endswith("/g") else "dictionary",
        )
    patches = ["inlet", "outlet", "walls", *(("left", "right") if case.riser else ())]
    for name, (kind, dimensions, initial, boundary) in fields(case).items():
        places = {patch: boundary.get(patch, boundary["*"]) for patch in patches} | {
            "plane": {"type": "empty"}
        }
        values = {
            "dimensions": dimensions,
            "internalField": f"uniform {initial}",
            "boundaryField": places,
        }
        put(folder, f"0/{name}", values, kind)
    if not case.riser:
        height, below, above = STARTS[case.kind]
        lower, upper = (
            f"volScalarFieldValue alpha.particles {eps_s}" for eps_s in (below, above)
        )
        regions = (
            f"(boxToCell {{ box (-1 -1 -1) (1 {height} 1); fieldValues ({lower}); }})"
        )
        put(
            folder,
            "system/setFieldsDict",
            {"defaultFieldValues": f"({upper})", "regions": regions},
        )
