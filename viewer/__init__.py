"""Window, camera, scene and panels. Reads State, writes picks into Control; never imports a solver."""
