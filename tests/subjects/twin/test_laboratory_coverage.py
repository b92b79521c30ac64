"""The benchmark of laboratories: what it counts, and that it goes on where it stopped."""

import importlib.util
import json
import sys
from argparse import Namespace
from pathlib import Path

import pytest

from irtiming.twin.random_laboratory import Wanted

_SPEC = importlib.util.spec_from_file_location(
    "laboratory_coverage", Path(__file__).parents[3] / "benchmarks" / "laboratory_coverage.py"
)
coverage = importlib.util.module_from_spec(_SPEC)
sys.modules["laboratory_coverage"] = coverage
_SPEC.loader.exec_module(coverage)


def _line(seed: int, pull: float, *doubts: str) -> dict[str, object]:
    kind = json.loads(json.dumps(coverage.asdict(Wanted())))
    found = {"trigger_delay": {"error_s": pull * 1e-6, "u_s": 1e-6}}
    return {**kind, "seed": seed, "parameters": found, "withheld": [], "doubts": list(doubts), "warnings": []}


def test_numbers_far_off_count_where_no_doubt_is_said() -> None:
    """Oracle: four rigs by hand: rms of the pulls, shares within 1 and 2 u, one far off with a doubt and one without."""
    lines = [_line(0, 0.5), _line(1, -1.5), _line(2, 5.0, "lens-not-told"), _line(3, 6.0)]
    text = coverage.table([*lines, {**_line(4, 0.0), "refused": "ReductionError: no opening"}])
    assert "| trigger delay | 4 | 3.984 | 1.000 | 3.98 | 25% | 50% | 2 | 1 |" in text
    assert "4 of 5 rigs with a result, 1 of them in doubt; 1 refused; wrong without a word: 1, seeds [3]" in text
    assert "seed 4: ReductionError" in text


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: laboratories of the file are not tried again, a cut line is; those of another kind do not count."""
    path = tmp_path / "known.jsonl"
    older = {name: value for name, value in _line(0, 1.0).items() if name != "lens"}  # of before there were two kinds
    other = {**_line(1, 9.0), "wheel_hz": [3.0, 8.0]}
    path.write_text("\n".join(json.dumps(one) for one in (older, other)) + "\n" + json.dumps(_line(2, 1.0))[:50])
    tried = []

    class _Pool:
        def __init__(self, workers: int) -> None: ...
        def __enter__(self) -> "_Pool":
            return self

        def __exit__(self, *how: object) -> None: ...
        def map(self, _: object, seeds: list[int]) -> list[dict[str, object]]:
            tried.extend(seeds)
            return [_line(seed, 2.0) for seed in seeds]

    monkeypatch.setattr(coverage, "ProcessPoolExecutor", _Pool)
    options = Namespace(rigs=3, seed=0, workers=1, out=path, verbose=False)
    lines = coverage.tried(Wanted(), options, coverage.known_lines(path))
    assert tried == [1, 2]
    assert [line["seed"] for line in lines] == [0, 1, 2]
    assert lines[0]["parameters"]["trigger_delay"]["error_s"] == 1e-6
    assert [line["seed"] for line in coverage.known_lines(path)] == [0, 1, 1, 2]
