"""Volume change per syllable on histories whose volumes are known."""

import numpy as np
import pytest

from lingual.analysis.volume_change import LabelledInterval, VolumeChange, volume_change_per_label
from lingual.model import LingualError, StateHistory

RATIOS = (1.0, 1.02, 0.98, 1.0, 1.0, 0.99, 1.0, 1.03)


@pytest.fixture
def history() -> StateHistory:
    """Eight frames at 100 Hz of one node, with the volumes of RATIOS."""
    history = StateHistory(1, 0)
    for n, ratio in enumerate(RATIOS):
        history.append(0.01 * n, np.zeros((1, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(3), volume_ratio=ratio)
    return history


def test_productions_of_a_syllable_are_averaged_with_equal_weight(history):
    """/ta/ twice, 4 and 2 frames long: means 1 % and 0.5 %; /ka/ once. Shrinking counts like growing."""
    intervals = [
        LabelledInterval("ta", 0.0, 0.031),
        LabelledInterval("ka", 0.06, 0.07),
        LabelledInterval("ta", 0.039, 0.055),
    ]
    changes = volume_change_per_label(history, intervals)
    assert list(changes) == ["ta", "ka"]
    assert changes["ta"] == VolumeChange(pytest.approx(0.0075), pytest.approx(0.02), 2)
    assert changes["ka"] == VolumeChange(pytest.approx(0.015), pytest.approx(0.03), 1)


def test_no_interval_gives_no_syllable(history):
    assert volume_change_per_label(history, []) == {}


def test_an_interval_without_frames_is_named(history):
    with pytest.raises(LingualError, match=r"in 'li' from 0\.5 s to 0\.7 s"):
        volume_change_per_label(history, [LabelledInterval("li", 0.5, 0.7)])
