"""Annotation files, read in a process of its own."""

from __future__ import annotations

from functools import partial
from typing import Any

from nvcore.dataset import Dataset
from nvcore.inputs.load import load, read_source
from nvcore.inputs.readers.base import Reading
from nvcore.inputs.session import Session, Source
from ui.confined.process import Allowance, call
from ui.settings.limits import limits_of_environment

WHAT = "reading the files"


def load_confined(session: Session) -> Dataset:
    """As `nvcore.inputs.load.load`.

    Raises
    ------
    InputError
        Also if it takes more frames, memory or time than the server allows.
    """
    read = partial(load, max_frames=limits_of_environment().max_frames)
    return call(read, session, allowance=_allowance(), what=WHAT)


def read_confined(source: Source, **options: Any) -> Reading:
    """As `nvcore.inputs.load.read_source`.

    Raises
    ------
    InputError
        Also if it takes more memory or time than the server allows.
    """
    return call(partial(read_source, **options), source, allowance=_allowance(), what=WHAT)


def _allowance() -> Allowance:
    limits = limits_of_environment()
    return Allowance(limits.reading_mb, limits.reading_s)
