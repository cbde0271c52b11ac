"""posreal: optimal passive suspension devices, and how to build them from springs, dampers and inerters."""

__version__ = "0.1.0"
