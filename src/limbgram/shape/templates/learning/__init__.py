"""Learning: what was done alike to several limbs, from shapes before and after it."""

from limbgram.shape.templates.learning.displacing import LearnOptions, Pair
from limbgram.shape.templates.learning.learning import Learned, learn

__all__ = ["LearnOptions", "Learned", "Pair", "learn"]
