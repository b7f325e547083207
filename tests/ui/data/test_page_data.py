"""The Data page: what is open, its findings and its pictures."""

from __future__ import annotations

from pathlib import Path

from data_page import answer, late_drive, late_page, opened, press, send, send_video, space_of

from pages import checked, texts


def test_the_page_opens_on_the_sample():
    page = opened()
    assert "Open now: Sample recordings (" in texts(page)
    assert page.table[0].value["Source"].tolist() == ["Truth", "X: FIR", "Y: NIR"]
    assert len(page.table[1].value) == 10


def test_an_input_is_shown_with_its_conversion_and_without_folders_of_the_machine():
    table = opened().table[0].value
    assert [name.replace("\\", "") for name in table["Files"]] == [
        "truth.csv",
        "fir.csv",
        "nir.csv",
    ]
    assert all("pixels" in text for text in table["Read as"])


def test_pictures_of_the_sample_are_found():
    shown = opened().table[1].value["Pictures"]
    assert shown.str.contains("mp4", regex=False).all()


def test_a_time_offset_found_is_applied_with_one_click(tmp_path: Path):
    page = opened()
    truth, late = late_drive(tmp_path)
    send(page, "upload_truth", ("truth.csv", truth))
    send(page, "upload_system_0", ("good.csv", truth.replace(b"track", b"score")))
    send(page, "upload_system_1", ("late.csv", late))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "3 frames too late" in texts(page)
    keys = [b.key for b in page.button if (b.key or "").startswith("apply_")]
    press(page, keys[0])
    assert space_of(page).opened.session.systems[1].offset_frames == -3
    assert "frames too late" not in texts(page)


def test_findings_stand_worst_first(tmp_path: Path):
    page = opened()
    truth, _ = late_drive(tmp_path)
    twice = truth + b"5,40,100,20,60,0\n"
    send(page, "upload_truth", ("truth.csv", twice))
    send(page, "upload_system_0", ("good.csv", truth.replace(b"track", b"score")))
    press(page, "open_upload")
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    badges = [one.value for one in page.markdown if "-badge[" in one.value]
    order = [("Error" in one, "Warning" in one) for one in badges]
    assert order == sorted(order, reverse=True)
    assert "Error" in badges[0]


def test_the_size_is_proposed_from_the_pictures_and_they_find_their_recording(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "drive.mp4")
    press(page, "open_upload")
    answer(page, fps=20.0)
    press(page, "open_upload")
    assert page.table[1].value["Size (px)"].tolist() == ["640 × 480"]
    assert "drive.mp4" in page.table[1].value["Pictures"][0].replace("\\", "")
    assert (space_of(page).picture_rows[0] == range(60)).all()


def test_the_first_pictures_frame_can_be_given(tmp_path: Path):
    page = late_page(tmp_path)
    send_video(page, "drive.mp4")
    press(page, "open_upload")
    answer(page, fps=20.0)
    press(page, "open_upload")
    (field,) = [one for one in page.number_input if "first picture" in one.label]
    field.set_value(1)
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert space_of(page).picture_rows[0].tolist() == list(range(-1, 59))
    assert "1 of 60 listed frames have no picture" in page.table[1].value["Pictures"][0]


def test_pictures_sent_later_can_be_chosen_and_taken_away_again(tmp_path: Path):
    page = opened()
    send_video(page, "more.mp4")
    (choice,) = [one for one in checked(page.run()).selectbox if one.label == "Pictures"]
    choice.set_value("more.mp4")
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert space_of(page).pictures[0].name == "more.mp4"
    (choice,) = [one for one in page.selectbox if one.label == "Pictures"]
    choice.set_value("no pictures")
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert 0 not in space_of(page).pictures


def test_removed_pictures_are_no_longer_offered(tmp_path: Path):
    page = opened()
    send_video(page, "more.mp4")
    checked(page.run())
    press(page, "remove_pictures")
    (choice,) = [one for one in page.selectbox if one.label == "Pictures"]
    assert "more.mp4" not in choice.options


def test_a_live_parameter_survives_a_correction_of_the_session(tmp_path: Path):
    page = opened()
    checked(page.slider(key="alpha").set_value(0.6).run())
    (submit,) = [one for one in page.button if one.label == "Use these pictures"]
    checked(submit.click().run())
    assert page.session_state["params"].alpha == 0.6


def test_findings_are_counted_with_what_they_mean_for_the_figures(tmp_path: Path):
    page = opened()
    truth, _ = late_drive(tmp_path)
    send(page, "upload_truth", ("truth.csv", truth + b"5,40,100,20,60,0\n"))
    send(page, "upload_system_0", ("good.csv", truth.replace(b"track", b"score")))
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    assert "1 error that makes figures wrong" in texts(page)


def test_what_only_may_be_looked_at_is_not_said_to_change_no_figure():
    page = opened()
    truth = b"frame,x,y,w,h\n0,9,9,40,90\n1,9,9,40,90\n2,9,9,40,90\n"
    both = b"frame,x,y,w,h,score\n0,9,9,40,90,0.9\n1,300,100,40,90,0.5\n"  # one of nobody
    send(page, "upload_truth", ("t.csv", truth))
    send(page, "upload_system_0", ("a.csv", both))
    send(page, "upload_system_1", ("b.csv", both + b"2,10,9,40,90,0.9\n"))
    checked(page.run())
    answer(page, width=640, height=480, fps=20.0)
    press(page, "open_upload")
    counts = [one.label for one in page.expander if "to look at" in one.label]
    assert "where the ground truth has nobody" in texts(page)
    assert len(counts) == 1
    assert "change" not in counts[0]
