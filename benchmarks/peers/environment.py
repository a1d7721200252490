"""The peers' own virtual environment, made once: benchmarks/peers/.venv from requirements.txt.

Every line is installed by itself, so that a peer that cannot be installed does not keep the others away.
"""

import json
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
FOLDER = HERE / ".venv"
REQUIREMENTS = HERE / "requirements.txt"
STAMP = FOLDER / "installed.json"
"""The lines that were asked for and, for each that failed, the reason."""


def python() -> Path:
    return FOLDER / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def prepare() -> dict[str, str]:
    """Makes the environment where it is missing or older than the requirements; line -> reason of what failed."""
    lines = [line.strip() for line in REQUIREMENTS.read_text().splitlines()]
    wanted = [line for line in lines if line and not line.startswith("#")]
    if STAMP.is_file():
        stamp = json.loads(STAMP.read_text())
        if stamp["wanted"] == wanted and not stamp["failed"]:
            return {}
    if not python().is_file():
        venv.create(FOLDER, with_pip=True)
    failed = {}
    for line in wanted:
        print(f"installing {line}", flush=True)
        command = [python(), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-c", REQUIREMENTS, line]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            failed[line] = last_line(done.stderr)
    STAMP.write_text(json.dumps({"wanted": wanted, "failed": failed}))
    return failed


def last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no reason was given"
