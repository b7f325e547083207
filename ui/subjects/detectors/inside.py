"""Detectors page: views into an ICF model and its decisions."""

from __future__ import annotations

from typing import Final

import numpy as np
import streamlit as st

from nvcore.common.errors import NvcoreError, ParameterError
from nvcore.figures.style import plain
from nvcore.metrics.detection import WindowGrid
from nvcore.pictures import Picture
from nvcore.subjects.detectors import figures
from nvcore.subjects.detectors.icf import displays
from nvcore.subjects.detectors.icf.settings import IcfSettings
from ui.session import state
from ui.shell.messages import shown_error
from ui.subjects.detectors import asking
from ui.subjects.detectors.confined import DetectorSpec, Inside, pictures_of
from ui.subjects.detectors.trial import chosen_box
from ui.widgets.charts import draw_chart
from ui.widgets.choices import choose_side_by_side

VIEWS: Final = {
    "pictures": "Picture and channels",
    "map": "Score map",
    "window": "One window",
    "traces": "Objects and background",
    "training": "Training",
}
STRIDES: Final = range(1, 11)
MOST_TRACES: Final = 12
"""Objects of a frame that are followed over the trees."""
MAPS: Final[tuple[figures.MapOf, ...]] = ("trees", "confidence")


@st.fragment
def draw(spec: DetectorSpec, inside: Inside, picture: Picture) -> None:
    """Draw the selected view."""
    st.header("Inside the model")
    view = choose_side_by_side(
        "What is shown", VIEWS, "detector_view", default="pictures", label_visibility="collapsed"
    )
    try:
        if view == "pictures":
            _draw_pictures(spec, inside, picture)
        elif view == "map":
            _draw_map(spec, inside, picture)
        elif view == "window":
            _draw_window(spec, inside, picture)
        elif view == "traces":
            _draw_traces(spec, inside, picture)
        else:
            draw_chart(
                figures.training_plot(inside.error, inside.round_ends, theme=state.theme().shade),
                "detector_training",
                of=plain(asking.described(spec).about.name),
                help="Share of the training's windows on the wrong side. Each round but the first "
                "has more background, that which the round before took for objects: it is harder.",
            )
    except NvcoreError as error:  # the picture is too small at that scale
        st.warning(shown_error(error), icon=":material/warning:")


def _choose_scale(inside: Inside, picture: Picture) -> float:
    """Draw the choice of a scale at which the picture holds a window, and return it."""
    scales = displays.usable_scales(inside.settings, picture.shape[1], picture.shape[0])
    if not scales:
        raise ParameterError("the picture is smaller than the window at every scale")
    if len(scales) == 1:
        return scales[0]
    scale: float = st.select_slider(
        "Scale",
        scales,
        min(scales, key=lambda scale: abs(scale - 1)),
        format_func=lambda scale: f"{scale:.3g}",
        key=f"detector_scale_{asking.key_of(scales)}",
        help="Divisor of the picture's size: below 1 it is enlarged, for smaller objects.",
    )
    return scale


def _draw_pictures(spec: DetectorSpec, inside: Inside, picture: Picture) -> None:
    scale, shade = _choose_scale(inside, picture), state.theme().shade
    computed, steps, channels = asking.ask_model(pictures_of, spec, picture, scale)
    title, subtitle = "The picture, step by step", f"scale {computed:.3g}"
    figure = figures.pictures_plot(steps, theme=shade, title=title, subtitle=subtitle, columns=3)
    of = asking.on_frame(asking.described(spec).about)
    draw_chart(figure, "detector_steps", of=of)
    origin = "" if computed == scale else f", made from those of scale {computed:.3g} as in a run"
    figure = figures.pictures_plot(
        # the angles alone: in a narrow window whole names run into each other
        {name.removeprefix("gradient "): channel for name, channel in channels.items()},
        theme=shade,
        title="Channels",
        subtitle=f"what the features are sums of, at scale {scale:.3g}{origin}; angles: of the "
        "gradient; the contrast of each is stretched",
        stretched=True,
    )
    draw_chart(figure, "detector_channels", of=of)


def _draw_map(spec: DetectorSpec, inside: Inside, picture: Picture) -> None:
    left, right = st.columns(2)
    with left:
        scale = _choose_scale(inside, picture)
    with right:
        of = choose_side_by_side("Colour", MAPS, "detector_map_of", default="trees")
    windows = asking.ask_model(displays.map_at, spec, picture, scale)
    figure = figures.score_map_plot(
        windows, inside.settings, picture, theme=state.theme().shade, of=of
    )
    n_trees = windows.n_features / 2 / max(windows.n_windows, 1)
    draw_chart(
        figure,
        "detector_map",
        of=asking.on_frame(asking.described(spec).about),
        help=f"A window is given to {n_trees:.1f} of {inside.n_trees:,} trees on average: most are "
        "rejected early.",
    )
    _draw_windows_per_stride(inside.settings, picture)


def _draw_windows_per_stride(settings: IcfSettings, picture: Picture) -> None:
    """Draw the number of windows in a picture of this size, at all scales, by stride."""
    height, width = picture.shape[:2]
    counts = [
        WindowGrid(settings.window_width, settings.window_height, stride, settings.scales)
        for stride in STRIDES
    ]
    rows = (
        ["Stride, px", *map(str, STRIDES)],
        ["---:"] * (1 + len(STRIDES)),
        ["Windows of a picture", *(f"{grid.per_image(width, height):,.0f}" for grid in counts)],
    )
    st.markdown("\n".join(f"| {' | '.join(row)} |" for row in rows))
    st.caption(
        f"At all scales together, before region, band and proposals leave any out. The stride is "
        f"{settings.stride} px."
    )


def _draw_traces(spec: DetectorSpec, inside: Inside, picture: Picture) -> None:
    scale = _choose_scale(inside, picture)
    truth = asking.truth_in(picture)
    objects = asking.ask_model(displays.truth_paths, spec, picture, truth[:MOST_TRACES])
    background = asking.ask_model(displays.rejected_paths, spec, picture, truth, scale)
    about = asking.described(spec).about
    draw_chart(
        figures.traces_plot(objects, background, theme=asking.theme_of(about)),
        "detector_traces",
        of=asking.on_frame(about),
        help=f"Objects: the window nearest to each of the truth's first {MOST_TRACES} boxes, where "
        "one fits, at the scale of that. Background: windows of the chosen scale that are "
        "rejected, some early and some late. A line ends where its window is rejected.",
    )


def _draw_window(spec: DetectorSpec, inside: Inside, picture: Picture) -> None:
    boxes = asking.found(spec, picture)
    row = chosen_box(spec, boxes)
    if row is None:
        st.info("No window came through, so there is none to follow. Choose another frame.")
        return
    box = float(boxes.x[row]), float(boxes.y[row]), float(boxes.w[row])
    height, width = picture.shape[:2]
    place = asking.ask_model(displays.window_of, spec, width, height, box)
    path = asking.ask_model(displays.window_path, spec, picture, *place)
    st.caption(
        f"The box with the score {boxes.score[row]:.3g}, at scale {place[0]:.3g}; a click in the "
        "picture above chooses another."
    )
    about = asking.described(spec).about
    theme, of = asking.theme_of(about), asking.on_frame(about)
    left, right = st.columns(2, gap="medium")
    with left:
        draw_chart(figures.confidence_plot(path, theme=theme), "detector_confidence", of=of)
    with right:
        number = st.number_input("Tree", 1, inside.n_trees, 1, 1, key="detector_tree", width=200)
        tree = asking.ask_model(displays.tree, spec, number - 1)
        leaf = int(np.asarray(path.leaf)[number - 1])
        window = inside.settings.window_width, inside.settings.window_height
        figure = figures.tree_plot(tree, theme=theme, window=window, number=number, leaf=leaf)
        draw_chart(figure, "detector_tree_plot", of=of)
