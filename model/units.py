"""Conversion between the SI units inside and the millimetres of recordings and reports."""

M_PER_MM = 1e-3
MM_PER_M = 1e3
