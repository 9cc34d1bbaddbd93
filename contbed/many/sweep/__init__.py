"""Parameter studies: many scenes from one study file, with designs, workers, tables
and plots.
"""
