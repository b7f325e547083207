"""A trained model: all that a run needs, and where it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.classifier import Classifier
from nvcore.detectors.icf.boosting import Trees
from nvcore.detectors.icf.cascade import Calibration
from nvcore.detectors.icf.channels import plane_names
from nvcore.detectors.icf.features import Features
from nvcore.detectors.icf.regions import EVERYWHERE, Band
from nvcore.detectors.icf.settings import OF_A_RUN, IcfSettings
from nvcore.errors import ParameterError
from nvcore.wording import count_text, did_you_mean, listed, one_line


@dataclass(frozen=True, eq=False, repr=False)
class IcfModel:
    """A trained model.

    Attributes
    ----------
    name
        For people.
    label
        What its boxes are: ``pedestrian``.
    settings
        With which it was trained, and with which it runs unless told otherwise.
    is_colour
        Whether it needs colour pictures; else it works on grey ones.
    features
        Those that its trees use.
    trees, calibration
        The classifier, and what objects reach in it, those trained on and those held out.
    powers
        By which power of the scale each channel changes; float64, (n_channels,).
    band
        Where the boxes of the training lay.
    error, round_ends
        Training error after each tree, of all rounds one after another, float64, and where each
        round ends in it, int32, (n_rounds,).
    n_objects, n_background
        Windows of the last round.
    seed
        Of the training.
    trained_on
        The training's data.
    classifier
        Says of each box of which class it is; None: the model knows one kind of object.
    """

    name: str
    label: str
    settings: IcfSettings
    is_colour: bool
    features: Features
    trees: Trees
    calibration: Calibration
    powers: NDArray[np.float64]
    error: NDArray[np.float64]
    round_ends: NDArray[np.int32]
    n_objects: int
    n_background: int
    seed: int
    band: Band = EVERYWHERE
    trained_on: Sequence[TrainedOn] = field(default=())
    classifier: Classifier | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """What its boxes are: the classes, or the one kind of object."""
        return (self.label,) if self.classifier is None else self.classifier.classes

    @property
    def channels(self) -> tuple[str, ...]:
        """Name of each channel that the features count in."""
        return plane_names(self.settings, self.is_colour)

    def __repr__(self) -> str:
        return (
            f"<IcfModel {one_line(self.name)}: {count_text(len(self.trees), 'tree')}, "
            f"{count_text(len(self.features), 'feature')}, detects {one_line(listed(self.labels))}>"
        )

    def windows_in_words(self) -> list[str]:
        """Windows of the training, and its error at the end of each round; a line each."""
        lines = [f"windows: {self.n_objects:,} of objects, {self.n_background:,} of background"]
        start = 0
        for number, end in enumerate(self.round_ends.tolist(), 1):
            trees = count_text(end - start, "tree")
            lines.append(f"  round {number}: {trees}, training error {self.error[end - 1]:.2%}")
            start = end
        return lines

    def run_with(self, **changes: Any) -> IcfModel:
        """The same model with other settings of its runs.

        Raises
        ------
        ParameterError
            If one is not a setting of a run (`OF_A_RUN`), or its value is not possible: a model of
            grey pictures has no red places.
        """
        known, odd = listed(sorted(OF_A_RUN)), sorted(set(changes) - OF_A_RUN)
        fixed = [name for name in odd if hasattr(self.settings, name)]
        if fixed:
            raise ParameterError(
                f"{listed(fixed)}: fixed by the training; of a run there are {known}"
            )
        if odd:
            hint = did_you_mean(odd[0], sorted(OF_A_RUN), f"of a run there are {known}")
            raise ParameterError(f"there is no setting {odd[0]!r}; {hint}")
        if changes.get("proposals") == "red" and not self.is_colour:
            raise ParameterError(
                "proposals: red is of pictures in colour, and the model was trained on grey ones; "
                "expected none"
            )
        return replace(self, settings=replace(self.settings, **changes))
