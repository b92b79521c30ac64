"""Small parts that several pages show: findings, facts, tables, progress. Every text is shown as text, whatever is in it."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from html import escape
from typing import Any

from nicegui import ui

from irtiming.web.jobs import Job

_MOST_OK = 4
_LANGUAGES = {"en": "English", "de": "Deutsch"}


@contextmanager
def card(title: str = "") -> Iterator[None]:
    """A part of a page, with a heading where it has one."""
    with ui.element("section").classes("card"):
        if title:
            with ui.element("h2"):
                ui.label(title)
        yield


def language(label: str) -> ui.select:
    """In which a page is written; a person chooses."""
    return ui.select(_LANGUAGES, value="en", label=label).mark("language")


@contextmanager
def columns(kind: str = "") -> Iterator[None]:
    """Parts beside each other where there is room, below each other where there is none."""
    with ui.element("div").classes(f"columns {kind}"):
        yield


def html(content: str = "") -> ui.html:
    """Content that was made here, of texts that were escaped."""
    return ui.html(content, sanitize=False)


def finding_html(severity: str, text: str, *, cure: str = "", title: str = "") -> str:
    """One finding as HTML: its colour is named in a word, too."""
    head = f"<b>{escape(title or severity)}</b>"
    tail = f'<span class="cure">{escape(cure)}</span>' if cure else ""
    return f'<div class="finding {escape(severity)}">{head}{escape(text)}{tail}</div>'


def findings_html(findings: Sequence[Mapping[str, Any]]) -> str:
    """Findings of a file or a result, the worst first; where many are ok, these are folded."""
    order = ("error", "missing", "doubt", "warning", "info", "ok")
    ranked = sorted(findings, key=lambda one: order.index(one["severity"]) if one["severity"] in order else len(order))
    shown = [
        finding_html(one["severity"], " ".join(filter(None, (one.get("where"), one["what"]))), cure=one.get("cure", ""))
        for one in ranked
    ]
    n_ok = sum(one["severity"] == "ok" for one in ranked)
    if n_ok <= _MOST_OK:
        return "".join(shown)
    folded = "".join(shown[-n_ok:])
    return "".join(shown[:-n_ok]) + f"<details><summary>{n_ok} are ok</summary>{folded}</details>"


def links_html(links: Mapping[str, str]) -> str:
    """Addresses of this server by their titles, one below the other."""
    rows = "".join(
        f'<li><a href="{escape(address)}"><span><b>{escape(title)}</b></span></a></li>'
        for address, title in links.items()
    )
    return f'<ul class="files">{rows}</ul>'


def facts_html(facts: Mapping[str, Any]) -> str:
    """Names and values; what is None is left out."""
    rows = (
        f"<dt>{escape(name)}</dt><dd>{escape(str(value))}</dd>" for name, value in facts.items() if value is not None
    )
    return f'<dl class="facts">{"".join(rows)}</dl>'


def table_html(headings: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int] = ()) -> str:
    """A table; the columns ``right`` hold numbers."""
    kinds = ["r" if column in right else "" for column in range(len(headings))]
    head = "".join(
        f'<th scope="col" class="{kind}">{escape(text)}</th>' for kind, text in zip(kinds, headings, strict=True)
    )
    body = "".join(
        "<tr>"
        + "".join(f'<td class="{kind}">{escape(cell)}</td>' for kind, cell in zip(kinds, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return f'<div class="scroll"><table class="plain"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def steps_html(job: Job) -> str:
    """Bars of the pieces of work of a job."""
    parts = []
    for name, (done, total) in job.steps.items():
        share = 100 * done / max(1, total)
        parts.append(
            f'<div class="note">{escape(name)}: {done} of {total}</div><div class="bar" role="progressbar" '
            f'aria-label="{escape(name)}" aria-valuenow="{share:.0f}" aria-valuemin="0" aria-valuemax="100">'
            f'<i style="width:{share:.1f}%"></i></div>'
        )
    return "".join(parts)


def log_html(job: Job) -> str:
    """What a job said, the latest last."""
    return (
        f'<pre class="log" tabindex="0" aria-label="what was said">{escape(chr(10).join(job.lines))}</pre>'
        if job.lines
        else ""
    )


def put(element: ui.html, content: str) -> None:
    """Show other content, if it is another."""
    if element.content != content:
        element.set_content(content)


def complain(error: Exception | str) -> None:
    """Say why something was not done."""
    ui.notify(str(error), type="negative", position="top", multi_line=True, timeout=8000, close_button="close")
