"""Everything that ends in a Trajectory: recordings, filters, trajectory files."""
