"""Faults in the simulated rig while it is recorded, and a program that is killed: the quick part of two benchmarks."""

import importlib.util
import os
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("genicam", reason="the extra irtiming[rig] is not installed")
pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")
pytest.importorskip("pymeasure", reason="the extra irtiming[rig] is not installed")

from irtiming.twin.rig import draw
from irtiming.twin.scene import paper_scene

ROOT = Path(__file__).parents[2]
SPEED = 8.0


def _benchmark(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


faults = _benchmark("fault_injection")
killed = _benchmark("killed_series")


@pytest.fixture(scope="module")
def rig():
    scene = paper_scene(faults.ROWS, faults.COLUMNS)
    return draw(replace(scene, faults=replace(scene.faults, lost_frames=0)), seed=1)


def _address(last):
    pid = os.getpid()
    return f"127.{pid >> 14 & 63 | 64}.{pid >> 7 & 127}.{pid & 127 | 128 if last else pid & 127}"


@contextmanager
def _quick():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(faults, "SPEEDS", (SPEED,))
        yield


@pytest.mark.parametrize(
    ("kinds", "may_be"),
    [
        ("packets lost,triggers missed", None),
        ("first triggers missed,spurious frames", None),
        ("generator garbled,Ctrl-C", None),
        ("blackbody drifts,packets lost for ever", None),
        ("chopper: wrong blade", {faults.REFUSED}),
        ("blackbody: bit error", {faults.REFUSED}),
    ],
)
def test_no_recording_is_wrong_without_saying_so(rig, kinds, may_be):
    """Oracle: the twin, which knows the frame of each trigger, each edge and each temperature; a file that is taken has them."""
    with _quick():
        told = faults.attempt(rig, 20, kinds=kinds.split(","), address=_address(0))
    assert not {faults.WRONG, faults.TRACEBACK, faults.HUNG} & set(told["results"]), told
    if may_be is not None:
        assert set(told["results"]) <= may_be, told


def test_a_rig_without_faults_is_recorded(rig):
    """Oracle: the same twin; refusing everything would be no answer. A busy computer may spoil one run, not three."""
    for seed in (20, 21, 22):
        with _quick():
            told = faults.attempt(rig, seed, kinds=["nothing"], address=_address(0))
        assert set(told["results"]) <= {faults.COMPLETE, faults.REFUSED}, told
        if set(told["results"]) == {faults.COMPLETE}:
            return
    pytest.fail(f"three times nothing was recorded whole: {told}")


def test_the_witness_finds_a_frame_at_the_wrong_trigger(rig, monkeypatch):
    """Oracle: a camera whose first trigger made no frame, recorded by a program that trusts every pairing: it must be told."""
    monkeypatch.setattr(
        faults.Trial, "now_or_later", lambda self, of, **values: [setattr(of, *v) for v in values.items()]
    )
    monkeypatch.setattr("irtiming.acquire.pairing.Pairing._check_first", lambda *_: None)
    with _quick():
        told = faults.attempt(rig, 20, kinds=["first triggers missed"], address=_address(0))
    assert set(told["results"]) == {faults.WRONG}, told


@pytest.mark.slow
def test_a_killed_program_leaves_what_it_said_and_goes_on():
    """Oracle: what the program said to have written; the same command completes the series afterwards."""
    (left,) = killed.killed(1, seed=7, workers=1)
    assert left.problems == []
    assert left.missing <= 1
