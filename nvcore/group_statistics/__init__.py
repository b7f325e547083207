"""Statistics of groups: persons or drives under several conditions. They need no comparison.

`reading`: values, or means, SD and n typed in. `summaries`: ANOVA, Welch, Tukey, Games–Howell, all
from n, mean and SD. `permutation`: tests over all ways, or random ones. `repeated`: the same
persons in all conditions. `sample_size`: how many a further study needs. `comparison`: all of it,
which test fits, and the conclusions. `text`: for the terminal, as JSON, as files.
"""

from nvcore.group_statistics.comparison import GroupComparison, compare_groups

__all__ = ["GroupComparison", "compare_groups"]
