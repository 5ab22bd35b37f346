"""Scale: scene units to millimetres, with the evidence for it.

In      a Scene; BoardDetections of a board lying in it, known distances, both or neither.
Out     a MetricScene.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
