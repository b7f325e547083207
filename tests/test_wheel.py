"""The wheel outside the checkout: a light core, and with its extra the whole dashboard."""

from __future__ import annotations

import signal
import subprocess

import pytest
from app_server import serving
from driver_trials import write_trials
from installed import LOOP, Installed, install
from places import ROOT

MISSING = "more packages: pip install 'nvcore"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    return install(tmp_path_factory.mktemp("wheel"))


def test_nothing_but_the_package_is_at_the_top(wheel: Installed):
    names = {path.name for path in wheel.site.iterdir()}
    assert names - {"__pycache__"} == {"nvcore", "nvcore-0.1.0.dist-info"}


def test_the_wheel_has_the_whole_dashboard(wheel: Installed):
    for part in ("app.py", "pages", "ui", "sample_data", ".streamlit"):
        source, copy = ROOT / part, wheel.dashboard / part
        pairs = [(source, copy)] if source.is_file() else [
            (path, copy / path.relative_to(source))
            for path in source.rglob("*")
            if path.is_file() and path.suffix != ".pyc"
        ]  # fmt: skip
        assert pairs
        for path, installed in pairs:
            assert installed.read_bytes() == path.read_bytes(), installed


def test_the_wheel_has_the_machine_code_made_for_it(wheel: Installed):
    assert (wheel.site / "nvcore" / "metrics" / "kernels" / "machine_code" / LOOP).exists()


def test_the_light_core_is_enough_for_these_commands(wheel: Installed):
    session = wheel.sample
    commands: list[tuple[object, ...]] = [
        ("compare", session, "--out", "report"),
        ("check", session),
        ("gate", session, "--rule", "encounters == 38"),
        ("plan", session, "--measure", "mean_similarity"),
        ("convert", session.with_name("truth.csv"), "a.json", "--to", "coco", "--size", "640x480"),
        ("sample", "copied"),
    ]
    for code, _, error in wheel.run_each(*commands):
        assert code == 0, error


def test_the_light_core_names_the_extra_for_others(wheel: Installed):
    extras: dict[tuple[object, ...], str] = {
        ("report", wheel.sample): f"the HTML report needs {MISSING}[report]'",
        ("app",): f"the dashboard needs {MISSING}[app]'",
        ("detect", wheel.sample, "--detector", "hog", "--out", "hog"): (
            f"detectors need {MISSING}[detectors]'"
        ),
        ("train", wheel.sample, "--out", "model.npz"): (
            f"training a detector needs {MISSING}[detectors]'"
        ),
        ("models",): f"nvcore models needs {MISSING}[detectors]'",
        ("driver", "train", "trials.csv", "--features", "f.csv", "--out", "driver.npz"): (
            f"nvcore driver train needs {MISSING}[driver]'"
        ),
    }
    told = [(2, "", f"Error: {text}\n") for text in extras.values()]
    assert wheel.run_each(*extras) == told


def test_from_python_the_light_core_compares_and_names_the_extra_of_figures(wheel: Installed):
    done = wheel.python(
        "import nvcore as nv\n"
        f"result = nv.compare({str(wheel.sample)!r})\n"
        "assert result.venn.n_near == 38 and 'In short' in str(result)\n"
        "for need in (lambda: result.figures, lambda: result.write_html('a.html'),\n"
        "             lambda: nv.figures, lambda: nv.pictures):\n"
        "    try:\n"
        "        need()\n"
        "    except nv.NvcoreError as error:\n"
        "        print(error)\n"
    )
    assert done.stdout.splitlines() == [
        f"figures need {MISSING}[report]'",
        f"the HTML report needs {MISSING}[report]'",
        f"figures need {MISSING}[report]'",
        f"pictures need {MISSING}[report]'",
    ], done.stderr


def test_the_extra_for_reports_is_enough_for_a_report(wheel: Installed):
    options = ("--only", "urban_crossing", "--no-stability", "--out", "night.html")
    done = wheel.run("report", wheel.sample, *options, extras=("report",))
    assert done.returncode == 0, done.stderr
    assert "encounters detected, of " in (wheel.folder / "night.html").read_text()


def test_the_extra_for_detectors_is_enough_for_one_but_onnx(wheel: Installed):
    part = ("--only", "urban_crossing", "--frames", "40:41", "--out", "hog")
    quick = ("--detector", "hog:daimler", "--set", "scale_step=1.5")
    done = wheel.run("detect", wheel.sample, *quick, *part, extras=("detectors",))
    assert done.returncode == 0, done.stderr
    done = wheel.run("models", "icf:sample", extras=("detectors",))
    assert done.returncode == 0, done.stderr
    assert "detects: pedestrian" in done.stdout
    model = wheel.folder / "model.onnx"
    model.write_bytes(b"\x08\x08\x12\x04test")
    done = wheel.run("models", model, extras=("detectors",))
    assert (done.returncode, done.stderr) == (2, f"Error: ONNX models need {MISSING}[onnx]'\n")


def test_the_extra_for_the_driver_is_enough_to_train(wheel: Installed):
    trials, features = write_trials(wheel.folder, 8, ("A", "B"))
    quick = ("--quick", "--out", "driver.npz")
    done = wheel.run(
        *("driver", "train", trials, "--features", features), *quick, extras=("driver",)
    )
    assert done.returncode == 0, done.stderr
    assert (wheel.folder / "driver.npz").is_file()


def test_the_dashboard_starts_and_ends_with_control_c(wheel: Installed):
    command = wheel.command("app", "--no-browser", "--port")
    environment = wheel.environment("app")
    with serving(command, cwd=wheel.folder, environment=environment) as (_, server):
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0


def test_a_session_that_names_no_file_ends_before_the_server_starts(wheel: Installed):
    session = wheel.folder / "gone.toml"
    session.write_text('[truth]\npath = "gone.csv"\n[[system]]\npath = "gone.csv"\n')
    command, environment = wheel.command("app", session), wheel.environment("app")
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=wheel.folder, env=environment, timeout=300
    )
    assert done.returncode == 2
    assert "gone.csv" in done.stderr
    assert done.stderr.count("\n") == 1
