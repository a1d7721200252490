"""The choice of a solver as the command line spells it."""

from pathlib import Path

import pytest

from lingual.app.solver_options import SOLVERS, TOLERANCES, VOLUME_MODES, SolverOptions
from lingual.model import LingualError


def test_a_name_alone_has_every_default():
    for name in SOLVERS:
        assert SolverOptions.parse(name) == SolverOptions(name=name)
        assert SolverOptions.parse(f"{name}:") == SolverOptions(name=name)
    assert SolverOptions().name == "reduced"


def test_options_are_read_as_the_types_of_their_defaults():
    options = SolverOptions.parse("reduced:domains=12,material=neo-hookean,volume=none,contact=off,precision=float64")
    assert options == SolverOptions("reduced", 12, "neo-hookean", "none", False, precision="float64")
    assert SolverOptions.parse("modal-warping:modes=30").modes == 30


@pytest.mark.parametrize(
    ("word", "value"), [("on", True), ("YES", True), ("true", True), ("off", False), ("No", False)]
)
def test_switches_have_several_words(word, value):
    assert SolverOptions.parse(f"reduced:contact={word}").contact is value


def test_every_volume_mode_and_precision_can_be_named():
    for mode in VOLUME_MODES:
        assert SolverOptions.parse(f"full:volume={mode}").volume == mode
    for precision in TOLERANCES:
        assert SolverOptions.parse(f"reduced:precision={precision}").precision == precision


def test_given_keeps_what_is_none():
    options = SolverOptions.parse("reduced:domains=8,contact=off")
    path = Path("a.txt")
    changed = options.given(domains=None, contact=True, volume=None, train_on=(path,))
    assert changed == SolverOptions("reduced", 8, contact=True, train_on=(path,))
    assert options.given() == options


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("magic", "no solver 'magic'; choose one of reduced, full, modal-warping"),
        ("", "no solver ''"),
        ("reduced:speed=9", "'speed=9' in 'reduced:speed=9' is not an option of a solver"),
        ("reduced:domains", "'domains' in 'reduced:domains' is not an option"),
        ("reduced:name=full", "'name=full' in 'reduced:name=full' is not an option"),
        ("reduced:train_on=a.txt", "is not an option"),
        ("reduced:domains=many", "domains in 'reduced:domains=many' is 'many'; it must be a whole number"),
        ("modal-warping:modes=1.5", "must be a whole number"),
        ("reduced:contact=maybe", "contact in 'reduced:contact=maybe' is 'maybe'; write on or off"),
        ("reduced:volume=half", "no volume mode 'half'; choose one of none, subspace, full"),
        ("reduced:precision=float16", "no precision 'float16'; choose one of float32, float64"),
    ],
)
def test_a_mistake_gets_one_sentence_that_names_it(text, says):
    with pytest.raises(LingualError) as raised:
        SolverOptions.parse(text)
    assert says in str(raised.value)
    assert str(raised.value).endswith(".")
