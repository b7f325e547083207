"""Python API for the driver's view: features, estimates, and estimators of detectability."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nvcore.api.inputs import keywords_named, load_part
from nvcore.common.arguments import PathLike, called_with
from nvcore.common.extras import needs
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import check_file, check_folder, write_run, write_whole
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import one_line
from nvcore.inputs.files.pipes import pipes_kept
from nvcore.report.protect_inputs import refuse_outputs, refuse_to_replace
from nvcore.subjects.driver.calls.arguments import (
    EstimateArguments,
    EvaluateArguments,
    FeatureArguments,
    TrainArguments,
    TrialArguments,
)

if TYPE_CHECKING:
    from nvcore.subjects.driver.estimators import Search, Training
    from nvcore.subjects.driver.evaluation import Evaluation
    from nvcore.subjects.driver.features.images import ImageFeatures
    from nvcore.subjects.driver.running.writing import WrittenEstimates, WrittenFeatures
    from nvcore.subjects.driver.trials import TrainingTable


@called_with(FeatureArguments)
@pipes_kept()
def driver_features(arguments: FeatureArguments) -> WrittenFeatures:
    """Compute the light, and eight features of how visible each pedestrian is in the pictures.

    Parameters
    ----------
    out
        Folder for ``features.csv`` and its record ``driver.json``.

    Raises
    ------
    InputError
        If an input cannot be used or would be replaced, or no evaluated frame has a picture.
    MissingFactError
        As for `load`.
    ParameterError
        If there is no such setting, or a value is outside its range.
    MissingExtraError
        If the extra ``driver`` is not installed.

    Examples
    --------
    >>> features = driver_features("night.toml", "features")  # doctest: +SKIP
    >>> print(features.run)  # doctest: +SKIP
    """
    with keywords_named(), driver_job(arguments) as job:
        features: WrittenFeatures = job(arguments.progress)
        return features


def image_features(
    images: PathLike,
    boxes: PathLike,
    out: PathLike,
    *,
    settings: Mapping[str, Any] | None = None,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> ImageFeatures:
    """Compute the eight features of pedestrians in single pictures, such as those of a study.

    Parameters
    ----------
    images
        Folder with the pictures.
    boxes
        CSV with the columns image, pedestrian, x, y, w, h (px), and optionally fixation_x and
        fixation_y.
    out
        CSV file to write: image, pedestrian, and the features. A record with the same name plus
        ``.json`` is written beside it.
    settings, n_threads, progress
        Same as in `driver_features`.

    Raises
    ------
    InputError
        If a file cannot be used, with the line, or would be replaced.
    """
    with needs("driver", "features of pictures need"):
        from nvcore.subjects.driver.features.feature_record import record_beside
        from nvcore.subjects.driver.features.images import image_features as features_of_images
        from nvcore.subjects.driver.settings import settings_from

    path = Path(out)
    refuse_to_replace([path, record_beside(path)], [Path(boxes), Path(images)])
    features = features_of_images(
        Path(images),
        Path(boxes),
        settings_from(settings or {}),
        n_threads=n_threads,
        progress=progress,
    )
    content = to_csv_bytes(features.table)
    write_whole(path, content)
    if path.is_file():  # no record beside a pipe
        write_whole(record_beside(path), features.record({path.name: content}))
    return features


@called_with(EstimateArguments)
@pipes_kept()
def estimate_driver(arguments: EstimateArguments) -> WrittenEstimates:
    """Estimate how likely the driver sees each pedestrian unaided, in every frame.

    Feature settings that are not given are those of the model. ``session.toml`` is the session with
    the estimates for `compare`.

    Raises
    ------
    InputError
        As for `driver_features`, or if the model cannot be used, or no pedestrian can be estimated.
    MissingFactError, ParameterError, MissingExtraError
        As for `driver_features`.
    """
    with keywords_named(), driver_job(arguments) as job:
        estimates: WrittenEstimates = job(arguments.progress)
        return estimates


@contextmanager
def driver_job(
    arguments: FeatureArguments | EstimateArguments,
    *,
    inputs: Sequence[Path] = (),
    loading: Progress = no_progress,
) -> Iterator[Callable[[Progress], Any]]:
    """Check the arguments of `driver_features` or `estimate_driver`, and yield its run.

    Parameters as for `nvcore.subjects.detectors.calls.python.detector_job`, errors as for the two
    calls.
    """
    estimate = arguments if isinstance(arguments, EstimateArguments) else None
    what = "estimates of what the driver sees" if estimate else "features of pictures"
    with needs("driver", f"{what} need"):
        from nvcore.subjects.driver.estimators import estimator_path, read_estimator
        from nvcore.subjects.driver.running.estimate import check_settings, run_estimate
        from nvcore.subjects.driver.running.run import run_features
        from nvcore.subjects.driver.running.writing import (
            ESTIMATE_OUTPUTS,
            FEATURE_OUTPUTS,
            write_estimates,
            write_features,
        )
        from nvcore.subjects.driver.settings import settings_from

    own, read, outputs = None, [*inputs, arguments.source], FEATURE_OUTPUTS
    if estimate:
        read.append(path := estimator_path(estimate.model))
        estimator, outputs = read_estimator(path), ESTIMATE_OUTPUTS
        own = estimator.feature_settings
    values = settings_from(arguments.settings or {}, features=own)
    if estimate:
        check_settings(values.features, estimator)
    out = Path(arguments.out)
    dataset, session = load_part(arguments.source, arguments, progress=loading)
    check_folder(out, outputs)
    refuse_outputs(out, outputs, read, session)

    def run(progress: Progress) -> WrittenEstimates | WrittenFeatures:
        n_threads = arguments.n_threads
        features = run_features(dataset, values, n_threads=n_threads, progress=progress)
        if not estimate:
            return write_features(features, out)
        estimates = run_estimate(features, estimator, interpolate=estimate.interpolate)
        return write_estimates(estimates, dataset, out)

    yield run


@called_with(TrainArguments)
def train_driver(arguments: TrainArguments) -> Training:
    """Train an estimator of how well drivers see pedestrians, on trials with people.

    The same data and seed give the same file.

    Parameters
    ----------
    name
        Name of the model. None: the file name.

    Returns
    -------
    Training
        ``.estimator``, with its errors on pedestrians left out and those of a constant.

    Raises
    ------
    InputError
        If an input cannot be used or would be replaced, the training data are too few, or `out`
        cannot be written to.
    MissingExtraError
        If the extra ``driver`` is not installed.

    Examples
    --------
    >>> training = train_driver("trials.csv", "features.csv", "model.npz")  # doctest: +SKIP
    """
    with needs("driver", "training an estimator needs"):
        from nvcore.common.output.model_files import check_name
        from nvcore.subjects.driver.estimators import train_estimator, write_estimator

    out = Path(arguments.out)
    name = arguments.name or one_line(out.stem)
    check_name("name", name)
    refuse_to_replace([out], _inputs(arguments))
    check_file(out, "model.npz")
    training = train_estimator(
        _table(arguments),
        name=name,
        search=_search(arguments),
        n_threads=arguments.n_threads,
        progress=arguments.progress,
    )
    write_estimator(training.estimator, out)
    return training


@called_with(EvaluateArguments)
def evaluate_driver(arguments: EvaluateArguments) -> Evaluation:
    """Evaluate estimators on unseen pedestrians by leaving out one at a time.

    Returns
    -------
    Evaluation
        `nvcore.subjects.driver.evaluation.evaluation_tables` converts it to tables.

    Raises
    ------
    InputError
        If an input cannot be used or would be replaced, the training data are too few, `out` or
        `html` cannot be written to, or `out` contains the run of another command.
    MissingExtraError
        If the extra ``driver`` is not installed, or ``report`` if `html` is given.

    Examples
    --------
    >>> evaluation = evaluate_driver("trials.csv", "features.csv", "tables")  # doctest: +SKIP
    """
    with needs("driver", "evaluating an estimator needs"):
        from nvcore.subjects.driver.evaluation import evaluate_estimators
        from nvcore.subjects.driver.evaluation.estimator_report import (
            EVALUATION_FILES,
            evaluation_files,
        )
    out, html = (None if path is None else Path(path) for path in (arguments.out, arguments.html))
    if html is not None:
        with needs("report", "the HTML page of an evaluation needs"):
            from nvcore.subjects.driver.evaluation.page import write_evaluation_html

    files = [] if out is None else [out / name for name in EVALUATION_FILES]
    refuse_to_replace([*files, *([] if html is None else [html])], _inputs(arguments))
    if out is not None:
        check_folder(out, EVALUATION_FILES)
    if html is not None:
        check_file(html, "evaluation.html")
    evaluation = evaluate_estimators(
        _table(arguments),
        search=_search(arguments),
        n_threads=arguments.n_threads,
        progress=arguments.progress,
    )
    if out is not None:
        write_run(out, evaluation_files(evaluation), EVALUATION_FILES)
    if html is not None:
        write_evaluation_html(evaluation, html)
    return evaluation


def _inputs(arguments: TrialArguments) -> list[Path]:
    files = (arguments.trials, arguments.features, arguments.boxes)
    return [Path(file) for file in files if file is not None]


def _table(arguments: TrialArguments) -> TrainingTable:
    from nvcore.subjects.driver.trials import training_table

    return training_table(
        Path(arguments.trials),
        Path(arguments.features),
        boxes=None if arguments.boxes is None else Path(arguments.boxes),
        judging=arguments.judging,
        leave_out=arguments.leave_out,
    )


def _search(arguments: TrialArguments) -> Search:
    from nvcore.subjects.driver.estimators import QUICK, Search

    return replace(QUICK if arguments.quick else Search(), seed=arguments.seed)
