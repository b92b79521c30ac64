"""The pages as a person uses them, in a real browser; and as nobody should."""

import importlib.util
import json
import re
import shutil
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from irtiming.archive import rig_writer, writer
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import paper_scene, with_wheel_speed
from results_by_hand import result_by_hand

ROOT = Path(__file__).parents[2]
CHROMIUM = shutil.which("chromium")
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
FORM = {
    "Number": ["W-1"], "Signed by": ["Dr. A. Example"], "Name": ["Laboratory", "Customer"], "Street": ["Messweg 1"] * 2,
    "Postcode": ["38116"] * 2, "City": ["Braunschweig"] * 2, "Country (two letters)": ["DE"] * 2, "E-mail": ["a@example.org"] * 2,
}  # fmt: skip


def _hostile():
    spec = importlib.util.spec_from_file_location("hostile_requests", ROOT / "benchmarks" / "hostile_requests.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def hostile():
    """The benchmark of hostile requests."""
    return _hostile()


@pytest.fixture(scope="module")
def served(hostile, tmp_path_factory):
    """A server of a folder that has things outside it which it must not touch."""
    around = tmp_path_factory.mktemp("pages").resolve()
    hostile.lay_out(around)
    (around / "lab" / "run.nxs").unlink()
    with hostile.served(around) as found:
        yield found


@contextmanager
def _browser(served, *, patience_ms=180_000):
    """A page of a narrow browser that has come in; at its end no other host was asked, and the console has no error."""
    from playwright.sync_api import sync_playwright

    base, foreign, complaints = f"http://{served.host}", [], []
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS) as browser:
        page = browser.new_context(viewport={"width": 400, "height": 800}).new_page()
        page.on("request", lambda one: None if one.url.startswith((base, "data:", "ws:")) else foreign.append(one.url))
        page.on("console", lambda one: complaints.append(one.text) if one.type == "error" else None)
        page.set_default_timeout(patience_ms)
        page.goto(served.address)
        yield page
    assert foreign == []
    assert complaints == []


def test_a_few_dozen_hostile_requests_reach_nothing(hostile, served):
    """Oracle: the files on the disk, and what was written outside the folder; the benchmark does ten thousand of them."""
    before = hostile.state(served.around)
    counts, wrong = hostile.attack(served, n=60, seed=2)
    assert wrong == []
    assert counts["403"] > 10
    assert hostile.is_alive(served)
    assert hostile.state(served.around) == before


@pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")
def test_a_session_in_a_browser_from_the_plan_to_the_certificate(served):
    """Oracle: the truth of the simulated rig, the files on the disk, and what the browser asked of other hosts: nothing."""
    from playwright.sync_api import expect

    lab, base = served.around / "lab", f"http://{served.host}"
    with _browser(served) as page:
        expect.set_options(timeout=180_000)
        assert "token" not in page.url

        _start_rig(page, base, lab)
        _plan(page, base)
        _record(page, base)
        _analyse(page, base)
        _certify(page, base)
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
    truth = json.loads((lab / "simulated-rig" / "truth.json").read_text())
    found = json.loads((lab / "results" / "recordings.json").read_text())["parameters"]["trigger_delay"]
    assert abs(found["value"] - truth["trigger_delay_s"]) < 5 * found["standard_uncertainty"]


def _start_rig(page, base, lab):
    page.goto(f"{base}/rig")
    for label, value in (("Rows", "32"), ("Columns", "40"), ("Seconds of the rig in one of yours", "3")):
        page.get_by_label(label, exact=True).fill(value)
    page.get_by_role("button", name="Start the simulated rig").click()
    page.get_by_text("its files are in simulated-rig").wait_for()
    plan = lab / "simulated-rig" / "plan.toml"
    plan.write_text(plan.read_text().split("[references]")[0])  # a blackbody that settles takes its time


def _plan(page, base):
    page.goto(f"{base}/plan")
    page.get_by_text(re.compile("u.trigger delay. = ")).wait_for()
    samples = page.get_by_label("Samples in a turn").locator("[tabindex]")
    samples.focus()
    for key, value in (("PageDown", 500), ("PageDown", 100), ("ArrowRight", 150), ("ArrowLeft", 100)):
        samples.press(
            key
        )  # the next one when the server has answered: what it says of a key comes after other keys otherwise
        page.get_by_text(f"Samples in a turn: {value}", exact=True).wait_for()
    page.locator(".q-chip", has_text="9 Hz").locator(".q-chip__icon--remove").click()
    page.get_by_role("button", name="Write the plan").click()
    page.get_by_text("Record has it in its list").wait_for()


def _record(page, base):
    page.goto(f"{base}/record")
    _choose(page, "The rig's numbers", "(no estimate while recording)")
    for _ in range(4):  # a busy computer may be late for the rig; the same again goes on
        page.get_by_role("button", name="Record", exact=True).click()
        page.get_by_text("goes on; closing this page stops nothing").wait_for()
        page.goto(f"{base}/library")
        page.goto(f"{base}/record")
        ending = page.get_by_text(re.compile("complete:|ended early:"))
        ending.wait_for()
        if "complete" in ending.inner_text():
            break
        _choose(page, "The rig's numbers", "(no estimate while recording)")


def _analyse(page, base):
    page.goto(f"{base}/analyse")
    _choose(page, "Language of the report", "Deutsch")
    page.get_by_role("button", name="Analyse", exact=True).click()
    page.wait_for_url(re.compile("result="), wait_until="commit")
    page.get_by_text("value ± standard uncertainty").wait_for()
    page.frame_locator("iframe[title=report]").get_by_text("Unsicherheitsbudget").first.wait_for()


def _certify(page, base):
    page.get_by_role("link", name="Make a certificate").click()
    page.get_by_label("Number", exact=True).wait_for()
    for label, values in FORM.items():
        for number, value in enumerate(values):
            page.get_by_label(label, exact=True).nth(number).fill(value)
    page.get_by_role("button", name="Preview").click()
    page.frame_locator("iframe").get_by_text("No. W-1").wait_for()


def _choose(page, label, option):
    page.get_by_role("combobox", name=label, exact=True).click()
    page.get_by_role("option", name=option).click()


@pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")
def test_a_campaign_in_a_browser(served):
    """Oracle: the twin's delay within three u, in the table; the one file that is no recording; no other host asked."""
    lab, base = served.around / "lab", f"http://{served.host}"
    true_s = _record_a_camera(lab / "cameras")
    with _browser(served, patience_ms=120_000) as page:
        page.goto(f"{base}/campaigns")
        _choose(page, "Folder of recordings, or a CSV that lists them", "cameras")
        _choose(page, "What was measured on the rig", "cameras/rig.toml")
        _choose(page, "Language of the page", "Deutsch")
        page.get_by_role("button", name="Measure", exact=True).click()
        page.wait_for_url(re.compile("result="), wait_until="commit")
        page.frame_locator("iframe[title=campaign]").get_by_text("1 Kamera gemessen").wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
    told = json.loads((lab / "campaigns" / "campaign" / "campaign.json").read_text())
    assert [one["serial_number"] for one in told["lines"]] == ["A"]
    assert abs(told["lines"][0]["trigger_delay_s"] - true_s) < 3 * told["lines"][0]["u_trigger_delay_s"]
    assert [Path(one["files"][0]).name for one in told["broken"]] == ["junk.nxs"]


def _record_a_camera(folder):
    scene = with_wheel_speed(paper_scene(24, 32), 3.0, frame_hz=30.303, samples=200)
    drawn = draw(replace(scene, radiance=replace(scene.radiance, reference_frames=20)), seed=5)
    folder.mkdir()
    rig_writer.write_rig(drawn.measured, folder / "rig.toml")
    one = simulate(drawn.scene, seed=1, name="A")
    writer.write(replace(one, camera=replace(one.camera, serial_number="A")), folder / "A.nxs")
    (folder / "junk.nxs").write_text("junk")
    return drawn.scene.timing.trigger_delay_s


@pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")
def test_a_history_in_a_browser(served):
    """Oracle: four results by hand, 1 us apart; the change by the last has u = sqrt(2) 0.3 us; no other host asked."""
    from playwright.sync_api import expect

    lab, base = served.around / "lab", f"http://{served.host}"
    (lab / "results").mkdir(exist_ok=True)
    names = []
    for number, day in enumerate(("2025-11-23", "2026-02-23", "2026-05-24", "2026-11-23")):
        result = result_by_hand(400e-6 + number * 1e-6, start=f"{day}T10:00:00Z", serial="H7")
        names.append(f"results/H7-{day}.json")
        (lab / names[-1]).write_text(result.model_dump_json())
    with _browser(served) as page:
        page.goto(f"{base}/history?camera=H7")
        page.get_by_role("combobox", name="Results", exact=True).click()
        for name in names:
            option = page.get_by_role("option", name=name)
            if option.get_attribute("aria-selected") != "true":
                option.click()
            expect(option).to_have_attribute("aria-selected", "true")  # a choice counts when the server has answered
        page.keyboard.press("Escape")
        page.get_by_role("button", name="Enter", exact=True).press("Enter")
        page.get_by_text("4 new of 4").wait_for()
        page.get_by_role("heading", name="Drift since the last calibration").wait_for()
        row = page.get_by_role("row", name=re.compile("trigger delay .*2026-05-24 … 2026-11-23"))
        assert "1.00 ± 0.42 µs" in row.inner_text()
        page.get_by_role("img", name="Control chart of trigger delay").wait_for()
        page.get_by_role("heading", name="4 results of").wait_for()
        since = page.get_by_label("Drift since (a day)", exact=True)
        since.fill("2026-01-31")
        since.press("Enter")
        page.get_by_role("row", name=re.compile("trigger delay .*2025-11-23 … 2026-11-23")).wait_for()
        since.fill("today")
        since.press("Enter")
        page.get_by_text("must be a day such as 2026-01-31").first.wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
