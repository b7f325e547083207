"""Names, personal codes and balanced orders of participants."""

from __future__ import annotations

import hashlib
import secrets
from typing import Final

import numpy as np

MOST_NAME: Final = 64
PSEUDONYM_LENGTH: Final = 8
CODE_LETTERS: Final = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""Letters and digits that are not easily confused."""


def draw_pseudonym() -> str:
    """Draw a random name for tables, which says nothing about the person."""
    return "".join(secrets.choice(CODE_LETTERS) for _ in range(PSEUDONYM_LENGTH))


def draw_code() -> str:
    """Draw a personal code, such as ABCD-EFGH-2345.

    It has 60 random bits, too many to guess, or to search for the code of a known hash.
    """
    return "-".join("".join(secrets.choice(CODE_LETTERS) for _ in range(4)) for _ in range(3))


def hash_code(token: str, code: str) -> str:
    """Return the hash of a personal code, whatever capitals, spaces and hyphens are typed.

    Examples
    --------
    >>> hash_code("study", "abcd-2345") == hash_code("study", " ABCD2345")
    True
    """
    letters = "".join(letter for letter in code.upper() if letter.isalnum())
    return hashlib.sha256(f"{token} {letters}".encode()).hexdigest()


def counterbalanced_order(n_items: int, participant: int) -> np.ndarray:
    """Return the order of items for one participant: a row of Williams' Latin square (1949).

    Over `n_items` participants (twice as many where that is odd) every item stands in every place
    equally often, and follows every other item equally often.

    Parameters
    ----------
    participant
        0-based number of the participant. Beyond the square it starts again.

    Examples
    --------
    >>> counterbalanced_order(4, 0).tolist(), counterbalanced_order(4, 1).tolist()
    ([0, 1, 3, 2], [1, 2, 0, 3])
    """
    steps = np.arange(n_items)
    zigzag = np.where(steps % 2 == 1, (steps + 1) // 2, (n_items - steps // 2) % max(n_items, 1))
    order: np.ndarray = (zigzag + participant) % max(n_items, 1)
    is_mirrored = n_items % 2 == 1 and participant // max(n_items, 1) % 2 == 1
    return order[::-1] if is_mirrored else order
