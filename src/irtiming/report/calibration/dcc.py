"""A certificate as Digital Calibration Certificate of PTB: XML of dcc.xsd 3.1.2 with quantities of D-SI 2.1.0.

Every quantity that is certified is an ``si:real`` with ``si:expandedUnc``; numbers stand in coherent SI units, unrounded.
"""

import base64
from typing import final
from xml.etree import ElementTree as Xml

from irtiming.archive.certificate_file import RULES, Organisation
from irtiming.report.calibration import conditions, rows
from irtiming.report.calibration.content import CalibratedItem, MeasuredItem, Sheet
from irtiming.report.calibration.dcc_numbers import UNITS, printable, real
from irtiming.report.calibration.measurands import BudgetLine, Measurand
from irtiming.report.language import translated
from irtiming.report.sections.inputs import versions

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
SCHEMA_VERSION = "3.1.2"
_SCHEMA = f"{DCC} https://ptb.de/dcc/v3.1.2/dcc.xsd"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"


def xml(sheet: Sheet, *, page: str = "") -> str:
    """The certificate as text of XML.

    Parameters
    ----------
    sheet
        What it says.
    page
        The same for people, as HTML, to be carried inside; none if empty.
    """
    for prefix, uri in (("dcc", DCC), ("si", SI), ("xsi", _XSI)):
        Xml.register_namespace(prefix, uri)
    root = Xml.Element(
        f"{{{DCC}}}digitalCalibrationCertificate",
        {"schemaVersion": SCHEMA_VERSION, f"{{{_XSI}}}schemaLocation": _SCHEMA},
    )
    writer = _Writer(sheet)
    writer.administrative(_child(root, "administrativeData"))
    results = _child(root, "measurementResults")
    for number, one in enumerate(sheet.results, 1):
        writer.result(_child(results, "measurementResult"), one, number=number)
    if page:
        document = _child(root, "document")
        _child(document, "fileName", "certificate.html")
        _child(document, "mimeType", "text/html")
        _child(document, "dataBase64", base64.b64encode(page.encode()).decode())
    Xml.indent(root, " ")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{Xml.tostring(root, encoding="unicode")}\n'


def _child(parent: Xml.Element, name: str, text: str | None = None, **attributes: str) -> Xml.Element:
    found = Xml.SubElement(parent, f"{{{DCC}}}{name}", {key: printable(value) for key, value in attributes.items()})
    if text is not None:
        found.text = printable(text)
    return found


@final
class _Writer:
    """Writes the parts of one certificate in its language."""

    def __init__(self, sheet: Sheet) -> None:
        self._sheet, self._form = sheet, sheet.form

    def _t(self, text: str) -> str:
        return translated(text, self._sheet.language)

    def _words(self, parent: Xml.Element, name: str, text: str, **attributes: str) -> Xml.Element:
        """A text in the language of the certificate."""
        found = _child(parent, name, **attributes)
        _child(found, "content", text, lang=self._sheet.language)
        return found

    def administrative(self, parent: Xml.Element) -> None:
        """Who, for whom, what, when."""
        software = _child(_child(parent, "dccSoftware"), "software")
        self._words(software, "name", "irtiming")
        _child(software, "release", versions().get("irtiming", "0"))
        self._core(_child(parent, "coreData"))
        items = _child(parent, "items")
        for number, item in enumerate(self._sheet.items, 1):
            self._item(_child(items, "item", id=f"item{number}"), item)
        laboratory = _child(parent, "calibrationLaboratory")
        if code := self._form.laboratory.code or self._form.laboratory.accreditation:
            _child(laboratory, "calibrationLaboratoryCode", code)
        self._contact(_child(laboratory, "contact"), self._form.laboratory)
        persons = _child(parent, "respPersons")
        signing = [one for one in self._form.person if one.signs]
        for one in self._form.person:
            found = _child(persons, "respPerson")
            person = _child(found, "person")
            self._words(person, "name", one.name)
            if one.email:
                _child(person, "eMail", one.email)
            if one.role:
                _child(found, "role", one.role)
            _child(found, "mainSigner", "true" if signing and one is signing[0] else "false")
        self._contact(_child(parent, "customer"), self._form.customer)
        self._statements(_child(parent, "statements"))

    def _core(self, core: Xml.Element) -> None:
        head, dates, sheet = self._form.certificate, self._form.dates, self._sheet
        _child(core, "countryCodeISO3166_1", self._form.laboratory.country)
        _child(core, "usedLangCodeISO639_1", sheet.language)
        if sheet.language != "en":
            _child(core, "usedLangCodeISO639_1", "en")
        _child(core, "mandatoryLangCodeISO639_1", sheet.language)
        _child(core, "uniqueIdentifier", head.number)
        if head.order or head.replaces:
            listed = _child(core, "identifications")
            for issuer, value, name in (
                ("customer", head.order, "order"),
                ("calibrationLaboratory", head.replaces, "replaces"),
            ):
                if value:
                    self._identification(listed, issuer, value, name)
        if dates.received:
            _child(core, "receiptDate", dates.received.isoformat())
        _child(core, "beginPerformanceDate", sheet.first_day.isoformat())
        _child(core, "endPerformanceDate", sheet.last_day.isoformat())
        _child(core, "performanceLocation", self._form.place.kind)

    def _identification(self, listed: Xml.Element, issuer: str, value: str, name: str) -> None:
        found = _child(listed, "identification")
        _child(found, "issuer", issuer)
        _child(found, "value", value)
        self._words(found, "name", self._t(name))

    def _item(self, parent: Xml.Element, item: CalibratedItem) -> None:
        missing = self._t("not in the recordings")
        self._words(parent, "name", item.form.description or self._t("thermal infrared camera"))
        remarks = (("Condition when received", item.form.condition), ("Adjustment or repair", item.form.adjusted))
        if any(text for _, text in remarks):
            self._words(
                parent, "description", "; ".join(f"{self._t(label)}: {text}" for label, text in remarks if text)
            )
        if item.words["firmware"]:
            firmware = _child(_child(parent, "installedSoftwares"), "software")
            self._words(firmware, "name", self._t("firmware"))
            _child(firmware, "release", item.words["firmware"])
            _child(firmware, "type", "firmware")
        self._words(_child(parent, "manufacturer"), "name", item.words["manufacturer"] or missing)
        _child(parent, "model", item.words["model"] or missing)
        listed = _child(parent, "identifications")
        self._identification(listed, "manufacturer", item.words["serial_number"] or missing, "serial number")
        if item.form.owner_number:
            self._identification(listed, "customer", item.form.owner_number, "customer's number")

    def _contact(self, parent: Xml.Element, one: Organisation) -> None:
        self._words(parent, "name", one.name)
        _child(parent, "eMail", one.email)
        if one.phone:
            _child(parent, "phone", one.phone)
        location = _child(parent, "location")
        for name, text in (
            ("street", one.street),
            ("postCode", one.postcode),
            ("city", one.city),
            ("countryCode", one.country),
        ):
            _child(location, name, text)

    def _statements(self, parent: Xml.Element) -> None:
        sheet, form = self._sheet, self._form
        issued = _child(parent, "statement", id="issued")
        self._words(issued, "declaration", self._t("Date of issue"))
        _child(issued, "date", form.certificate.issued.isoformat())
        if sheet.is_simulated:
            self._words(
                _child(parent, "statement", id="simulated"),
                "declaration",
                f"{self._t('SIMULATED')}: {self._t(SPECIMEN)}",
            )
        traced = form.traceability.statement if form.traceability else self._t(conditions.TRACEABILITY)
        found = _child(parent, "statement", id="traceability")
        if sheet.is_simulated or form.traceability:
            _child(found, "traceable", "false" if sheet.is_simulated else "true")
        self._words(found, "declaration", self._t(conditions.NOT_TRACEABLE) if sheet.is_simulated else traced)
        said = [
            ONLY,
            *([f"{self._t('Amendment')}: {form.certificate.amendment}"] if form.certificate.amendment else []),
            *form.certificate.remarks,
        ]
        if outside := dict.fromkeys(one for each in sheet.results for one in each.result.not_in_uncertainty):
            said.append(f"{self._t('Not contained in U')}: {'; '.join(map(self._t, outside))}")
        for text in said:
            self._words(_child(parent, "statement"), "declaration", self._t(text))

    def result(self, parent: Xml.Element, one: MeasuredItem, *, number: int) -> None:
        """One result with method, software, equipment, conditions and every measurand."""
        parent.set("refId", f"item{one.item + 1}")
        self._words(parent, "name", f"{self._t('Timing of the camera')} ({one.file.name})")
        method = _child(_child(parent, "usedMethods"), "usedMethod")
        self._words(method, "name", self._form.method.procedure or one.result.method)
        self._words(method, "description", " ".join([self._t(conditions.method(self._sheet)), *self._said_of_method()]))
        _child(method, "reference", "V. Schatz, Meas. Sci. Technol. 34 (2023) 055407")
        software = _child(parent, "usedSoftware")
        for name, release in one.result.software.items():
            found = _child(software, "software")
            self._words(found, "name", name)
            _child(found, "release", release)
        self._equipment(parent)
        self._conditions(_child(parent, "influenceConditions"), one)
        results = _child(parent, "results")
        for place, row in enumerate(one.measurands, 1):
            self._measurand(_child(results, "result", id=f"r{number}m{place}"), row)
        self._correlation(results, one)
        self._meta(_child(parent, "measurementMetaData"), one, number=number)

    def _said_of_method(self) -> list[str]:
        said = self._form.method
        return [
            f"{self._t(label)}: {text}."
            for label, text in (
                (
                    "Additions to, deviations from, exclusions from the method",
                    said.deviations or self._t("none stated"),
                ),
                ("Sampling", said.sampling),
                ("Results of external providers", said.external),
                ("Provided by the customer, and not in the laboratory's responsibility", said.customer_data),
            )
            if text
        ]

    def _equipment(self, parent: Xml.Element) -> None:
        if not self._form.equipment:
            return
        listed = _child(parent, "measuringEquipments")
        for one in self._form.equipment:
            found = _child(listed, "measuringEquipment")
            self._words(found, "name", one.name)
            if calibration := self._calibration(one.certificate, one.calibrated_by, one.calibrated, one.due):
                self._words(found, "description", calibration)
            if one.manufacturer:
                self._words(_child(found, "manufacturer"), "name", one.manufacturer)
            if one.model:
                _child(found, "model", one.model)
            if one.serial_number:
                self._identification(
                    _child(found, "identifications"), "manufacturer", one.serial_number, "serial number"
                )

    def _calibration(self, *parts: object) -> str:
        labels = ("certificate", "calibrated by", "calibrated", "due")
        return ", ".join(
            f"{self._t(label)}: {part}" for label, part in zip(labels, parts, strict=True) if part is not None
        )

    def _conditions(self, parent: Xml.Element, one: MeasuredItem) -> None:
        place = self._form.place
        for name, value, u, unit, kind in (
            ("air temperature", place.temperature, place.temperature_u_k, "K", "basic_temperature"),
            (
                "relative humidity",
                _share(place.humidity_percent),
                _share(place.humidity_u_percent),
                "1",
                "basic_humidityRelative",
            ),
        ):
            if value is not None:
                quantity = self._quantity(parent, name, kind)
                quantity.append(real(value, unit, u=u or None))
        for label, text in conditions.of(self._sheet, one):
            found = _child(parent, "influenceCondition")
            self._words(found, "name", self._t(label))
            self._words(_child(found, "data"), "text", text or self._t("not stated"))
        if place.other:
            found = _child(parent, "influenceCondition")
            self._words(found, "name", self._t("Environment"))
            self._words(_child(found, "data"), "text", place.other)

    def _quantity(self, parent: Xml.Element, name: str, kind: str) -> Xml.Element:
        found = _child(parent, "influenceCondition", refType=kind)
        self._words(found, "name", self._t(name))
        return _child(_child(found, "data"), "quantity")

    def _measurand(self, parent: Xml.Element, row: Measurand) -> None:
        name = rows.name_of(row, self._sheet.language)
        self._words(parent, "name", name)
        self._words(parent, "description", "; ".join(self._t(part) for part in (row.event, row.sign) if part))
        data = _child(parent, "data")
        quantity = _child(data, "quantity", refType=f"irtiming_{row.name}")
        self._words(quantity, "name", name)
        quantity.append(real(row.value, row.unit, u=row.u, k=row.coverage_factor, label=row.name))
        if row.conformity is not None:
            metadata = _child(_child(quantity, "measurementMetaData"), "metaData")
            self._words(metadata, "declaration", self._t(RULES[self._form.decision.rule]))
            _child(metadata, "conformity", row.conformity.outcome)
            self._limits(_child(metadata, "data"), row)
        budget = _child(data, "list", refType="irtiming_budget")
        self._words(budget, "name", f"{self._t('Uncertainty budgets')}: {name}")
        for line in row.budget:
            self._line(_child(budget, "list"), line)

    def _limits(self, data: Xml.Element, row: Measurand) -> None:
        for word, limit in zip(("lower limit", "upper limit"), row.limits, strict=True):
            if limit is not None:
                quantity = _child(data, "quantity")
                self._words(quantity, "name", self._t(word))
                quantity.append(real(limit, row.unit))

    def _line(self, parent: Xml.Element, line: BudgetLine) -> None:
        """Estimate with u(x) and distribution, |c|, contribution and degrees of freedom."""
        self._words(parent, "name", self._t(line.source))
        self._words(parent, "description", f"{self._t('type')} {line.kind}, {self._t(line.distribution)}")
        estimate = _child(parent, "quantity", refType="irtiming_estimate")
        estimate.append(real(line.estimate, line.unit, u=line.u, distribution=line.distribution, label="x"))
        for kind, label, value, unit in (
            ("sensitivity", "|c|", line.sensitivity, f"s/{line.unit}"),
            ("contribution", "|c| u(x)", line.contribution, "s"),
        ):
            _child(parent, "quantity", refType=f"irtiming_{kind}").append(real(value, unit, label=label))
        if line.degrees_of_freedom < 1e6:
            found = _child(parent, "quantity", refType="irtiming_degreesOfFreedom")
            found.append(real(line.degrees_of_freedom, "1", label="nu"))

    def _correlation(self, results: Xml.Element, one: MeasuredItem) -> None:
        names, matrix = one.result.correlation.names, one.result.correlation.matrix
        reported = {row.name for row in one.measurands}
        pairs = [
            (f"{names[i]}, {names[j]}", r)
            for i in range(len(names)) for j in range(i)
            if names[i] in reported and names[j] in reported and (r := matrix[i][j]) is not None
        ]  # fmt: skip
        if not pairs:
            return
        found = _child(results, "result", refType="irtiming_correlation")
        self._words(found, "name", self._t("Correlation coefficients"))
        data = _child(found, "data")
        for label, r in pairs:
            _child(data, "quantity").append(real(r, "1", label=label))

    def _meta(self, parent: Xml.Element, one: MeasuredItem, *, number: int) -> None:
        """Files with checksums, rig.toml and findings."""
        rig = _child(parent, "metaData", id=f"rig{number}")
        self._words(rig, "declaration", f"rig.toml SHA-256 {one.result.rig.sha256}")
        if numbers := [
            value for value in one.result.rig.values if value.unit in UNITS and not isinstance(value.value, str)
        ]:
            data = _child(rig, "data")
            for value in numbers:
                quantity = _child(data, "quantity")
                quantity.append(
                    real(float(value.value), value.unit, u=value.standard_uncertainty or None, label=value.name)
                )
        files = [f"{row['name']} SHA-256 {row['sha256']}" for row in rows.files(one)]
        found = [f"{finding.severity} {finding.code}: {finding.what}" for finding in one.result.findings]
        for text in (*files, *found):
            _child(_child(_child(parent, "metaData"), "declaration"), "content", text, lang="en")


SPECIMEN = (
    "The frames were made by a simulation, not by a camera. This is a specimen without any validity as a certificate."
)
ONLY = "The results relate only to the items calibrated, in the condition and with the settings described here."


def _share(percent: float | None) -> float | None:
    return None if percent is None else percent / 100
