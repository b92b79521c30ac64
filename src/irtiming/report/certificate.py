"""The certificate: one self-contained page that a reader can check from the verdict down to the inputs."""

from datetime import datetime

from irtiming.report import result, rolling_certificate, rolling_result, snapshot_certificate
from irtiming.report.evidence import Evidence, RollingEvidence
from irtiming.report.page import Certificate, Content, Verdict, render


def report(evidence: Evidence | RollingEvidence, *, created: datetime | None = None) -> Certificate:
    """Page and result of one analysis, of either kind of camera.

    Parameters
    ----------
    evidence
        An analysis; the report computes nothing that is not in it but means of runs, sums over rows and rounded text.
    created
        Date to print; now, where none is given.
    """
    if isinstance(evidence, RollingEvidence):
        return Certificate(page=page(evidence, created=created), result=rolling_result.result(evidence))
    return Certificate(page=page(evidence, created=created), result=result.result(evidence))


def page(evidence: Evidence | RollingEvidence, *, created: datetime | None = None) -> str:
    """One HTML page without any link to the outside: verdict and warnings first, then tables and figures."""
    if isinstance(evidence, RollingEvidence):
        heading, sections = "Timing of a rolling microbolometer camera", rolling_certificate.sections(evidence)
    else:
        heading, sections = "Timing of a snapshot photon camera", snapshot_certificate.sections(evidence)
    content = Content(heading=heading, verdict=verdict(evidence), warnings=evidence.warnings, sections=sections)
    return render(content, created=created)


def verdict(evidence: Evidence | RollingEvidence) -> Verdict:
    """What was measured, in one sentence, and what limits it."""
    if isinstance(evidence, RollingEvidence):
        return rolling_certificate.verdict(evidence)
    return snapshot_certificate.verdict(evidence)
