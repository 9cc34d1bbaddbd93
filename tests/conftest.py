"""One thread for each worker, as BLAS threads on shared cores slow small problems down
many times; and every quantity that a run of a test reports must have an entry in
`contbed.fields`. Generated cases have no deadline and may be slow to draw, as a machine
under load must not fail a test.
"""

import os

import pytest

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

try:
    from hypothesis import HealthCheck, settings
except ImportError:  # the tests that draw cases say so themselves
    pass
else:
    settings.register_profile(
        "contbed", deadline=None, suppress_health_check=[HealthCheck.too_slow]
    )
    settings.load_profile("contbed")


@pytest.fixture(autouse=True)
def every_quantity_has_an_entry(monkeypatch):
    # imported here, because NumPy reads the variables above when it is imported
    from contbed import fields, runner

    verdict = runner._verdict

    def checked(scene, result):
        unknown = [key for key in result.qoi if fields.result(key) is None]
        for columns in (result.profiles, *result.tables.values()):
            for header in columns:
                name, _, unit = header.rstrip("]").partition(" [")
                found = fields.field(name)
                # a key of the scene has its own unit
                if "." not in name and (found is None or found.unit != unit):
                    unknown.append(header)
        assert not unknown, f"not in contbed.fields, or with another unit: {unknown}"
        verdict(scene, result)

    monkeypatch.setattr(runner, "_verdict", checked)
