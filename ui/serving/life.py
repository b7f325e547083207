"""What the server does when it starts and when it ends."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from ui.serving.preparing import begin_to_prepare
from ui.session import ending, folders


@asynccontextmanager
async def lifespan(_app: Any) -> AsyncIterator[None]:
    """Ends sessions on the server's own loop; uploads go with the server, however it is stopped."""
    ending.close_sessions_on(asyncio.get_running_loop())
    begin_to_prepare()
    try:
        yield
    finally:
        folders.remove_own()
