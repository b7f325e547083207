"""How much more would it take? on the Overview page, run without a browser."""

from __future__ import annotations

import pytest
from inputs import write
from streamlit.testing.v1 import AppTest

from pages import begin_with, checked, figures, opened, part, session, texts
from ui.jobs.background import JobState
from ui.views.overview import plan


def alone() -> AppTest:
    """The question by itself."""
    evidence = "ui.session.results.measure_evidence(RESULT)"
    return checked(part(f"ui.views.overview.plan.draw(RESULT, {evidence}, None)").run())


def asked(app: AppTest) -> AppTest:
    return checked(app.button_group(key="overview_more").set_value("plan").run())


def verdict(app: AppTest) -> str:
    return " ".join(text.value for text in app.markdown[:2]).replace("\\", "")


def computed(app: AppTest) -> AppTest:
    job = app.session_state["workspace"].job(plan.RUN.name)
    job.join()
    assert job.state is JobState.DONE
    return checked(app.run())


def test_unfolding_the_question_asks_it_and_the_verdict_then_has_the_answer():
    app = asked(checked(opened()))
    assert "recordings to plan from" not in texts(app)
    app = computed(app)
    words = texts(app).replace("\\", "")
    answer = "a difference as large as found here (-0.083 s per encounter): no number of recordings"
    assert words.lower().count(answer) == 2  # in the verdict and below the question
    assert not any("How many recordings would show it" in str(plot) for plot in figures(app))
    checked(app.slider(key="alpha").set_value(0.5).run())  # another comparison: asked for anew
    assert "recordings to plan from" not in texts(app)
    assert app.button(key=f"{plan.RUN.name}_start")


def test_a_size_says_what_to_plan_for_and_has_its_power_drawn():
    app = alone()
    checked(app.selectbox(key="plan_measure").set_value("log_average_miss_rate").run())
    checked(app.button(key=f"{plan.RUN.name}_start").click().run())
    app = computed(app)
    words = texts(app).replace("\\", "")
    assert "would show a difference as large as found here (-5.3 pp) in 80 % of studies" in words
    assert " recordings: plan for " in words
    assert any("How many recordings would show it" in str(plot) for plot in figures(app))


def test_a_margin_asks_whether_a_system_is_at_most_so_much_worse():
    app = alone()
    checked(app.button_group(key="plan_question").set_value("y").run())
    assert "Give the margin" in texts(app)
    checked(app.selectbox(key="plan_measure").set_value("encounters_detected").run())
    checked(app.number_input(key="plan_y_encounters_detected").set_value(30.0).run())
    checked(app.button(key=f"{plan.RUN.name}_start").click().run())
    words = texts(computed(app)).replace("\\", "")
    assert "Y is shown to be at most 30.0 pp worse than X" in words
    assert "If X and Y are equal, about" in words


def test_few_recordings_are_no_pilot(tmp_path, monkeypatch: pytest.MonkeyPatch):
    two = session(tmp_path, "fir.csv", "nir.csv")
    rows = [f"urban,{f},100,200,40,100" for f in range(20)]
    write(tmp_path / "truth.csv", "recording,frame,x,y,w,h,track", *(f"{row},1" for row in rows))
    for name, kept in (("fir", rows), ("nir", rows[:5])):
        scored = (f"{row},0.9" for row in kept)
        write(tmp_path / f"{name}.csv", "recording,frame,x,y,w,h,score", *scored)
    begin_with(two, monkeypatch)
    app = alone()
    assert "A plan needs a pilot of 6 recordings or more" in texts(app)
    assert not [button for button in app.button if button.key == f"{plan.RUN.name}_start"]
