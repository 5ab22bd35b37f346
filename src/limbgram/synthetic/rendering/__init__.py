"""From a staged scene to the JPEG of a camera."""
