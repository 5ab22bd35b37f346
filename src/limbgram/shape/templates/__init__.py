"""Templates: rectifications that follow landmarks, learned from pairs, applied to other limbs."""

from limbgram.shape.templates.applying import Applied, apply_template, moves_at_marks
from limbgram.shape.templates.files import encode_template, read_template
from limbgram.shape.templates.learning import Learned, LearnOptions, Pair, learn
from limbgram.shape.templates.template import Template, TemplateMark

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
