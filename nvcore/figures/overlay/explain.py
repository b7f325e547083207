"""Explanation of a frame's numbers in words: each box, and the similarity of each system."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from nvcore.common.wording import capitalised, number
from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import miss_factors
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import MISS_CLASS_TEXT, DetectionState, MissClass, TruthState
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.matching import iou_of_pairs
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import border_of, miss_terms
from nvcore.tables.boxes.states import gather_boxes

NOBODY: Final = -1
MOST_BOXES: Final = 2000
"""Most boxes of a frame that are explained, since each is compared with each."""
SMALL: Final = 0.0005
"""Smallest loss of similarity worth mentioning; less is shown as a similarity of 1.000."""


@dataclass(frozen=True)
class BoxReason:
    """Explanation of a box of a frame: its outcome, weight and cost.

    Attributes
    ----------
    title, lines
        Name and outcome of the box, followed by one sentence per line.
    encounter, track
        Row of ``result.encounters`` and track (as in `nvcore.tables.boxes.states.TruthBoxes`) of
        the pedestrian, or of the one that the detection matches; -1 if there is none.
    truth
        For a matched detection, index of its pedestrian's box in the list; -1 if there is none.
    """

    title: str
    lines: tuple[str, ...]
    encounter: int = NOBODY
    track: int = NOBODY
    truth: int = NOBODY


def explain_boxes(result: Result, row: int) -> list[BoxReason]:
    """Explain the boxes of a frame in the order of `gather_boxes`: truth, X, Y.

    Detections below the threshold are skipped.

    Parameters
    ----------
    row
        Row of the frames table. Frames with more than `MOST_BOXES` boxes are not explained.
    """
    frame = _Frame(result, row)
    if frame.n_boxes > MOST_BOXES:
        return []
    reasons = [_pedestrian(frame, i) for i in range(len(frame.truth))]
    for letter in "xy":
        states = frame.state[letter]
        reasons += [_detection(frame, letter, int(i)) for i in np.flatnonzero(states)]
    return reasons


def explain_similarity(result: Result, row: int, letter: str) -> str:
    """Explain the similarity of X or Y in a frame.

    Parameters
    ----------
    letter
        "x" or "y".
    """
    frame = _Frame(result, row)
    system = result.system(letter)
    loss_miss, loss_false = (float(loss[row]) for loss in (system.loss_miss, system.loss_false))
    texts = []
    if (worst := frame.worst(letter)) != NOBODY and loss_miss >= SMALL:
        how = "detected a little aside" if frame.is_matched(letter, worst) else "not detected"
        texts.append(
            f"Misses take {loss_miss:.3f}: {frame.name(worst)}, {frame.truth.h[worst]:.0f} px "
            f"tall, weight {frame.k[worst]:.2f}, is {how} and costs most."
        )
    if loss_false >= SMALL:
        texts.append(f"False alarms take {loss_false:.3f}, the largest cost of one detection.")
    if not texts:
        text = "Nothing that costs is missed, and no detection is far from {everybody}."
        texts.append(result.objects.say(text))
    n_missed = int(np.count_nonzero(frame.missed(letter)))
    n_far = int(np.count_nonzero(frame.missed(letter) & (frame.k < RELEVANT_K)))
    if n_far:
        who = f"All {n_far:,}" if n_far == n_missed else f"{n_far:,} of {n_missed:,}"
        who = "The only one" if n_missed == 1 else who
        texts.append(
            f"{who} not detected {'is' if n_far == 1 else 'are'} too far to count (weight below "
            f"{RELEVANT_K:g})."
        )
    return " ".join(texts)


class _Frame:
    """Boxes of one frame with all data for their explanation, as arrays by box."""

    def __init__(self, result: Result, row: int) -> None:
        dataset, frames = result.dataset, result.dataset.frame_columns
        self.result, self.row = result, row
        self.half_width = float(frames.half_width[row])
        self.rows = {"truth": dataset.truth.rows_of(row, row + 1)}
        self.truth = result.weighed_truth.of_frames(row, row + 1)
        gathered = gather_boxes(result, row, row + 1).truth
        self.tracks, self.is_relevant = gathered.track, gathered.is_relevant
        self.is_salient = {"x": gathered.is_salient_x, "y": gathered.is_salient_y}
        self.truth_state = {"x": gathered.state_x, "y": gathered.state_y}
        self.k = result.k_truth.k[self.rows["truth"]]
        self.k_miss = result.k_miss[self.rows["truth"]]
        factors = miss_factors(dataset, result.params)
        self.factors = {label: of[self.rows["truth"]] for label, of in factors.items()}
        edge_weight = in_use(result.params, "edge_weight", frames)
        self.border = border_of(self.truth, frames, edge_weight)
        self.boxes: dict[str, BoxColumns] = {}
        self.state, self.terms, self.det_border = {}, {}, {}
        for letter, system in result.sides:
            detections = dataset.system(system.name)
            rows = self.rows[letter] = detections.rows_of(row, row + 1)
            boxes = self.boxes[letter] = detections.of_frames(row, row + 1)
            self.state[letter] = system.matches.state[rows]
            nearest = system.nearest.truth[self.rows["truth"]]
            self.terms[letter] = miss_terms(self.truth, self.k_miss, nearest, frames, edge_weight)
            self.det_border[letter] = border_of(boxes, frames, edge_weight)

    @property
    def n_boxes(self) -> int:
        return len(self.truth) + sum(len(boxes) for boxes in self.boxes.values())

    @cached_property
    def overlaps(self) -> dict[str, np.ndarray]:
        """IoU of each truth box with each detection, by system, shape (n_truth, n_det)."""
        x, y, w, h = (values[:, np.newaxis] for values in self.truth.xywh)
        return {
            letter: iou_of_pairs((x, y, w, h), boxes.xywh) for letter, boxes in self.boxes.items()
        }

    def name(self, i: int) -> str:
        track = int(self.result.tracks.track[self.rows["truth"]][i])
        noun = self.result.objects.singular
        return f"this {noun}" if track < 0 else f"{noun} {track}"

    def is_matched(self, letter: str, i: int) -> bool:
        return bool(self.truth_state[letter][i] == TruthState.MATCHED)

    def nearest(self, letter: str, i: int) -> float:
        """Return a pedestrian's distance to the system's nearest detection, px, or infinity."""
        return float(self.result.system(letter).nearest.truth[self.rows["truth"]][i])

    def loss(self, letter: str, i: int) -> float:
        """Return the similarity that a pedestrian costs if no other one costs more."""
        return self.result.params.alpha * float(self.terms[letter][i]) / self.half_width

    def missed(self, letter: str) -> np.ndarray:
        is_missed: np.ndarray = self.truth_state[letter] == TruthState.MISSED
        return is_missed

    def worst(self, letter: str) -> int:
        """Return the pedestrian with the largest term."""
        row = int(self.result.system(letter).distances.salient_row[self.row])
        return NOBODY if row < 0 else row - self.rows["truth"].start


def _pedestrian(frame: _Frame, i: int) -> BoxReason:
    truth, k = frame.truth, float(frame.k[i])
    if truth.ignore[i]:
        return BoxReason(
            "Ignored by the ground truth",
            ("Detecting it is neither right nor wrong; detections on it count for nothing.",),
        )
    missed = " and ".join(letter.upper() for letter in "xy" if frame.missed(letter)[i])
    name, is_near = frame.name(i), frame.is_relevant[i]
    outcome = f"missed by {missed}" if is_near else f"too far to count, not detected by {missed}"
    title = f"{capitalised(name)}: {outcome if missed else 'detected by X and Y'}"
    distance = f", {truth.distance_m[i]:.0f} m away" if np.isfinite(truth.distance_m[i]) else ""
    counts = "counts" if is_near else "does not count as a miss"
    lines = [
        f"{truth.h[i]:.0f} px tall{distance}: weight {k:.2f}, {counts} (from {RELEVANT_K:g})",
        *(f"{_what_system_did(frame, letter, i)}{_cost(frame, letter, i)}" for letter in "xy"),
        *_mark(frame, i),
    ]
    encounter = int(frame.result.encounters.encounter_of[frame.rows["truth"]][i])
    if encounter != NOBODY and frame.is_relevant[i]:
        lines += [_failure(frame.result, letter, encounter) for letter in "xy"]
    return BoxReason(title, tuple(lines), encounter, int(frame.tracks[i]))


def _what_system_did(frame: _Frame, letter: str, i: int) -> str:
    """Describe the detection that matches the pedestrian, or those next to a missed one."""
    system, params, name = frame.result.system(letter), frame.result.params, letter.upper()
    overlaps, states = frame.overlaps[letter][i], frame.state[letter]
    match = int(system.matches.truth_det[frame.rows["truth"]][i])
    nearest = frame.nearest(letter, i)
    if match >= 0:
        j = match - frame.rows[letter].start
        score = number(float(frame.boxes[letter].score[j]), ".2f")
        return f"{name}: detected, score {score}, IoU {overlaps[j]:.2f}"
    text = f"{name}: not detected"
    if np.isfinite(nearest):
        text += f", {nearest:.0f} px to the nearest detection"
    elif params.pairing != "matched":
        text = f"{name}: no detection that counts in this frame"
    if params.match != "iou" or not overlaps.any():
        return text
    best = int(np.argmax(overlaps))
    if overlaps[best] < params.iou:
        return f"{text}; best IoU {overlaps[best]:.2f}, a match needs {params.iou:g}"
    if states[best] == DetectionState.BELOW:
        return (
            f"{text}; one with IoU {overlaps[best]:.2f} has score "
            f"{number(float(frame.boxes[letter].score[best]), '.2f')}, below the threshold of "
            f"{number(system.threshold, '.2f')}"
        )
    somebody = frame.result.objects.say("{somebody}")
    return f"{text}; the one with IoU {overlaps[best]:.2f} is matched to {somebody} else"


def _cost(frame: _Frame, letter: str, i: int) -> str:
    """Describe the similarity that this pedestrian costs, or would cost if others cost less."""
    params, nearest = frame.result.params, frame.nearest(letter, i)
    loss, worst = frame.loss(letter, i), frame.worst(letter)
    if loss < SMALL:
        return ""
    px = min(frame.border[i], nearest)
    share = f"{px:.0f} of {frame.half_width:.0f} px"
    weight = f"weight {frame.k[i]:.2f}" + "".join(
        f" × {label} {factor[i]:.2f}" for label, factor in frame.factors.items() if factor[i] != 1
    )
    how = f"alpha {params.alpha:g} × {weight} × {share}"
    if worst in (i, NOBODY):
        return f". Takes {loss:.3f} of {letter.upper()}'s similarity: {how}"
    if frame.is_matched(letter, i):
        return ""
    return (
        f". Would take {loss:.3f} of {letter.upper()}'s similarity ({how}), but "
        f"{frame.name(worst)} takes {frame.loss(letter, worst):.3f}, and only the largest is taken"
    )


def _mark(frame: _Frame, i: int) -> list[str]:
    """Explain the triangle on this pedestrian."""
    letters = [letter.upper() for letter in "xy" if frame.is_salient[letter][i]]
    if not letters:
        return []
    text = f"▼ Costs {' and '.join(letters)} the most in this frame"
    if frame.is_relevant[i]:
        return [text]
    somebody = frame.result.objects.say("{somebody}")
    return [f"{text}. The mark goes by cost alone: also {somebody} too far to count can have it"]


def _failure(result: Result, letter: str, encounter: int) -> str:
    """Describe the system's performance in the whole encounter."""
    system, name = result.system(letter), letter.upper()
    kind = MissClass(system.encounters["miss_class"].iloc[encounter])
    text = result.objects.say(MISS_CLASS_TEXT[kind]).rstrip(".")
    text = f"{name} in the whole encounter: {text[0].lower()}{text[1:]}"
    return f"{text}; severity {float(system.failures['severity_s'].iloc[encounter]):.2f} s"


def _detection(frame: _Frame, letter: str, j: int) -> BoxReason:
    result, system, name = frame.result, frame.result.system(letter), letter.upper()
    boxes, rows = frame.boxes[letter], frame.rows[letter]
    state = DetectionState(frame.state[letter][j])
    score = number(float(boxes.score[j]), ".2f")
    size = f"Score {score}, {boxes.h[j]:.0f} px tall"
    if state == DetectionState.ABSORBED:
        return BoxReason(
            f"Detection of {name} on an ignored region", (size, "It counts for nothing")
        )
    k, nearest = float(system.weights.k[rows][j]), float(system.nearest.detections[rows][j])
    border = float(frame.det_border[letter][j])
    lines = [f"{size}, weight {k:.2f}"]
    overlaps = frame.overlaps[letter][:, j]
    truth = int(system.matches.det_truth[rows][j])
    loss = (1 - result.params.alpha) * k * min(border, nearest) / frame.half_width
    if truth >= 0:
        i = truth - frame.rows["truth"].start
        lines.append(f"IoU {overlaps[i]:.2f} with {frame.name(i)}")
        encounter = int(result.encounters.encounter_of[truth])
        title = f"Detection of {name}: matches {frame.name(i)}"
        return BoxReason(title, tuple(lines), encounter, int(frame.tracks[i]), i)
    noun, nobody = result.objects.singular, result.objects.say("{nobody}")
    away = f"{nearest:.0f} px to the nearest {noun}" if np.isfinite(nearest) else f"{nobody} there"
    best = f"; best IoU {overlaps.max():.2f}" if len(overlaps) and overlaps.any() else ""
    lines.append(f"Matches {nobody}: {away}{best}")
    lines.append(
        f"Costs {loss:.3f} of {name}'s similarity, if no other false alarm costs more"
        if loss >= SMALL
        else f"Takes nothing of {name}'s similarity"
    )
    return BoxReason(f"Detection of {name}: false alarm", tuple(lines))
