import numpy as np
import pytest

from lingual.viewer.colour_bar import labelled_ticks, tick_text, ticks
from lingual.viewer.colour_map import CONTROL_POINTS, colour_table, linear_to_srgb, srgb_to_linear
from lingual.viewer.session_view import ScalarField


def lightness(table):
    return srgb_to_linear(table / 255.0) @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("name", ["viridis", "magma"])
def test_sequential_maps_grow_lighter_throughout(name):
    assert np.all(np.diff(lightness(colour_table(name))[::8]) > 0.0)  # neighbours differ by rounding


def test_the_diverging_map_is_lightest_in_the_middle_and_even_on_both_sides():
    light = lightness(colour_table("diverging"))
    assert abs(int(np.argmax(light)) - 128) <= 2
    assert np.abs(light - light[::-1]).max() < 0.08


@pytest.mark.parametrize("name", CONTROL_POINTS)
def test_maps_pass_through_their_control_points(name):
    table = colour_table(name)
    first, *_, last = CONTROL_POINTS[name].split()
    assert bytes(table[0]).hex() == first
    assert bytes(table[-1]).hex() == last


def test_srgb_round_trip():
    values = np.linspace(0.0, 1.0, 50)
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(values)), values, atol=1e-6)


@pytest.mark.parametrize(("low", "high"), [(0.0, 17.3), (-0.4, 2.1), (0.93, 1.07), (0.0, 3.2e5), (-1e-6, 1e-6)])
def test_ticks_are_round_and_few(low, high):
    found = ticks(low, high)
    assert 3 <= len(found) <= 8
    assert low - 1e-9 <= found[0]
    assert found[-1] <= high + 1e-9
    texts = [text for _, text in labelled_ticks(low, high)]
    assert len(set(texts)) == len(texts)


def test_tick_texts():
    assert tick_text(-2.0, 1.0) == "\N{MINUS SIGN}2"
    assert tick_text(0.25, 0.25) == "0.25"
    assert tick_text(2.5, 2.5) == "2.5"
    assert ticks(1.0, 1.0) == []


def test_a_field_is_placed_along_its_bar():
    field = ScalarField("x", np.array([-1.0, 0.0, 5.0, np.nan]), "mm", (0.0, 4.0))
    np.testing.assert_allclose(field.fraction(), [0.0, 0.0, 1.0, 0.0])
    signed = ScalarField("det F", np.array([0.8, 1.0, 1.2]), "", (0.9, 1.2), centre=1.0)
    assert signed.diverging
    assert signed.span == pytest.approx((0.8, 1.2))
    np.testing.assert_allclose(signed.fraction(), [0.0, 0.5, 1.0], atol=1e-6)
    assert signed.title == "det F"
