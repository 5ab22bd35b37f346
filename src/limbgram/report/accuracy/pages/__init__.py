"""Pages: an assessment as one HTML page and as a PDF of two pages, from its JSON tree alone."""

from limbgram.report.accuracy.pages.html import accuracy_page
from limbgram.report.accuracy.pages.pdf import accuracy_pdf
from limbgram.report.accuracy.pages.pictures import accuracy_pictures

__all__ = ["accuracy_page", "accuracy_pdf", "accuracy_pictures"]
