"""Deletes the answers of finished studies, even if nobody opens their pages."""

from __future__ import annotations

import asyncio
import logging
from typing import Final

from nvcore.errors import InputError
from ui.subjects import contributed

EVERY_S: Final = 3600.0
"""Often enough that a study is deleted on the day it ends."""
_LOG = logging.getLogger("nvcore.ui")


async def keep_deleting_ended() -> None:
    """Delete finished studies now and every hour, until cancelled."""
    while True:
        await asyncio.to_thread(delete_ended)
        await asyncio.sleep(EVERY_S)


def delete_ended() -> None:
    """Delete finished studies with all their answers."""
    for studies in contributed("STUDIES"):
        if not studies.file().is_file():
            continue
        try:
            studies.store()  # opening it deletes them
        except InputError as error:
            _LOG.warning("Could not delete the answers of finished studies: %s", error)
