"""How the detectability of a dataset was estimated, as the record beside the file says.

    {"written_by": "nvcore 0.1.0", "model": "driver.npz", "fingerprint": "5f1c...",
     "simulated": "all", "n_subjects": 12}

Every entry may be missing: it is not known then.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from nvcore.errors import FormatError, InputError
from nvcore.wording import one_line, shortened

MAX_BYTES: Final = 1 << 20
SIMULATED: Final = ("no", "some", "all", "")
"""Of how many subjects the answers were simulated; empty: not known."""
_EXPECTED: Final = "expected the record that nvcore driver estimate writes (docs/driver.md)"
_SHOWN_NAME: Final = 40


@dataclass(frozen=True)
class EstimateRecord:
    """How detectability was estimated.

    Attributes
    ----------
    model
        Name of the estimator's model; empty: not known.
    fingerprint
        sha256 of the model; empty: not known.
    simulated
        Whether the subjects from whose answers it was learnt were simulated: ``no``, ``some``,
        ``all``; empty: not known.
    n_subjects
        How many subjects; 0: not known.
    written_by
        Program and version.
    """

    model: str = ""
    fingerprint: str = ""
    simulated: str = ""
    n_subjects: int = 0
    written_by: str = ""

    def __post_init__(self) -> None:
        if self.simulated not in SIMULATED:
            raise ValueError(f"simulated: expected no, some or all, found {self.simulated!r}")
        if self.n_subjects < 0:
            raise ValueError(f"n_subjects: expected 0 or more, found {self.n_subjects}")

    @property
    def made_by(self) -> str:
        """The estimator in a few words; empty: not known."""
        if not self.model:
            return ""
        name = shortened(one_line(self.model), _SHOWN_NAME)
        known = one_line(self.fingerprint[:12])
        return f"estimated by {name}" + (f" (fingerprint {known})" if known else "")

    @property
    def caution(self) -> str:
        """Whose answers it rests on, where some were simulated; empty: none were, or unknown."""
        if self.simulated == "all":
            return "learnt from simulated subjects"
        return "learnt in part from simulated subjects" if self.simulated == "some" else ""


def estimate_json(record: EstimateRecord) -> bytes:
    """The record as JSON; the same record gives the same bytes."""
    return (json.dumps(asdict(record), indent=1) + "\n").encode()


def read_estimate_record(path: Path, name: str) -> EstimateRecord:
    """Read a record.

    Parameters
    ----------
    name
        Of the file, as the user gave it.

    Raises
    ------
    InputError
        If it cannot be opened, or is no such record.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(f"is larger than {MAX_BYTES >> 20} MiB; {_EXPECTED}", file=name)
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=name) from error
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not JSON: {error}; {_EXPECTED}", file=name) from error
    if not isinstance(content, dict):
        raise FormatError(f"expected an object; {_EXPECTED}", file=name)
    try:
        return EstimateRecord(**_fields(content))
    except ValueError as error:
        raise FormatError(f"{error}; {_EXPECTED}", file=name) from error


def _fields(content: dict[str, Any]) -> dict[str, Any]:
    """Those of its entries that a record has; ValueError for one of another type."""
    values = {}
    for key, default in asdict(EstimateRecord()).items():
        value = content.get(key, default)
        if not isinstance(value, type(default)) or isinstance(value, bool):
            kind = "a whole number" if isinstance(default, int) else "a text"
            raise ValueError(f"{key}: expected {kind}, found {str(value)[:30]!r}")
        values[key] = value
    return values
