"""Linear systems by policy, Newton, time steps."""
