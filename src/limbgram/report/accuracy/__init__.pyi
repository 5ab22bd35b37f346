"""Accuracy: its names, each imported when it is first used."""

from .assessment import Assessment, assess
from .evidence import Evidence
from .truth import KnownTruth

__all__ = ["Assessment", "Evidence", "KnownTruth", "assess"]
