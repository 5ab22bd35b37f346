"""Whether a wheel holds every file of the package: `python .ci/wheel.py dist/limbgram-*.whl`."""

import sys
from pathlib import Path
from zipfile import ZipFile

SOURCES = Path(__file__).parents[1] / "src"

held = set(ZipFile(sys.argv[1]).namelist())
files = (file for file in (SOURCES / "limbgram").rglob("*") if file.is_file())
wanted = {file.relative_to(SOURCES).as_posix() for file in files if "__pycache__" not in file.parts}
if not wanted or wanted - held:
    sys.exit(
        f"{sys.argv[1]} lacks {', '.join(sorted(wanted - held)) or 'a package to compare with'}."
    )
