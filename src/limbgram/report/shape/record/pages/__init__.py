"""Pages: a record as one HTML page and as a PDF of two sheets, from its tree alone."""

from limbgram.report.shape.record.pages.html import record_page
from limbgram.report.shape.record.pages.pdf import record_pdf

__all__ = ["record_page", "record_pdf"]
