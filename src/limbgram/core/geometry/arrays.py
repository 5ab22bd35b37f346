"""Array shapes that many folders share. Names say meaning; frame and unit stand in the variable.

A letter means one length throughout a call: where two sets of points differ in number, spell out
the annotation of one with another letter. Tests check that (tests/conftest.py).
"""

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32, UInt8

Vector2 = Float64[np.ndarray, "2"]
Vector3 = Float64[np.ndarray, "3"]
Matrix3 = Float64[np.ndarray, "3 3"]
Points2 = Float64[np.ndarray, "n 2"]
Points3 = Float64[np.ndarray, "n 3"]
AnyPoints2 = Float64[np.ndarray, "*n 2"]
AnyPoints3 = Float64[np.ndarray, "*n 3"]
"""One point, a list or a grid of them."""
Faces = Int32[np.ndarray, "f 3"]
GreyImage = UInt8[np.ndarray, "h w"]
ColourImage = UInt8[np.ndarray, "h w 3"]
FloatImage = Float32[np.ndarray, "h w"]
Mask = Bool[np.ndarray, "h w"]
