"""How well estimators do on pedestrians that they have not seen."""

from nvcore.driver.evaluation.published import PUBLISHED_NOTE
from nvcore.driver.evaluation.run import Evaluation, evaluate_estimators
from nvcore.driver.evaluation.tables import evaluation_tables

__all__ = ["PUBLISHED_NOTE", "Evaluation", "evaluate_estimators", "evaluation_tables"]
