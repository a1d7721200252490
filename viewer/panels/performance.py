"""Frame-time readout: display and simulation."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from ..theme import MUTED
from .panel_context import PanelContext

_RECENT = 200  # simulation steps in the readout


def draw_performance(context: PanelContext) -> None:
    """Milliseconds per picture and per simulation step, and a small graph of the former."""
    imgui.separator_text("Time per frame")
    timing = context.timing
    _row("Display", f"{timing.work_median:5.1f} ms   {timing.frames_per_second:3.0f} frames/s")
    steps = context.session.history.scalar("step_ms")[-_RECENT:]
    steps = steps[np.isfinite(steps)]
    _row("Simulation", f"{np.median(steps):5.2f} ms / step" if len(steps) else "-")
    _row("Solver", context.session.solver_name)
    work = np.array(timing.work or [0.0], dtype=np.float32)
    size = ImVec2(imgui.get_content_region_avail().x, 2.4 * imgui.get_font_size())
    imgui.plot_lines("##work", work, scale_min=0.0, scale_max=max(33.4, float(work.max())), graph_size=size)
    imgui.set_item_tooltip(f"Work per picture, 0 to 33 ms\n{context.renderer}")


def _row(label: str, value: str) -> None:
    imgui.text_colored(MUTED, label)
    imgui.same_line(6.2 * imgui.get_font_size())
    imgui.text(value)
