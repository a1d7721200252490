"""Solvers behind one protocol: reduced and full space."""
