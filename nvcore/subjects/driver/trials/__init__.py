"""Trials with people: responses to pictures at a given time after the light changed."""

from nvcore.subjects.driver.inputs.study_tables import TRIAL_COLUMNS
from nvcore.subjects.driver.trials.judging import Judging, judge_trials, side_of_angle
from nvcore.subjects.driver.trials.table import TrainingTable, training_table

__all__ = [
    "TRIAL_COLUMNS",
    "Judging",
    "TrainingTable",
    "judge_trials",
    "side_of_angle",
    "training_table",
]
