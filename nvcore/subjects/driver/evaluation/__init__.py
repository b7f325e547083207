"""Evaluation of estimators on pedestrians that they were not trained on."""

from nvcore.subjects.driver.evaluation.published import PUBLISHED_NOTE
from nvcore.subjects.driver.evaluation.tables import (
    Evaluation,
    evaluate_estimators,
    evaluation_tables,
)

__all__ = ["PUBLISHED_NOTE", "Evaluation", "evaluate_estimators", "evaluation_tables"]
