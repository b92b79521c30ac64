"""The certificate: one self-contained page that a reader can check from the verdict down to the inputs."""

from datetime import datetime

from irtiming.records.analysis import Analysis
from irtiming.records.choices import Language
from irtiming.records.finding import Finding
from irtiming.report import event_words, result
from irtiming.report.blocks import Section
from irtiming.report.language import finding_title, language, t, writing_in
from irtiming.report.page import Certificate, Content, Warned, render
from irtiming.report.sections import (
    diagnosis,
    events,
    image,
    inputs,
    joint_fit,
    lag,
    parameters,
    pixel_sums,
    relative_delays,
    rig,
    row_sums,
    two_constants,
    uncertainty,
    wheel,
)
from irtiming.report.verdict import verdict


def report(analysis: Analysis, *, created: datetime | None = None, written_in: Language = "en") -> Certificate:
    """Page and result of one analysis.

    Parameters
    ----------
    analysis
        The report computes nothing that is not in it but means of runs, sums over rows and rounded text.
    created
        Date to print; now, where none is given.
    written_in
        Language of the page; the result is the same in all.
    """
    with writing_in(written_in):
        made = page(analysis, created=created)
    return Certificate(page=made, result=result.result(analysis))


def page(analysis: Analysis, *, created: datetime | None = None) -> str:
    """One HTML page without any link to the outside: verdict and warnings first, then tables and figures."""
    content = Content(
        heading=t(f"Timing of a {analysis.readout_mode} {analysis.camera_type} camera"),
        verdict=verdict(analysis),
        warnings=tuple(_warned(one, analysis) for one in result.doubts(analysis)),
        sections=sections(analysis),
    )
    return event_words.text(render(content, created=created), event_words.event_of(analysis))


def _warned(one: Finding, analysis: Analysis) -> Warned:
    text = event_words.text(one.sentence(), event_words.event_of(analysis), said_in="en")
    return Warned(text=text, title=finding_title(one.code, language()), is_doubt=one.severity == "doubt")


def sections(analysis: Analysis) -> tuple[Section, ...]:
    """The body of the page, in the order of the argument; each section asks the analysis what it has."""
    made = (
        parameters.section(analysis),
        events.section(analysis),
        relative_delays.section(analysis),
        pixel_sums.section(analysis),
        *row_sums.sections(analysis),
        lag.section(analysis),
        two_constants.section(analysis.two_constants),
        joint_fit.section(analysis),
        diagnosis.section(analysis),
        uncertainty.section(analysis),
        image.section(analysis),
        rig.section(analysis),
        wheel.section(analysis),
        inputs.section(analysis),
    )
    return tuple(section for section in made if section is not None)
