"""Registration: a second shape laid on a first, by landmarks, by its shape, or as it is."""

from limbgram.shape.comparing.registration.icp import IcpOptions, Looseness
from limbgram.shape.comparing.registration.registration import (
    WAYS,
    Alignment,
    RegistrationOptions,
    Way,
    as_is,
    as_they_lie,
    by_landmarks,
    by_shape,
)

__all__ = [
    "WAYS",
    "Alignment",
    "IcpOptions",
    "Looseness",
    "RegistrationOptions",
    "Way",
    "as_is",
    "as_they_lie",
    "by_landmarks",
    "by_shape",
]
