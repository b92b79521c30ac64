"""Many cameras measured: a folder or a list of recordings in, one table, one page and the register of results out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from irtiming.archive import campaign_table
from irtiming.archive.checksum import sha256_of
from irtiming.archive.json_file import require_places, write_atomically, write_json
from irtiming.archive.limits_file import LimitsFile, read_limits
from irtiming.archive.nexus import program_version
from irtiming.archive.parquet import require_parquet
from irtiming.archive.register import entries, tables
from irtiming.archive.register.entries import Entry
from irtiming.distribute.campaign import CampaignOrder, Measured, Progress, measure
from irtiming.errors import ArchiveError
from irtiming.records.campaign import Campaign
from irtiming.records.choices import Language
from irtiming.report import campaign_page
from irtiming.report.language import writing_in
from irtiming.units import counted

NO_REGISTER = "none"
TABLE, PARQUET, PAGE, SUMMARY = "table.csv", "table.parquet", "campaign.html", "campaign.json"


@final
@dataclass(frozen=True, kw_only=True)
class Order:
    """What a person wants: a folder of recordings or a CSV that lists them, the rig, and the folder of all that is found.

    ``register`` is an SQLAlchemy URL or a file; `NO_REGISTER` for none. ``scheduler`` is a Dask address, or ``here`` for no other
    process; without it there are ``workers`` on this computer. ``language`` is that of the page.
    """

    source: Path
    rig: Path
    out: Path
    limits: Path | None = None
    wheel_calibration: Path | None = None
    scheduler: str | None = None
    workers: int | None = None
    register: str = tables.DEFAULT
    json: Path | None = None
    language: Language = "en"


@final
@dataclass(frozen=True, kw_only=True)
class Done:
    """The campaign, the files that were written, and how many results are new in the register; None without one."""

    campaign: Campaign
    files: tuple[Path, ...]
    n_registered: int | None


def run(order: Order, *, progress: Progress = lambda name, done, total: None) -> Done:
    """Measure what is missing, and write table, page and register of all that is there.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, something is not installed, or nothing at all could be analysed.
    """
    require_parquet()
    if order.register != NO_REGISTER:
        tables.opened(order.register).dispose()  # before the long work
    asked = _asked(order)
    _require_places(order, asked)
    measured = measure(asked, progress=progress)
    files = tuple(_written(measured.campaign, order))
    new = None
    if order.register != NO_REGISTER:
        new = entries.add(order.register, list(_entries(measured)))
    return Done(campaign=measured.campaign, files=files, n_registered=new)


def _require_places(order: Order, asked: CampaignOrder) -> None:
    """No file of the campaign is one that it reads, before the long work."""
    read = [order.source, order.rig, order.limits, order.wheel_calibration, *(one.path for one in asked.recordings)]
    if order.register != NO_REGISTER:
        read.append(tables.file_of(order.register))
    own = [order.out / name for name in (TABLE, PARQUET, PAGE, SUMMARY)]
    if order.out.is_dir():  # where it is still to be made, nothing in it is read
        require_places({}, files=own, inputs=read)
    require_places({"JSON": [order.json]}, inputs=[*read, *own])


def _asked(order: Order) -> CampaignOrder:
    if order.source.is_dir():
        recordings = campaign_table.in_folder(order.source)
    elif order.source.suffix.lower() == ".csv":
        recordings = campaign_table.read_list(order.source)
    else:
        raise ArchiveError(
            "is neither a folder nor a .csv; name a folder of recordings, or a CSV that lists them",
            where=str(order.source),
        )
    return CampaignOrder(
        recordings=recordings, rig=order.rig, folder=order.out,
        limits=LimitsFile() if order.limits is None else read_limits(order.limits),
        wheel_calibration=order.wheel_calibration, scheduler=order.scheduler, n_workers=order.workers,
    )  # fmt: skip


def _written(campaign: Campaign, order: Order) -> Iterator[Path]:
    rows, head = campaign_table.rows_of(campaign.lines), list(_head(campaign))
    campaign_table.write_csv(rows, order.out / TABLE, head=head)
    yield order.out / TABLE
    campaign_table.write_parquet(rows, order.out / PARQUET, head=head)
    yield order.out / PARQUET
    with writing_in(order.language):
        page = campaign_page.page(campaign)
    write_atomically(page, order.out / PAGE)
    yield order.out / PAGE
    content = summary(campaign, rows)
    for path in (order.out / SUMMARY, *([] if order.json is None else [order.json])):
        write_json(content, path)
        yield path


def _head(campaign: Campaign) -> Iterator[str]:
    yield f"{program_version()}: one line for each camera and setting; SI units, u standard, U expanded uncertainty (95.45 %)"
    yield f"decision rule: {campaign.rule or 'none, there are no limits'}"
    if campaign.broken:
        yield f"not in this table: {counted(sum(len(one.files) for one in campaign.broken), 'recording')}, listed in {SUMMARY}"


def summary(campaign: Campaign, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The campaign as plain data, SI units."""
    return {
        "format": "irtiming-campaign",
        "version": "1.0",
        "decision_rule": campaign.rule,
        "lines": list(rows),
        "broken": [{"files": list(one.files), "what": one.what} for one in campaign.broken],
        "repeatability_and_reproducibility": [campaign_page.study_as_json(one) for one in campaign.studies],
        "left_out_of_study": campaign.left_out_of_study,
        "limits_of_none": list(campaign.limits_of_none),
    }


def _entries(measured: Measured) -> Iterator[Entry]:
    for path, one, result in measured.results:
        yield Entry(
            point=one.point, sha256=sha256_of(path), recordings_sha256=tuple(each.sha256 for each in result.inputs),
            rig_sha256=result.rig.sha256, operator=one.operator, run=one.run,
        )  # fmt: skip
