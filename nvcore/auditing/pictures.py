"""Findings on the assignment of pictures to frames.

No measure depends on pictures. The codes begin with `nvcore.common.findings.OF_PICTURES`. The
import needs the extra ``report``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.common.findings import (
    OF_PICTURES,
    Cases,
    Finding,
    Remedy,
    Severity,
    Step,
    accepted,
    worst_first,
)
from nvcore.common.wording import capitalised, count_text, one_line
from nvcore.dataset import Dataset
from nvcore.inputs.recordings import is_missing
from nvcore.inputs.session import Session
from nvcore.pictures.index import NumberingRule, is_of_other_shape, why_unclear
from nvcore.pictures.notes import MAY_MISLEAD, PictureTrait
from nvcore.pictures.recordings import RecordingPictures

_MOST_STEPS: Final = 4
_MOST: Final = 0.5
"""Share of a recording's frames without a picture that makes it an error."""
_NO_NUMBERS: Final = "No measure depends on pictures."
_LOOK: Final = "Look at a frame with quick movement, whether boxes and {many} lie together."

_ADVICE: Final = {
    PictureTrait.CUT: "Copy or convert it again, best from the original. The frames that can be "
    "read are shown.",
    PictureTrait.GAP: "Frames are found by their times where their numbers go so far; else picture "
    f"i shows frame i, as in programs that decode the video. {_LOOK}",
    PictureTrait.UNEVEN: "Picture i shows frame i. If the frames were numbered by time, convert "
    f"the video to a constant rate. {_LOOK}",
    PictureTrait.REPEATED: "Each counts as a picture, as in a player. OpenCV passes over them: if "
    f"it numbered the frames, later pictures lag behind their boxes. {_LOOK}",
    PictureTrait.OTHER_STREAMS: "If another camera is meant, save its stream as a file of its own.",
    PictureTrait.PASSED_OVER: "There is nothing to do, unless a frame of the recording is among "
    "them.",
    PictureTrait.FURTHER_PAGES: "If they are other frames, save each page as a file.",
}


@dataclass(frozen=True)
class _Case:
    """Case of a finding on the pictures of one recording."""

    severity: Severity
    kind: str
    recording: str
    text: str
    advice: str
    file: str = ""
    rows: tuple[int, ...] | np.ndarray = ()
    steps: tuple[Step, ...] = ()


def audit_pictures(dataset: Dataset, opened: RecordingPictures) -> tuple[Finding, ...]:
    """Return the findings on the pictures of all recordings, worst first, without decoding any.

    Several recordings with the same problem are one finding.
    """
    alike: dict[tuple[Severity, str], list[_Case]] = defaultdict(list)
    for case in _cases(dataset, opened):
        alike[case.severity, case.kind].append(case)
    findings = map(_finding, alike.values())
    return worst_first(accepted(findings, dataset.settings.accept))


def _finding(cases: list[_Case]) -> Finding:
    first, n_more = cases[0], len(cases) - 1
    more = f" The same goes for {count_text(n_more, 'more recording')}." if n_more else ""
    rows = np.concatenate([np.asarray(case.rows, dtype=np.int64) for case in cases])
    steps = [step for case in cases for step in case.steps]
    return Finding(
        first.severity,
        f"{OF_PICTURES}{first.kind}",
        f"pictures of {one_line(first.recording)}",
        len(rows) or len(cases),
        f"{capitalised(first.text)}.{more}",
        first.advice,
        file=first.file,
        example=f"recording {first.recording}",
        cases=Cases("frames", rows) if len(rows) else None,
        steps=tuple(steps[:_MOST_STEPS]),
    )


def _cases(dataset: Dataset, opened: RecordingPictures) -> Iterator[_Case]:
    names = [str(name) for name in dataset.recordings["name"]]
    session = dataset.settings
    entries = session.entries(names) if isinstance(session, Session) else {}
    for number, name in enumerate(names):  # a loop over recordings: at most hundreds
        if number in opened.sources:
            yield from _of_frames(dataset, opened, number, name)
            for note in opened.sources[number].notes:
                yield _Case(
                    Severity.WARNING if note.trait in MAY_MISLEAD else Severity.NOTE,
                    note.trait.value.replace(" ", "-"),
                    name,
                    note.text,
                    dataset.objects.say(_ADVICE[note.trait]),
                    file=opened.sources[number].name,
                )
        elif number in opened.notes:
            path = entries[name].pictures if name in entries else None
            # missing ones are a finding of the inputs
            if path is None or not isinstance(session, Session) or not is_missing(session, path):
                yield _Case(
                    Severity.ERROR,
                    "unreadable",
                    name,
                    f"they cannot be opened. {one_line(opened.notes[number]).rstrip('.')}",
                    f"Boxes are drawn on a blank until they can. {_NO_NUMBERS}",
                    file=path or "",
                    steps=opened.steps.get(number, ()),
                )


def _of_frames(
    dataset: Dataset, opened: RecordingPictures, number: int, name: str
) -> Iterator[_Case]:
    """Yield the cases about the pictures for the frames of one recording."""
    frames, source = dataset.frame_columns, opened.sources[number]
    listed_frames = frames.frame[frames.rows_of(number)]
    mapped, file = opened.frame_maps.get(number), source.name
    without = np.flatnonzero(opened.indices[number] < 0)
    rows = frames.first[number] + without
    first_picture = (Step(Remedy.FIRST_PICTURE, subject=name),)
    if mapped is not None and mapped.rule is NumberingRule.UNCLEAR:
        yield _Case(
            Severity.ERROR,
            "unclear",
            name,
            "which of them shows which frame is not clear, and none is shown. "
            f"{capitalised(why_unclear(listed_frames, source))}",
            f"{_NO_NUMBERS} Name the pictures by the numbers of their frames; or say which frame "
            "the first one shows, if the next ones show the next numbers.",
            file=file,
            rows=rows,
            steps=first_picture,
        )
    elif len(without):
        is_most = len(without) >= _MOST * len(listed_frames)
        yield _Case(
            Severity.ERROR if is_most else Severity.WARNING,
            "missing",
            name,
            f"{len(without):,} of {len(listed_frames):,} evaluated frames have none, first frame "
            f"{listed_frames[without[0]]}; there are {count_text(source.n, 'picture')}",
            f"{_NO_NUMBERS} Check that these are the pictures of this recording, all of them, and "
            "at its rate.",
            file=file,
            rows=rows,
            steps=first_picture if is_most else (),
        )
    if mapped is not None and mapped.rule in (NumberingRule.ORDER, NumberingRule.ORDER_FROM_ZERO):
        are_numbered = source.numbers is not None
        shown = (
            f"there are as many as evaluated frames, {source.n:,}: they show these in their order"
            if mapped.rule is NumberingRule.ORDER
            else "in their order they show frame 0, 1, 2 and so on"
        )
        why = (
            f"the numbers in their names are not those of the frames ({listed_frames[0]} to "
            f"{listed_frames[-1]})"
            if are_numbered
            else "no numbers of frames are in their names"
        )
        is_sure = mapped.rule is NumberingRule.ORDER or not are_numbered
        yield _Case(
            Severity.NOTE if is_sure else Severity.WARNING,
            "in-order",
            name,
            shown if source.is_video else f"{shown}, as {why}",
            dataset.objects.say(_LOOK),
            file=file,
            steps=() if is_sure else first_picture,
        )
    if mapped is not None and mapped.is_either:
        other = "minus one" if mapped.rule is NumberingRule.NUMBER else "as they are"
        yield _Case(
            Severity.NOTE,
            "either",
            name,
            f"the numbers in their names would fit the frames {other} as well",
            dataset.objects.say(_LOOK),
            file=file,
            steps=first_picture,
        )
    width, height = float(frames.width[number]), float(frames.height[number])
    if is_of_other_shape(source, width, height):
        yield _Case(
            Severity.WARNING,
            "other-shape",
            name,
            f"they are {source.width} x {source.height} px, of another shape than the recording's "
            f"{width:g} x {height:g} px",
            "Boxes are drawn scaled. Check that pictures and recording belong together, and the "
            "size given.",
            file=file,
        )
