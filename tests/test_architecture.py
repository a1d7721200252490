"""The house keeps its own rules: import arrows, light imports, and a package list that matches the folders."""

import json
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
OUTSIDE = {"tests", "docs", "benchmarks", "examples", "build", "shared", "papers"}
CODE_SUFFIXES = {".py", ".pyc", ".pyi", ".md"}


@pytest.fixture(scope="module")
def setuptools() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def package_files() -> list[Path]:
    """Files under the folders that the package is made of, relative to the root."""
    top = [f for f in ROOT.iterdir() if f.is_dir() and f.name not in OUTSIDE and (f / "__init__.py").exists()]
    files = [f.relative_to(ROOT) for folder in top for f in folder.rglob("*") if f.is_file()]
    return [f for f in files if "__pycache__" not in f.parts]


def package_of(folder: Path) -> str:
    return ".".join(("lingual", *folder.parts))


def test_imports_follow_the_arrows_of_the_design():
    """In a process of its own: import-linter switches existing loggers off."""
    lint = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(sys.argv[1], no_cache=True))"
    run = subprocess.run([sys.executable, "-c", lint, ROOT / "pyproject.toml"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 broken" in run.stdout


@pytest.mark.parametrize("module", ["lingual", "lingual.app", "lingual.app.command_line"])
def test_importing_pulls_in_neither_torch_nor_graphics(module):
    heavy = loaded_by(module) & {"torch", "OpenGL", "moderngl", "glfw", "imgui_bundle", "pytetwild"}
    assert heavy == set()


def test_importing_the_package_alone_does_not_start_warp():
    assert not loaded_by("lingual") & {"warp", "numpy"}


def loaded_by(module: str) -> set[str]:
    """Top-level modules that a fresh interpreter has after importing `module`, less those it starts with."""
    script = f"import sys, json; old = set(sys.modules); import {module}; print(json.dumps([*set(sys.modules) - old]))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return {name.partition(".")[0] for name in json.loads(run.stdout)}


def test_the_package_list_equals_the_folders(setuptools):
    folders = {f.parent for f in package_files() if f.name == "__init__.py"}
    assert sorted(setuptools["packages"]) == sorted({"lingual", *map(package_of, folders)})


def test_every_folder_with_code_is_a_package():
    folders = {f.parent for f in package_files() if f.suffix == ".py"}
    assert {folder for folder in folders if not (ROOT / folder / "__init__.py").exists()} == set()


def test_data_files_of_packages_are_shipped(setuptools):
    globs = setuptools["package-data"]
    data = [f for f in package_files() if f.suffix not in CODE_SUFFIXES]
    left_out = [str(f) for f in data if not any(fnmatch(f.name, glob) for glob in globs.get(package_of(f.parent), []))]
    assert left_out == []
    assert {".frag", ".vert", ".glsl", ".npz", ".toml"} <= {f.suffix for f in data}


def test_no_data_glob_is_idle(setuptools):
    files = package_files()
    for package, globs in setuptools["package-data"].items():
        for glob in globs:
            assert any(package_of(f.parent) == package and fnmatch(f.name, glob) for f in files), (package, glob)


def test_imports_inside_the_package_are_relative():
    """Type checkers and editors then resolve them from any checkout."""
    absolute = [
        f"{f}:{number}"
        for f in package_files()
        if f.suffix == ".py"
        for number, line in enumerate((ROOT / f).read_text().splitlines(), start=1)
        if line.strip().startswith(("from lingual", "import lingual"))
    ]
    assert absolute == []
