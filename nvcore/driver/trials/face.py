"""Python API to train and evaluate estimators of the driver's perception."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.arguments import called_with
from nvcore.driver.arguments import EvaluateArguments, TrainArguments, TrialArguments
from nvcore.extras import needs
from nvcore.output.files import check_file, check_folder, write_run
from nvcore.report.protect_inputs import refuse_to_replace
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.driver.estimators import Search, Training
    from nvcore.driver.evaluation import Evaluation
    from nvcore.driver.trials import TrainingTable


@called_with(TrainArguments)
def train_driver(arguments: TrainArguments) -> Training:
    """Train an estimator of how well drivers see pedestrians, on trials with people.

    The same data and seed give the same file.

    Parameters
    ----------
    name
        Name of the model. None: the name of the file.

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
        from nvcore.driver.estimators import train_estimator, write_estimator
        from nvcore.output.model_files import check_name

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
        `nvcore.driver.evaluation.evaluation_tables` makes tables of it.

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
        from nvcore.driver.estimator_report import EVALUATION_FILES, evaluation_files
        from nvcore.driver.evaluation import evaluate_estimators
    out, html = (None if path is None else Path(path) for path in (arguments.out, arguments.html))
    if html is not None:
        with needs("report", "the HTML page of an evaluation needs"):
            from nvcore.driver.evaluation.page import write_evaluation_html

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
    from nvcore.driver.trials import training_table

    return training_table(
        Path(arguments.trials),
        Path(arguments.features),
        boxes=None if arguments.boxes is None else Path(arguments.boxes),
        judging=arguments.judging,
        leave_out=arguments.leave_out,
    )


def _search(arguments: TrialArguments) -> Search:
    from nvcore.driver.estimators import QUICK, Search

    return replace(QUICK if arguments.quick else Search(), seed=arguments.seed)
