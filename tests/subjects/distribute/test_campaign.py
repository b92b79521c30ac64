"""Campaigns of made-up cameras: what is taken together, how it is judged, what a restart does. Frames are in tests/round_trip."""

import csv
import json
from pathlib import Path

import pyarrow.parquet
import pytest
from typer.testing import CliRunner

from irtiming.archive import rig_writer
from irtiming.archive.campaign_table import in_folder
from irtiming.archive.limits_file import read_limits
from irtiming.cli.main import app
from irtiming.distribute.pieces import Seen
from irtiming.distribute.workers import workers
from irtiming.errors import ArchiveError, ReductionError
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.setting_point import CameraKey
from irtiming.session.campaign import Order, run
from irtiming.twin.rig import draw
from irtiming.twin.scene import paper_scene, with_wheel_speed
from results_by_hand import OWN_S, RIG_S, english_words_in, result_by_hand

LIMITS = """
[decision]
rule = "guard band"
[[limit]]
parameter = "trigger_delay"
lower = "395 us"
upper = "410 us"
"""


@pytest.fixture
def laboratory(tmp_path, monkeypatch):
    """A folder whose files "SERIAL DELAY_US" are looked at and analysed by hand; gives the folder and what was analysed."""
    scene = with_wheel_speed(paper_scene(24, 32), 3.0)
    rig_writer.write_rig(draw(scene, seed=5).measured, tmp_path / "rig.toml")
    (tmp_path / "limits.toml").write_text(LIMITS)
    (tmp_path / "in").mkdir()
    analysed = []

    def look(listed):
        text = listed.path.read_text()
        if text == "broken":
            raise ArchiveError("is not an HDF5 file", where=str(listed.path))
        camera = CameraKey(manufacturer="Maker", model="M1", serial_number=text.split()[0], camera_type="photon",
                           readout_mode="snapshot")  # fmt: skip
        return Seen(listed=listed, sha256=text.ljust(64, "0"), camera=camera, settings=CameraSettings(),
                    integration_time_s=250e-6, frame_period_s=0.033, size=(24, 32), wheel_hz=3.0)  # fmt: skip

    def analyse(unit):
        analysed.append(unit.recordings[0].name)
        serial, delay_us, *_ = unit.recordings[0].read_text().split()
        if delay_us == "nan":
            raise ReductionError("the wheel stood still")
        if delay_us == "gone":
            raise ArchiveError("cannot be read (stale file handle)")
        return result_by_hand(float(delay_us) * 1e-6, serial=serial, findings=("tail-unknown",)).model_dump()

    monkeypatch.setattr("irtiming.distribute.campaign.look", look)
    monkeypatch.setattr("irtiming.distribute.campaign.analysed", analyse)
    return tmp_path, analysed


def _record(folder, **texts):
    for name, text in texts.items():
        path = folder / "in" / name.replace("_", "/")
        path.parent.mkdir(exist_ok=True)
        path.with_suffix(".nxs").write_text(text)


def _order(folder, **more):
    told = {"source": folder / "in", "rig": folder / "rig.toml", "out": folder / "out", "limits": folder / "limits.toml",
            "scheduler": "here", "register": "none"}  # fmt: skip
    return Order(**(told | more))


def test_every_camera_is_judged_by_the_rule(laboratory):
    """Oracle: by hand: U = 1.0 us; 396.5 lies further than U inside, 395.5 and 394.5 nearer, 393.5 further out; ISO 14253-1."""
    folder, _ = laboratory
    _record(folder, a="A 396.5", b="B 395.5", c="C 394.5", d="D 393.5", e="broken", f="F nan", g="A 396.5")
    done = run(_order(folder))
    assert {one.camera.serial_number: one.judgement for one in done.campaign.lines} == {
        "A": "pass", "B": "conditional pass", "C": "conditional fail", "D": "fail",
    }  # fmt: skip
    assert [Path(one.files[0]).name for one in done.campaign.broken] == ["e.nxs", "f.nxs", "g.nxs"]
    assert "same recording" in done.campaign.broken[2].what
    with (folder / "out" / "table.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert [row["serial_number"] for row in rows] == ["A", "B", "C", "D"]
    assert float(rows[0]["U_trigger_delay_s"]) == pytest.approx(2 * (OWN_S**2 + RIG_S**2) ** 0.5)
    table = pyarrow.parquet.read_table(folder / "out" / "table.parquet")
    assert table.column("trigger_delay_s").to_pylist() == [float(row["trigger_delay_s"]) for row in rows]
    page = (folder / "out" / "campaign.html").read_text()
    assert "1 of 4 pass" in page
    assert "tail-unknown" in page


def test_limits_of_no_camera_and_warnings_of_results_are_on_page_and_table(laboratory):
    """Oracle: by hand; one of two cameras has limits of its own, with a small letter, and its results warn of a tail."""
    folder, _ = laboratory
    _record(folder, a="A 396.5", b="B 396.5")
    (folder / "limits.toml").write_text(
        LIMITS + LIMITS[LIMITS.index("[[") :].replace("us", "ms") + 'serial_number = "b"'
    )
    done = run(_order(folder))
    assert done.campaign.limits_of_none == ("b",)
    assert json.loads((folder / "out" / "campaign.json").read_text())["limits_of_none"] == ["b"]
    page = (folder / "out" / "campaign.html").read_text()
    assert "limits of the camera with serial number b, and no result of it" in page
    assert "warnings of their own, by code and how many: tail-unknown (2)" in page


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        (LIMITS + LIMITS[LIMITS.index("[[") :], "states trigger_delay of all cameras more than once"),
        (
            2 * (LIMITS[LIMITS.index("[[") :] + 'serial_number = "A"\n'),
            "of the camera with serial_number = 'A' more than once",
        ),
        ('[[limit]]\nparameter = "row_delay"\nlower = "40 us"\nupper = "40 us"', "upper = 40 us; they must differ"),
        ('[[limit]]\nparameter = "row_delay"\nlower = "40 us"\nupper = "30 us"', "upper = 30 us; exchange them"),
    ],
)
def test_limits_of_which_one_would_not_count_are_refused(tmp_path, limits, said):
    """Oracle: by hand; of two limits of one parameter neither is said to be the right one."""
    (tmp_path / "limits.toml").write_text(limits)
    with pytest.raises(ArchiveError, match=said):
        read_limits(tmp_path / "limits.toml")


def test_a_camera_may_have_limits_of_its_own_beside_those_of_all(tmp_path):
    """Oracle: by hand; each once."""
    own = LIMITS[LIMITS.index("[[") :] + 'serial_number = "A"'
    (tmp_path / "limits.toml").write_text(f"{LIMITS}{own}")
    assert [one.serial_number for one in read_limits(tmp_path / "limits.toml").limit] == [None, "A"]


def test_recordings_that_are_not_whole_and_copies_are_left_out(laboratory):
    """Oracle: by hand; of six recordings, two are in folders of the folder that are no run, and one below such a folder."""
    folder, _ = laboratory
    apart = {"set-aside/b": "A 402", "applied/c": "A 403", "monday/converted/old/d": "A 404"}
    for name, text in {"a": "A 400", "monday/a": "A 401", "my-set-aside/a": "A 405", **apart}.items():
        (folder / "in" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "in" / f"{name}.nxs").write_text(text)
    found = in_folder(folder / "in")
    assert [(one.path.name, one.run) for one in found] == [
        ("a.nxs", ""),
        ("a.nxs", "monday"),
        ("a.nxs", "my-set-aside"),
    ]
    assert len(in_folder(folder / "in" / "set-aside")) == 1


def test_the_page_of_a_campaign_in_german(laboratory):
    """Oracle: the same camera by hand; the common English words are not on the page."""
    folder, _ = laboratory
    _record(
        folder, a="A 396.5", b="B 395.5", monday_a="A 396.7", tuesday_b="B 395.3", wednesday_b="B 395.4", e="broken"
    )
    run(_order(folder, language="de"))
    page = (folder / "out" / "campaign.html").read_text()
    assert "1 von 2 bestanden" in page
    assert "Regelkarten" in page
    assert english_words_in(page) == set()


def test_a_restart_does_what_is_missing_or_has_changed(laboratory):
    """Oracle: the count of analyses; and the same table, byte for byte, where nothing has changed."""
    folder, analysed = laboratory
    _record(folder, a="A 400", b="B 401", f="F nan")
    run(_order(folder))
    table = (folder / "out" / "table.csv").read_bytes()
    assert sorted(analysed) == ["a.nxs", "b.nxs", "f.nxs"]
    next((folder / "out" / "results").glob("B-*.json")).unlink()
    run(_order(folder))
    assert analysed[3:] == ["b.nxs"]
    assert (folder / "out" / "table.csv").read_bytes() == table
    _record(folder, a="A 402", c="C 403")
    run(_order(folder))
    assert sorted(analysed[4:]) == ["a.nxs", "c.nxs"]


def test_a_file_that_could_not_be_read_is_tried_again(laboratory):
    """Oracle: the count of analyses; what the data do not tell is told no better the second time, a file may be there again."""
    folder, analysed = laboratory
    _record(folder, a="A 400", f="F nan", g="G gone")
    for names in (["a.nxs", "f.nxs", "g.nxs"], ["g.nxs"]):
        analysed.clear()
        broken = run(_order(folder)).campaign.broken
        assert sorted(analysed) == names
        assert [Path(one.files[0]).name for one in broken] == ["f.nxs", "g.nxs"]


def test_results_of_one_camera_are_a_mean_that_keeps_the_rig(laboratory):
    """Oracle: by hand: three runs of each camera; u^2 = own^2 / 3 + rig^2; repeatability is the spread of the runs."""
    folder, _ = laboratory
    delays = {"A": (400.0, 400.3, 399.7), "B": (403.0, 403.3, 402.7)}
    _record(folder, **{f"run{k}_{s}": f"{s} {us}" for s, many in delays.items() for k, us in enumerate(many)})
    campaign = run(_order(folder)).campaign
    found = campaign.lines[0].values["trigger_delay"]
    assert found.value == pytest.approx(400e-6)
    assert found.standard_uncertainty == pytest.approx((OWN_S**2 / 3 + RIG_S**2) ** 0.5, rel=1e-6)
    study = campaign.studies[0]
    assert (study.n_cameras, study.n_operators, study.n_repeats) == (2, 1, 3)
    assert study.repeatability**0.5 == pytest.approx(0.3e-6)
    assert study.rms_u_own == pytest.approx(OWN_S, rel=1e-6)


def test_a_list_names_operators_and_is_checked(laboratory):
    """Oracle: by hand: two operators, two runs, two cameras make a study; an unknown column and a missing file are refused."""
    folder, _ = laboratory
    lines = ["file,operator,run"]
    for serial in "AB":
        for operator in "xy":
            for number in "12":
                name = f"{serial}{operator}{number}"
                _record(folder, **{name: f"{serial} {400 + ord(serial) - 65}.{number} {operator}"})
                lines.append(f"in/{name}.nxs,{operator},{number}")
    (folder / "table.csv").write_text("\n".join(lines))
    study = run(_order(folder, source=folder / "table.csv")).campaign.studies[0]
    assert (study.n_cameras, study.n_operators, study.n_repeats) == (2, 2, 2)
    (folder / "table.csv").write_text("file,inspector\na.nxs,me")
    with pytest.raises(ArchiveError, match="has the column 'inspector'"):
        run(_order(folder, source=folder / "table.csv"))
    (folder / "table.csv").write_text("file\nnowhere.nxs")
    with pytest.raises(ArchiveError, match="nothing could be analysed"):
        run(_order(folder, source=folder / "table.csv"))


def _dies_once(piece):
    """Work that kills its process the first time that it is given 3."""
    import os
    from pathlib import Path

    number, folder = piece
    mark = Path(folder) / "died"
    if number == 3 and not mark.exists():
        mark.touch()
        os._exit(9)
    if number == 4:
        raise ValueError("of this piece alone")
    return number**2


def test_a_worker_that_dies_takes_nothing_along(tmp_path):
    """Oracle: squares; the piece whose worker died is done again, the one that fails says so, the rest is not touched."""
    import cloudpickle

    cloudpickle.register_pickle_by_value(__import__(__name__))
    with workers(n_workers=1) as pool:
        found = dict(pool.each(_dies_once, {str(k): (k, str(tmp_path)) for k in range(6)}))
    assert (tmp_path / "died").exists()
    failed = found.pop("4")
    assert found == {"0": 0, "1": 1, "2": 4, "3": 9, "5": 25}
    assert "ValueError: of this piece alone" in failed.what
    assert not failed.is_lasting


def test_the_command_enters_the_register_and_lists_what_is_broken(laboratory):
    """Oracle: by hand: three results of two cameras, once each; Python's own csv; one broken file named on the screen."""
    folder, _ = laboratory
    _record(folder, a="A 400", b="B 401", d="broken", monday_a="A 402")
    arguments = [
        "campaign", folder / "in", "--rig", folder / "rig.toml", "-o", folder / "out", "--scheduler", "here",
        "--register", folder / "register.sqlite", "--json", folder / "all.json",
    ]  # fmt: skip
    for new in (3, 0):
        done = CliRunner().invoke(app, [str(one) for one in arguments], env={"COLUMNS": "200"})
        assert done.exit_code == 0, done.output
        assert f"register: {new} new of 3 results" in done.output
    assert "d.nxs: is not an HDF5 file" in " ".join(done.output.split())
    told = json.loads((folder / "all.json").read_text())
    assert [(line["serial_number"], line["results"]) for line in told["lines"]] == [("A", 2), ("B", 1)]
    assert len(told["broken"]) == 1
