"""A system keeps its colour, line and mark, whether it is compared as X or as Y."""

from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset

from nvcore.api.figures import Figures
from nvcore.common.palette import STYLES, Scheme, scheme_for
from nvcore.comparison.compare import Result, compare
from nvcore.figures.overlay import annotate
from nvcore.figures.overlay.brush import X_RGB, Y_RGB
from nvcore.figures.style import LOOK, which_is_which
from nvcore.figures.venn import AREAS

NAMES = ["fir", "nir", "radar", "lidar", "old", "older"]


def test_the_place_in_the_session_decides_and_two_systems_never_look_alike():
    assert scheme_for("dark", NAMES, "fir", "nir")[:3] == ("dark", 0, 1)
    assert scheme_for("dark", NAMES, "nir", "fir")[:3] == ("dark", 1, 0)
    assert scheme_for("light", NAMES, "radar", "fir")[:3] == ("light", 2, 0)
    first_again = scheme_for("light", NAMES, "older", "fir")
    assert len(STYLES) == 5
    assert first_again.x != first_again.y
    assert scheme_for("light", ["fir"], "fir", None)[:3] == ("light", 0, 1)


def test_the_styles_differ_in_each_of_their_signs():
    for signs in zip(*((s.light, s.dark, s.dash, s.symbol, s.words) for s in STYLES), strict=True):
        assert len(set(signs)) == len(STYLES)
    assert {style.symbol for style in STYLES} <= {*AREAS}  # the Venn diagram knows each mark


def test_a_look_follows_the_scheme():
    look = LOOK[Scheme("dark", 1, 0)]
    assert (look.x, look.y) == (LOOK["dark"].y, LOOK["dark"].x)
    assert (look.dash("x"), look.symbol("y")) == ("dash", "circle")
    assert look.ink == LOOK["dark"].ink


def compared(x: str, y: str) -> Result:
    """`x` finds the pedestrian, `y` does not."""
    truth = [at(f, 50, track=1) for f in range(4)]
    return compare(make_dataset(truth, truth, []), x=x, y=y)


@pytest.mark.parametrize("names", [("x", "y"), ("y", "x")])
def test_figures_and_pictures_draw_a_system_alike_after_a_swap(names: tuple[str, str]):
    result = compared(*names)
    figure = Figures(result).timeline(0)
    lines = {
        trace.name.partition(": ")[2]: (trace.line.color, trace.line.dash)
        for trace in figure.data
        if trace.name and ": " in trace.name
    }
    assert lines["x"] == (STYLES[0].light, "solid")
    assert lines["y"] == (STYLES[1].light, "dash")
    drawn = annotate(result, None, -1, 0, layers=("x", "y"), caption=False)
    assert np.all(drawn == X_RGB, axis=2).any()
    assert not np.all(drawn == Y_RGB, axis=2).any()


def test_a_figure_without_a_legend_says_which_system_is_which():
    scheme = scheme_for("light", NAMES, "nir", "fir")
    assert which_is_which(scheme) == "; X: nir, Y: fir"
    assert which_is_which("light") == ""
    assert LOOK[scheme] is LOOK[Scheme("light", scheme.x, scheme.y)]
