"""The head that ships with Lingual, built from a parametric description."""

from .build import load_head

__all__ = ["load_head"]
