"""Overview page: all recordings as strips of time, where to look first."""

from __future__ import annotations

from nvcore.comparison.compare import Result
from nvcore.figures.lanes import loss_strip_plot
from nvcore.tables.loss_strip import loss_strip
from ui.session import state
from ui.shell.navigate import open_row
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.text import docs_link


def draw(result: Result) -> None:
    """Draw a strip for each recording. A click opens the frame that loses most there."""
    figure = kept_figure(
        "loss_strip",
        (result.params, state.systems(), state.theme()),
        lambda: loss_strip_plot(result, loss_strip(result), theme=state.theme()),
    )
    row = clicked_chart(
        figure,
        "loss_strip",
        alt="For each recording, over time: how much similarity the worse system loses",
        help="Each row is a recording. The stronger the colour, the more of its similarity the "
        "worse of the two systems loses (1 − similarity, 0 is best). Click to open the frame "
        f"({docs_link('Metrics', 'similarity')}).",
    )
    if row is not None:
        open_row(int(row))
