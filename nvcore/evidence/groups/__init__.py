"""Statistics of groups: persons or drives under several conditions. No comparison is needed.

`reading`: values, or means, SD and n typed in. `analyses`: tests by formula, for independent groups
and for the same persons, and sizes of further studies. `permutation`: tests over all ways, or
random ones. `comparison`: all tests, the most suitable one, and the conclusions. `text`: output for
the terminal, as JSON and as files.
"""

from nvcore.evidence.groups.comparison import GroupComparison, compare_groups

__all__ = ["GroupComparison", "compare_groups"]
