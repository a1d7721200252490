"""`python -m lingual.precompute.head`: regenerates the medium head that ships with the package."""

from .build import write_asset

write_asset()
