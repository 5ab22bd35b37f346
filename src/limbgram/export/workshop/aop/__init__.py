"""AOP: written, read back, and told what the format costs."""

from limbgram.export.workshop.aop.cost import AopReport, DistalCap, GirthLevel
from limbgram.export.workshop.aop.writing import AopOptions, LineEnd, Own, write_aop

__all__ = ["AopOptions", "AopReport", "DistalCap", "GirthLevel", "LineEnd", "Own", "write_aop"]
