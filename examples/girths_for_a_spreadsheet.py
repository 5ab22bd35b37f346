"""Girths, volume and a length as a workbook, and as text for a spreadsheet with decimal commas."""

from pathlib import Path

from limbgram.services.measure import MeasureFiles, MeasureRequest, measure
from shapes import stump

asked = MeasureRequest(
    every_mm=25,
    volumes=((50.0, 150.0),),
    lengths=(("patellar tendon", "fibula head"),),
)
files = MeasureFiles(xlsx=Path("girths.xlsx"), csv=Path("girths.csv"), decimal="comma")
sheet = measure(stump(), asked, files)
print(sheet.measures)  # short; in a notebook `sheet.measures` is a table with its ±
print(Path("girths.csv").read_text("utf-8-sig").splitlines()[1])
