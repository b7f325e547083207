"""Settings of the ICF detector: features, training and runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, asdict, dataclass, fields
from typing import Any, Final, Literal, get_args

from nvcore.common.errors import ParameterError
from nvcore.common.records import convert, types_of
from nvcore.common.wording import shortened
from nvcore.dataset.provenance import Setting
from nvcore.metrics.detection import scale_steps
from nvcore.subjects.detectors.settings import facts_of, setting, value_text
from nvcore.subjects.detectors.suppression import OverlapOf

ChannelSet = Literal["grey", "rgb", "hsv", "luv", "magnitude", "orientations"]
Magnitude = Literal["euclidean", "sum"]
Cascade = Literal["constant", "calibrated", "hard", "none"]
Proposals = Literal["none", "red"]

OF_COLOUR: Final[tuple[ChannelSet, ...]] = ("rgb", "hsv", "luv")
"""Colour channel sets. Grey pictures use their grey levels instead."""
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
"""Settings that each run of a trained model may change. The others are fixed by its training."""
MAX_WINDOW: Final = 256
MAX_STRIDE: Final = 256
MAX_SCALES: Final = 64
MAX_TREES: Final = 20_000
MAX_FEATURES: Final = 200_000


@dataclass(frozen=True, kw_only=True)
class IcfSettings:
    """Settings of the detector. Lengths in px refer to the window.

    For a setting with several values, the range applies to each value.

    Raises
    ------
    ParameterError
        If a value is not possible.
    """

    channels: tuple[ChannelSet, ...] = setting(
        ("luv", "magnitude", "orientations"),
        "grey, rgb, hsv, luv, magnitude (of the gradient), orientations.",
    )
    orientation_bins: int = setting(
        6, "Equal parts of the circle, or of half of it, with a channel each.", low=1, high=36
    )
    full_circle: bool = setting(
        False, "Whether dark on bright and bright on dark are two orientations."
    )
    magnitude: Magnitude = setting(
        "euclidean",
        "Of a gradient.",
        choices={"euclidean": "root of the sum of squares", "sum": "of both absolute differences"},
    )
    blur: bool = setting(True, "3x3 Gaussian, first of all.")
    clahe_clip: float = setting(
        0.0,
        "Clip limit of the contrast-limited adaptive histogram equalisation of the brightness; "
        "0: none.",
        low=0,
        high=1000,
    )
    clahe_tile_px: int = setting(64, "About the side of its tiles, px.", low=4, high=4096)
    window_width: int = setting(64, "Width of the classifier's window, px.", low=8, high=MAX_WINDOW)
    window_height: int = setting(64, "Height of the window, px.", low=8, high=MAX_WINDOW)
    object_width: float = setting(
        52.0, "Width of an object in the middle of the window, and of its box, px.",
        low=1, high=MAX_WINDOW,
    )  # fmt: skip
    object_height: float = setting(
        52.0, "Height of an object in the middle of the window, and of its box, px.",
        low=1, high=MAX_WINDOW,
    )  # fmt: skip
    features: int = setting(5000, "Features in the pool.", low=1, high=MAX_FEATURES)
    least_area: int = setting(25, "Least area of their rectangles, px².", low=1, high=MAX_WINDOW**2)
    difference_share: float = setting(
        0.0, "Share of them that are the difference of two rectangles of one size.", low=0, high=1
    )
    trees_per_round: tuple[int, ...] = setting(
        (64, 256, 1024),
        "Trees of each round of training. Every round but the first has more background, that "
        "which the round before took for objects, and begins anew.",
        low=1,
        high=MAX_TREES,
    )
    feature_share: float = setting(
        0.25, "Share of the pool that is tried for each tree.", low=0.001, high=1
    )
    patience: int | None = setting(
        None,
        "A round ends where its training error has not fallen for so many trees; none: never.",
        low=1,
        high=MAX_TREES,
    )
    negatives: int = setting(
        8000, "Windows of background in the first round, drawn at random.", low=1, high=1_000_000
    )
    negatives_per_round: int = setting(
        6000, "Windows of background added before each further round.", low=0, high=1_000_000
    )
    copies: int = setting(
        3,
        "Further windows of each object, moved by up to half a stride and scaled by up to half a "
        "step of the scales.",
        low=0,
        high=100,
    )
    mirrored: bool = setting(False, "Whether every other copy is mirrored.")
    least_object_px: float = setting(
        0.0,
        "Copies are shrunk at random, down to this height of the object in its picture, so that "
        "small and blurred objects are learned, too; 0: not at all.",
        low=0,
        high=MAX_WINDOW,
    )
    cascade: Cascade = setting(
        "calibrated",
        "What rejects a window before the last tree.",
        choices={
            "constant": "a confidence below the setting rejection",
            "calibrated": "a confidence below what objects had there",
            "hard": "too low a sum of one stage by itself",
            "none": "nothing: every window is given to every tree",
        },
    )
    rejection: float = setting(-1.0, "Of the constant cascade.", low=-1000, high=1000)
    kept_share: float = setting(
        1.0,
        "Share of the objects that the calibrated trace and the stages let pass: of those trained "
        "on, and of those held out by themselves.",
        low=0.5,
        high=1,
    )
    slack: float = setting(
        0.0,
        "How far below the least sum of these objects the calibrated trace and the floors of the "
        "stages lie: room for objects a little unlike them.",
        low=0,
        high=100,
    )
    scales: tuple[float, ...] = setting(
        scale_steps(1.0, 1.7, 0.1),
        "Divisors of the picture's size, ascending, with blanks between; below 1 it is enlarged.",
        low=0.05,
        high=50,
    )
    scales_between: int = setting(
        0,
        "How many scales after each computed one are made from its channels; 0: none.",
        low=0,
        high=MAX_SCALES,
    )
    stride: int = setting(6, "Step between two windows, px.", low=1, high=MAX_STRIDE)
    threshold: float = setting(0.0, "Lowest confidence of a box.", low=-1e6, high=1e6)
    overlap: float = setting(
        0.5,
        "Of two boxes that overlap by more than this share, the less confident goes; 1: both stay.",
        low=0,
        high=1,
    )
    overlap_of: OverlapOf = setting(
        "union",
        "Of what the overlap is a share.",
        choices={"union": "of both boxes together", "smaller": "of the smaller box"},
    )
    region: tuple[float, ...] = setting(
        (),
        "Corners of a polygon in which a window's centre must lie, as shares of the picture's "
        "width and height, with blanks between; empty: anywhere.",
        low=0,
        high=1,
    )
    use_band: bool = setting(
        False, "Whether windows must lie where the objects of the training lay, by their size."
    )
    proposals: Proposals = setting(
        "none",
        "Which windows are looked at.",
        choices={"none": "all", "red": "those with enough red pixels"},
    )
    red_share: float = setting(0.02, "Least share of red pixels of a proposal.", low=0, high=1)

    def __post_init__(self) -> None:
        for spec in fields(self):
            _check(spec, getattr(self, spec.name))
        _check_together(self)

    @property
    def aspect(self) -> float:
        """Width of an object's box divided by its height."""
        return self.object_width / self.object_height

    def as_json(self) -> dict[str, Any]:
        """Return all settings by name as JSON values. Tuples become lists."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(self).items()
        }

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> IcfSettings:
        """Parse the settings that `as_json` wrote.

        Raises
        ------
        ParameterError
            If a setting is missing, unknown or impossible.
        """
        if odd := sorted(set(map(str, values)) ^ types_of(IcfSettings).keys()):
            raise ParameterError(f"settings: missing or unknown are {', '.join(odd)}")
        lists = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
        return IcfSettings(**{**values, **lists})

    def in_words(self) -> dict[str, Setting]:
        """Return all settings by name, with several values joined as text, for reports."""
        return {
            name: " ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
            if isinstance(value, tuple)
            else value
            for name, value in asdict(self).items()
        }


def _check(spec: Field[Any], value: Any) -> None:
    """Reject a value that is impossible for a setting regardless of the others."""
    facts = facts_of(spec)
    try:
        convert(types_of(IcfSettings)[spec.name], value, spec.name)
    except ValueError as error:
        raise ParameterError(str(error)) from error
    if isinstance(value, list):
        raise ParameterError(f"{spec.name}: expected a tuple, found a list")
    if facts.low is None or facts.high is None or value is None:
        return
    numbers = value if isinstance(value, tuple) else (value,)
    if not all(facts.low <= number <= facts.high for number in numbers):
        text = shortened(value_text(value), 80)
        raise ParameterError(f"{spec.name}: expected {facts.low:g} to {facts.high:g}, got {text}")


def _check_together(settings: IcfSettings) -> None:
    s = settings
    if not s.channels or len(set(s.channels)) < len(s.channels):
        known = ", ".join(get_args(ChannelSet))
        raise ParameterError(
            f"channels: expected some of {known}, each once, got {value_text(s.channels)}"
        )
    if s.object_width > s.window_width or s.object_height > s.window_height:
        raise ParameterError(
            f"object_width, object_height: the object ({s.object_width:g}x{s.object_height:g} px) "
            f"must fit into the window ({s.window_width}x{s.window_height} px)"
        )
    if s.least_area > s.window_width * s.window_height:
        raise ParameterError(f"least_area: no rectangle of {s.least_area} px² fits into the window")
    if not 1 <= len(s.scales) <= MAX_SCALES or list(s.scales) != sorted(set(s.scales)):
        raise ParameterError(
            f"scales: expected 1 to {MAX_SCALES} of them, ascending, such as 1, 1.1, 1.2; got "
            f"{value_text(s.scales)}"
        )
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
)
"""Speed-sign detector of the Aalborg report (2015), with defaults for values it does not state."""

SIGNS: Final = IcfSettings(
    window_width=32,
    window_height=32,
    object_width=27.0,
    object_height=27.0,
    features=3000,
    least_area=16,
    trees_per_round=(64, 256, 800),
    least_object_px=16.0,
    slack=0.75,
    scales=tuple(round(0.66 * 1.15**i, 4) for i in range(15)),
    stride=4,
    overlap_of="smaller",
)
"""Settings for round signs of 18 to 125 px."""

PEDESTRIANS: Final = IcfSettings(
    window_width=32,
    window_height=64,
    object_width=21.0,
    object_height=52.0,
    trees_per_round=(32, 128, 512, 2048),
    mirrored=True,
    scales=tuple(round(0.5 * 2 ** (i / 8), 4) for i in range(25)),
    stride=4,
    overlap_of="smaller",
)
"""Settings for upright people of about 26 px and more."""
