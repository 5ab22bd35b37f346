"""Assessing: the accuracy of a finished case, from what it keeps, with or without a truth."""
