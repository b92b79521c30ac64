"""``python -m irtiming``: the command line, where the program ``irtiming`` is not on the path."""

from irtiming.cli.start import run

run()
