"""``nvcore driver train`` and ``evaluate``: from files to a model and tables; what is refused."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import pytest
from driver_trials import write_trials
from inputs import nvcore

import nvcore as nv
from nvcore.common.errors import InputError
from nvcore.subjects.driver.estimators import QUICK, Search, read_estimator
from nvcore.subjects.driver.features import FeatureSettings
from nvcore.subjects.driver.features.feature_record import record_beside, record_bytes
from nvcore.subjects.driver.trials import Judging

SUBJECTS = ("A", "B", "C", "D", "E", "F")


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    quick = Search(n_settings=1, n_folds=2)
    monkeypatch.setattr("nvcore.subjects.driver.estimators.QUICK", quick)
    assert quick != QUICK
    return write_trials(tmp_path, 8, SUBJECTS)


def test_from_trials_to_a_model(files: tuple[Path, Path], tmp_path: Path):
    trials, features = files
    out = tmp_path / "driver.npz"
    ran = nvcore("driver", "train", trials, "--features", features, "--quick", "--out", out)
    assert ran.exit_code == 0, ran.output
    lines = ran.stdout.splitlines()
    assert lines[0] == (
        "288 trials by a simulated observer, not by people: 6 subjects, 8 pedestrians, "
        "6 adaptation periods"
    )
    titles = next(line for line in lines if "switched" in line)
    assert titles.split() == ["period", "switched", "single", "constant"]
    assert [line.split()[0] for line in lines if line.startswith("    ")][:1] == ["0.5"]
    assert any(line.lstrip().startswith("single  ") for line in lines)
    assert lines[-1].startswith("trained in ")
    assert f"nvcore driver estimate SESSION --model {out}" in ran.stderr
    estimator = read_estimator(out)
    assert estimator.name == "driver"
    assert estimator.origin.n_subjects == 6
    assert "\nfeatures and settings were chosen by a quick search\n" in ran.stdout
    described = nvcore("models", out).stdout
    assert "its estimates are learnt by a quick search" in described


def test_from_trials_to_tables_and_figures_on_one_page(files: tuple[Path, Path], tmp_path: Path):
    trials, features = files
    out = tmp_path / "evaluation.html"
    given = ("driver", "evaluate", trials, "--features", features, "--quick", "--html")
    ran = nvcore(*given, out)
    assert ran.exit_code == 0, ran.output
    assert f"figures written to {out}" in ran.stderr
    page = out.read_text("utf-8")
    for name in ("errors", "estimates", "periods", "histograms", "pairs", "ranks"):
        assert page.count(f'id="chart-{name}"') == 1
    assert "288 trials by a simulated observer, not by people" in page
    assert "By a quick search of 1 setting." in page
    assert "the mean of that row is 0.1418" in page
    assert page.count('<td class="right">mean</td>') == 1
    again, tables = tmp_path / "again.html", tmp_path / "tables"
    second = nvcore(*given, again, "--threads", "2", "--out", tables)
    assert second.stdout.splitlines()[:-1] == ran.stdout.splitlines()[:-1]  # the last: how long
    assert again.read_bytes() == out.read_bytes()
    assert "paper, switched" in ran.stdout
    assert "the mean of that row is 0.1418" in ran.stdout
    assert "by a quick search of 1 setting\n" in ran.stdout
    assert (tables / "errors.csv").read_text().count("\n") == 8
    assert {path.name for path in tables.glob("*.csv")} == {
        *("errors.csv", "choices.csv", "pairs.csv", "pair_ranks.csv"),
        *("periods.csv", "histograms.csv", "estimates.csv", "subjects.csv"),
    }
    assert (tables / "summary.txt").read_text() in second.stdout


def test_a_page_that_would_replace_an_input_is_refused_before_the_work(
    files: tuple[Path, Path], tmp_path: Path
):
    trials, features = files
    given = ("driver", "evaluate", trials, "--features", features, "--quick", "--html")
    named = nvcore(*given, trials)
    assert named.exit_code == 2
    assert "--html: expected a file that ends in .html" in named.stderr
    (folder := tmp_path / "evaluation.html").mkdir()
    with pytest.raises(InputError, match=r"is a folder; give the name of a file, such as eval"):
        nv.evaluate_driver(trials, features, html=folder, quick=True)


def test_the_square_can_be_an_angle(files: tuple[Path, Path], tmp_path: Path):
    trials, features = files
    lengths = ("--distance-mm", "270", "--shown-width-mm", "226", "--picture-width-px", "1920")
    out = tmp_path / "driver.npz"
    angle = ("--square-degrees", "5", *lengths, "--leave-out", "B", "--quick", "--out", out)
    ran = nvcore("driver", "train", trials, "--features", features, *angle)
    assert ran.exit_code == 0, ran.output
    assert "subject B is left out" in ran.stdout
    assert read_estimator(out).origin.square_px == pytest.approx(200.3, abs=0.1)


def test_the_model_notes_the_settings_and_pictures_of_its_features(
    files: tuple[Path, Path], tmp_path: Path
):
    trials, features = files
    out = tmp_path / "driver.npz"
    flags = ("driver", "train", trials, "--features", features, "--quick", "--out", out)
    words = "settings of the features are not known"
    assert words in nvcore(*flags).stdout
    assert read_estimator(out).feature_settings is None
    assert "trained on pictures of unknown or different sizes" in nvcore("models", out).stdout
    settings = FeatureSettings(surround=3)
    contents = {features.name: features.read_bytes()}
    entries = {"settings": {"features": asdict(settings)}, "picture_px": [960, 540]}
    record = record_bytes(contents, **entries)
    record_beside(features).write_bytes(record)
    assert words not in nvcore(*flags).stdout
    assert read_estimator(out).feature_settings == settings
    assert read_estimator(out).origin.picture_px == (960, 540)
    assert "trained on pictures of 960 x 540 px; estimates are for" in nvcore("models", out).stdout


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--square-degrees", "5"), "--square-degrees needs --distance-mm, --shown-width-mm"),
        (
            ("--square-degrees", "5", "--square-px", "9"),
            "--square-px or --square-degrees, not both",
        ),
        (("--distance-mm", "270"), "belong to --square-degrees"),
        (("--leave-out", "Z"), "there is no subject 'Z'"),
        (("--out", "{trials}"), "is an input, and would be replaced"),
        (("--out", "{trials}/m.npz", "--boxes", "gone.csv"), "cannot be written to; give another"),
        (("--boxes", "gone.csv"), "gone.csv: cannot be opened"),
    ],
)
def test_what_cannot_be_done_is_said(
    files: tuple[Path, Path], tmp_path: Path, options: tuple[str, ...], told: str
):
    trials, features = files
    given = [text.format(trials=trials) for text in options]
    out = () if "--out" in given else ("--out", tmp_path / "driver.npz")
    ran = nvcore("driver", "train", trials, "--features", features, "--quick", *given, *out)
    assert ran.exit_code == 2
    assert told in " ".join(ran.stderr.split())
    assert not (tmp_path / "driver.npz").exists()


def test_python_users_do_the_same(files: tuple[Path, Path], tmp_path: Path):
    trials, features = files
    training = nv.train_driver(
        trials,
        features,
        tmp_path / "m.npz",
        judging=Judging(square_px=150),
        quick=True,
        name="mine",
    )
    assert training.estimator.name == "mine"
    with pytest.raises(nv.NvcoreError, match="name: expected 1 to 200 printable characters"):
        nv.train_driver("gone.csv", features, tmp_path / "n.npz", name="n" * 201)
    assert read_estimator(tmp_path / "m.npz").origin.square_px == 150
    evaluation = nv.evaluate_driver(trials, features, quick=True)
    assert len(evaluation.rows) == 48
    with pytest.raises(nv.NvcoreError, match="cannot be written to; give another folder"):
        nv.evaluate_driver("gone.csv", features, trials / "tables")
