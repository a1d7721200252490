"""Where names are written beside the points they belong to, without covering each other."""

import numpy as np
from numpy.typing import NDArray


def label_corners(points: NDArray[np.floating], sizes: NDArray[np.floating], gap: float) -> NDArray[np.float64]:
    """Top left corners of labels, (n, 2) pixels, y down: right of and above the points, as far as they fit.

    points: (n, 2) pixels; those that are not finite get NaN. sizes: (n, 2) width and height. gap: pixels
    between a point and its label. A label that would cover an earlier one moves up until it does not.
    """
    corners = np.full((len(points), 2), np.nan)
    for i in np.argsort(-points[:, 1], kind="stable"):  # from the lowest up, NaN last
        if not np.isfinite(points[i]).all():
            continue
        left, top = points[i, 0] + gap, points[i, 1] - gap - sizes[i, 1]
        for j in np.argsort(-corners[:, 1], kind="stable"):
            apart = corners[j, 0] + sizes[j, 0] < left or left + sizes[i, 0] < corners[j, 0]
            if not np.isfinite(corners[j]).all() or apart:
                continue
            if top < corners[j, 1] + sizes[j, 1] + 2.0 and corners[j, 1] < top + sizes[i, 1] + 2.0:
                top = corners[j, 1] - sizes[i, 1] - 2.0
        corners[i] = left, top
    return corners
