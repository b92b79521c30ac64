"""Lines through slopes: against gnuplot's fit, with known lines, and given to the right wheel edge."""

import shutil
import subprocess

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate.published.slopes import fit, line_through
from irtiming.physics.wheel import exposed_fraction, slope_centres_rad, wheel_model
from irtiming.records.exposed import ExposedFraction
from irtiming.reduce.published import plateaus

TURN = 2 * np.pi
OMEGA = TURN * 3
EDGES = (0.0, 1.5718, 3.1421, 4.7125)


def _model(gate=0.2682):
    return wheel_model(EDGES, gate, opening_angle_rad=float(np.radians(75)), centre_angle_rad=float(np.radians(-90)))


def _points(seed):
    """A noisy slope with the paper's numbers; odd seeds fall, every third has angles of uneven quality."""
    rng = np.random.default_rng(seed)
    slope = (-1 if seed % 2 else 1) / np.radians(75)
    centre = rng.uniform(-1, 7)
    x = np.sort(centre + rng.uniform(-0.45, 0.45, 140) / abs(slope))
    u_x = np.full(x.size, 1e-3) if seed % 3 else rng.uniform(1e-4, 5e-3, x.size)
    u_y = rng.uniform(5e-4, 4e-3, x.size)
    y = 0.5 + slope * (x + rng.normal(0, u_x) - centre) + rng.normal(0, u_y)
    return x, y, u_x, u_y, slope, centre


@pytest.fixture(scope="module")
def gnuplot_fits(tmp_path_factory):
    """What gnuplot makes of twelve slopes: (m, c, u_m, u_c) with errors in both variables, and unweighted."""
    if shutil.which("gnuplot") is None:
        pytest.skip("gnuplot is not installed")
    folder = tmp_path_factory.mktemp("gnuplot")
    lines = ["set fit quiet nolog errorvariables errorscaling", "FIT_LIMIT = 1e-14", "f(x) = 0.5 + m * (x - c)"]
    for seed in range(12):
        *points, slope, centre = _points(seed)
        np.savetxt(folder / f"{seed}.dat", np.stack(points, axis=1), fmt="%.17g")
        for columns in ("1:2:3:4 xyerrors", "1:2"):
            lines += [
                f"m = {1.1 * slope}; c = {centre + 0.02}",
                f"fit f(x) '{folder / f'{seed}.dat'}' using {columns} via m, c",
                "print sprintf('%.15g %.15g %.15g %.15g', m, c, m_err, c_err)",
            ]
    (folder / "fit.gp").write_text("\n".join(lines) + "\n")
    ended = subprocess.run(["gnuplot", str(folder / "fit.gp")], capture_output=True, text=True, check=True, timeout=60)
    numbers = np.array([[float(v) for v in line.split()] for line in ended.stderr.splitlines()])
    assert numbers.shape == (24, 4), ended.stderr
    return numbers.reshape(12, 2, 4)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("weighted", [True, False])
def test_line_agrees_with_gnuplot(gnuplot_fits, seed, weighted):
    """Oracle: gnuplot's ``fit ... using 1:2:3:4 xyerrors via m, c`` and its unweighted form, on the same points."""
    x, y, u_x, u_y, *_ = _points(seed)
    (m, c), covariance, _ = line_through(x, y, u_x=u_x if weighted else None, u_y=u_y if weighted else None)
    theirs = gnuplot_fits[seed, 0 if weighted else 1]
    u = np.sqrt(np.diag(covariance))
    assert m == pytest.approx(theirs[0], abs=1e-3 * theirs[2])
    assert c == pytest.approx(theirs[1], abs=1e-3 * theirs[3])
    np.testing.assert_allclose(u, theirs[2:], rtol=0.01)


def test_exact_points_give_the_exact_line():
    """Oracle: the line that made the points."""
    x = np.linspace(1.0, 2.0, 30)
    (m, c), covariance, chi_square = line_through(x, 0.5 - 0.7 * (x - 1.4), u_x=None, u_y=None)
    assert m == pytest.approx(-0.7, abs=1e-12)
    assert c == pytest.approx(1.4, abs=1e-12)
    assert chi_square < 1e-25
    assert np.all(np.abs(covariance) < 1e-20)


@pytest.mark.parametrize("offset", [0.0, 500.0])
def test_pulls_of_the_centre_are_standard(offset):
    """Oracle: 500 noisy lines with known centre; pulls have mean 0 and spread 1, wherever the angle zero is."""
    rng = np.random.default_rng(3)
    x = offset + np.linspace(-0.5, 0.5, 100)
    pulls, chi_squares = [], []
    u_x, u_y = np.full(100, 2e-3), np.full(100, 3e-3)
    for _ in range(500):
        y = 0.5 + 0.76 * (x + rng.normal(0, 2e-3, 100) - offset - 0.1) + rng.normal(0, 3e-3, 100)
        (_, centre), covariance, chi_square = line_through(x, y, u_x=u_x, u_y=u_y)
        pulls.append((centre - offset - 0.1) / np.sqrt(covariance[1, 1]))
        chi_squares.append(chi_square)
    assert abs(np.mean(pulls)) < 4 / np.sqrt(500)
    assert np.std(pulls) == pytest.approx(1, abs=0.13)
    assert np.mean(chi_squares) == pytest.approx(1, abs=0.03)


def test_uncertainties_are_scaled_by_the_scatter():
    """Oracle: by hand; stated uncertainties ten times too small change reduced chi square, not the result's u."""
    x, y, u_x, u_y, *_ = _points(5)
    line, covariance, chi_square = line_through(x, y, u_x=u_x, u_y=u_y)
    same, scaled, larger = line_through(x, y, u_x=u_x / 10, u_y=u_y / 10)
    assert same == pytest.approx(line, rel=1e-12)
    np.testing.assert_allclose(scaled, covariance, rtol=1e-9)
    assert larger == pytest.approx(100 * chi_square)


@pytest.fixture
def measured():
    """Averaged data of a noise-free wheel seen with a set delay and the camera's own."""

    def make(set_delay_s, *, own_delay_s=4.9e-4, gate=0.2682, n=1000):
        model = _model(gate)
        angle = np.mod(TURN * (np.arange(n) + 0.37) / n, TURN)
        fraction = exposed_fraction(angle + OMEGA * (set_delay_s + own_delay_s), model)
        return model, ExposedFraction(
            trigger_delay_time_set_s=set_delay_s,
            rotation_speed_hz=3.0,
            angular_frequency_rad_per_s=OMEGA,
            names=("a",),
            files=("a",),
            wheel_angle_rad=angle,
            fraction=fraction,
            u_wheel_angle_rad=None,
            u_fraction=None,
            plateaus=plateaus.find(angle, fraction, name="a"),
        )

    return make


@pytest.mark.parametrize("set_delay_s", np.arange(0, 0.1001, 0.005))
@pytest.mark.parametrize("gate", [0.2682, 0.95, -0.4])
def test_each_slope_goes_to_its_edge_for_any_delay(measured, set_delay_s, gate):
    """Oracle: the centres of figure 4(b), shifted to smaller angles by omega times the delay, wrapped at 2 pi."""
    model, data = measured(set_delay_s, gate=gate)
    found = fit(data, model, angular_frequency_rad_per_s=OMEGA, limits=(0.05, 0.95))
    shift = OMEGA * (set_delay_s + 4.9e-4)
    centres = np.array([line.centre_rad for line in found.lines])
    np.testing.assert_allclose(np.angle(np.exp(1j * (centres + shift - slope_centres_rad(model)))), 0, atol=1e-9)
    assert [line.edge for line in found.lines] == [0, 1, 2, 3]
    assert [line.slope_per_rad < 0 for line in found.lines] == [True, False, True, False]
    for line in found.lines:
        assert abs(line.slope_per_rad) == pytest.approx(1 / np.radians(75), rel=1e-6)
        assert np.all(np.diff(line.angle_rad) > 0)
        assert np.ptp(line.angle_rad) == pytest.approx(0.9 * np.radians(75), abs=0.02)
        assert 0.05 < line.fraction.min() < line.fraction.max() < 0.95


@pytest.mark.parametrize("centre_near", [0.2, TURN - 0.2])
def test_slope_across_the_end_of_the_turn_is_wrapped(measured, centre_near):
    """Oracle: by hand; edge 2's slope is put 0.2 rad to either side of the angle zero and stays in one piece."""
    model = _model()
    delay = np.mod(slope_centres_rad(model)[2] - centre_near, TURN) / OMEGA - 4.9e-4
    model, data = measured(float(delay))
    line = fit(data, model, angular_frequency_rad_per_s=OMEGA, limits=(0.05, 0.95)).lines[2]
    assert np.angle(np.exp(1j * (line.centre_rad - centre_near))) == pytest.approx(0, abs=1e-9)
    assert line.fraction.size == pytest.approx(0.9 * 75 / 0.36, abs=2)
    assert line.angle_rad[0] < line.centre_rad < line.angle_rad[-1]


def test_limits_are_obeyed(measured):
    """Oracle: the fractions of the points used."""
    model, data = measured(0.0)
    lines = fit(data, model, angular_frequency_rad_per_s=OMEGA, limits=(0.3, 0.6)).lines
    assert all(0.3 < line.fraction.min() < line.fraction.max() < 0.6 for line in lines)


def test_too_few_points_are_refused(measured):
    """Oracle: by hand; 1000 points a turn leave 208 on a slope and 8 between 0.48 and 0.52."""
    model, data = measured(0.0)
    with pytest.raises(EstimationError, match=r"slope of edge . has [789] points between 0.48 and 0.52, at least 10"):
        fit(data, model, angular_frequency_rad_per_s=OMEGA, limits=(0.48, 0.52))


@pytest.mark.parametrize("n", [5, 12])
def test_covariance_of_a_line_through_few_points_is_that_of_many_draws(n):
    """Oracle: 3000 draws; mean stated covariance of (m, c) over that of the lines, and the residual variance, are one."""
    random, x = np.random.default_rng(n), np.linspace(2.0, 3.0, n)
    lines, covariances, variances = [], [], []
    for _ in range(3000):
        y = 0.5 + 0.8 * (x - 2.4) + random.normal(0, 2e-3, n)
        line, covariance, variance = line_through(x, y, u_x=None, u_y=None)
        lines.append(line)
        covariances.append(covariance)
        variances.append(variance)
    seen, stated = np.cov(np.array(lines).T), np.mean(covariances, axis=0)
    np.testing.assert_allclose(np.diag(stated) / np.diag(seen), 1, atol=0.1)
    assert stated[0, 1] / seen[0, 1] == pytest.approx(1, abs=0.2)
    assert np.mean(variances) == pytest.approx(4e-6, rel=0.05)
    assert np.mean(lines, axis=0) == pytest.approx([0.8, 2.4], abs=1e-3)
