"""The calls of Python users that train and evaluate estimators of what the driver sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.extras import needs
from nvcore.output.files import check_file, check_folder, write_run
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import refuse_to_replace
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.driver.estimators import Training
    from nvcore.driver.evaluation import Evaluation
    from nvcore.driver.trials import Judging


def train_driver(
    trials: str | Path,
    features: str | Path,
    out: str | Path,
    *,
    boxes: str | Path | None = None,
    judging: Judging | None = None,
    leave_out: Sequence[str] = (),
    quick: bool = False,
    seed: int = 0,
    name: str | None = None,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Training:
    """Train an estimator of how well drivers see pedestrians, on trials with people.

    The same data and seed give the same file.

    Parameters
    ----------
    trials
        CSV file, a row for each picture shown to a subject (docs/driver.md).
    features
        CSV file of ``image,pedestrian`` and the eight features of the pictures.
    out
        The file of the model, by custom ``.npz``.
    boxes
        CSV file of ``image,pedestrian,x,y,w,h``; None: `features` has these columns.
    judging
        Which responses are right; None: a square of 200 px around the touch overlaps the middle
        half of the pedestrian.
    leave_out
        Subjects whose responses are not used.
    quick
        Fewer settings are tried, for a first look.
    seed
        Of all that is drawn at random.
    name
        Of the model; None: the file's.
    n_threads
        Regressions at a time; None: as many as there are cores.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`:
        nothing is then written.

    Returns
    -------
    Training
        ``.estimator``, and its errors on pedestrians left out beside those of a constant.

    Raises
    ------
    InputError
        If an input cannot be used, would be replaced, or there is too little to learn; or `out`
        cannot be written to.
    MissingExtraError
        If the extra ``driver`` is not installed.

    Examples
    --------
    >>> training = train_driver("trials.csv", "features.csv", "model.npz")  # doctest: +SKIP
    """
    with needs("driver", "training an estimator needs"):
        from nvcore.driver.estimators import QUICK, Search, train_estimator, write_estimator
        from nvcore.driver.trials import training_table

    path = Path(out)
    refuse_to_replace([path], _paths(trials, features, boxes))
    check_file(path, "model.npz")
    table = training_table(
        Path(trials),
        Path(features),
        boxes=None if boxes is None else Path(boxes),
        judging=judging,
        leave_out=leave_out,
    )
    training = train_estimator(
        table,
        name=name or one_line(path.stem),
        search=replace(QUICK if quick else Search(), seed=seed),
        n_threads=n_threads,
        progress=progress,
    )
    write_estimator(training.estimator, path)
    return training


def evaluate_driver(
    trials: str | Path,
    features: str | Path,
    out: str | Path | None = None,
    *,
    html: str | Path | None = None,
    boxes: str | Path | None = None,
    judging: Judging | None = None,
    leave_out: Sequence[str] = (),
    quick: bool = False,
    seed: int = 0,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Evaluation:
    """How well estimators do on pedestrians that they have not seen, leaving out one at a time.

    Parameters
    ----------
    out
        Folder for the tables as CSV files; None: none are written.
    html
        File for figures and tables as one HTML page; None: none is written. It needs the extra
        ``report``.
    trials, features, boxes, judging, leave_out, quick, seed, n_threads, progress
        As of `train_driver`.

    Returns
    -------
    Evaluation
        `nvcore.driver.evaluation.evaluation_tables` gives its tables.

    Raises
    ------
    InputError
        If an input cannot be used, would be replaced, or there is too little to learn; or `out`
        or `html` cannot be written to, or `out` holds the run of another command.
    MissingExtraError
        If the extra ``driver`` is not installed, or with `html` ``report``.

    Examples
    --------
    >>> evaluation = evaluate_driver("trials.csv", "features.csv", "tables")  # doctest: +SKIP
    """
    with needs("driver", "evaluating an estimator needs"):
        from nvcore.driver.estimators import QUICK, Search
        from nvcore.driver.evaluation import evaluate_estimators
        from nvcore.driver.trials import training_table
        from nvcore.report.driver import EVALUATION_FILES, evaluation_files
    if html is not None:
        with needs("report", "the HTML page of an evaluation needs"):
            from nvcore.report.html.evaluation import write_evaluation_html

    files = [] if out is None else [Path(out) / name for name in EVALUATION_FILES]
    refuse_to_replace([*files, *_paths(html)], _paths(trials, features, boxes))
    if out is not None:
        check_folder(Path(out), EVALUATION_FILES)
    if html is not None:
        check_file(Path(html), "evaluation.html")
    table = training_table(
        Path(trials),
        Path(features),
        boxes=None if boxes is None else Path(boxes),
        judging=judging,
        leave_out=leave_out,
    )
    evaluation = evaluate_estimators(
        table,
        search=replace(QUICK if quick else Search(), seed=seed),
        n_threads=n_threads,
        progress=progress,
    )
    if out is not None:
        write_run(Path(out), evaluation_files(evaluation), EVALUATION_FILES)
    if html is not None:
        write_evaluation_html(evaluation, Path(html))
    return evaluation


def _paths(*files: str | Path | None) -> list[Path]:
    return [Path(file) for file in files if file is not None]
