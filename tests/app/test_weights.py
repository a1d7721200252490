"""`lingual weights`: table, JSON, picture, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from lingual.analysis.cantilever import load_end_cantilever
from lingual.analysis.weight_study import study_weights, tongue_bend
from lingual.app import weights


@pytest.fixture(scope="module")
def studies(small_tongue):
    """A coarse cantilever and the small tongue."""
    return [
        study_weights(load_end_cantilever((12, 2, 2)), 3, 0.0),
        study_weights(tongue_bend(small_tongue), 5),
    ]


@pytest.fixture
def quick(monkeypatch, studies):
    """Lets the command find the coarse studies; returns what it asked for."""
    asked = []

    def run(meshes, domain_count, progress):
        asked.append((meshes, domain_count))
        return studies

    monkeypatch.setattr(weights, "run_studies", run)
    return asked


def test_the_command_prints_a_table_for_each_body_and_writes_json(lingual, quick, tmp_path):
    code, out, err = lingual("weights", "--mesh", "head-small", "--domains", "7", "--json", tmp_path / "w" / "s.json")
    assert (code, err) == (0, "")
    assert quick == [(["head-small"], 7)]
    for word in ("cantilever: 3 domains", "block: 5 domains", "principal", "perpendicular", "harmonic", "fixed"):
        assert word in " ".join(out.split())
    cantilever, block = json.loads((tmp_path / "w" / "s.json").read_text())["studies"]
    assert (cantilever["body"], block["body"]) == ("cantilever", "block")
    assert len(cantilever["trials"]) == 12
    assert cantilever["trials"][0]["displacement_error"] < 0.1
    assert sum(block["nodes_of_domain"]) == block["node_count"]
    assert cantilever["full"]["tip_mm"][2] < 0.0


def test_without_a_mesh_the_head_is_studied(lingual, quick):
    assert lingual("weights")[0] == 0
    assert quick == [(["head"], 5)]


def test_the_picture_is_written(lingual, quick, tmp_path):
    code, out, err = lingual("weights", "--show", "diffused", "--out", tmp_path / "p.png")
    if "EGL" in err:
        pytest.skip("no EGL with OpenGL 4.1")
    assert code == 0
    assert "Written" in out
    assert (tmp_path / "p.png").stat().st_size > 10_000


def test_the_studies_are_of_the_cantilever_and_of_the_meshes(monkeypatch, studies, small_tongue):
    monkeypatch.setattr(weights, "study_cantilever", lambda progress: studies[0])
    monkeypatch.setattr(weights, "load_tongue", lambda mesh, progress: replace(small_tongue, name=mesh))
    monkeypatch.setattr(weights, "study_weights", lambda bend, count, progress: (bend.name, count))
    assert weights.run_studies(["a", "b"], 6) == [studies[0], ("a", 6), ("b", 6)]


def test_the_table_gives_errors_in_per_cent(studies):
    console = Console(width=200, record=True)
    console.print(weights.study_table(studies[0]))
    trial = studies[0].trials[0]
    row = next(line for line in console.export_text().splitlines() if "principal" in line)
    assert f"{100 * trial.displacement_error:.1f} %" in row
    assert f"{trial.weights.min():.2f} to {trial.weights.max():.2f}" in row


def test_the_picture_colours_bends_by_their_distance_and_shows_the_weights_at_the_tip(studies):
    bends, weights_row = weights.picture_rows(studies[0], "raw")
    full, principal, *_ = bends.stills
    assert not full.scalar.values.any()
    gap = principal.nodes - full.nodes
    np.testing.assert_allclose(principal.scalar.values, 1e3 * np.linalg.norm(gap, axis=1))
    assert len({still.scalar.limits for still in bends.stills}) == 1
    assert weights_row.stills[0].scalar.categories == ("1/3", "2/3", "end")
    assert weights_row.stills[1].scalar.values is not None
    end = studies[0].bend.tip_nodes
    assert weights_row.stills[1].scalar.values[end].mean() > 0.5


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--show", "magic"), "no treatment of weights 'magic'; choose one of raw, blended, diffused"),
        (("--mesh", "nowhere"), "no mesh 'nowhere'"),
        (("--out", "file.txt/p.png"), "cannot be written"),
        (("--json", "file.txt/s.json"), "cannot be written"),
    ],
)
def test_a_mistake_gets_one_sentence(lingual, tmp_path, arguments, says):
    (tmp_path / "file.txt").write_text("")
    code, _, err = lingual("weights", *arguments)
    assert code == 2
    assert err.startswith("error: ")
    assert says in " ".join(err.split())


def test_help_names_every_option(lingual):
    code, out, _ = lingual("weights", "--help")
    assert code == 0
    for word in ("--mesh", "--domains", "--show", "--out", "--json", "cantilever"):
        assert word in out
