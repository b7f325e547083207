"""What a conductor may decide."""

import json
import math
from dataclasses import asdict

import pytest

from nvcore.common.errors import InputError
from nvcore.subjects.driver.study.settings import Facts, StudySettings, Timing


def test_the_papers_times_make_three_kinds_of_run():
    assert Timing().pairs == [(0, 4), (1, 5.5), (2.5, 7)]


def test_the_answer_to_the_first_picture_ends_before_the_second():
    Timing(answer_s=3.0)  # 0.5 s picture, 3 s answer, 0.5 s cross: 4 s
    with pytest.raises(InputError, match=r"comes 4 s after the first, which needs 4\.1 s"):
        Timing(answer_s=3.1)
    Timing(answer_s=0, adaptation_s=(0, 0.1))  # without a limit it may come late


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"adaptation_s": (0, 1, 2)}, "even number, rising; got 3: 0, 1 and 2"),
        ({"adaptation_s": (0, 0.04), "answer_s": 0}, "0 s and the next are less than 50 ms apart"),
        ({"adaptation_s": (1, 0)}, "even number, rising"),
        ({"adaptation_s": (0, math.nan)}, "0 to 600"),
        ({"adaptation_s": (-1, 8)}, "0 to 600"),
        ({"adaptation_s": range(26)}, "expected 24 at most, got 26"),
        ({"bright_s": -1}, "bright_s: expected 0 to 600 s, got -1"),
        ({"show_s": 0}, "more than 0"),
    ],
)
def test_impossible_times_are_refused(wrong, words):
    with pytest.raises(InputError, match=words):
        Timing(**wrong)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"design": "some"}, "all or latin"),
        ({"consent": " "}, "1 to 20,000"),
        ({"questions": ("a", "a")}, "the same"),
        ({"questions": ("",)}, "1 to 300"),
        ({"questions": tuple("abcdefghijklmnopqrstu")}, "20 own questions"),
        ({"n_practice": 11}, "0 to 10"),
        ({"keep_days": 0}, "1 to 3650"),
    ],
)
def test_impossible_settings_are_refused(wrong, words):
    with pytest.raises(InputError, match=words):
        StudySettings(**wrong)


def test_lengths_and_light_levels_are_above_0_or_unknown():
    with pytest.raises(InputError, match="dark_lux: expected a number above 0, got 0"):
        Facts(dark_lux=0)
    assert Facts().screen_text({}) == ""
    assert Facts(distance_cm=60).screen_text({"screen_inch": "24"}) == "24 inch, 60 cm away"


def test_settings_are_the_same_after_they_were_written():
    settings = StudySettings(
        design="all",
        timing=Timing(answer_s=1, adaptation_s=(0, 5), bright_s=30.5),
        facts=Facts(bright_lux=1000, dark_lux=10),
        questions=("Glasses?", "age"),
    )
    again = StudySettings.from_json(json.loads(json.dumps(asdict(settings), allow_nan=False)))
    assert again == settings
    assert list(again.form)[-2:] == ["1. Glasses?", "2. age"]
