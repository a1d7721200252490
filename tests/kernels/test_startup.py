"""Warp starts without a word."""

import subprocess
import sys


def test_importing_the_kernels_prints_nothing():
    run = subprocess.run(
        [sys.executable, "-c", "import lingual.kernels.elasticity"], capture_output=True, text=True, check=True
    )
    assert (run.stdout, run.stderr) == ("", "")
