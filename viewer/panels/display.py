"""View and display options."""

from imgui_bundle import ImVec2, imgui

from ..camera import VIEWS
from ..session_view import NO_FIELD
from ..view_options import BACKDROPS
from .panel_context import PanelContext

_TISSUE_LABELS = {"tooth": "Teeth", "bone": "Bone", "mucosa": "Palate, gums"}


def draw_display(context: PanelContext) -> None:
    """Built-in views, the scalar on the tongue, and what is visible."""
    _draw_views(context)
    _draw_field_choice(context)
    _draw_visibility(context)


def _draw_views(context: PanelContext) -> None:
    imgui.separator_text("View")
    spacing = imgui.get_style().item_spacing.x
    width = 0.5 * (imgui.get_content_region_avail().x - spacing)
    for i, name in enumerate(VIEWS):
        if imgui.button(name.capitalize(), ImVec2(width, 0)):
            context.look(name)
        imgui.set_item_tooltip(f"Key {i + 1}")
        if i % 2 == 0:
            imgui.same_line()
    options = context.options
    options.cut = imgui.checkbox("Midsagittal cut", options.cut)[1]
    imgui.set_item_tooltip("C")
    imgui.same_line()
    if imgui.button("Reset", ImVec2(-1, 0)):
        context.reset_view()
    imgui.set_item_tooltip("R")


def _draw_field_choice(context: PanelContext) -> None:
    imgui.separator_text("Colour")
    options = context.options
    imgui.set_next_item_width(-1)
    if imgui.begin_combo("##field", _field_label(options.field_name)):
        for name in context.session.field_names():
            if imgui.selectable(_field_label(name), name == options.field_name)[0]:
                options.field_name = name
        imgui.end_combo()
    imgui.set_item_tooltip("Scalar on the tongue (F)")


def _field_label(name: str) -> str:
    return "Natural" if name == NO_FIELD else name[:1].upper() + name[1:]


def _draw_visibility(context: PanelContext) -> None:
    imgui.separator_text("Show")
    options = context.options
    half = 0.5 * imgui.get_content_region_avail().x
    present = {surface.tissue for surface in context.session.model.rigid}
    boxes = [("Tongue", "show_tongue"), ("Sensors", "show_sensors"), ("Names", "show_labels")]
    boxes.append(("Targets", "show_targets"))
    for i, (label, name) in enumerate(boxes):
        setattr(options, name, imgui.checkbox(label, getattr(options, name))[1])
        if i % 2 == 0:
            imgui.same_line(half)
    for i, tissue in enumerate(t for t in _TISSUE_LABELS if t in present):
        shown = options.show_tissue.get(tissue, True)
        options.show_tissue[tissue] = imgui.checkbox(_TISSUE_LABELS[tissue], shown)[1]
        if i % 2 == 0:
            imgui.same_line(half)
    imgui.new_line() if len(present) % 2 else None
    if present:
        imgui.set_next_item_width(-1)
        options.opacity = imgui.slider_float("##opacity", options.opacity, 0.0, 2.0, "Opacity %.2f")[1]
    imgui.set_next_item_width(-1)
    chosen = BACKDROPS.index(options.backdrop) if options.backdrop in BACKDROPS[:2] else 0
    chosen = imgui.combo("##backdrop", chosen, ["Dark backdrop", "Light backdrop"])[1]
    options.backdrop = BACKDROPS[chosen]
