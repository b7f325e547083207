"""Process from which the others are forked, with one thread and all modules that they need.

``python -m ui.confined.nursery SOCKET``, with the number of an open socket. Each message there
brings one end of a connection, for which a process is forked. That process sends its PID, receives
its memory limit, and answers calls until the connection closes. `multiprocessing` cannot be used,
as its processes import the main module of their parent, which in Streamlit is the page.
"""

from __future__ import annotations

import contextlib
import errno
import os
import resource
import signal
import socket
import sys
import traceback
from functools import partial
from importlib import import_module
from itertools import chain
from multiprocessing.connection import Connection
from pathlib import Path

import nvcore.inputs.load
import nvcore.pictures.open  # noqa: F401  # loaded for the forked processes
from nvcore.common.errors import NvcoreError
from ui.confined.transfer import Fault, Step, send_answer
from ui.settings.limits import MEBI
from ui.subject import subject_pages

ENDS_FIRST = "900"
"""OOM score (of 1000) at which the kernel kills these processes before the server.

Several large pictures at a time may fill the machine, even if each stays within its limit.
"""
CV_NO_MEMORY = -4
"""``code`` of OpenCV's error when it runs out of memory."""
MOST_TEXT = 300


def main(control: socket.socket) -> None:
    """Fork a process for each received connection, until the server has ended."""
    for module in chain(*(subject.preloaded for subject in subject_pages())):
        import_module(module)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C ends the server, which ends us
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the processes
    with contextlib.suppress(OSError):  # Linux only: where memory runs out, these end first
        Path("/proc/self/oom_score_adj").write_text(ENDS_FIRST, encoding="ascii")
    while True:
        message, descriptors, _, _ = socket.recv_fds(control, 1, 1)
        if not message:
            if os.getpgrp() == os.getpid():  # with all that it forked: nobody waits for them
                os.killpg(0, signal.SIGKILL)
            return
        try:
            number = os.fork()
        except OSError:  # no room for another process: the caller gets EOFError
            number = -1
        if number == 0:
            control.close()
            with contextlib.suppress(EOFError, OSError):
                answer_calls(Connection(descriptors[0]))
            os._exit(0)
        os.close(descriptors[0])


def answer_calls(theirs: Connection) -> None:
    """Answer each call with True and its return value, or False and its error."""
    theirs.send(os.getpid())
    _limit_memory(theirs.recv())

    def tell(share: float, words: str) -> None:
        send_answer(theirs, Step(share, words))

    while True:
        function, arguments, has_progress = theirs.recv()
        if has_progress:
            function = partial(function, progress=tell)
        try:
            answer = (True, function(*arguments))
        except NvcoreError as error:
            answer = (False, error)
        except MemoryError:
            answer = (False, MemoryError())
        except Exception as error:  # noqa: BLE001  # a bug of ours, reported as such
            is_no_memory = getattr(error, "errno", 0) == errno.ENOMEM or (
                getattr(error, "code", 0) == CV_NO_MEMORY
            )
            if not is_no_memory:
                traceback.print_exc()
            text = traceback.format_exception_only(error)[-1].strip()
            answer = (False, MemoryError() if is_no_memory else Fault(text[:MOST_TEXT]))
        send_answer(theirs, answer)
        del function, arguments, answer


def _limit_memory(n_mb: int) -> None:
    """Limit how much the address space may grow from now on (Linux only)."""
    statistics = Path("/proc/self/statm")
    if statistics.exists():
        n_bytes_now = int(statistics.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (n_bytes_now + n_mb * MEBI,) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
