"""The first visitor finds what every visitor starts with compared, judged and audited."""

from __future__ import annotations

import pytest

from nvcore import auditing
from pages import alone, checked
from ui.jobs import companions
from ui.serving.life import prepare_start
from ui.session import results, sample, state


def test_the_first_visitor_need_not_wait_for_the_comparison(monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("it was not prepared")

    monkeypatch.setattr(sample, "_samples", type(sample._samples)())
    prepare_start()
    monkeypatch.setattr(state, "compare", refuse)
    monkeypatch.setattr(results, "evidence_table", refuse)
    monkeypatch.setattr(results, "judge_miss_rate", refuse)
    monkeypatch.setattr(companions, "find_companions", refuse)
    for name in ("audit_inputs", "audit_system", "audit_pair"):
        monkeypatch.setattr(auditing, name, refuse)
    page = checked(alone("overview").run())
    assert not page.error
