"""From results to points: which camera, which setting, and what each number has in common with those of other results.

Common are inputs of the rig: all of type B, and of type A those of wheel and mask. An input that rig.toml states is the same in
two results where it states the same number with the same uncertainty; any other where rig.toml is the same file.
"""

from math import inf, isfinite

from irtiming.archive.result_model import Contribution, Result
from irtiming.errors import EstimationError
from irtiming.records.recording import USUAL_READOUT
from irtiming.records.setting_point import (
    CameraKey,
    PointParameter,
    SettingName,
    SettingPoint,
    in_time,
    is_same_setting,
)
from irtiming.records.sources import CLOCK, OF_THE_RIG, RIG_KEYS

_NORMAL_K = 2.0


def point(result: Result, *, label: str) -> SettingPoint:
    """What a result says, by name.

    Parameters
    ----------
    result
        Of one or several recordings.
    label
        Where it comes from, for people.

    Raises
    ------
    EstimationError
        If it determines no parameter, or its recordings have different settings.
    """
    names = [
        name for name, one in result.parameters.items()
        if one.value is not None and one.standard_uncertainty is not None
        and isfinite(one.value) and isfinite(one.standard_uncertainty) and one.standard_uncertainty > 0
    ]  # fmt: skip
    if not names:
        raise EstimationError("the result determines nothing of the camera; analyse more recordings", where=label)
    item = result.item
    starts = [one.start_time for one in result.inputs if one.start_time]
    codes = [one.code for one in result.findings if one.severity in ("warning", "doubt", "error")]
    return SettingPoint(
        label=label,
        camera=CameraKey(
            manufacturer=item.manufacturer or "", model=item.model or "", serial_number=item.serial_number or "",
            camera_type=result.camera, readout_mode=result.readout_mode or USUAL_READOUT[result.camera],
            event=result.frame_event,
        ),
        settings=_settings(result, label),
        parameters={name: _parameter(result, name) for name in names},
        start_time=min(starts, key=in_time, default=""),
        n_recordings=len(result.inputs),
        findings=tuple(dict.fromkeys(codes)),
        simulated=result.simulated,
    )  # fmt: skip


def _settings(result: Result, label: str) -> dict[SettingName, float | str]:
    """Those that all recordings agree on; none where it is not stated."""
    stated: dict[SettingName, list[float | str | None]] = {
        "integration_time": [one.integration_time for one in result.inputs],
        "frame_period": [one.frame_period for one in result.inputs],
        "internal_delay_set": [one.settings.internal_delay_set for one in result.inputs],
        "region_first_row": [one.settings.region_first_row for one in result.inputs],
        "rows": [None if one.image is None else one.image.rows for one in result.inputs],
        "gain_setting": [one.settings.gain_setting for one in result.inputs],
    }
    if result.camera != "photon":
        del stated["integration_time"]
    found: dict[SettingName, float | str] = {}
    for name, values in stated.items():
        known = [value for value in values if value is not None]
        if not known:
            continue
        if any(not is_same_setting(value, known[0]) for value in known):
            if name == "frame_period":
                continue  # one result may hold several frame rates, whose delays its analysis found to agree
            raise EstimationError(
                f"its recordings have several settings of {name} ({known[0]}, {known[-1]}); analyse each setting by itself",
                where=label,
            )
        found[name] = known[0]
    temperatures = [one.settings.sensor_temperature for one in result.inputs if one.settings.sensor_temperature]
    if temperatures:
        found["sensor_temperature"] = sum(temperatures) / len(temperatures)
    return found


def _parameter(result: Result, name: str) -> PointParameter:
    one = result.parameters[name]
    value, u = one.value or 0.0, one.standard_uncertainty or 0.0
    freedom = inf if one.effective_degrees_of_freedom is None else one.effective_degrees_of_freedom
    common: dict[str, float] = {}
    for part in result.contributions:
        adds = part.standard_uncertainty.get(name)
        if adds and isfinite(adds) and (part.type == "B" or part.source in OF_THE_RIG):
            sign = -1.0 if part.source == CLOCK and value < 0 else 1.0
            common[_input(part, result)] = sign * adds
    return PointParameter(
        value=value, standard_uncertainty=u, unit=one.unit, degrees_of_freedom=freedom,
        expanded_uncertainty=one.expanded_uncertainty or (one.coverage_factor or _NORMAL_K) * u,
        event=one.reference_event, common=common,
    )  # fmt: skip


def _input(part: Contribution, result: Result) -> str:
    """Name of an input by which it is known in other results."""
    key = RIG_KEYS.get(part.source)
    stated = next((one for one in result.rig.values if one.name == key), None)
    if stated is not None:
        return f"{part.source} | {key} = {stated.value} ± {stated.standard_uncertainty}"
    return f"{part.source} | {result.rig.sha256}"
