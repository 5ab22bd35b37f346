"""Assessing: the accuracy of a finished case, from what it keeps, with or without a truth."""

from limbgram.cases.assessing.accuracy import assess_case, evidence_of, write_accuracy

__all__ = ["assess_case", "evidence_of", "write_accuracy"]
