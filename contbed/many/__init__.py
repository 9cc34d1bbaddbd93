"""Studies of many runs, side by side.

store           values by key, shared by all; `runs` with folders of their own, computed by `workers`
study_file      reading of study files: every mistake with file and line
value_sets      lists, ranges and samples of a key; `distributions` of uncertain ones
quantities      names and units of parameters and results; `tables` writes them
sweep/          every combination of values of keys
uncertainty/    spreads and indices of the results of a sample
derivatives/    derivatives of results by keys of a scene
optimise/       best values of keys under constraints
calibrate/      keys fitted to measured values
cascade/        packings of particles, closures from them, and the bed with these
validate/       measured beds beside computed ones
compare         one reactor by several models
converge        one scene on finer and finer meshes
bench           run time against error of programs
"""
