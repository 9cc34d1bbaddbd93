"""Built-in meshes, gmsh meshes, their checks and their grading."""
