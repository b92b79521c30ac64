"""Which numbers recordings share whose rows are summed: by hand, from names alone."""

from types import SimpleNamespace

from irtiming.estimate.row_numbers import of_camera
from irtiming.physics.light.bent_rows import NONLINEARITIES
from irtiming.physics.response import pixel_memory

LAG, EDGES = "time_constant", tuple(f"edge_delay_{k}" for k in range(4))


class _Estimate:
    def __init__(self, names):
        self.names = names

    def __contains__(self, name):
        return name in self.names


def _fit(*names, **timing):
    return SimpleNamespace(estimate=_Estimate((*EDGES, *names)), timing=dict.fromkeys(names, 0.0) | timing)


def test_before_one_blackbody_each_number_of_the_camera_is_one():
    """Oracle: by hand; names in the order in which fits have them, each with its own local number wherever a fit has it."""
    fits = [_fit(LAG, "row_delay", time_constant=5e-3), _fit("row_delay", "integration_time")]
    first = _fit(LAG, "row_delay", "integration_time", time_constant=5e-3, integration_time=1e-3)
    found = of_camera(fits, first, blackbodies=[[0, 1]])
    assert [one.name for one in found] == [LAG, "row_delay", "integration_time"]
    assert [list(effects) for effects in found[1].effects] == [["row_delay"], ["row_delay"]]
    assert [one.start for one in found] == [5e-3, 0.0, 1e-3]
    assert all(one.u is None and one.unit == "s" for one in found)


def test_before_two_blackbodies_each_has_a_time_constant_and_edges_that_uncover_later():
    """Oracle: by hand; a cold one (recordings 0 and 2) and a warm one; edges 0 and 2 cover, 1 and 3 uncover, or the reverse."""
    fits = [_fit(LAG, "row_delay", time_constant=5e-3) for _ in range(3)]
    found = {one.name: one for one in of_camera(fits, fits[0], blackbodies=[[0, 2], [1]])}
    assert list(found) == [
        "row_delay",
        *(f"{what} of blackbody {k}" for k in (0, 1) for what in (LAG, "uncovering_later")),
    ]
    assert found[f"{LAG} of blackbody 0"].effects == [{LAG: 1.0}, {}, {LAG: 1.0}]
    assert found[f"{LAG} of blackbody 1"].start == 5e-3
    later = found["uncovering_later of blackbody 1"]
    assert later.effects == [{}, dict(zip(EDGES, (-1.0, 1.0, -1.0, 1.0), strict=True)), {}]
    assert later.start == 0


def test_a_bent_response_goes_with_the_blackbody_and_a_memory_is_small():
    """Oracle: by hand; the contrast bends it, so each blackbody has its own where it was fitted; a memory is small."""
    bend = NONLINEARITIES[0]
    fits = [_fit("row_delay", bend, **{bend: 0.02}), _fit("row_delay", pixel_memory.PARAMETER)]
    first = _fit("row_delay", pixel_memory.PARAMETER, bend)
    found = {one.name: one for one in of_camera(fits, first, blackbodies=[[0], [1]])}
    assert list(found) == ["row_delay", pixel_memory.PARAMETER, f"{bend} of blackbody 0"]
    assert found[f"{bend} of blackbody 0"].effects == [{bend: 1.0}, {}]
    assert (found[f"{bend} of blackbody 0"].unit, found[f"{bend} of blackbody 0"].start) == ("1", 0.02)
    memory = found[pixel_memory.PARAMETER]
    assert (memory.unit, memory.u, memory.known) == ("1", pixel_memory.U_SHARE, 0.0)
