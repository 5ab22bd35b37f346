"""Accuracy: what a finished case knows of its own error, judged, with what limits it.

In      Evidence: products of a case; and its truth where there is one.
Out     a JSON tree, one HTML page without scripts, a PDF of two pages.
"""

from limbgram.report.accuracy.assessment import Assessment, assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.truth import KnownTruth

__all__ = ["Assessment", "Evidence", "KnownTruth", "assess"]
