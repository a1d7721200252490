"""Rigid obstacles as signed distance grids that are known in closed form."""

import numpy as np
import pytest

from lingual.model.signed_distance import SignedDistanceGrid

SPACING = 1e-3
LOWER = np.full(3, -0.012)
COUNT = 25


def grid_of(distance, frame: str) -> SignedDistanceGrid:
    points = LOWER + SPACING * np.moveaxis(np.indices((COUNT, COUNT, COUNT)), 0, -1)
    return SignedDistanceGrid(frame, LOWER, SPACING, distance(points).astype(np.float32))


@pytest.fixture(scope="session")
def floor():
    """Function (height [m], frame) -> grid of everything below that height."""
    return lambda height=0.0, frame="jaw": grid_of(lambda x: x[..., 2] - height, frame)


@pytest.fixture(scope="session")
def ball():
    """Function (centre [m], radius [m], frame) -> grid of a ball."""
    return lambda centre, radius=5e-3, frame="head": grid_of(
        lambda x: np.linalg.norm(x - np.asarray(centre), axis=-1) - radius, frame
    )
