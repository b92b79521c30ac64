"""Kinds of cameras by their names for people."""

CAMERAS = {
    "photon snapshot": "cooled camera (snapshot)",
    "microbolometer rolling": "microbolometer camera (rolling)",
    "photon rolling": "CMOS camera (rolling)",
    "microbolometer snapshot": "snapshot camera with lag",
}
"""By kind of pixel and readout."""
