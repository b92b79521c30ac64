"""Measure the timing of a thermal infrared camera with a chopper wheel and a blackbody."""

from irtiming.errors import IrTimingError

__all__ = ["IrTimingError"]
