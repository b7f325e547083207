"""Records of how the detectability of a dataset was estimated.

    {"written_by": "nvcore 0.1.0",
     "estimator": {"name": "driver", "fingerprint": "5f1c...", "simulated": "all",
                   "n_subjects": 12, "no_better_at_s": [0.5]},
     "estimates": {"n": 1557, "n_light_unknown": 821, "outside": {"Height": 12}},
     "settings": {"light": {"drop_factor": 10.0}},
     "files": {"detectability.csv": "9e07..."}}

Missing entries are unknown. Additional entries are ignored.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from nvcore.common.records import read_record, values_of
from nvcore.common.wording import MOST_NAMED, listed, one_line, shortened
from nvcore.notes import Note, phrase
from nvcore.settings.objects import PEDESTRIAN

SIMULATED: Final = ("no", "some", "all", "")
"""Values for the share of subjects with simulated answers. Empty: unknown."""
SEARCHES: Final = ("", "quick")
"""Values for the search for features and settings. Empty: default or unknown."""
_MOST: Final = 2**53
_SHOWN_NAME: Final = 40
_PARTS: Final = {
    "written_by": str,
    "files": Mapping[str, str],
    **dict.fromkeys(("estimator", "estimates", "settings"), Mapping[str, object]),
}
_OF_PARTS: Final[dict[str, dict[str, Any]]] = {
    "estimator": {
        **dict.fromkeys(("name", "fingerprint", "simulated", "search"), str),
        "n_subjects": int,
        "no_better_at_s": tuple[float, ...],
        "of_no_use": bool,
    },
    "estimates": {
        **dict.fromkeys(("n", "n_light_unknown"), int),
        **dict.fromkeys(("outside", "other_width"), Mapping[str, int]),
        **dict.fromkeys(("light_doubts", "picture_doubts"), Mapping[str, str]),
    },
    "settings": {"light": Mapping[str, object]},
}


@dataclass(frozen=True)
class EstimateRecord:
    """Record of how detectability was estimated.

    Attributes
    ----------
    name
        Name of the estimator. Empty: unknown.
    fingerprint
        Fingerprint of the training data or of the model. Empty: unknown.
    simulated
        Share of training subjects with simulated answers: ``no``, ``some``, ``all``. Empty:
        unknown.
    n_subjects
        Number of subjects. 0: unknown.
    files
        sha256 of each described file, by name.
    written_by
        Program and version that wrote the record.
    light
        Criteria for a change of light (`nvcore.subjects.driver.illumination.LightSettings`), as
        written, without validation. Empty: unknown.
    n_estimates, n_light_unknown
        Numbers of estimates of the run in total, and in frames for which the last change of light
        was unknown. 0: unknown.
    outside
        Number of estimates with a feature outside the training range, by feature name.
    no_better_at_s
        Adaptation periods at which the estimator was no better than a constant on unseen
        pedestrians. Empty: none, or unknown.
    of_no_use
        Whether the estimator was no better than a constant over all periods, either.
    search
        ``quick`` if fewer settings than by default were tried in the training, else empty.
    other_width
        Picture width, px, of recordings whose width differs from that of the training, by name.
    light_doubts
        Signs of another unit or clock of the light meter, by recording name.
    picture_doubts
        Signs that pictures or gaze belong to another recording, by recording name.
    estimated_in, stated_in
        Names of the dataset's recordings with estimates, and with values of the ground truth. They
        are not part of the record file.
    """

    name: str = ""
    fingerprint: str = ""
    simulated: str = ""
    n_subjects: int = 0
    files: Mapping[str, str] = field(default_factory=dict)
    written_by: str = ""
    light: Mapping[str, object] = field(default_factory=dict)
    n_estimates: int = 0
    n_light_unknown: int = 0
    outside: Mapping[str, int] = field(default_factory=dict)
    no_better_at_s: tuple[float, ...] = ()
    of_no_use: bool = False
    search: str = ""
    other_width: Mapping[str, int] = field(default_factory=dict)
    light_doubts: Mapping[str, str] = field(default_factory=dict)
    picture_doubts: Mapping[str, str] = field(default_factory=dict)
    estimated_in: frozenset[str] = field(default=frozenset(), compare=False)
    stated_in: frozenset[str] = field(default=frozenset(), compare=False)

    def __post_init__(self) -> None:
        if self.simulated not in SIMULATED:
            raise ValueError(f"simulated: expected no, some or all, found {self.simulated!r}")
        if self.search not in SEARCHES:
            raise ValueError(f"search: expected quick, or none, found {self.search!r}")
        _check_counts("n_subjects", [self.n_subjects])
        _check_counts("n", [self.n_estimates])
        _check_counts("n_light_unknown", [self.n_light_unknown], most=self.n_estimates)
        _check_counts("outside", self.outside.values(), most=self.n_estimates)
        _check_counts("other_width", self.other_width.values())

    @property
    def made_by(self) -> str:
        """Description of the estimator in a few words, "" if unknown."""
        if not self.name:
            return ""
        note = Note(
            "driver.made_by",
            name=shortened(one_line(self.name), _SHOWN_NAME),
            n_subjects=self.n_subjects,
            fingerprint=one_line(self.fingerprint[:12]),
        )
        return phrase(note, PEDESTRIAN)

    @property
    def caution(self) -> str:
        """Doubts about subjects, training, pictures and light of the estimates, or empty."""
        notes = []
        if self.search or self.simulated in ("all", "some"):
            notes.append(Note("driver.learnt", simulated=self.simulated, search=self.search))
        if self.of_no_use or self.no_better_at_s:
            periods = listed([f"{period:g}" for period in self.no_better_at_s], most=MOST_NAMED)
            notes.append(Note("driver.no_better", at_s=None if self.of_no_use else periods))
        for key, named in (
            ("driver.in_other_width", self.other_width),
            ("driver.in_doubtful_light", self.light_doubts),
            ("driver.in_doubtful_pictures", self.picture_doubts),
        ):
            if named:
                short = [shortened(one_line(name), _SHOWN_NAME) for name in named]
                notes.append(Note(key, names=listed(short, most=MOST_NAMED)))
        return listed([phrase(note, PEDESTRIAN) for note in notes])


def _check_counts(name: str, counts: Iterable[int], most: int = _MOST) -> None:
    if not all(0 <= n <= most for n in counts):
        raise ValueError(f"{name}: expected 0 to {most}")


def estimate_json(record: EstimateRecord) -> bytes:
    """Serialize the record as JSON. Equal records give equal bytes."""
    stated = ("name", "fingerprint", "simulated", "n_subjects")  # entries that every record has

    def known(*names: str) -> dict[str, object]:  # earlier records lack these entries
        return {name: value for name in names if (value := getattr(record, name))}

    estimates: dict[str, object] = {"n": record.n_estimates}
    estimates |= {"n_light_unknown": record.n_light_unknown, "outside": record.outside}
    content = {
        "written_by": record.written_by,
        "estimator": {name: getattr(record, name) for name in stated}
        | known("no_better_at_s", "of_no_use", "search"),
        "estimates": estimates | known("other_width", "light_doubts", "picture_doubts"),
        "files": record.files,
    }
    return (json.dumps(content, indent=1) + "\n").encode()


def read_estimate_record(path: Path, name: str) -> EstimateRecord:
    """Read a record of how detectability was estimated from a JSON file.

    Parameters
    ----------
    name
        File name as given by the user.

    Raises
    ------
    InputError
        If the file cannot be opened, or any part of the record is invalid.
    """
    expected = "expected the record that nvcore driver estimate writes (docs/driver-reference.md)"
    return read_record(path, name, _record, expected=expected)


def _record(content: object) -> EstimateRecord:
    record = values_of(_PARTS, content, "", known_only=False)
    for name, types in _OF_PARTS.items():
        record |= values_of(types, record.pop(name, {}), name, known_only=False)
    return EstimateRecord(n_estimates=record.pop("n", 0), **record)
