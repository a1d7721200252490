"""Lingual: speech in, a moving, physically simulated tongue out, at interactive rate.

    text | voice | recording -> Trajectory -> Control -> Solver.step -> State -> viewer | analysis | files

Importing the package is light: neither torch nor OpenGL nor Warp is loaded until a part
that needs it is imported.
"""

__version__ = "0.1.0"
