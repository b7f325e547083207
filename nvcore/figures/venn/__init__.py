"""Venn diagram of the encounters: two circles with areas in proportion to the counts."""

from nvcore.figures.venn.circles import circles_of, overlap_area
from nvcore.figures.venn.figure import MOST_MARKS, venn_figure

__all__ = ["MOST_MARKS", "circles_of", "overlap_area", "venn_figure"]
