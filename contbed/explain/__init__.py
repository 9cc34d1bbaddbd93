"""Data sheets of all that has a name: closures, models, keys of scenes, results,
materials, terms; editor schema.
"""
