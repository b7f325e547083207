"""A detector trained: the call of Python users, and what the command makes of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from nvcore.api.inputs import Part, PathLike, Size, frames_from, keywords_named, load_part
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Setting
from nvcore.extras import needs
from nvcore.inputs.pipes import pipes_kept
from nvcore.inputs.session import Session
from nvcore.output.files import check_file
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import files_read, refuse_to_replace
from nvcore.settings import as_names
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.detectors.icf import IcfSettings
    from nvcore.detectors.training.gathering import Folders, TrainingData
    from nvcore.detectors.training.run import Training
    from nvcore.detectors.training.split import Choice, SplitBy


@pipes_kept()
def train(
    source: PathLike | Session | Dataset | None,
    out: PathLike,
    *,
    preset: Literal["pedestrians", "signs", "as-in-report"] | None = None,
    settings: Mapping[str, Setting | Sequence[Setting]] | None = None,
    name: str | None = None,
    only: str | Sequence[str] = (),
    tags: str | Sequence[str] = (),
    size: Size | None = None,
    fps: float | None = None,
    frames: str | range | None = None,
    every: int | None = None,
    hold_out: str | Sequence[str] = (),
    split: SplitBy = "auto",
    share: float = 0.1,
    gap: int = 20,
    least_height: float | None = None,
    crops: PathLike | None = None,
    crop_share: float | None = None,
    background: PathLike | None = None,
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
        Changes of the preset, by name; several values of one as a sequence.
    name
        Of the model; None: the file's.
    only, tags
        Names of recordings, and tags that they all have; empty: all that the session compares.
    size, fps
        See `load`.
    frames, every
        Of the evaluated frames only these (see `load`), and only every so many; None: all, thinned
        out to 5,000 boxes.
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
        ``.model``, and how many objects were learned, held out, kept and found. ``print`` shows
        what the command prints.

    Raises
    ------
    InputError
        If an input cannot be used, would be replaced, or there is nothing to learn.
    MissingFactError
        As `load`.
    ParameterError
        If a setting cannot be used.
    MissingExtraError
        If the extra ``detectors`` is not installed.

    Examples
    --------
    >>> train("night.toml", "night.npz", only="urban_01")  # doctest: +SKIP
    >>> detect("night.toml", "night.npz", "icf", only="urban_02")  # doctest: +SKIP
    """
    selection = Selection(
        frames=frames,
        every=every,
        hold_out=hold_out,
        split=split,
        share=share,
        gap=gap,
        least_height=least_height,
        crops=crops,
        crop_share=crop_share,
        background=background,
        seed=seed,
    )
    part = Part(only=only, tags=tags, size=size, fps=fps)
    with (
        keywords_named(),
        training_job(
            *(source, out, selection), preset=preset, settings=settings, name=name, part=part
        ) as job,
    ):
        return job.run(progress)


@dataclass(frozen=True, kw_only=True)
class Selection:
    """What is learned, and what is held out; see `train`."""

    frames: str | range | None = None
    every: int | None = None
    hold_out: str | Sequence[str] = ()
    split: SplitBy = "auto"
    share: float = 0.1
    gap: int = 20
    least_height: float | None = None
    crops: PathLike | None = None
    crop_share: float | None = None
    background: PathLike | None = None
    seed: int = 0

    def choice(self) -> Choice:
        """Of a session, as the library takes it; raises ParameterError."""
        from nvcore.detectors.training.split import Choice

        return Choice(
            frames=frames_from(self.frames),
            every=self.every,
            hold_out=as_names(self.hold_out),
            split=self.split,
            share=self.share,
            seed=self.seed,
            gap=self.gap,
            least_height=self.least_height,
        )

    def folders(self) -> Folders:
        """Those that pictures are read from."""
        from nvcore.detectors.training.gathering import Folders

        return Folders(
            crops=None if self.crops is None else Path(self.crops),
            background=None if self.background is None else Path(self.background),
            crop_share=self.crop_share,
        )


@dataclass(frozen=True, eq=False)
class TrainingJob:
    """What a model will be trained on: gathered, with pictures open, and known to be possible.

    Attributes
    ----------
    training_data
        Pictures and boxes.
    settings
        Of the model.
    out, name, label
        Its file, its name, and what it detects.
    seed
        Of all that is drawn at random.
    """

    training_data: TrainingData
    settings: IcfSettings
    out: Path
    name: str
    label: str
    seed: int

    def run(self, progress: Progress = no_progress) -> Training:
        """Train the model and write it; errors as `train`."""
        from nvcore.detectors.icf import write_model
        from nvcore.detectors.training.run import train_on

        training = train_on(
            *(self.training_data, self.settings),
            name=self.name,
            label=self.label,
            seed=self.seed,
            progress=progress,
        )
        write_model(training.model, self.out)
        return training


@contextmanager
def training_job(
    source: PathLike | Session | Dataset | None,
    out: PathLike,
    selection: Selection,
    *,
    preset: str | None = None,
    settings: Mapping[str, Setting | Sequence[Setting]] | None = None,
    name: str | None = None,
    part: Part | None = None,
    inputs: Sequence[Path] = (),
    loading: Progress = no_progress,
) -> Iterator[TrainingJob]:
    """All that a training needs; what cannot be done is refused before anything is trained.

    Parameters
    ----------
    source, out, preset, settings, name
        See `train`.
    selection
        What is learned, and what is held out.
    part
        Of the source; None: all of it.
    inputs
        Further files that are read, and must not be replaced.
    loading
        Progress of the reading.

    Raises
    ------
    InputError, MissingFactError, ParameterError, MissingExtraError
        As `train`.
    """
    with needs("detectors", "training a detector needs"):
        from nvcore.detectors.training.gathering import gather
        from nvcore.detectors.training.presets import objects_of, preset_for, preset_settings
        from nvcore.pictures import session_pictures

    path, settings = Path(out), settings or {}
    preset_settings(preset or preset_for(None), settings)  # what is wrong is said before loading
    choice, folders = selection.choice(), selection.folders()
    dataset = session = pictures = None
    if source is not None:
        dataset, session = load_part(source, part or Part(), progress=loading)
    files = [*inputs, *(Path(path) for path in [source] if isinstance(path, PathLike))]
    files += [folder for folder in (folders.crops, folders.background) if folder is not None]
    check_file(path, "model.npz")
    refuse_to_replace([path], [*files, *(files_read(session) if session is not None else ())])
    chosen = preset or preset_for(None if dataset is None else dataset.objects)
    resolved = preset_settings(chosen, settings)
    objects = objects_of(chosen) if dataset is None else dataset.objects
    try:
        if dataset is not None and session is not None:
            pictures = session_pictures(session, dataset)
        yield TrainingJob(
            training_data=gather(dataset, pictures, resolved, choice, folders),
            settings=resolved,
            out=path,
            name=name or one_line(path.stem),
            label=objects.singular,
            seed=choice.seed,
        )
    finally:
        if pictures is not None:
            pictures.close()
