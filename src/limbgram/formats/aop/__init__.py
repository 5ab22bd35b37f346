"""AOP: the exchange format of the trade, a radius map round the carving axis."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
