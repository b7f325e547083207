"""Venn diagram of the encounters: two circles with areas in proportion to the counts."""

from nvcore.figures.venn.circles import overlap_area, place_circles
from nvcore.figures.venn.figure import MOST_MARKS, WORDS, venn_figure

__all__ = ["MOST_MARKS", "WORDS", "overlap_area", "place_circles", "venn_figure"]
