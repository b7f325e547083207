"""Run one target in its own process, which a decoder, a hang or lack of memory may end.

python -m scripts.fuzz.worker TARGET STORE SECONDS
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from random import Random
from typing import Final

import atheris

ROOT: Final = Path(__file__).resolve().parents[2]
TIMEOUT_S: Final = 10
"""Maximum wall-clock time per input."""
MEMORY_MB: Final = 1500
"""Maximum memory of the process. Imports take a third of it."""
PLAIN: Final = 0.2
"""Share of libFuzzer's own changes if a target has its own mutations."""
COMPILED: Final = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in ROOT.glob("nvcore/**/*.py")
    if "kernels" in path.with_suffix("").parts or "\n@compiled" in path.read_text("utf-8")
]
"""Modules with loops whose compiler does not support the instrumentation of lines."""
with atheris.instrument_imports(include=["nvcore", "ui", "tomllib", "zipfile"], exclude=COMPILED):
    from scripts.fuzz.trial import Trial


def dictionary(words: Path) -> list[str]:
    """Return the fuzzer's flag for the words of the seeds, or none if there are no words."""
    return [f"-dict={words}"] if words.stat().st_size else []


def main() -> None:
    """Fuzz until the time is over, or the process ends."""
    name, store, seconds = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    with tempfile.TemporaryDirectory(prefix="nvcore-fuzz-") as folder:
        trial = Trial(name, store, Path(folder))
        trial.warm_up()
        corpus = store / "corpus" / name
        corpus.mkdir(parents=True, exist_ok=True)
        seeds, words = store / "seeds" / name, store / "seeds" / f"{name}.dict"
        flags = [
            f"-max_total_time={seconds}",
            f"-timeout={TIMEOUT_S}",
            f"-rss_limit_mb={MEMORY_MB}",
            f"-max_len={trial.target.most_bytes}",
            f"-artifact_prefix={trial.faults}/",
            *dictionary(words),
            "-len_control=0",
            "-reload=0",
            "-print_final_stats=1",
        ]

        def change(content: bytes, most: int, seed: int) -> bytes:
            mutate, rng = trial.target.mutate, Random(seed)
            if mutate is None or rng.random() < PLAIN:
                return bytes(atheris.Mutate(content, most))
            return mutate(content, rng)[:most]

        def try_one(content: bytes) -> None:
            trial(content)

        arguments = [sys.argv[0], *flags, str(corpus), str(seeds)]
        atheris.Setup(arguments, try_one, custom_mutator=change)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
