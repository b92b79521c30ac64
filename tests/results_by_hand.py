"""Results of a made-up photon camera on one rig, with the budget of its delay: own errors, and those of the rig."""

import re

from irtiming.archive.result_model import Result

OWN_S, RIG_S = 0.3e-6, 0.4e-6


def result_by_hand(
    delay_s, *, serial="A", window_s=250e-6, settings=None, rig="rig", start="2026-11-23T10:00:00+00:00", findings=()
):  # fmt: skip
    """A result with start and middle of integration; ``rig`` is the name and checksum of rig.toml."""
    u = (OWN_S**2 + RIG_S**2) ** 0.5
    values = {"trigger_delay": delay_s, "exposure_midpoint_delay": delay_s + window_s / 2}
    quantity = {
        "standard_uncertainty": u, "expanded_uncertainty": 2 * u, "coverage_factor": 2.0, "effective_degrees_of_freedom": None,
        "unit": "s", "reference_event": "start of integration", "sign": "positive: after",
    }  # fmt: skip
    parts = [("noise of the frames", "A", OWN_S), ("mask centre angle phi_M", "B", RIG_S)]
    content = {
        "method": "pixel-sum", "camera": "photon", "readout_mode": "snapshot",
        "item": {"manufacturer": "Maker", "model": "M1", "serial_number": serial, "firmware": None},
        "parameters": {name: quantity | {"value": value} for name, value in values.items()},
        "correlation": {"names": list(values), "matrix": [[1.0, 1.0], [1.0, 1.0]]},
        "contributions": [
            {"source": source, "type": kind, "standard_uncertainty": dict.fromkeys(values, size), "degrees_of_freedom": None,
             "share_percent": dict.fromkeys(values, 0.0), "unit": "s"}
            for source, kind, size in parts
        ],
        "findings": [{"code": code, "severity": "warning", "where": "", "what": "is odd"} for code in findings],
        "relative_delays": [], "budget": [], "edge_delays": None, "warnings": [], "geometry": {}, "wheel": None, "choices": {},
        "inputs": [
            {"file": "run.nxs", "sha256": f"{serial}{delay_s}{window_s}{start}", "frames": 10, "trigger_delay_time_set": 0.0,
             "rotation_speed": 3.0, "roi": [0, 1, 0, 1], "border_px": 1, "bad_pixels": 0, "axle_row_column_px": None,
             "integration_time": window_s, "image": {"rows": 120, "columns": 160}, "frame_period": 0.033, "start_time": start,
             "settings": settings or {}}
        ],
        "rig": {"file": "rig.toml", "sha256": rig, "values": [
            {"name": "mask.centre_angle", "value": -1.57 if rig == "rig" else float(len(rig)), "standard_uncertainty": 5e-4,
             "unit": "rad"},
        ]},
        "software": {},
    }  # fmt: skip
    return Result.model_validate(content)


def english_words_in(page):
    """Texts of a page and its figures that have one of the commonest English words, but for what is quoted as it is."""
    page = re.sub(r'<style.*?</style>|<span class="original".*?</span>', "", page, flags=re.DOTALL)
    texts = {
        " ".join(text.split())
        for text in re.findall(r"<!--(.*?)-->|>([^<>]+)<", page, flags=re.DOTALL)
        for text in text
    }
    english = re.compile(r"\b(the|of|and|from|by|each|rows?|frames?|what|delay|edge|wheel|is|are|per|time)\b")
    as_it_is = re.compile(
        r"Measuring timing properties of|glibc|(made|found) by hand|the shutter is|frames lost|HDF5 file"
    )
    return {text for text in texts if english.search(text) and not as_it_is.search(text)}
