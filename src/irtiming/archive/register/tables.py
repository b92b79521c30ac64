"""The register of results: its tables in any database that SQLAlchemy knows, and where it is."""

from importlib import import_module
from pathlib import Path
from typing import Any

from irtiming.errors import ArchiveError

DEFAULT = "register.sqlite"
VERSION = 1
_LETTERS = 255


def opened(register: str, *, must_exist: bool = False) -> Any:
    """Engine of the database, its tables made where they are missing.

    Parameters
    ----------
    register
        An SQLAlchemy URL such as ``postgresql://user@host/name``, or the name of an SQLite file.
    must_exist
        Whether a file that is not there is refused.

    Raises
    ------
    ArchiveError
        If SQLAlchemy or a driver is not installed, or the database cannot be opened or is of a later version.
    """
    sql = library()
    if "://" not in register:
        path = Path(register)
        if must_exist and not path.is_file():
            raise ArchiveError(
                f"there is no register {register}; name it with --register, or make one with irtiming campaign or irtiming "
                "history --add"
            )
        if not path.absolute().parent.is_dir():
            raise ArchiveError(f"{register}: there is no folder {path.parent}; make it first")
        register = f"sqlite:///{path.absolute()}"
    try:
        engine = sql.create_engine(register)
        metadata().create_all(engine)
        with engine.begin() as line:
            table = metadata().tables["register_version"]
            found = line.execute(sql.select(table.c.version)).scalar()
            if found is None:
                line.execute(sql.insert(table).values(version=VERSION))
    except ModuleNotFoundError as error:
        raise ArchiveError(
            f"this register needs the driver {error.name}; install it with pip install {error.name}"
        ) from error
    except (sql.exc.SQLAlchemyError, UnicodeDecodeError) as error:
        raise unusable(register, error) from error
    if found is not None and not (isinstance(found, int) and found <= VERSION):
        raise ArchiveError(f"the register is of version {found!s:.40}, this irtiming knows {VERSION}; update it")
    return engine


def file_of(register: str) -> Path | None:
    """File of an SQLite register; None where a server has it."""
    name = register.removeprefix("sqlite:///")
    return None if "://" in name else Path(name)


def unusable(register: str, error: Exception) -> ArchiveError:
    """Error for a register that cannot be used; a password in its URL is not shown."""
    where = register.rsplit("@", 1)[-1]
    reason = str(getattr(error, "orig", None) or error).splitlines()[0]
    return ArchiveError(f"the register {where} cannot be used ({reason}); check its name and that its server answers")


def library() -> Any:
    """SQLAlchemy.

    Raises
    ------
    ArchiveError
        If it is not installed.
    """
    try:
        return import_module("sqlalchemy")
    except ModuleNotFoundError as error:
        raise ArchiveError(
            "the register of results needs SQLAlchemy; install it with pip install 'irtiming[campaign]'"
        ) from error


def metadata() -> Any:
    """The tables; docs/reference/register.md says what is in each column."""
    sql = library()
    found = sql.MetaData()
    text, number = sql.String(_LETTERS), sql.Float(53)
    sql.Table("register_version", found, sql.Column("version", sql.Integer, primary_key=True, autoincrement=False))
    sql.Table(
        "result", found,
        sql.Column("id", sql.Integer, primary_key=True),
        sql.Column("sha256", sql.String(64), unique=True, nullable=False),
        *(sql.Column(name, text, nullable=False, default="", index=name == "serial_number")
          for name in ("serial_number", "model", "manufacturer", "camera", "readout_mode", "reference_event")),
        sql.Column("measured_at", text, nullable=False, default=""),
        sql.Column("registered_at", text, nullable=False),
        *(sql.Column(name, text, nullable=False, default="") for name in ("operator", "run", "program_version", "rig_sha256")),
        sql.Column("recordings", sql.Integer, nullable=False),
        sql.Column("simulated", sql.Boolean, nullable=False),
        sql.Column("file", sql.Text, nullable=False),
    )  # fmt: skip
    of_result = {"nullable": False, "index": True}
    sql.Table(
        "setting", found, sql.Column("result_id", sql.ForeignKey("result.id"), **of_result),
        sql.Column("name", text, nullable=False), sql.Column("number", number), sql.Column("words", text),
        sql.UniqueConstraint("result_id", "name"),
    )  # fmt: skip
    sql.Table(
        "value", found, sql.Column("result_id", sql.ForeignKey("result.id"), **of_result),
        sql.Column("parameter", text, nullable=False), sql.Column("value", number, nullable=False),
        sql.Column("standard_uncertainty", number, nullable=False), sql.Column("expanded_uncertainty", number, nullable=False),
        sql.Column("degrees_of_freedom", number), sql.Column("unit", text, nullable=False),
        sql.Column("reference_event", text, nullable=False), sql.UniqueConstraint("result_id", "parameter"),
    )  # fmt: skip
    sql.Table(
        "common_input", found, sql.Column("result_id", sql.ForeignKey("result.id"), **of_result),
        sql.Column("parameter", text, nullable=False), sql.Column("source", sql.String(512), nullable=False),
        sql.Column("contribution", number, nullable=False), sql.UniqueConstraint("result_id", "parameter", "source"),
    )  # fmt: skip
    sql.Table(
        "recording", found, sql.Column("result_id", sql.ForeignKey("result.id"), **of_result),
        sql.Column("sha256", sql.String(64), nullable=False, index=True), sql.UniqueConstraint("result_id", "sha256"),
    )  # fmt: skip
    sql.Table(
        "finding", found, sql.Column("result_id", sql.ForeignKey("result.id"), **of_result),
        sql.Column("code", text, nullable=False),
    )  # fmt: skip
    return found
