"""What participants are promised: the text of consent, and how long answers are kept."""

from __future__ import annotations

from typing import Final

from nvcore.errors import InputError

MOST_TEXT: Final = 20_000
"""Characters of a text of consent."""
LONGEST_KEPT_DAYS: Final = 3650
KEPT_DAYS: Final = 365
"""Days that answers are kept, unless the conductor says otherwise."""


def check_terms(consent: str, keep_days: int) -> None:
    """Refuse terms that cannot be.

    Raises
    ------
    InputError
        If there is no text or too long a one, or answers would be kept too briefly or too long.
    """
    if not 0 < len(consent.strip()) <= MOST_TEXT:
        raise InputError(f"the text of consent has 1 to {MOST_TEXT:,} characters")
    if not 1 <= keep_days <= LONGEST_KEPT_DAYS:
        raise InputError(f"answers are kept 1 to {LONGEST_KEPT_DAYS} days")
