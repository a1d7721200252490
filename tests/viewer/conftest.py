"""Fixtures of the viewer's tests; those that draw are skipped, by name, where there is no EGL."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))  # importlib mode does not make the tests' folder importable

from synthetic_session import SyntheticSession

from lingual.model import LingualError
from lingual.viewer.context import headless_context
from lingual.viewer.offscreen import OffscreenRenderer


@pytest.fixture(scope="session")
def session():
    return SyntheticSession()


@pytest.fixture
def gl():
    """A headless context that is current during the test."""
    try:
        context = headless_context()
    except LingualError as error:
        pytest.skip(f"no EGL with OpenGL 4.1: {error}")
    yield context
    context.release()


@pytest.fixture(scope="module")
def renderer(session):
    """A 320 x 240 renderer of the synthetic session."""
    try:
        renderer = OffscreenRenderer(session, 320, 240)
    except LingualError as error:
        pytest.skip(f"no EGL with OpenGL 4.1: {error}")
    yield renderer
    renderer.release()
