"""Intended use: what every page, PDF and record says of what the program is for."""

OF_SCANS = (
    "limbgram measures the outer shape of a limb or a model of it. It is not a cleared medical "
    "device: a qualified professional verifies dimensions before anything is made from them."
)
"""Of a case and its accuracy, where nothing has been shaped yet."""
OF_SHAPES = (
    "Shape capture and computer-aided shaping of casts and limbs by qualified prosthetic and "
    "orthotic professionals. Not for diagnosis. A professional must verify dimensions before "
    "fabrication. Not a cleared medical device."
)
"""Of a record, which may be kept with what was made."""
NOT_TESTED = (
    "Not strength tested. The thickness is that of the model, not of what was made; a professional "
    "checks fit, edges and strength before anybody wears it. It claims no correction."
)
"""Of a device: on every page and in the file itself."""
