r"""Gauge repeatability and reproducibility by analysis of variance, crossed: every operator measures every camera several times.

.. math:: y_{coj} = \mu + C_c + O_o + (CO)_{co} + E_{coj}

Mean squares of cameras, operators, their interaction and the rest give the variances (AIAG, Measurement Systems Analysis, 4th
ed., chapter III; ISO 22514-7). The interaction is pooled with the rest where its F-test gives a probability of more than 0.25. An
estimate below 0 becomes 0. With one operator it is the one-way analysis: repeatability and cameras alone.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from irtiming.records.arrays import Array
from irtiming.records.campaign import CampaignPoint, GaugeStudy
from irtiming.records.setting_point import CameraKey, groups, in_time

_POOLED = 0.25
_FEWEST_CAMERAS = 2
_SHARES = ("1", "")


def study(values: Array, *, parameter: str = "", unit: str = "", rms_u_own: float = 0.0) -> GaugeStudy:
    """Variances of a balanced study.

    Parameters
    ----------
    values
        Shape (camera, operator, repeat); at least two cameras and two repeats.
    parameter, unit, rms_u_own
        For the record.
    """
    n_c, n_o, n_r = values.shape
    grand, of_cell = values.mean(), values.mean(axis=2)
    of_camera, of_operator = values.mean(axis=(1, 2)), values.mean(axis=(0, 2))
    ss_c = n_o * n_r * float(np.sum((of_camera - grand) ** 2))
    ss_o = n_c * n_r * float(np.sum((of_operator - grand) ** 2))
    ss_co = n_r * float(np.sum((of_cell - of_camera[:, None] - of_operator[None] + grand) ** 2))
    ss_e = float(np.sum((values - of_cell[:, :, None]) ** 2))
    df_c, df_o, df_co, df_e = n_c - 1, n_o - 1, (n_c - 1) * (n_o - 1), n_c * n_o * (n_r - 1)
    ms_c, ms_e, p_value, interaction = ss_c / df_c, ss_e / df_e, None, 0.0
    if n_o == 1:
        operators, cameras = 0.0, (ms_c - ms_e) / n_r
    else:
        ms_o, ms_co = ss_o / df_o, ss_co / df_co
        p_value = float(fdtrc(df_co, df_e, ms_co / ms_e)) if ms_e > 0 else 0.0
        if p_value > _POOLED:
            ms_e = (ss_co + ss_e) / (df_co + df_e)
            ms_co = ms_e
        interaction = (ms_co - ms_e) / n_r
        operators, cameras = (ms_o - ms_co) / (n_c * n_r), (ms_c - ms_co) / (n_o * n_r)
    return GaugeStudy(
        parameter=parameter, unit=unit, n_cameras=n_c, n_operators=n_o, n_repeats=n_r, repeatability=ms_e,
        operators=max(0.0, operators), interaction=max(0.0, interaction), cameras=max(0.0, cameras),
        interaction_p_value=p_value, rms_u_own=rms_u_own,
    )  # fmt: skip


def studies(points: Sequence[CampaignPoint]) -> tuple[tuple[GaugeStudy, ...], str]:
    """A study of each parameter, over the setting with most results; and in words what was left out of it.

    Parameters
    ----------
    points
        Of any cameras. A study must be balanced: it takes the cameras of one kind that every operator measured, and as many
        repeats of each as there are of all.

    Returns
    -------
    No study where fewer than two cameras were measured twice; then the words say so.
    """
    cells = _cells(points)
    operators = sorted({operator for _, operator in cells})
    cameras = sorted({camera for camera, _ in cells}, key=lambda camera: camera.serial_number)
    whole = [camera for camera in cameras if all(len(cells.get((camera, one), ())) >= 2 for one in operators)]
    if len(whole) < _FEWEST_CAMERAS:
        return (), "repeatability takes two results or more, by every operator, of at least two cameras at one setting"
    n_repeats = min(len(cells[camera, one]) for camera in whole for one in operators)
    used = [[cells[camera, one][:n_repeats] for one in operators] for camera in whole]
    n_used = len(whole) * len(operators) * n_repeats
    left = len(points) - n_used
    flat = [each.point for row in used for cell in row for each in cell]
    names = [
        name for name, one in flat[0].parameters.items()
        if one.unit not in _SHARES and all(name in each.parameters for each in flat)
    ]  # fmt: skip
    found = []
    for name in names:
        given = [[[each.point.parameters[name] for each in cell] for cell in row] for row in used]
        values = np.array([[[one.value for one in cell] for cell in row] for row in given])
        own = [
            max(0.0, one.standard_uncertainty**2 - sum(c**2 for c in one.common.values()))
            for row in given for cell in row for one in cell
        ]  # fmt: skip
        unit = given[0][0][0].unit
        found.append(study(values, parameter=name, unit=unit, rms_u_own=float(np.sqrt(np.mean(own)))))
    words = f"{left} of {len(points)} results are not in the study, which must be balanced" if left else ""
    return tuple(found), words


def _cells(points: Sequence[CampaignPoint]) -> dict[tuple[CameraKey, str], list[CampaignPoint]]:
    """Results by camera and operator, of the kind of camera and the setting that most of them have; by run and time."""
    largest = {id(one) for one in max(groups((one.point for one in points), of_kind=True), key=len)}
    mine = [one for one in points if id(one.point) in largest]
    cells: dict[tuple[CameraKey, str], list[CampaignPoint]] = {}
    for one in sorted(mine, key=lambda each: (each.run, in_time(each.point.start_time), each.point.label)):
        cells.setdefault((one.point.camera, one.operator), []).append(one)
    return cells
