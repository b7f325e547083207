"""Statistics of groups: persons or drives under several conditions. They need no comparison.

`reading`: values, or means, SD and n typed in. `analyses`: tests by formula, of independent groups
and of the same persons, and sizes of further studies. `permutation`: tests over all ways, or random
ones. `comparison`: all of it, which test fits, and the conclusions. `text`: for the terminal, as
JSON, as files.
"""

from nvcore.group_statistics.comparison import GroupComparison, compare_groups

__all__ = ["GroupComparison", "compare_groups"]
