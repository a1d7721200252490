"""Computed once per mesh and cached: meshes, domains, basis, cubature, skin."""
