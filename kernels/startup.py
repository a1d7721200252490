"""Warp's settings for the whole program, and a quiet start of its runtime."""

import os
import sys

import warp as wp


def start_warp() -> None:
    """Starts Warp without its banner; nothing is printed where there is no CUDA driver.

    Warp's native library writes that there is none straight to the process's standard error, which no
    setting prevents, so standard error is closed for the moment of the start.
    """
    wp.config.log_level = wp.LOG_WARNING
    wp.config.enable_backward = False
    sys.stderr.flush()
    saved = os.dup(2)
    devnull = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(devnull, 2)
        wp.init()
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(devnull)
