"""Curves of a comparison over time, as PNG and SVG."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..model import LingualError

if TYPE_CHECKING:
    from .compare import ComparedRun

COLOURS = ("#0072b2", "#d55e00", "#009e73")
"""Told apart by colour-blind eyes (Okabe and Ito)."""


def write_plots(folder: Path, compared: "Sequence[ComparedRun]") -> None:
    """Writes curves.png and curves.svg. Raises LingualError when they cannot be written."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # slow to import, and of no use elsewhere
    from matplotlib.figure import Figure

    panels = ["surface distance, mean [mm]", "surface distance, max [mm]", "Hausdorff distance [mm]",
              "volume change [%]", "strain energy [mJ]", "sensor error [mm]", "time a step [ms]"]  # fmt: skip
    figure = Figure(figsize=(9.0, 1.55 * len(panels)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(panels), 1, sharex=True)
    for each, colour in zip(compared, COLOURS, strict=False):
        history, distance = each.run.history, each.distance
        curves = [
            *((None, None, None) if distance is None else (distance.mean, distance.maximum, distance.hausdorff)),
            100.0 * (history.scalar("volume_ratio") - 1.0),
            1e3 * history.scalar("strain_energy"),
            np.maximum(history.scalar("sensor_error_mm"), 1e-15),
            history.scalar("step_ms"),
        ]
        for axis, curve in zip(axes, curves, strict=True):
            if curve is not None:
                axis.plot(history.time, curve, color=colour, linewidth=1.1, label=each.run.label)
    for axis, title in zip(axes, panels, strict=True):
        axis.set_ylabel(title.replace(" [", "\n["), fontsize=8)
        axis.grid(alpha=0.25)
        axis.tick_params(labelsize=8)
        axis.spines[["top", "right"]].set_visible(False)
    for axis in axes[-2:]:
        axis.set_yscale("log")
    axes[-1].set_xlabel("time [s]", fontsize=9)
    figure.legend(*axes[3].get_legend_handles_labels(), loc="outside upper left", ncols=3, fontsize=9, frameon=False)
    try:
        for ending in ("png", "svg"):
            figure.savefig(folder / f"curves.{ending}", dpi=150)
    except OSError as error:
        raise LingualError(f"The curves cannot be written in {folder} ({error.strerror}).") from error
