"""What is read of a session beside truth and systems, by the core and by subjects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.inputs.session import Session


@dataclass(frozen=True)
class Input:
    """Files beside those of the truth and the systems, such as those of a subject.

    Attributes
    ----------
    name
        What they are called in `Dataset.inputs`; no system is called so where a session names them.
    is_named
        Whether a session names them.
    join
        The dataset with what they say of it, where the session names them.

    Raises
    ------
    InputError
        By `join`, if a file cannot be used; with file and line.
    """

    name: str
    is_named: Callable[[Session], bool]
    join: Callable[[Dataset, Session], Dataset]
