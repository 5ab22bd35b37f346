"""Units: what one of another unit is in millimetres."""

MM_PER_INCH = 25.4
"""Since 1959, exactly."""
MM3_PER_ML = 1000.0
