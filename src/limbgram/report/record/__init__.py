"""Record: a shape's page and PDF for the file."""

from limbgram.report.record.pages import record_page, record_pdf
from limbgram.report.record.record import SCHEMA, Record, RecordOptions, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource

__all__ = [
    "SCHEMA",
    "CaseSource",
    "RecipeSource",
    "Record",
    "RecordOptions",
    "ShapeSource",
    "record_of",
    "record_page",
    "record_pdf",
]
