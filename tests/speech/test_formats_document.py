"""The examples of docs/formats.md are files that Lingual reads."""

import re
from pathlib import Path

import pytest

from lingual.speech import read_trajectory

DOCUMENT = Path(__file__).parents[2] / "docs" / "formats.md"


def test_the_csv_example_is_a_trajectory(tmp_path):
    (example,) = re.findall(r"```\n(# lingual trajectory.*?)```", DOCUMENT.read_text(), re.DOTALL)
    path = tmp_path / "example.csv"
    path.write_text(example)
    trajectory = read_trajectory(path)
    assert trajectory.channels == ("TT", "TB", "LI")
    assert trajectory.measured.tolist() == [[True, False, True]] * 3
    assert trajectory.positions[1, 0].tolist() == pytest.approx([-0.0118, float("nan"), 0.0043], nan_ok=True)
