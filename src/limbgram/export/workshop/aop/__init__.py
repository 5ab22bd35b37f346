"""AOP: written, read back, and told what the format costs."""

from limbgram.export.workshop.aop.cost import AopReport, DistalCap, GirthLevel
from limbgram.export.workshop.aop.writing import AopOptions, LineEnd, write_aop

__all__ = ["AopOptions", "AopReport", "DistalCap", "GirthLevel", "LineEnd", "write_aop"]
