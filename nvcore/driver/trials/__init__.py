"""Trials with people: who saw which pedestrian how long after the light changed."""

from nvcore.driver.inputs.trials import TRIAL_COLUMNS
from nvcore.driver.trials.judging import Judging, judge_trials, side_of_angle
from nvcore.driver.trials.reading import parse_trials, read_boxes, read_trials
from nvcore.driver.trials.subjects import subjects_table
from nvcore.driver.trials.table import TrainingTable, detectability_table, training_table

__all__ = [
    "TRIAL_COLUMNS",
    "Judging",
    "TrainingTable",
    "detectability_table",
    "judge_trials",
    "parse_trials",
    "read_boxes",
    "read_trials",
    "side_of_angle",
    "subjects_table",
    "training_table",
]
