"""Measure how often tests of small groups find a difference between equal means.

    python -m bench.group_tests [--sets 2000] [--shape normal]

The module draws groups of values with equal means, and prints the share of them with p at 0.05 or
less as a table. Methods: permuting F, permuting Welch's F, the larger p of that and of Welch's F
distribution, a parametric bootstrap (Krishnamoorthy, Lu and Mathew 2007, A parametric bootstrap
approach for ANOVA with unequal variances), and Welch's F distribution, which `nvcore groups` uses.
The last one is also measured on `MORE` times as many sets. The result is in
docs/decisions/089-small-groups-by-welch.md.
"""

from __future__ import annotations

import argparse
from typing import Final

import numpy as np
import scipy

from nvcore.evidence.groups.analyses import welch_f
from nvcore.evidence.groups.permutation import permute_between
from nvcore.evidence.paired_tests import SIGNIFICANT

CASES: Final = (
    *(((4, 12), sds) for sds in ((1, 1), (3, 1), (1, 3))),
    *(((5, 5, 15), sds) for sds in ((1, 1, 1), (3, 1, 1), (3, 3, 1), (3, 2, 1), (1, 1, 3))),
    *(((4, 4, 4), sds) for sds in ((1, 1, 1), (1, 1, 3), (1, 2, 3), (1, 3, 3))),
    *(((3, 3, 3, 3), sds) for sds in ((1, 1, 1, 1), (1, 1, 1, 3), (1, 1, 3, 3))),
)
"""Sizes and SD of the groups."""
SHAPES: Final = {
    "normal": np.random.Generator.standard_normal,
    "exponential": lambda rng, size: rng.exponential(size=size) - 1,
    "uniform": lambda rng, size: rng.uniform(-np.sqrt(3), np.sqrt(3), size),
}
"""Generators of values with mean 0 and SD 1."""
SEED: Final = 54
MORE: Final = 50
N_BOOTSTRAP: Final = 1_000


def draw(
    rng: np.random.Generator, shape: str, n: np.ndarray, sds: tuple[int, ...], n_sets: int
) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    """Draw values of each group, (n_sets, n), with their means and variances, (n_sets, k)."""
    groups = [sd * SHAPES[shape](rng, (n_sets, size)) for size, sd in zip(n, sds, strict=True)]
    mean = np.stack([own.mean(axis=1) for own in groups], axis=1)
    return groups, mean, np.stack([own.var(axis=1, ddof=1) for own in groups], axis=1)


def by_welch(n: np.ndarray, mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    f, df = welch_f(n, mean, variance)
    p: np.ndarray = scipy.stats.f.sf(f, len(n) - 1, df)
    return p


def by_bootstrap(
    rng: np.random.Generator, n: np.ndarray, mean: np.ndarray, variance: np.ndarray
) -> float:
    k = len(n)
    drawn = rng.normal(0, np.sqrt(variance / n), (N_BOOTSTRAP, k))
    spread = variance * rng.chisquare(n - 1, (N_BOOTSTRAP, k)) / (n - 1)
    return float(np.mean(welch_f(n, drawn, spread)[0] >= welch_f(n, mean, variance)[0]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=2_000, help="of groups in each row")
    parser.add_argument("--shape", choices=SHAPES, default="normal", help="of the values")
    asked = parser.parse_args()
    n_sets, shape = asked.sets, asked.shape
    print(
        "| sizes | SD | permuted F | permuted Welch | larger p | bootstrap | Welch | Welch, more |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for sizes, sds in CASES:
        rng, n = np.random.default_rng(SEED), np.array(sizes)
        groups, *moments = draw(rng, shape, n, sds, n_sets)
        of_f, of_welch = (
            np.array(
                [permute_between(own, has_welch=has_welch).p for own in zip(*groups, strict=True)]
            )
            for has_welch in (False, True)
        )
        welch = by_welch(n, *moments)
        bootstrap = np.array([by_bootstrap(rng, n, *own) for own in zip(*moments, strict=True)])
        more = by_welch(n, *draw(rng, shape, n, sds, MORE * n_sets)[1:])
        each = (of_f, of_welch, np.maximum(of_welch, welch), bootstrap, welch, more)
        shares = [f"{np.mean(p <= SIGNIFICANT):.1%}".replace("%", " %") for p in each]
        cells = [", ".join(map(str, sizes)), ", ".join(map(str, sds)), *shares]
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
