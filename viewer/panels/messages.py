"""What went wrong, in one sentence, over the picture."""

from imgui_bundle import ImVec2, imgui

from ..theme import WARNING
from .panel_context import PanelContext


def draw_messages(context: PanelContext) -> None:
    """A plate at the top of the view with the session's failure or notice, if there is one."""
    failure, notice = context.session.failure, context.session.notice
    if failure is None and notice is None:
        return
    view = context.viewport
    imgui.set_next_window_pos(ImVec2(view.left + 18, view.top + 18))
    imgui.set_next_window_size(ImVec2(max(min(view.width - 36, 620), 1), 0))
    flag = imgui.WindowFlags_
    flags = flag.no_decoration | flag.no_move | flag.no_saved_settings | flag.no_focus_on_appearing
    imgui.push_style_var(imgui.StyleVar_.window_rounding, 8.0)
    if imgui.begin("##message", None, flags.value)[0]:
        imgui.text_colored(WARNING, "The simulation stopped" if failure else "Not everything converged")
        imgui.push_text_wrap_pos(0.0)
        imgui.text_unformatted(failure or notice or "")
        imgui.pop_text_wrap_pos()
    imgui.end()
    imgui.pop_style_var()
