"""Small folders as the commands leave them, for reports; written by hand where a
command takes too long for a test.
"""

import json

from contbed import load, run
from contbed.explain import editor
from contbed.many.derivatives import sensitivities as design
from contbed.many.optimise.optimise import optimise

VERSIONS = {"contbed": "0.2.0"}


def of_run(folder):
    run(
        load(_bed(folder), {"output.plots": False, "output.fields": False}),
        out=folder / "run",
    )
    profiles = folder / "run" / "profiles.csv"
    lines = profiles.read_text().splitlines(keepends=True)
    profiles.write_text("".join([lines[0], *lines[-3:]]))
    return folder / "run", "summary.json"


def of_sweep(folder):
    run = {
        "run": "0" * 16,
        "exit_code": 0,
        "problem": "",
        "parameters": {"boundary.left.gas.velocity": 0.1},
        "qoi": {"x": 1.0},
    }
    failed = {
        "run": "1" * 16,
        "exit_code": 3,
        "problem": "no",
        "parameters": {"boundary.left.gas.velocity": 0.2},
        "qoi": {},
    }
    about = {
        "parameters": {"boundary.left.gas.velocity": {"unit": "m/s"}},
        "qoi": {"x": {"unit": None}},
    }
    content = {
        "study": "s.toml",
        "cases": 2,
        "ended": 2,
        "failed": 1,
        "warnings": ["w"],
        **about,
        "runs": [run, failed],
    }
    (folder / "table.json").write_text(json.dumps(content))
    return folder, "table.json"


def of_uncertainty(folder):
    of_sweep(folder)
    (folder / "uncertainty.csv").write_text(
        "result,unit,estimator,runs,mean,standard error of the mean,standard "
        "deviation,low,high\n"
        "x,K,samples,2,1,1,1,1,1\nx,K,gradients,1,1,0,1,1,1\n"
    )
    (folder / "indices.csv").write_text(
        "result,unit,parameter,share by gradients,total\n"
        "x,K,boundary.left.gas.velocity,1,1\n"
    )
    return folder, "uncertainty.csv"


def of_sensitivities(folder):
    scene = load(_bed(folder))
    found, about = design.sensitivities(
        scene, ["T_fluid_out_K"], ["packed_bed.porosity", "boundary.left.gas.velocity"]
    )
    design.write(found, about, folder / "derivatives", "")
    return folder / "derivatives", "sensitivities.json"


def of_optimum(folder):
    _bed(folder)
    (folder / "design.toml").write_text(
        'scene = "bed.toml"\nmaximise = "T_fluid_out_K"\nconstraints = '
        '["pressure_drop_Pa <= 1.5 kPa"]\n'
        "[keys]\nboundary.left.gas.velocity = { from = 0.49, to = 0.51 }\n"
    )
    optimise(folder / "design.toml", folder / "optimum")
    return folder / "optimum", "summary.json"


def of_calibration(folder):
    data = {
        "fitted": 1,
        "chi_square": 1.0,
        "degrees of freedom": 1.0,
        "kept back": 0,
        "kept back inside of the band": 0,
    }
    content = {
        "status": "ok", "versions": VERSIONS, "calibration": "c.toml", "title": "", "warnings": [],
        "covariance": {"keys": ["mesh.length"], "matrix": [[0.01]]},
        "correlation": [[1.0]],
        "data": data, "posterior": None, "runs": {"kept": 3, "before": 0, "failed": 0},
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(content))
    (folder / "points.csv").write_text(
        "experiment,line,quantity,unit,t [s],x "
        "[m],fitted,measured,predicted,low,high,deviation over error\n"
        "a,a.csv:2,T,K,1,,yes,300,301,299,303,1\n"
        "a,a.csv:3,T,K,2,,yes,310,311,309,313,1\n"
    )
    (folder / "keys.csv").write_text(
        "key,unit,prior,fitted,standard error,low,high\n"
        "mesh.length,m,even,1,0.1,0.9,1.1\n"
    )
    (folder / "combinations.csv").write_text(
        "singular value,seen,combination,mesh.length\n3,yes,mesh.length,1\n"
    )
    for name in ("fit", "residuals", "keys"):
        (folder / f"{name}.png").write_bytes(b"a picture")
    return folder, "summary.json"


def of_cascade(folder):
    band = {
        "probability": 0.9,
        "low": 890.0,
        "high": 910.0,
        "mean": 900.0,
        "standard_deviation": 5.0,
    }
    measured = {
        "case": "c", "quantity": "T_solid", "unit": "K", "uncertainty": 0.5, "points": 2, "share in the band": 0.5,
        "share in the band of a measurement": 1.0, "shares of the parts": {"packing": 1.0},
    }  # fmt: skip
    content = {
        "status": "ok", "versions": VERSIONS, "title": "", "cascade": "c.toml", "qoi": {"T_fluid_out_K": 900.0},
        "band": {"T_fluid_out_K": band}, "parts": [{"name": "packing", "standard_deviation": {"T_fluid_out_K": 5.0}}],
        "measured": measured, "visited": {"Re": [1.0, 2.0]}, "porosities": [0.4, 0.41], "laws": "equally probable",
        "runs": {"asked": 3, "before": 0}, "warnings": [],
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(content))
    (folder / "samples.csv").write_text("packing,T_fluid_out [K]\n1,895\n2,905\n")
    (folder / "table.csv").write_text("part,share in T_fluid_out_K\npacking,1\n")
    (folder / "band.png").write_bytes(b"a picture")
    return folder, "summary.json"


def _bed(folder):
    (folder / "bed.toml").write_text(editor.template("packed_bed"))
    return folder / "bed.toml"


KINDS = {
    "run": of_run,
    "sweep": of_sweep,
    "derivatives": of_sensitivities,
    "optimum": of_optimum,
    "calibration": of_calibration,
    "cascade": of_cascade,
}
"""What writes a folder of each kind, and returns it with the name of its JSON file."""
