"""Sessions into a store: what is taken, what is told, and what one bad input leaves alone."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import drive, flags, nvcore, write
from store_writers import recordings

import nvcore as nv
from nvcore.common.errors import InputError, ParameterError, SessionError
from nvcore.dataset import Dataset
from nvcore.inputs.session import TABLES_OF_SUBJECTS, RecordingEntry, Session, Source, SystemSource
from nvcore.subjects.fleet import ingest as ingest_module
from nvcore.subjects.fleet.ingest import CARRIED, tables_of
from nvcore.subjects.fleet.store import Store, other_settings


def session(folder: Path, *lines: str) -> Path:
    """A session of `drive`."""
    drive(folder)
    return write(
        folder / "session.toml",
        "[defaults]", 'size = "640x480"', "fps = 20",
        "[truth]", 'path = "truth.csv"',
        "[[system]]", 'name = "FIR"', 'path = "fir.csv"', "threshold = 0.75",
        "[[system]]", 'name = "NIR"', 'path = "nir.csv"',
        *lines,
    )  # fmt: skip


def titled(folder: Path, number: int) -> Path:
    entries = (
        line
        for name in ("urban", "rural")
        for line in ("[[recording]]", f'name = "{name}"', f'title = "{name} {number}"')
    )
    return session(folder / str(number), *entries)


def test_a_session_is_stored_with_all_that_it_says(tmp_path: Path):
    path = session(
        tmp_path / "drive",
        "[[recording]]", 'name = "urban"', 'tags = ["night", "road=urban"]', 'unit = "car 7"',
        'recorded_at = "2026-03-01T00:20:00+01:00"', 'pictures = "urban.mp4"', "horizon = 250",
        "first_picture = 3",
        'context = "urban"', "speed_kmh = 50",
        "[[recording]]", 'name = "rural"', 'visible = "seen.mp4"',
    )  # fmt: skip
    (tmp_path / "drive" / "urban.mp4").touch()
    (tmp_path / "drive" / "seen.mp4").touch()
    done = nv.ingest(path, store=tmp_path / "store", labels={"FIR": "spring"})
    assert done.errors == {}
    assert done.not_stored == {"[[recording]] visible": 1}
    snapshot = nv.open_store(tmp_path / "store").snapshot()
    rural, urban = snapshot.recordings.to_dict("records")
    assert [*urban["tags"]] == ["night", "road=urban"]
    assert urban["recorded_at"] == pd.Timestamp("2026-02-28T23:20Z")
    assert Path(urban["pictures"]) == tmp_path / "drive" / "urban.mp4"
    assert urban["first_picture"] == 3
    assert (urban["unit"], urban["horizon"], urban["context"], urban["speed_kmh"]) == (
        "car 7", 250, 0, 50,
    )  # fmt: skip
    assert (rural["unit"], rural["pictures"], rural["recorded_at"]) == ("", "", pd.NaT)
    assert [*rural["objects"]] == ["pedestrian", "pedestrians"]
    assert urban["source"] == str(path)
    assert urban["duration_s"] == pytest.approx(1.0)
    sources = snapshot.sources.set_index(["recording", "source"])
    assert sources.loc[("urban", "FIR"), ["label", "kind", "threshold", "n_rows"]].tolist() == [
        "spring", "system", 0.75, 20,
    ]  # fmt: skip
    assert np.isnan(sources.loc[("urban", "NIR"), "threshold"])
    (digest,) = sources.loc[("rural", "truth"), "inputs"]
    assert digest == nv.load(path).inputs.query("subject == 'truth'")["sha256"].item()


def test_every_key_of_a_session_is_carried_or_named(tmp_path: Path):
    tables = {"[compare]": Session, "[[recording]]": RecordingEntry, "[[system]]": SystemSource}
    tables |= {f"[{name}]": kind for name, kind in TABLES_OF_SUBJECTS.items()}
    named = {
        *("[compare] x", "[compare] y", "[compare] accept", "[compare] operating_point"),
        *("[compare] rules", "[[system]] version_of"),
        *("[compare] primary", "[compare] protocol", "[compare] published", "[compare] codes"),
        *("[[recording]] visible", "[[recording]] visible_map"),
        *("[[recording]] light", "[[recording]] gaze"),
        *("[[system]] provenance", "[[system]] alerts", "[[system]] alert_policy"),
        "[driver] provenance",
    }
    carried = {f"{table} {name}" for table, names in CARRIED.items() for name in names.split()}
    keys = {f"{table} {of.name}" for table, kind in tables.items() for of in fields(kind)}
    assert carried | named == keys
    assert not carried & named
    path = session(
        tmp_path, 'alerts = "log.csv"', 'provenance = "made.json"',
        "[compare]", 'x = "NIR"', 'accept = ["no-match"]', 'operating_point = "as-set"',
        "[primary]", 'measure = "mean_similarity"', "[protocol]", "height_px = [50, 200]",
        "[codes]", 'path = "codes.csv"',
        "[[published]]", 'name = "ours"', "fppi = 0.1", "miss_rate = 0.2",
        "[[recording]]", 'name = "urban"', 'light = "lux.csv"',
    )  # fmt: skip
    write(tmp_path / "codes.csv", "recording,start_s,end_s,code", "urban,0,0.5,glare")
    write(tmp_path / "log.csv", "start_s,end_s,kind,recording", "0,0.5,own,urban")
    write(tmp_path / "lux.csv", "time_s,lux", "0,10", "0.5,12")
    done = nv.ingest(path, store=tmp_path / "store")
    assert done.errors == {}
    assert done.not_stored == dict.fromkeys(
        (
            *("[compare] x", "[protocol]", "[[published]]", "[compare] accept", "[[code]]"),
            *("[primary]", "[compare] operating_point", "[[recording]] light"),
            *("[[system]] provenance", "[[system]] alerts"),
        ),
        1,
    )


def test_settings_of_a_session_are_stored_and_a_scan_says_which_it_does_not_use(tmp_path: Path):
    store = tmp_path / "store"
    settings = ("[parameters]", "alpha = 0.5", "match = 'lateral'", "threshold_x = 0.8")
    nv.ingest(session(tmp_path / "a", *settings), recordings("b"), store=store)
    rows = nv.open_store(store).snapshot().recordings
    stated = '{"alpha": 0.5, "match": "lateral"}'
    assert rows["parameters"].to_dict() == {"b": "", "rural": stated, "urban": stated}
    done = nv.scan(store, tmp_path / "out", x="FIR", y="NIR", shard="0/1", alpha=0.6)
    assert done.summary.params.params == nv.Params(alpha=0.6)
    assert (
        "note: 2 of 2 recordings were ingested with other settings: alpha 0.5 (the scan uses 0.6), "
        "match lateral (the scan uses iou)"
    ) in str(done).splitlines()
    rows["parameters"] = [stated, '{"alpha": 0.6, "midpoint": 30}', ""]
    assert other_settings(rows, nv.Params(alpha=0.6, match="lateral")) == (
        "2 of 3 recordings were ingested with other settings: alpha 0.5 (the scan uses 0.6), "
        "midpoint 30 (the scan uses the default)"
    )
    assert other_settings(rows[:1], nv.Params(alpha=0.5, match="lateral")) == ""
    # the same input with other settings is no new version
    done = nv.ingest(session(tmp_path / "a", settings[0], settings[-1]), store=store)
    assert (len(done.sources), len(done.older)) == (0, 0)
    assert nv.open_store(store).snapshot().recordings["parameters"].tolist() == ["", "", ""]


def test_inputs_that_differ_in_parameters_alone_are_one_version(tmp_path: Path):
    plain = recordings("a")
    asking = plain.with_settings(replace(plain.settings, params=nv.Params(alpha=0.5)))
    for _ in range(2):
        done = nv.ingest(plain, asking, store=tmp_path)
        assert done.errors == {}
        assert Store(tmp_path).snapshot().recordings["parameters"].tolist() == ['{"alpha": 0.5}']
    assert len([*(tmp_path / "recordings").glob("*.parquet")]) == 1


def test_a_scan_takes_settings_by_name_and_no_alerts_of_logs(tmp_path: Path):
    for settings, error in (
        ({"alpa": 0.5}, r"there is no parameter 'alpa'; did you mean 'alpha'"),
        ({"alpha": 2}, "alpha"),
        ({"alerts": "log"}, "a store holds no alert logs, so a scan cannot use them"),
    ):
        with pytest.raises(ParameterError, match=error):
            nv.scan(tmp_path / "store", tmp_path / "out", x="FIR", y="NIR", **settings)
    assert "alpha=0.8" in (nv.scan.__doc__ or "")


def test_an_older_version_given_again_stays_older_unless_asked(tmp_path: Path):
    old, new = recordings("a", "b"), recordings("a", "b", seed=1, fps=25.0)
    for dataset in (old, new):
        assert nv.ingest(dataset, store=tmp_path).older.empty
    done = nv.ingest(old, store=tmp_path)
    assert done.older.to_numpy().tolist() == [[of, 1, 2, 2] for of in ("", "truth", "x", "y")]
    assert Store(tmp_path).snapshot().pick("x")["version"].tolist() == [2, 2]
    assert nv.ingest(old, store=tmp_path, newest=True).older.empty
    assert Store(tmp_path).snapshot().pick("x")["version"].tolist() == [1, 1]


def test_the_command_says_which_version_is_newest(tmp_path: Path):
    path, store = session(tmp_path), tmp_path / "store"
    earlier = (tmp_path / "fir.csv").read_text()
    nvcore("ingest", path, "--store", store)
    (tmp_path / "fir.csv").write_text(earlier.replace("0.9", "0.8"))
    nvcore("ingest", path, "--store", store)
    (tmp_path / "fir.csv").write_text(earlier)
    result = nvcore("ingest", path, "--store", store)
    assert result.stderr.splitlines()[-1] == (
        "note: FIR of 2 recordings is there as version 1; version 2 stays the newest (--newest "
        "changes that)"
    )
    assert "note" not in nvcore("ingest", path, "--store", store, "--newest").stderr
    assert Store(store).snapshot().pick("FIR")["version"].tolist() == [1, 1]


def test_what_is_stored_has_the_numbers_of_the_dataset(tmp_path: Path, kaist: Dataset):
    nv.ingest(kaist, store=tmp_path)
    names = kaist.recordings["name"].tolist()
    tables = Store(tmp_path).snapshot().read(names, ["truth", *kaist.systems])
    own = tables_of(kaist)
    assert len(kaist.boxes) == len(tables["boxes"])
    for name in ("frames", "boxes"):
        stored, made = tables[name].to_pandas(), own[name].to_pandas()
        order = np.argsort(made["recording"].astype(str), kind="stable")
        texts = made.select_dtypes("category").columns
        made, stored = (
            made.iloc[order].astype(dict.fromkeys(texts, object)),
            stored.astype(dict.fromkeys(texts, object)),
        )
        pd.testing.assert_frame_equal(stored, made.reset_index(drop=True))


def test_versions_do_not_depend_on_what_they_came_with(tmp_path: Path):
    both = recordings("a", "b")
    alone = both.only(names="b")
    nv.ingest(both, store=tmp_path)
    done = nv.ingest(alone, store=tmp_path)
    assert (len(done.recordings), len(done.sources), done.n_known) == (0, 0, 3)
    settings = replace(both.settings, params=nv.Params(threshold_x=0.5))
    done = nv.ingest(both.with_settings(settings), store=tmp_path)
    assert done.sources["source"].tolist() == ["x", "x"]
    assert Store(tmp_path).snapshot().pick("x")["threshold"].tolist() == [0.5, 0.5]


def test_pictures_that_have_moved_are_taken_with_their_first_frame(tmp_path: Path):
    dataset = recordings("a")
    for pictures, first, expected in (
        ("a.mp4", 5, ("a.mp4", 5)), ("b.mp4", None, ("b.mp4", None)), (None, None, ("b.mp4", None)),
    ):  # fmt: skip
        entry = RecordingEntry("a", pictures=pictures, first_picture=first)
        session = Session(tmp_path, Source(("t",)), (), (entry,))
        nv.ingest(replace(dataset, settings=session), store=tmp_path / "store")
        [row] = Store(tmp_path / "store").snapshot().recordings.to_dict("records")
        number = None if np.isnan(row["first_picture"]) else row["first_picture"]
        assert (Path(row["pictures"]).name, number) == expected


def test_many_sessions_are_one_commit_a_batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for number in range(6):
        titled(tmp_path / "drives", number)
    write(tmp_path / "drives" / "policy.toml", "pause_s = 3")
    monkeypatch.setattr(ingest_module, "BATCH_ROWS", 200)  # two sessions
    done = nv.ingest(tmp_path / "drives", store=tmp_path / "store")
    assert (len(done.recordings), len(done.sources)) == (12, 36)
    assert Store(tmp_path / "store").snapshot().versions["sources"] == 3
    assert nv.ingest(tmp_path / "drives", store=tmp_path / "store").n_known == 36
    assert Store(tmp_path / "store").snapshot().versions["sources"] == 3


def test_a_bad_input_among_good_ones_is_told_by_file_and_line(tmp_path: Path):
    for number in range(4):
        titled(tmp_path / "drives", number)
    (tmp_path / "drives" / "1" / "fir.csv").write_text(
        "recording,frame,x,y,w,h,score\nurban,0,1,2,3,4,0.5\nurban,1,x,2,3,4,0.5\n"
    )
    (tmp_path / "drives" / "2" / "session.toml").write_text("[truth\n")
    (tmp_path / "drives" / "3" / "truth.csv").write_bytes(bytes(range(256)) * 9)
    result = nvcore("ingest", tmp_path / "drives", "--store", tmp_path / "store")
    assert result.exit_code == 1
    assert "2 recordings (40 frames), 6 sources (91 boxes) appended" in result.stdout
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 3
    assert "1/fir.csv, line 3: " in errors[0]
    assert "2/session.toml" in errors[1]
    assert "3/truth.csv" in errors[2]
    names = Store(tmp_path / "store").snapshot().recordings["recording"].tolist()
    assert names == ["rural 0", "urban 0"]
    result = nvcore("ingest", tmp_path / "drives" / "2", "--store", tmp_path / "other")
    assert result.exit_code == 2
    assert not (tmp_path / "other").exists()


def test_one_name_for_two_recordings_is_refused(tmp_path: Path):
    session(tmp_path / "1")
    session(tmp_path / "2")
    lines = (tmp_path / "2" / "truth.csv").read_text().splitlines()
    write(tmp_path / "2" / "truth.csv", *lines[:-1], lines[-1].replace(",200,", ",210,"))
    done = nv.ingest(tmp_path, store=tmp_path / "store")
    (error,) = done.errors.values()
    assert "recording 'rural' is in" in str(error)
    assert "as well, with another 'truth'" in str(error)
    assert len(done.recordings) == 2
    done = nv.ingest(tmp_path / "2", store=tmp_path / "store")  # meant: it is a correction
    assert done.errors == {}
    assert done.sources[["recording", "source"]].to_numpy().tolist() == [["rural", "truth"]]


def test_flags_name_the_files_of_one_comparison(tmp_path: Path):
    drive(tmp_path)
    given = ("ingest", *flags(tmp_path), "--store", tmp_path / "store", "--label", "fir=v1")
    assert nvcore(*given, "--label", "truth=v2", "--tag", "none").exit_code == 2
    result = nvcore(*given, "--truth-kind", "automatic", "--only", "urban")
    assert (result.exit_code, result.stdout) == (
        0, "1 recording (20 frames), 3 sources (50 boxes) appended\n",
    )  # fmt: skip
    snapshot = Store(tmp_path / "store").snapshot()
    assert snapshot.pick("truth")["kind"].tolist() == ["automatic"]
    assert snapshot.pick("fir@v1")["recording"].tolist() == ["urban"]
    assert nvcore("ingest", "--store", tmp_path / "store").exit_code == 2
    result = nvcore(*given[:-1], "far=v1")
    assert result.exit_code == 1
    assert "error: label of far: no source is called so; did you mean 'fir'?" in result.stderr


def test_what_cannot_be_meant_is_refused(tmp_path: Path):
    data = recordings("a")
    for labels in ({"x": "12"}, {"x": " "}, {"x": "a@b"}, {"x": "v" * 101}):
        with pytest.raises(InputError, match="a version of 'x' cannot be called"):
            nv.ingest(data, store=tmp_path, labels=labels)
    with pytest.raises(ParameterError, match="the store that is given has its own"):
        nv.ingest(data, store=nv.open_store(tmp_path), storage={})
    with pytest.raises(InputError, match="expected annotated, automatic and absent, found 'anot'"):
        nv.ingest(data, store=tmp_path, truth_kind="anot")
    with pytest.raises(InputError, match="the ground truth is to be absent, and has 15 boxes"):
        tables_of(data, truth_kind="absent")
    with pytest.raises(InputError, match="two sources are called 'truth'; rename one"):
        tables_of(replace(data, systems=("truth", "y")))
    (tmp_path / "empty").mkdir()
    (error,) = nv.ingest(tmp_path / "empty", store=tmp_path).errors.values()
    assert "holds no session file" in str(error)
    path = session(tmp_path / "d", "[[recording]]", 'name = "urban"', 'recorded_at = "noon"')
    (error,) = nv.ingest(path, store=tmp_path).errors.values()
    assert isinstance(error, SessionError)
    assert "recorded_at: expected a time such as 2026-03-01T18:20:00+01:00" in str(error)
