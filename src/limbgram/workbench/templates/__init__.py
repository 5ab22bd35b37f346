"""Templates: rectifications that follow landmarks, learned from pairs, applied to other limbs."""

from limbgram.workbench.templates.files import encode_template, read_template
from limbgram.workbench.templates.learning import Learned, LearnOptions, Pair, learn
from limbgram.workbench.templates.template import (
    Applied,
    Template,
    TemplateMark,
    apply_template,
    moves_at_marks,
)

__all__ = [
    "Applied",
    "LearnOptions",
    "Learned",
    "Pair",
    "Template",
    "TemplateMark",
    "apply_template",
    "encode_template",
    "learn",
    "moves_at_marks",
    "read_template",
]
