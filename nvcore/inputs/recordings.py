"""Size, frame rate and horizon of every recording: from the data, or as given."""

from __future__ import annotations

import glob
import os
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.file_kinds import as_stored
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.common.wording import MOST_NAMED, count_text, did_you_mean, listed
from nvcore.inputs.evaluated_frames import MIN_SAMPLED
from nvcore.inputs.readers.base import Reading, rows_finding, warning
from nvcore.inputs.session import Session
from nvcore.settings.defaults import is_chosen

MOST_SIGNS: Final = 1000
"""Longest name of a recording, since names are shown and used as file names."""
SINGLE: Final = 2
"""Largest number of frames of a recording that is rather single pictures."""
MIN_SINGLE: Final = 5
"""Number of recordings from which on it is no coincidence that most are single pictures."""
MAX_GAPS: Final = 0.1
"""Share of steps between label files up to which longer ones are gaps."""
NO_BOX: Final = (
    "no frame is evaluated: the ground truth holds no box (only a header, or other classes?). "
    "Check that it is the right file, and which classes count; if there is no {one} in it, "
    "say which frames are evaluated"
)
NO_BOX_STEPS: Final = (Step(Remedy.CLASSES), Step(Remedy.FRAMES))


def check_names(reading: Reading) -> None:
    """Refuse names of recordings that cannot be intended.

    Raises
    ------
    InputError
        If one is longer than `MOST_SIGNS`.
    """
    longest = max(reading.recordings["name"], key=len, default="")
    if len(longest) > MOST_SIGNS:
        raise InputError(
            f"a recording's name has {len(longest):,} signs, expected {MOST_SIGNS:,} at the most: "
            f"{longest[:30]!r} ..."
        )


def contradicted_facts(truth: Reading, recordings: pd.DataFrame) -> list[Finding]:
    """Report given sizes and frame rates that contradict the data."""
    stated = truth.recordings.set_index("name").reindex(recordings["name"])
    findings = []
    for columns, quantity in ((["width", "height"], "image size"), (["fps"], "frame rate")):
        ours, theirs = recordings[columns].to_numpy(), stated[columns].to_numpy(dtype=float)
        # a rate is rounded here, measured there
        is_same = np.isclose(ours, theirs, rtol=0.01 if columns == ["fps"] else 0, atol=0)
        differs = (np.isfinite(theirs) & ~is_same).any(axis=1)
        if not differs.any():
            continue
        first = int(np.argmax(differs))
        given_text, stated_text = ("x".join(f"{v:g}" for v in row[first]) for row in (ours, theirs))
        findings.append(
            warning(
                "contradicted-fact",
                int(np.count_nonzero(differs)),
                f"The {quantity} given ({given_text}) is not that of the data ({stated_text}).",
                "Do not give it where the data hold it.",
                role="truth",
                example=f"recording {recordings['name'].iloc[first]}",
            )
        )
    return findings


def is_missing(session: Session, path: str) -> bool:
    """Whether a session's path does not exist, or the folder of its pattern does not."""
    place = session.folder / path
    # os.path: Path.exists raises for names that no file can have
    if glob.has_magic(place.name) and not os.path.exists(place):  # noqa: PTH110
        place = place.parent
    return not os.path.exists(as_stored(place))  # noqa: PTH110


def missing_pictures(session: Session, names: Sequence[str]) -> list[Finding]:
    """Report missing pictures that the session names for recordings."""
    missing = [
        (path, f"recording {name}")
        for name, entry in session.entries(list(names)).items()
        for path in (entry.pictures, entry.visible)
        if path is not None and is_missing(session, path)
    ]
    return rows_finding(
        np.ones(len(missing), dtype=bool),
        "missing-pictures",
        f"{count_text(len(missing), 'recording has', 'recordings have')} pictures named that "
        "are not there: no file or folder has that path.",
        "Correct the path, which starts from the folder of the file that names it. The numbers "
        "need no pictures.",
        role="truth",
        place=missing.__getitem__,
    )


def single_frames(truth: Reading, names: Sequence[str], n_frames: np.ndarray) -> list[Finding]:
    """Report many recordings of one or two frames, a sign of misinterpreted picture names.

    Parameters
    ----------
    names, n_frames
        Names of the recordings and their numbers of evaluated frames, int64, shape (n,).
    """
    if truth.named is None or len(names) < MIN_SINGLE:
        return []
    of_names = {*truth.named.recording}
    is_single = (n_frames <= SINGLE) & np.array([name in of_names for name in names])
    if 2 * is_single.sum() <= len(names):
        return []
    first = str(names[int(np.argmax(is_single))])
    of_first = truth.named.table["recording"] == first
    return [
        Finding(
            Severity.ERROR,
            "single-frames",
            TRUTH_NAME,
            int(is_single.sum()),
            f"{is_single.sum()} of {len(names)} recordings have one or two frames each; the names "
            "of pictures tell recordings and frames.",
            "A camera, a date or a part of a hash may have been taken for the frame number: say "
            "how the names are meant. Single pictures are no fault.",
            file=str(truth.named.table["name"][of_first].iloc[0]),
            example=f"recording {first}",
            steps=(
                Step(Remedy.FRAME_NAMES, "counter"),
                Step(Remedy.FRAME_NAMES, "order"),
                Step(Remedy.ACCEPT, "single-frames"),
            ),
        )
    ]


def missing_label_files(names: Sequence[str], frames: Sequence[np.ndarray]) -> list[Finding]:
    """Report gaps between label files whose frame numbers otherwise rise in equal steps.

    Parameters
    ----------
    names, frames
        Names of the recordings, and the evaluated frames of each.
    """
    gaps = []
    for name, numbers in zip(names, frames, strict=True):
        steps = np.diff(numbers)
        usual = int(np.median(steps)) if len(steps) >= MIN_SAMPLED else 0
        is_gap = steps > usual
        if usual and 0 < is_gap.mean() <= MAX_GAPS and not (steps % usual).any():
            n_missing = int((steps[is_gap] // usual - 1).sum())
            first = int(numbers[np.argmax(is_gap)]) + usual
            gaps.append((name, n_missing, first, f"{numbers[0]}:{numbers[-1]}:{usual}"))
    if not gaps:
        return []
    name, _, first, span = gaps[0]
    n_missing = sum(gap[1] for gap in gaps)
    return [
        warning(
            "missing-label-files",
            n_missing,
            f"{count_text(n_missing, 'frame has', 'frames have')} no label file, although those "
            "before and after have: what is detected there is left out.",
            "If nobody is there, evaluate these frames, too: detections are then false alarms.",
            role="truth",
            example=f"recording {name}, frame {first}",
            steps=(Step(Remedy.FRAMES, span.removesuffix(":1") if len(names) == 1 else ""),),
        )
    ]


def check_listed(session: Session, truth: Reading) -> None:
    """Refuse a recording in a table that has neither ground truth nor evaluated frames.

    Raises
    ------
    InputError
        If there is one, with the line.
    """
    table = session.recordings_file
    if table is None or table.line_of is None or session.frames is not None:
        return
    names = truth.recordings["name"].tolist()
    entries = session.entries(names)
    for name, line in table.line_of.items():
        if name in entries and name not in names and entries[name].frames is None:
            raise InputError(no_such_recording(name, names), file=table.path, line=line)


def no_such_recording(name: str, names: Sequence[str]) -> str:
    """Explain, for an error, that the ground truth lacks a recording of a table."""
    known = f"its recordings are {listed(names, most=MOST_NAMED)}"
    return (
        f"there is no recording {name!r} in the ground truth; "
        f"{did_you_mean(name, names, known)}. One without boxes needs its evaluated "
        "frames, as frames in a session file"
    )


def describe_recordings(
    session: Session, chosen: Session, truth: Reading
) -> tuple[pd.DataFrame, list[bool]]:
    """Make the table of recordings: name, width, height, fps, horizon, context, and so on.

    Also return whether `chosen` compares each recording. The others are left out later, so their
    size or frame rate is 1 if it is unknown.

    Raises
    ------
    MissingFactError
        If a size or a frame rate of a recording that is compared is unknown.
    """
    table = truth.recordings.copy()
    entries = session.entries(table["name"].tolist())
    known = set(table["name"])
    more = [name for name in entries if name not in known]
    if more:
        extra = pd.DataFrame({"name": more, "width": np.nan, "height": np.nan, "fps": np.nan})
        table = pd.concat([table, extra], ignore_index=True)
    if table.empty:
        raise InputError(
            session.objects.say(NO_BOX), file=session.truth.path[0], steps=NO_BOX_STEPS
        )
    own = [entries.get(name) for name in table["name"]]
    width, height = session.size or (None, None)
    of_all = {"width": width, "height": height, "fps": session.fps}
    for column in ("width", "height", "fps", "horizon", "context", "speed_kmh"):
        values = [getattr(entry, column, None) for entry in own]
        common = of_all.get(column)
        given = pd.Series([common if value is None else value for value in values], dtype=float)
        table[column] = given.fillna(table[column]) if column in table else given
    tags = [getattr(entry, "tags", ()) for entry in own]
    units = [getattr(entry, "unit", None) or "" for entry in own]
    compared = [
        is_chosen(*of, chosen.only_tags, chosen.only)
        for of in zip(table["name"], tags, strict=True)
    ]
    _check_known(table[compared], entries)
    facts = ["width", "height", "fps"]
    table[facts] = table[facts].astype(float).fillna(1.0)
    table = table.assign(tags=pd.Series(tags, dtype=object), unit=pd.Series(units, dtype=object))
    return table, compared


def _check_known(table: pd.DataFrame, entries: Collection[str]) -> None:
    """Raise one error that names all unknown facts of the first incomplete recording.

    Parameters
    ----------
    entries
        Names of the recordings that the session describes.
    """
    is_unknown = ~(table[["width", "height", "fps"]].to_numpy(dtype=float) > 0)
    is_incomplete = is_unknown.any(axis=1)
    if not is_incomplete.any():
        return
    first = int(np.argmax(is_incomplete))
    size, fps = bool(is_unknown[first, :2].any()), bool(is_unknown[first, 2])
    quantities = " and ".join(["image size"] * size + ["frame rate"] * fps)
    keys = {(True, True): "width, height and fps", (True, False): "width and height"}
    n_others = int(np.count_nonzero(is_incomplete)) - 1
    others = f" (nor those of {n_others} more)" if n_others else ""
    name = table["name"].iloc[first]
    unnamed = way_out = ""
    if entries and name not in entries:
        unnamed = ": it is in the ground truth, but not in the session's [[recording]] entries"
        way_out = "; or compare only some: recordings = [NAME] under [compare] in the session file"
    raise MissingFactError(
        f"the {quantities} of recording {name!r} {'are' if size and fps else 'is'} not in the "
        f"data{others}{unnamed}; the session file can state {keys.get((size, fps), 'fps')}"
        f"{way_out}",
        facts=(*["size"] * size, *["fps"] * fps),
    )
