"""Syntax: Python's own source, parsed by one thread at a time."""

import threading

PARSING = threading.Lock()
"""Held while a source is parsed, `inspect.getsource` of a class included: CPython counts the depth
of trees for all threads together, and two that parse at once fail ("AST constructor recursion depth
mismatch")."""
