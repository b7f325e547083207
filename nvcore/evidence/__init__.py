"""Statistical evidence on differences: units, intervals, paired tests, groups."""

from nvcore.evidence.bootstrap import BootstrapDifference, bootstrap_difference
from nvcore.evidence.measures import Evidence, significance_table
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.paired_tests import McNemar, SwapTest, holm, mcnemar, swap_test
from nvcore.evidence.pairwise import pairwise_table
from nvcore.evidence.subgroups import Subgroup, find_subgroups
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import Units, block_length, find_units

__all__ = [
    "BootstrapDifference",
    "Evidence",
    "McNemar",
    "Subgroup",
    "SwapTest",
    "Units",
    "block_length",
    "bootstrap_difference",
    "evidence_table",
    "find_subgroups",
    "find_units",
    "holm",
    "judge_miss_rate",
    "mcnemar",
    "pairwise_table",
    "significance_table",
    "subgroup_table",
    "swap_test",
]
