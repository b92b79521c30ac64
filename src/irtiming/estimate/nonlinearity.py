"""What is said of cameras whose response to light is not a straight line."""

from irtiming.estimate.joint import Joint, Measurand
from irtiming.physics.light.bent_rows import CUBIC, QUADRATIC
from irtiming.records.finding import Finding

_BEYOND_PARABOLA = 4.0  # standard uncertainties of the cubic part, from which what is beyond it may count too
_MIDDLE = 0.25  # of the quadratic part: how far the middle of the contrast lies off the straight line


def of_joint(joint: Joint) -> tuple[Finding, ...]:
    """Where the response's curve was fitted: a doubt where the frames show that it is no parabola.

    The model has the curve up to the third order. Where that one shows, the next ones may move the result by a share of what it
    does; where it does not, they are smaller still.

    Parameters
    ----------
    joint
        The joint fit, whose shared numbers have such a curve or not.
    """
    found = []
    for name in (one for one in joint.names if one.startswith(QUADRATIC)):
        both = (name, name.replace(QUADRATIC, CUBIC))
        curve = joint.estimate([Measurand(name=one, unit="1", weights={one: 1.0}) for one in both])
        quadratic, cubic = curve.values.tolist()
        found.append(
            Finding(
                code="response-not-linear",
                severity="doubt" if abs(cubic) > _BEYOND_PARABOLA * curve.u(both[1]) else "warning",
                what=f"the camera's response to light is not linear: in the middle between covered and open its output lies "
                f"{100 * _MIDDLE * quadratic:+.2g} % of the contrast off a straight line (quadratic part {quadratic:+.2g}, cubic "
                f"part {cubic:+.2g}); time constant and delays are corrected for these two parts, and for no higher ones",
                cure="record the camera's raw counts, not temperatures or enhanced images, or take a blackbody that is nearer to "
                "the wheel's temperature",
            )
        )
    return tuple(found)
