"""Registration: a second shape laid on a first, by landmarks, by its shape, or as it is."""

from limbgram.shape.comparing.registration.icp import IcpOptions
from limbgram.shape.comparing.registration.registration import (
    WAYS,
    Alignment,
    RegistrationOptions,
    Way,
    as_is,
    by_landmarks,
    by_shape,
)

__all__ = [
    "WAYS",
    "Alignment",
    "IcpOptions",
    "RegistrationOptions",
    "Way",
    "as_is",
    "by_landmarks",
    "by_shape",
]
