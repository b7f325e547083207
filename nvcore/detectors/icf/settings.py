"""Every setting of the detector: of its features, its training, and of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Final, Literal, get_args

from nvcore.detection import scale_steps
from nvcore.detectors.base import Setting
from nvcore.detectors.suppression import OverlapOf
from nvcore.errors import ParameterError

ChannelSet = Literal["grey", "rgb", "hsv", "luv", "magnitude", "orientations"]
Magnitude = Literal["euclidean", "sum"]
Cascade = Literal["constant", "calibrated", "hard", "none"]
Proposals = Literal["none", "red"]

OF_COLOUR: Final[tuple[ChannelSet, ...]] = ("rgb", "hsv", "luv")
"""Channels that a grey picture does not have: its grey levels take their place."""
OF_A_RUN: Final = frozenset(
    (
        "scales",
        "stride",
        "threshold",
        "cascade",
        "rejection",
        "overlap",
        "overlap_of",
        "region",
        "use_band",
        "proposals",
        "red_share",
        "scales_between",
    )
)
"""Settings that a trained model may be run with otherwise; the others made it what it is."""
MAX_WINDOW: Final = 256
MAX_STRIDE: Final = 256
MAX_SCALES: Final = 64
MAX_TREES: Final = 20_000
MAX_FEATURES: Final = 200_000


@dataclass(frozen=True, kw_only=True)
class IcfSettings:
    """Settings of the detector. Lengths in px are those of the window.

    Attributes
    ----------
    channels
        ``grey``, ``rgb``, ``hsv``, ``luv``, ``magnitude`` (of the gradient), ``orientations``.
    orientation_bins
        Equal parts of the circle, or of half of it, with a channel each.
    full_circle
        Whether dark on bright and bright on dark are two orientations.
    magnitude
        Of a gradient: ``euclidean``, or the ``sum`` of both absolute differences.
    blur
        3x3 Gaussian, first of all.
    clahe_clip, clahe_tile_px
        Clip limit of the contrast-limited adaptive histogram equalisation of the brightness (0:
        none), and about the side of its tiles.
    window_width, window_height
        Size of the classifier's window, px.
    object_width, object_height
        Size that an object has in the middle of the window, px; its box is of this size.
    features, least_area, difference_share
        Features in the pool, least area of their rectangles (px²), and the share that are the
        difference of two rectangles of one size.
    trees_per_round
        Trees of each round of training. Every round but the first has more background, that which
        the round before took for objects, and begins anew.
    feature_share
        Share of the pool that is tried for each tree.
    patience
        A round ends where its training error has not fallen for so many trees; None: never.
    negatives, negatives_per_round
        Windows of background in the first round, drawn at random, and those added before each
        further one.
    copies, mirrored
        Further windows of each object, moved by up to half a stride and scaled by up to half a
        step of the scales; whether every other of them is mirrored.
    least_object_px
        Copies are shrunk at random, down to this height of the object in its picture (0: none),
        so that small and blurred objects are learned, too.
    cascade, rejection
        What rejects a window before the last tree: the running sum of confidences below a
        ``constant`` (`rejection`) or below the least that objects had there (``calibrated``); the
        sum of one of the stages by itself (``hard``); or nothing (``none``).
    kept_share
        Share of the objects that the calibrated trace and the stages let pass: of those trained
        on, and of those held out by themselves.
    scales
        Divisors of the picture's size, ascending; below 1 it is enlarged.
    scales_between
        0: the channels of every scale are computed. Else those of so many scales after each
        computed one are made from its channels, by resizing (approximation).
    stride
        Step between two windows, px.
    threshold
        Lowest confidence of a detection.
    overlap, overlap_of
        Of two boxes that overlap by more than this share of their ``union`` or of the ``smaller``
        one, the less confident goes; 1: both stay.
    region
        Corners of a polygon in shares of the picture's width and height, one after another, in
        which the centre of a window must lie; empty: anywhere.
    use_band
        Whether windows must lie where the objects of the training lay, by their size.
    proposals, red_share
        ``red``: only windows with at least this share of red pixels are looked at.

    Raises
    ------
    ParameterError
        If a value is not possible.
    """

    channels: tuple[ChannelSet, ...] = ("luv", "magnitude", "orientations")
    orientation_bins: int = 6
    full_circle: bool = False
    magnitude: Magnitude = "euclidean"
    blur: bool = True
    clahe_clip: float = 0.0
    clahe_tile_px: int = 64
    window_width: int = 64
    window_height: int = 64
    object_width: float = 52.0
    object_height: float = 52.0
    features: int = 5000
    least_area: int = 25
    difference_share: float = 0.0
    trees_per_round: tuple[int, ...] = (64, 256, 1024)
    feature_share: float = 0.25
    patience: int | None = None
    negatives: int = 8000
    negatives_per_round: int = 6000
    copies: int = 3
    mirrored: bool = False
    least_object_px: float = 0.0
    cascade: Cascade = "calibrated"
    rejection: float = -1.0
    kept_share: float = 1.0
    scales: tuple[float, ...] = scale_steps(1.0, 1.7, 0.1)
    scales_between: int = 0
    stride: int = 6
    threshold: float = 0.0
    overlap: float = 0.5
    overlap_of: OverlapOf = "union"
    region: tuple[float, ...] = ()
    use_band: bool = False
    proposals: Proposals = "none"
    red_share: float = 0.02

    def __post_init__(self) -> None:
        _check_choices(self)
        for name, (low, high) in RANGES.items():
            _check_number(name, getattr(self, name), low, high)
        for name, (low, high) in _MEMBERS.items():
            for value in getattr(self, name):
                _check_number(name, value, low, high)
        if self.patience is not None:
            _check_number("patience", self.patience, 1, MAX_TREES)
        for name in _WHOLE:
            if not all(isinstance(value, int) for value in _values(getattr(self, name))):
                raise ParameterError(f"{name}: expected a whole number, got {getattr(self, name)}")
        _check_together(self)

    @property
    def aspect(self) -> float:
        """Width of an object's box divided by its height."""
        return self.object_width / self.object_height

    def as_json(self) -> dict[str, Any]:
        """All settings by name, as JSON has them: tuples are lists."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(self).items()
        }

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> IcfSettings:
        """The settings that `as_json` wrote.

        Raises
        ------
        ParameterError
            If one is missing, unknown or impossible.
        """
        names = {field.name for field in fields(IcfSettings)}
        if set(values) != names:
            odd = ", ".join(sorted(set(map(str, values)) ^ names))
            raise ParameterError(f"settings: missing or unknown are {odd}")
        known: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in values.items()
        }
        return IcfSettings(**known)

    def in_words(self) -> dict[str, Setting]:
        """All settings by name, several values as one text, to be written beside results."""
        return {
            name: " ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
            if isinstance(value, tuple)
            else value
            for name, value in asdict(self).items()
        }


CHOICES: Final[dict[str, tuple[Any, ...]]] = {
    "magnitude": get_args(Magnitude),
    "cascade": get_args(Cascade),
    "overlap_of": get_args(OverlapOf),
    "proposals": get_args(Proposals),
    "full_circle": (False, True),
    "blur": (False, True),
    "mirrored": (False, True),
    "use_band": (False, True),
}
RANGES: Final[dict[str, tuple[float, float]]] = {
    "orientation_bins": (1, 36),
    "clahe_clip": (0, 1000),
    "clahe_tile_px": (4, 4096),
    "window_width": (8, MAX_WINDOW),
    "window_height": (8, MAX_WINDOW),
    "object_width": (1, MAX_WINDOW),
    "object_height": (1, MAX_WINDOW),
    "features": (1, MAX_FEATURES),
    "least_area": (1, MAX_WINDOW**2),
    "difference_share": (0, 1),
    "feature_share": (0.001, 1),
    "negatives": (1, 1_000_000),
    "negatives_per_round": (0, 1_000_000),
    "copies": (0, 100),
    "least_object_px": (0, MAX_WINDOW),
    "rejection": (-1000, 1000),
    "kept_share": (0.5, 1),
    "scales_between": (0, MAX_SCALES),
    "stride": (1, MAX_STRIDE),
    "threshold": (-1e6, 1e6),
    "overlap": (0, 1),
    "red_share": (0, 1),
}
_MEMBERS: Final[dict[str, tuple[float, float]]] = {
    "trees_per_round": (1, MAX_TREES),
    "scales": (0.05, 50),
    "region": (0, 1),
}
_WHOLE: Final = (
    "orientation_bins",
    "clahe_tile_px",
    "window_width",
    "window_height",
    "features",
    "least_area",
    "trees_per_round",
    "negatives",
    "negatives_per_round",
    "copies",
    "scales_between",
    "stride",
)


def _values(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def _check_choices(settings: IcfSettings) -> None:
    for name, choices in CHOICES.items():
        value = getattr(settings, name)
        if not any(value is c or (isinstance(value, str) and value == c) for c in choices):
            expected = ", ".join(str(choice) for choice in choices)
            raise ParameterError(f"{name}: expected one of {expected}, got {value!r}")
    for name in ("channels", *_MEMBERS):
        if not isinstance(getattr(settings, name), tuple):
            raise ParameterError(f"{name}: expected several values, got {getattr(settings, name)}")
    known = get_args(ChannelSet)
    channels = settings.channels
    if not channels or not all(channel in known for channel in channels):
        raise ParameterError(f"channels: expected some of {', '.join(known)}, got {channels}")
    if len(set(channels)) < len(channels):
        raise ParameterError(f"channels: each once, got {channels}")


def _check_number(name: str, value: Any, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise ParameterError(f"{name}: expected a number, got {value!r}")
    if not low <= value <= high:
        raise ParameterError(f"{name}: expected {low:g} to {high:g}, got {value:g}")


def _check_together(settings: IcfSettings) -> None:
    s = settings
    if s.object_width > s.window_width or s.object_height > s.window_height:
        raise ParameterError(
            f"object_width, object_height: the object ({s.object_width:g}x{s.object_height:g} px) "
            f"must fit into the window ({s.window_width}x{s.window_height} px)"
        )
    if s.least_area > s.window_width * s.window_height:
        raise ParameterError(f"least_area: no rectangle of {s.least_area} px² fits into the window")
    if not 1 <= len(s.scales) <= MAX_SCALES or list(s.scales) != sorted(set(s.scales)):
        raise ParameterError(f"scales: expected 1 to {MAX_SCALES} ascending ones, got {s.scales}")
    if not 1 <= len(s.trees_per_round) <= 20:
        raise ParameterError("trees_per_round: expected 1 to 20 rounds")
    if len(s.region) % 2 or 0 < len(s.region) < 6:
        raise ParameterError("region: expected x and y of at least three corners")


AS_IN_REPORT: Final = IcfSettings(
    full_circle=True,
    clahe_clip=4.0,
    object_width=64.0,
    object_height=64.0,
    trees_per_round=(125, 250, 500, 1000),
    feature_share=1.0,
    patience=100,
    negatives=20_000,
    negatives_per_round=0,
    copies=0,
    cascade="constant",
    rejection=-1.0,
    scales=scale_steps(1.0, 1.7, 0.1),
    stride=6,
    overlap=0.5,
)
"""The speed-sign detector of the Aalborg report (2015); what it does not say is a default."""

SIGNS: Final = IcfSettings(
    window_width=32,
    window_height=32,
    object_width=27.0,
    object_height=27.0,
    features=3000,
    least_area=16,
    trees_per_round=(64, 256, 800),
    least_object_px=16.0,
    scales=tuple(round(0.66 * 1.15**i, 4) for i in range(15)),
    stride=4,
    overlap_of="smaller",
)
"""Round signs of 18 to 125 px."""

PEDESTRIANS: Final = IcfSettings(
    window_width=32,
    window_height=64,
    object_width=21.0,
    object_height=52.0,
    trees_per_round=(32, 128, 512, 2048),
    mirrored=True,
    scales=tuple(round(0.5 * 2 ** (i / 8), 4) for i in range(25)),
    stride=4,
    overlap=0.6,
    overlap_of="smaller",
)
"""Upright people of some 26 px and more."""
