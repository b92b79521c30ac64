"""A certificate made of results, and the form of an earlier one."""

from pathlib import Path
from typing import Any

from irtiming.archive.certificate_file import read_certificate_file
from irtiming.session.certificate import CertificateOrder, certify
from irtiming.web.orders import CertifyOrder
from irtiming.web.work import Line, give_way


def make(line: Line, order: CertifyOrder) -> dict[str, Any]:
    """What ``irtiming certificate`` does; gives the files and what stands on it."""
    give_way()
    sheet = certify(CertificateOrder(results=order.results, form=order.form, out=order.out))
    return {"out": [str(one) for one in order.out], "n_results": len(sheet.results), "is_simulated": sheet.is_simulated}


def form_of(line: Line, path: Path) -> dict[str, Any]:
    """All that a certificate.toml says, as plain data."""
    return read_certificate_file(path).model_dump(mode="json")
