"""The cache of these tests is a folder of their own."""

import pytest


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("LINGUAL_CACHE", str(folder))
    return folder
