"""The browser tests need Playwright, Chromium, and the client's tools (`npm ci` in web/) for axe.

Where one of them is missing, nothing here is collected.
"""

import importlib.util
import shutil
from pathlib import Path

_AXE = Path(__file__).parents[2] / "web" / "node_modules" / "axe-core" / "axe.min.js"
_READY = shutil.which("chromium") and _AXE.is_file() and importlib.util.find_spec("playwright")
collect_ignore_glob = [] if _READY else ["test_*.py"]
