"""Many scenes from one study file: designs, workers, tables and plots."""
