"""Judging of responses: the square around the touch against the pedestrian's centre region."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, ParameterError
from nvcore.subjects.driver.inputs.study_tables import BOX, PEDESTRIAN, is_off_time

DISPLAY_S: Final = 0.5
"""Duration for which a picture is shown (paper)."""


@dataclass(frozen=True, kw_only=True)
class Judging:
    """Criteria by which responses are judged.

    Attributes
    ----------
    square_px
        Side of the square around the touch, pixels of the picture. The paper uses 200, which is
        about 5 degrees there; see `side_of_angle`.
    centre_share
        Width and height of the pedestrian's centre region, as a share of the box's. The paper does
        not specify it. One half is our choice.
    display_s
        Duration for which a picture is shown. The adaptation period ends with it and starts with
        the change of light.

    Raises
    ------
    ParameterError
        If a value is outside its range.
    """

    square_px: float = 200.0
    centre_share: float = 0.5
    display_s: float = DISPLAY_S

    def __post_init__(self) -> None:
        for name, low, high in (
            ("square_px", 0.0, 1e5),
            ("centre_share", 0.0, 1.0),
            ("display_s", 0.0, 60.0),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ParameterError(f"{name}: expected {low:g} to {high:g}, got {value:g}")


def side_of_angle(
    degrees: float = 5.0, *, distance_mm: float, shown_width_mm: float, picture_width_px: float
) -> float:
    """Return the side of a square seen under this angle, in pixels of the picture.

    Parameters
    ----------
    degrees
        Angle, 0 to 90. The paper uses 5.
    distance_mm
        Distance from the eye to the screen.
    shown_width_mm
        Width of the picture on the screen.
    picture_width_px
        Width of the picture in its own pixels.

    Raises
    ------
    ParameterError
        If a length is not above 0, or the angle is outside its range.

    Examples
    --------
    On the paper's screen, 5 degrees are 200 px at 27 cm:

    >>> round(side_of_angle(distance_mm=270, shown_width_mm=226.2, picture_width_px=1920))
    200
    """
    if not 0 < degrees <= 90:
        raise ParameterError(f"degrees: expected 0 to 90, got {degrees:g}")
    lengths = {
        "distance_mm": distance_mm,
        "shown_width_mm": shown_width_mm,
        "picture_width_px": picture_width_px,
    }
    for name, length in lengths.items():
        if not 0 < length < math.inf:
            raise ParameterError(f"{name}: expected a length above 0, got {length:g}")
    side_mm = 2 * distance_mm * math.tan(math.radians(degrees) / 2)
    return side_mm * picture_width_px / shown_width_mm


def judge_trials(
    trials: pd.DataFrame, boxes: pd.DataFrame, judging: Judging, *, name: str = "trials"
) -> pd.DataFrame:
    """Judge responses and compute the adaptation period of each trial.

    A response is right if the square around the touch and the centre region of the pedestrian
    overlap. Touching sides do not count. A picture that was not seen is wrong.

    Parameters
    ----------
    trials
        Table from `nvcore.subjects.driver.trials.table.read_trials`.
    boxes
        ``image,pedestrian,x,y,w,h``, pixels of the picture, with one row for each pedestrian.
    name
        File name of the trials for error messages.

    Returns
    -------
    The trials with ``period_s`` (float64), ``is_right``, ``is_off_time`` (bool: the picture came
    more than 50 ms early or late) and the pedestrian's ``x``, ``y``, ``w``, ``h``.

    Raises
    ------
    InputError
        If the pedestrian of a trial has no box, with the line.
    """
    columns = [*PEDESTRIAN, *BOX]
    judged = trials.merge(boxes[columns], how="left", on=[*PEDESTRIAN], validate="many_to_one")
    is_lost = judged["x"].isna().to_numpy()
    if is_lost.any():
        trial = judged.iloc[int(np.argmax(is_lost))]
        raise InputError(
            f"there is no box for the pedestrian {trial['pedestrian']} of the picture "
            f"{trial['image']}; add it to the boxes, or leave the trial out",
            file=name,
            line=int(trial["line"]),
        )
    late_s = judged["adaptation_measured_s"] - judged["adaptation_asked_s"]
    return judged.assign(
        period_s=(judged["adaptation_asked_s"] + judging.display_s).round(6),
        is_right=is_right(judged, judging).to_numpy(),
        is_off_time=is_off_time(late_s).to_numpy(),
    )


def is_right(trials: pd.DataFrame, judging: Judging) -> pd.Series:
    """Return whether the square around each touch overlaps the centre region, bool.

    Parameters
    ----------
    trials
        Table with ``touch_x``, ``touch_y`` (NaN: not seen) and the pedestrian's ``x, y, w, h``.
    """
    across = (trials["touch_x"] - trials["x"] - trials["w"] / 2).abs()
    down = (trials["touch_y"] - trials["y"] - trials["h"] / 2).abs()
    half = judging.square_px / 2
    share = judging.centre_share / 2
    return (across < half + share * trials["w"]) & (down < half + share * trials["h"])
