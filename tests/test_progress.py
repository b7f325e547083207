"""Steps that run side by side, and how they are cancelled."""

from __future__ import annotations

from concurrent.futures import CancelledError, ThreadPoolExecutor
from threading import Event

import pytest

from nvcore.common.progress import no_progress, part_of, run_steps


def squares(n: int) -> list:
    return [lambda i=i: i * i for i in range(n)]


@pytest.mark.parametrize("n_threads", [0, 3])
def test_results_come_in_the_order_of_the_jobs(n_threads: int) -> None:
    if n_threads:
        with ThreadPoolExecutor(n_threads) as pool:
            assert run_steps(squares(20), pool, no_progress, "squares") == [
                i * i for i in range(20)
            ]
    else:
        assert run_steps(squares(20), None, no_progress, "squares") == [i * i for i in range(20)]


def test_nothing_to_do_is_done_at_once() -> None:
    shares: list[float] = []
    with ThreadPoolExecutor(1) as pool:
        for executor in (None, pool):
            assert run_steps([], executor, lambda share, _: shares.append(share), "none") == []
    assert shares == [1.0, 1.0]


def test_work_in_another_thread_is_cancelled_while_it_runs() -> None:
    may_end, is_second_begun = Event(), Event()
    shares: list[float] = []

    def progress(share: float, _what: str) -> None:
        shares.append(share)
        if len(shares) == 3:
            raise CancelledError

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(CancelledError):
            run_steps([may_end.wait, is_second_begun.set], pool, progress, "waiting")
        may_end.set()
    assert shares == [0, 0, 0]  # asked at intervals while nothing is done
    assert not is_second_begun.is_set()


def test_a_part_goes_from_one_share_of_the_whole_to_another() -> None:
    calls: list[tuple[float, str]] = []
    part = part_of(lambda share, what: calls.append((share, what)), 0.5, 0.75)
    part(0.0, "begin")
    part(1.0, "end")
    assert calls == [(0.5, "begin"), (0.75, "end")]
