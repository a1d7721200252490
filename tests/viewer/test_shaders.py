from importlib import resources

import pytest

from lingual.model import LingualError
from lingual.viewer import shader_program
from lingual.viewer.shader_program import load_program, shader_source

PAIRS = [
    ("tongue", "tongue"),
    ("tongue", "cut"),
    ("section", "section"),
    ("rigid", "rigid"),
    ("sensor", "sensor"),
    ("backdrop", "backdrop"),
    ("backdrop", "upscale"),
    ("depth", "depth"),
    ("rigid_depth", "depth"),
]


@pytest.mark.parametrize(("vertex", "fragment"), PAIRS)
def test_compiles(gl, vertex, fragment):
    load_program(gl, vertex, fragment).release()


def test_every_shader_file_is_in_a_pair():
    files = {path.name for path in resources.files("lingual.viewer.shaders").iterdir()}
    stages = {name for name in files if name.endswith((".vert", ".frag"))}
    assert stages == {f"{v}.vert" for v, _ in PAIRS} | {f"{f}.frag" for _, f in PAIRS}
    assert all(shader_source(name).startswith("#version 410 core") for name in stages)


def test_a_refused_shader_is_named(gl, monkeypatch):
    monkeypatch.setattr(shader_program, "shader_source", lambda name: "#version 410 core\nnonsense")
    with pytest.raises(LingualError, match="tongue/tongue"):
        load_program(gl, "tongue", "tongue")
