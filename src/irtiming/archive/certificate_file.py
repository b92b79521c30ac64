"""certificate.toml: what a certificate says that no recording knows; laboratory, customer, dates, equipment, limits."""

from collections.abc import Iterable
from datetime import date
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from irtiming.archive.typed_file import Number, OneOrSeveral, Part, Temperature, Uncertainty, read_toml
from irtiming.archive.typed_misfit import FileKind
from irtiming.errors import UnitError, one_line
from irtiming.records.choices import Language
from irtiming.units import seconds

Rule = Literal["simple acceptance", "guard band"]
"""How a result at a limit is judged: as if it were exact, or with the expanded uncertainty as a guard band (ILAC-G8)."""

RULES: dict[Rule, str] = {
    "simple acceptance": (
        "simple acceptance: a value within the limits passes, whatever its uncertainty "
        "(ILAC-G8:09/2019, 4.2.1; JCGM 106:2012, 8.2)."
    ),
    "guard band": (
        "guard band w = U: a value passes if it lies at least U within the limits, fails if it lies more than U outside, and "
        "passes or fails on condition in between (ILAC-G8:09/2019, 4.2.3; JCGM 106:2012, 8.3; ISO 14253-1)."
    ),
}
"""The same in a sentence, in English, as it stands on certificates and on the pages of campaigns."""

_KIND = FileKind(name="certificate.toml")


def _printable(text: str) -> str:
    if not text.strip():
        raise ValueError(f"is '{text}'; it must be text")
    return one_line(text)


def _time(text: str) -> str:
    try:
        seconds(text)
    except UnitError as error:
        raise ValueError(f"cannot be read; {error}") from error
    return text


def _country(text: str) -> str:
    if not (len(text) == 2 and text.isascii() and text.isupper()):
        raise ValueError(f"is '{text:.20}'; it must be two capital letters of ISO 3166-1, such as 'DE'")
    return text


Text = Annotated[str, AfterValidator(_printable)]
Time = Annotated[str, AfterValidator(_time)]


class Organisation(Part):
    """A laboratory or a customer, and how to reach it."""

    name: Text
    street: Text
    postcode: Text
    city: Text
    country: Annotated[str, AfterValidator(_country)] = Field(examples=["DE"])
    email: Text
    phone: Text | None = None

    @property
    def place(self) -> str:
        """Postcode, city and country in one line."""
        return f"{self.postcode} {self.city}, {self.country}"


class Laboratory(Organisation):
    """The laboratory that answers for the certificate."""

    accreditation: Text | None = Field(
        None, description="number, or what the body asks to be written", examples=["D-K-00000-01"]
    )
    accreditation_body: Text | None = None
    accreditation_mark: Text | None = Field(None, description="picture of the mark, PNG or SVG, beside this file")
    code: Text | None = Field(None, description="short code of the laboratory")


class Head(Part):
    """The certificate itself."""

    number: Text = Field(examples=["2026-0815"])
    issued: date = Field(examples=["2026-11-23"])
    language: Language = "en"
    order: Text | None = Field(None, description="the customer's order")
    replaces: Text | None = Field(None, description="number of the certificate that this one replaces")
    amendment: Text | None = Field(None, description="what was changed in it, and why")
    remarks: list[Text] = Field([], description="sentences to be printed among the remarks")

    @model_validator(mode="after")
    def _refuse_silent_change(self) -> "Head":
        if self.replaces and not self.amendment:
            raise ValueError(f"replaces '{self.replaces}' without amendment; it must say what was changed, and why")
        return self


class Item(Part):
    """The camera: what its recordings do not say, or say again; what both say must agree."""

    description: Text | None = Field(None, examples=["thermal infrared camera"])
    manufacturer: Text | None = None
    model: Text | None = None
    serial_number: Text | None = None
    firmware: Text | None = None
    owner_number: Text | None = Field(None, description="number by which the customer knows it")
    condition: Text | None = Field(None, description="when it was received", examples=["no visible damage"])
    settings: Text | None = Field(
        None, description="mode in which it was measured", examples=["trigger mode 1, filter off"]
    )
    adjusted: Text | None = Field(None, description="adjustment or repair between two results")


class Dates(Part):
    """Days."""

    received: date | None = None
    measured: Annotated[list[date], OneOrSeveral()] = Field(
        [], max_length=2, description="day, or first and last day; default: as the recordings say"
    )


class Place(Part):
    """Where it was measured, and around what."""

    kind: Literal["laboratory", "customer", "laboratoryBranch", "customerBranch", "other"] = "laboratory"
    name: Text | None = Field(None, examples=["laboratory, room 3"])
    temperature: Temperature | None = Field(None, description="of the air", examples=["23 C"])
    temperature_u_k: Uncertainty | None = None
    humidity_percent: Number | None = Field(None, ge=0, le=100)
    humidity_u_percent: Uncertainty | None = None
    other: Text | None = None


class Equipment(Part):
    """One piece of equipment that the results stand on, with its calibration."""

    name: Text
    manufacturer: Text | None = None
    model: Text | None = None
    serial_number: Text | None = None
    calibrated_by: Text | None = None
    certificate: Text | None = Field(None, description="number of its calibration certificate")
    calibrated: date | None = None
    due: date | None = None


class Person(Part):
    """A person who answers for the certificate; the first who signs is the one who authorises it."""

    name: Text
    role: Text | None = None
    email: Text | None = None
    signs: bool = True


class Procedure(Part):
    """How it was done, where the laboratory has words of its own."""

    procedure: Text | None = Field(None, examples=["LAB-07, revision 3"])
    deviations: Text | None = Field(None, description="additions to, deviations from, or exclusions from it")
    sampling: Text | None = None
    external: Text | None = Field(None, description="results that an external provider supplied, and who that is")
    customer_data: Text | None = Field(None, description="what the customer provided that may affect the results")


class Traceability(Part):
    """How the results are traceable to the SI, in the laboratory's words."""

    statement: Text


class Limit(Part):
    """A specification that a result is held against."""

    parameter: Text = Field(examples=["trigger_delay"])
    lower: Time | None = Field(None, examples=["350 us"])
    upper: Time | None = Field(None, examples=["450 us"])
    specification: Text | None = Field(None, description="where the limit stands")
    serial_number: Text | None = Field(
        None, description="of the camera that it is for; default: all of the certificate"
    )

    @model_validator(mode="after")
    def _refuse_empty(self) -> "Limit":
        low, high = self.bounds_s
        if low is None and high is None:
            raise ValueError(f"of {self.parameter} has neither lower nor upper; state one, or leave it out")
        if low is not None and high is not None and not low < high:
            cure = "exchange them" if low > high else "they must differ"
            raise ValueError(f"of {self.parameter} has lower = {self.lower}, upper = {self.upper}; {cure}")
        return self

    @property
    def bounds_s(self) -> tuple[float | None, float | None]:
        """Lower and upper limit, s; None where open."""
        return (
            None if self.lower is None else seconds(self.lower),
            None if self.upper is None else seconds(self.upper),
        )


def _each_once(limits: list[Limit]) -> list[Limit]:
    stated = [(one.parameter, one.serial_number) for one in limits]
    for parameter, serial in stated:
        if stated.count((parameter, serial)) > 1:
            of = "all cameras" if serial is None else f"the camera with serial_number = '{serial}'"
            raise ValueError(
                f"states {parameter} of {of} more than once, of which one would not count; state lower and upper in one, and "
                "what a single camera must keep to in another with its serial_number"
            )
    return limits


Limits = Annotated[list[Limit], OneOrSeveral(), AfterValidator(_each_once)]
"""Each parameter once for all cameras, and once for any camera."""


def limit_of(limits: Iterable[Limit], *, parameter: str, serial_number: str | None) -> Limit | None:
    """That of a parameter of a camera: its own before the one for all; None where there is neither."""
    mine = [one for one in limits if one.parameter == parameter and one.serial_number in (None, serial_number)]
    return min(mine, key=lambda one: one.serial_number is None, default=None)


class Decision(Part):
    """The rule by which a statement of conformity is made (ISO/IEC 17025, 7.8.6)."""

    rule: Rule = "guard band"
    agreed_with: Text | None = Field(None, description="with whom the rule was agreed")


class CertificateFile(Part):
    """Everything in certificate.toml."""

    certificate: Head
    laboratory: Laboratory
    customer: Organisation
    item: Annotated[list[Item], OneOrSeveral()] = Field(
        [], description="one; several are distinguished by serial_number"
    )
    dates: Dates = Dates()
    place: Place = Place()
    equipment: Annotated[list[Equipment], OneOrSeveral()] = Field([])
    person: Annotated[list[Person], OneOrSeveral()] = Field(min_length=1)
    method: Procedure = Procedure()
    traceability: Traceability | None = None
    decision: Decision = Decision()
    limit: Limits = Field([])


def read_certificate_file(path: str | Path) -> CertificateFile:
    """What a laboratory wants printed.

    Raises
    ------
    ArchiveError
        If the file cannot be read, a key is unknown or missing, or a value cannot be.
    """
    found, _ = read_toml(Path(path), CertificateFile, kind=_KIND)
    return found
