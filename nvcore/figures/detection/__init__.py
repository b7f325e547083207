"""Detection curves of X and Y with the operating points in use."""

from nvcore.figures.detection.kinds import CurveKind, legend_text
from nvcore.figures.detection.plot import curve_plot
from nvcore.figures.detection.points import MAX_POINTS

__all__ = ["MAX_POINTS", "CurveKind", "curve_plot", "legend_text"]
