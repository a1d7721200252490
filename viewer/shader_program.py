"""GLSL programs from the files of `shaders/`."""

import re
from functools import cache
from importlib import resources

import moderngl

from ..model import LingualError

_INCLUDE = re.compile(r'^\s*#include\s+"([\w.]+)"\s*$', re.MULTILINE)


@cache
def shader_source(name: str) -> str:
    """Text of `shaders/<name>` with its `#include "file"` lines replaced by those files."""
    text = resources.files(__package__).joinpath("shaders", name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: shader_source(match.group(1)), text)


def load_program(context: moderngl.Context, vertex: str, fragment: str) -> moderngl.Program:
    """Compiles `shaders/<vertex>.vert` with `shaders/<fragment>.frag`.

    A uniform block named "Frame" is bound to binding 0 (frame_uniforms.py).
    Raises LingualError with the driver's log when the driver refuses them.
    """
    try:
        program = context.program(
            vertex_shader=shader_source(f"{vertex}.vert"), fragment_shader=shader_source(f"{fragment}.frag")
        )
    except moderngl.Error as error:
        raise LingualError(f"The graphics driver refuses shader {vertex}/{fragment}: {error}") from error
    block = program.get("Frame", None)
    if isinstance(block, moderngl.UniformBlock):
        block.binding = 0
    return program


def set_uniform(program: moderngl.Program, name: str, value: object) -> None:
    """Sets a uniform if the driver kept it (unused ones are optimised away)."""
    member = program.get(name, None)
    if isinstance(member, moderngl.Uniform):
        member.value = value
