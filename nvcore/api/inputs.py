"""Loading of inputs of every kind into a `Dataset` with its settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final, TypeVar

import pandas as pd

from nvcore.common.arguments import Part, PathLike, Size
from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.progress import Progress, no_progress
from nvcore.comparison.measures.table import choose_primary
from nvcore.dataset import Dataset
from nvcore.inputs.facts import frames_from, objects_named, size_from
from nvcore.inputs.files.pipes import pipes_kept
from nvcore.inputs.load import load as load_session
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.recordings_file import with_facts
from nvcore.inputs.session.toml import read_session
from nvcore.settings.defaults import OperatingPoint, Settings, operating_point
from nvcore.settings.params import params_from
from nvcore.settings.protocols import Protocol, protocol_from

Input = PathLike | Sequence[PathLike] | Source | pd.DataFrame
"""Ground truth or detections: files, folders or globs, a `Source` with settings, or a table."""

KEYWORDS: Final = {
    "size": "size=(WIDTH, HEIGHT)",
    "fps": "fps=FPS",
    "frames": 'frames="FIRST:LAST"',
}
"""Keyword arguments of facts that the data may lack, by the name of the fact."""

AnySettings = TypeVar("AnySettings", bound=Settings)


@pipes_kept()
def load(
    source: PathLike | Session | Dataset | None = None,
    /,
    *,
    truth: Input | None = None,
    x: Input | None = None,
    y: Input | None = None,
    size: Size | None = None,
    fps: float | None = None,
    frames: str | range | None = None,
    recordings: PathLike | None = None,
    codes: PathLike | None = None,
    name_x: str | None = None,
    name_y: str | None = None,
    protocol: str | Protocol | None = None,
    objects: str | Sequence[str] | None = None,
    primary: str | None = None,
    operating_point: OperatingPoint | None = None,
    **params: float | str | None,
) -> Dataset:
    """Read the inputs of a comparison.

    Parameters
    ----------
    source
        Session file, session, or loaded dataset. A loaded dataset only accepts changes of names,
        protocol, primary measure, operating point and params.
    truth, x, y
        Ground truth and detections, in place of `source`. Each is a file, folder or glob (or
        several), a `Source` or `SystemSource` with settings for reading, or a table with the
        columns of plain CSV: frame, x, y, w, h (pixels, 0-based), and optionally score, track,
        ignore, recording, distance_m, occlusion. Without `y` a single system can be audited.
    size
        (width, height) of all pictures, px, or a text such as "640x480". None: as in the data or
        the session.
    fps
        Frames per second of all recordings. None: as in the data or the session.
    frames
        Evaluated frames: a range, ``"first:last[:step]"`` with both ends included and either end
        optional, or a file with one number per line. None: as in the data or the session.
    recordings
        CSV file with one line per recording: its size, frame rate, traffic context, tags and
        pictures (docs/formats.md). None: the session's. `size` and `fps` take precedence over it.
    codes
        CSV file of coded stretches (docs/formats.md). None: the session's.
    name_x, name_y
        Names of X and Y. With a session they select two of its systems.
    protocol
        Selection of the pedestrians that the detection measures count, such as ``"reasonable"``.
    objects
        Kind of objects in the boxes, such as ``"speed sign"``. For kinds unknown to the program,
        the singular or (singular, plural). None: the session's, or else pedestrians.
    primary
        Measure for the decision, to be chosen before a verdict is seen, such as
        ``"mean_similarity"``. None: the session's, or severity per encounter.
    operating_point
        Handling of unequal false alarms of X and Y: numbers at the thresholds ``"as-set"``, or
        with one threshold moved to ``"equal-alarms"``. None: the session's, or as set. Claims
        refer to equal false alarms, unless the thresholds are those of products, ``"delivered"``.
    params
        Settings by name, such as ``alpha=0.8`` or ``threshold_x=0.5`` (see `nvcore.Params`). A
        threshold of None counts every detection.

    Returns
    -------
    Dataset
        Its settings are the session's thresholds, parameters, protocol and choice of X and Y, for
        `compare` and `audit`.

    Raises
    ------
    InputError
        If a file cannot be used, with file and line, or the row of a table counted from 0.
    MissingFactError
        If the size, the frame rate or the frames are needed and unknown.
    ParameterError
        If a setting is unknown, or a value is outside its range.

    Examples
    --------
    >>> dataset = load("sample_data/session.toml")  # doctest: +SKIP
    >>> dataset.systems  # doctest: +SKIP
    ('FIR', 'NIR')
    """
    inputs = {"truth": truth, "x": x, "y": y}
    if isinstance(source, Dataset):
        facts = {"size": size, "fps": fps, "frames": frames, "recordings": recordings}
        facts["codes"] = codes
        given = {**inputs, **facts, "objects": objects}
        refuse_for_loaded([name for name, value in given.items() if value is not None])
        settings = with_choices(source.settings, name_x, name_y, protocol, primary, operating_point)
        return with_params(source.with_settings(settings), params)
    if (source is None) == all(value is None for value in inputs.values()):
        raise InputError("expected a session file, or truth=, x= and y=; give one of the two")
    tables: Mapping[Source, pd.DataFrame] = {}
    if source is None:
        session, tables = _session_of(inputs, (name_x, name_y))
        name_x = name_y = None  # the systems have these names already
    else:
        session = source if isinstance(source, Session) else read_session(Path(source))
    session = with_facts(
        session,
        recordings=recordings,
        codes=codes,
        objects=objects_named(objects),
        size=size_from(size),
        fps=fps,
        frames=frames_from(frames),
    )
    session = with_choices(session, name_x, name_y, protocol, primary, operating_point)
    with keywords_named():
        return with_params(load_session(session, tables=tables), params)


@contextmanager
def keywords_named() -> Iterator[None]:
    """Add the Python keywords that supply missing facts to the errors about them."""
    try:
        yield
    except MissingFactError as error:
        keywords = ", ".join(KEYWORDS[fact] for fact in error.facts)
        hint = f" (in Python: {keywords})" if keywords else ""
        raise MissingFactError(
            error.message + hint,
            file=error.file,
            line=error.line,
            facts=error.facts,
            steps=error.steps,
        ) from error


def load_part(
    source: PathLike | Session | Dataset, part: Part, *, progress: Progress = no_progress
) -> tuple[Dataset, Session]:
    """Load a session that need not name a system. Return its data, and the session.

    Raises
    ------
    InputError
        If an input cannot be used, or a dataset was not loaded from a session.
    MissingFactError
        As in `load`.
    """
    if isinstance(source, Dataset):
        given = [name for name in KEYWORDS if getattr(part, name) is not None]
        refuse_for_loaded(given)
        dataset = source.only(part.tags, part.only)
    else:
        if not isinstance(source, Session):
            source = read_session(Path(source), needs_system=False)
        session = with_facts(
            source,
            tags=part.tags,
            only=part.only,
            size=size_from(part.size),
            fps=part.fps,
            frames=frames_from(part.frames),
        )
        dataset = load_session(session, progress=progress)
    if not isinstance(dataset.settings, Session):
        raise InputError("expected a session, or a dataset that was loaded: it names the pictures")
    return dataset, dataset.settings


def refuse_for_loaded(names: Sequence[str]) -> None:
    """Raise InputError if facts are given for inputs that are loaded already."""
    if names:
        keywords = ", ".join(f"{name}=" for name in names)
        raise InputError(f"a dataset is loaded already: give {keywords} to load()")


def with_choices(
    settings: AnySettings,
    x: str | None,
    y: str | None,
    protocol: str | Protocol | None,
    primary: str | None,
    point: OperatingPoint | None,
) -> AnySettings:
    """Return the settings with these choices (None: unchanged).

    If X gets the name of Y or vice versa, the other one becomes the first remaining system.
    """
    if isinstance(protocol, str):
        protocol = protocol_from({"name": protocol})
    x, y = settings.names(x, y)
    return replace(
        settings,
        x=x,
        y=y,
        protocol=protocol or settings.protocol,
        primary=choose_primary(settings.primary, primary),
        operating_point=operating_point(point) or settings.operating_point,
    )


def with_params(dataset: Dataset, changes: Mapping[str, Any]) -> Dataset:
    """Return the dataset with some parameters replaced.

    Parameters
    ----------
    changes
        Fields of `nvcore.settings.params.Params`. A threshold of None counts every detection.

    Raises
    ------
    ParameterError
        If a name is unknown or a value is outside its range.
    """
    if not changes:
        return dataset
    settings = dataset.settings
    params = params_from({**settings.params.given(), **changes})
    settings = replace(settings, params=params)
    if isinstance(settings, Session):  # with None as a parameter the system's own would apply
        x, y = dataset.compared()
        freed = {
            name
            for name, threshold in ((x, "threshold_x"), (y, "threshold_y"))
            if threshold in changes and changes[threshold] is None
        }
        systems = tuple(
            replace(system, threshold=None) if name in freed else system
            for name, system in zip(dataset.systems, settings.systems, strict=True)
        )
        settings = replace(settings, systems=systems)
    return dataset.with_settings(settings)


def _session_of(
    inputs: Mapping[str, Input | None], names: Sequence[str | None]
) -> tuple[Session, dict[Source, pd.DataFrame]]:
    """Return a session of separate inputs, and the tables among its sources."""
    for keyword in ("truth", "x"):
        if inputs[keyword] is None:
            raise InputError(f"expected truth=, x= and y=; {keyword} is missing")
    present = {keyword: value for keyword, value in inputs.items() if value is not None}
    sources = {keyword: _source(value, keyword) for keyword, value in present.items()}
    for keyword, name in zip("xy", names, strict=True):
        if keyword in sources and name is not None:
            sources[keyword] = replace(sources[keyword], name=name)
    truth = Source(*(getattr(sources["truth"], spec.name) for spec in fields(Source)))
    systems = tuple(sources[keyword] for keyword in "xy" if keyword in sources)
    tables: dict[Source, pd.DataFrame] = {}
    for keyword, value in present.items():
        if isinstance(value, pd.DataFrame):
            tables[truth if keyword == "truth" else sources[keyword]] = value
    return Session(folder=Path.cwd(), truth=truth, systems=systems), tables


def _source(source: Input, keyword: str) -> SystemSource:
    """Return an input as a `SystemSource`. Its corrections are unused for the truth."""
    if isinstance(source, pd.DataFrame):
        return SystemSource((keyword,), name=keyword.upper())
    if isinstance(source, SystemSource):
        return source
    if isinstance(source, Source):
        return SystemSource(**vars(source))
    paths = [source] if isinstance(source, str | Path) else source
    return SystemSource(tuple(str(path) for path in paths))
