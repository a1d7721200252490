"""The head that ships with Lingual, built from a parametric description."""
