"""A CAD drawing: the surface, its sections and centreline, landmarks by name, in stated units."""

from pathlib import Path

import ezdxf

from limbgram.formats.reading import ShapeFile
from limbgram.services.export import Drawing, export
from shapes import stump

shape = ShapeFile(limb=stump(), sha256="", mm_per_unit=1.0)
export(shape, Drawing(spacing_mm=50), Path("stump.dxf"))
drawing = ezdxf.readfile("stump.dxf")
print(f"units: {ezdxf.units.unit_name(drawing.units)}")
for section in drawing.modelspace().query("LWPOLYLINE"):
    print(f"section {section.dxf.elevation:.0f} mm up, {len(section)} points")
for text in drawing.modelspace().query("TEXT"):
    print(f"landmark {text.dxf.text}")
