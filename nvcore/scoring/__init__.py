"""One system against the truth: every metric of it, and what a new setting can reuse."""

from nvcore.scoring.memo import Memo
from nvcore.scoring.result import SystemResult
from nvcore.scoring.system import nearest_of, score_system

__all__ = ["Memo", "SystemResult", "nearest_of", "score_system"]
