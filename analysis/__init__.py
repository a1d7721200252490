"""Measurements on deformed tongues: comparisons, energies, studies."""
