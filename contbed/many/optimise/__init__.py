"""Design studies: gradients of named results with respect to the keys of a scene,
and what is built on them.
"""
