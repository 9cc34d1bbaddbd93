"""Balances that a run reports."""


def assert_closed(result, tolerance, *names):
    """Assert that balances close to a share of what passes; all if none is named."""
    for name in names or result.balances:
        residual = result.balances[name]["relative_residual"]
        assert abs(residual) < tolerance, (name, residual)
