"""The call of Python users that trains a detector on recordings or folders of pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from nvcore.api.detect import dataset_of
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Setting
from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.inputs.session import Session
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import files_read, replaced_input
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.detectors.icf import IcfSettings
    from nvcore.detectors.training.gathering import Folders, Gathered
    from nvcore.detectors.training.run import Training
    from nvcore.detectors.training.split import Choice


def train(
    source: str | Path | Session | Dataset | None,
    out: str | Path,
    *,
    preset: Literal["pedestrians", "signs", "as-in-report"] | None = None,
    settings: Mapping[str, Setting | Sequence[float] | Sequence[str]] | None = None,
    name: str | None = None,
    only: Sequence[str] = (),
    first_frame: int | None = None,
    last_frame: int | None = None,
    every: int | None = None,
    hold_out: Sequence[str] = (),
    split: Literal["auto", "object", "recording", "time"] = "auto",
    share: float = 0.1,
    gap: int = 20,
    least_height: float | None = None,
    crops: str | Path | None = None,
    crop_share: float | None = None,
    background: str | Path | None = None,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Training:
    """Train a detector (Integral Channel Features); `detect` then takes its file.

    The same data, settings and seed give the same file.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`: its truth and pictures are learned.
        None: folders alone.
    out
        The file of the model, by custom ``.npz``.
    preset
        Settings to start from; None: ``signs`` where the objects are speed signs, else
        ``pedestrians``.
    settings
        Changes of the preset, by name.
    name
        Of the model; None: the file's.
    only
        Names of recordings; empty: all.
    first_frame, last_frame, every
        Frames of each recording, both included, and only every so many evaluated ones; None: all,
        thinned out to 5,000 boxes.
    hold_out, split, share, gap
        What is not learned but calibrates the rejection: recordings by name; or this share of the
        physical objects (tracks), of the recordings, or of the end of each recording, after a gap
        of so many frames; ``auto``: the first that is possible.
    least_height
        Lower boxes, px, are neither learned nor background; None: those that the smallest scale
        is too large for.
    crops, crop_share
        A folder of pictures with an object in the middle, which takes this share of their height
        (None: as in the window), or with those that ``boxes.csv`` lists (file, x, y, w, h, and
        class where there are several: the model then says of each box which it is).
    background
        A folder of pictures without an object.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`:
        nothing is then written.

    Returns
    -------
    Training
        ``.model``, and how many objects were learned, held out, kept and found.

    Raises
    ------
    InputError
        If an input cannot be used, would be replaced, or there is nothing to learn.
    ParameterError
        If a setting cannot be used.
    MissingExtraError
        If the extra ``detectors`` is not installed.

    Examples
    --------
    >>> train("night.toml", "night.npz", only=["urban_01"])  # doctest: +SKIP
    >>> detect("night.toml", "night.npz", "icf", only=["urban_02"])  # doctest: +SKIP
    """
    with needs("detectors", "training a detector needs"):
        from nvcore.detectors.training.gathering import Folders, write_trained
        from nvcore.detectors.training.presets import objects_of, preset_for, preset_settings
        from nvcore.detectors.training.run import train_on
        from nvcore.detectors.training.split import Choice

    path = Path(out)
    choice = Choice(
        first_frame=first_frame,
        last_frame=last_frame,
        every=every,
        hold_out=tuple(hold_out),
        split=split,
        share=share,
        gap=gap,
        least_height=least_height,
        seed=seed,
    )
    folders = Folders(
        crops=None if crops is None else Path(crops),
        background=None if background is None else Path(background),
        crop_share=crop_share,
    )
    dataset = None if source is None else dataset_of(source).only(names=only)
    chosen = preset or preset_for(None if dataset is None else dataset.objects)
    resolved = preset_settings(chosen, settings or {})
    objects = objects_of(chosen) if dataset is None else dataset.objects
    files = [Path(source)] if isinstance(source, str | Path) else []
    with gathering(dataset, resolved, choice, folders, path, files) as gathered:
        training = train_on(
            gathered,
            resolved,
            name=name or one_line(path.stem),
            label=objects.singular,
            seed=seed,
            progress=progress,
        )
    write_trained(training.model, path)
    return training


@contextmanager
def gathering(
    dataset: Dataset | None,
    settings: IcfSettings,
    choice: Choice,
    folders: Folders,
    out: Path,
    files: Sequence[Path] = (),
) -> Iterator[Gathered]:
    """What a training learns from, with its pictures open; `out` is none of it and can be written.

    Parameters
    ----------
    dataset
        That was loaded from a session; None: folders alone.
    files
        Further inputs that `out` must not replace.

    Raises
    ------
    InputError, ParameterError
        As `train`.
    """
    from nvcore.detectors.training.gathering import check_model_target, gather
    from nvcore.pictures import session_pictures

    inputs = [*files, *(path for path in (folders.crops, folders.background) if path is not None)]
    pictures = None
    if dataset is not None:
        session = dataset.settings
        if not isinstance(session, Session):
            raise InputError(
                "expected a session, or a dataset that was loaded: it names the pictures"
            )
        inputs += files_read(session)
        pictures = session_pictures(session, dataset)
    try:
        check_model_target(out)
        clash = replaced_input([out], inputs)
        if clash is not None:
            raise InputError("is an input, and would be replaced; give another file", file=clash)
        yield gather(dataset, pictures, settings, choice, folders)
    finally:
        if pictures is not None:
            pictures.close()
