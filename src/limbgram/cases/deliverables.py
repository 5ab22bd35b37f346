"""Deliverables: the files of a case for other programs, each written, read back and compared."""
