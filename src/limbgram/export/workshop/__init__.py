"""Workshop: limbs on disk, and files for carvers and CAD programs."""

from limbgram.export.workshop.aop import AopOptions, AopReport, write_aop
from limbgram.export.workshop.limb_file import write_limb, write_limb_file

__all__ = ["AopOptions", "AopReport", "write_aop", "write_limb", "write_limb_file"]
