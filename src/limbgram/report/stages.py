"""Stages: their names for people, on a page and at a terminal."""

_STAGES = {
    "survey": "Follow the film",
    "choose frames": "Choose its frames",
    "read photos": "Read the photos",
    "reduce photos": "Reduce the photos",
    "look at limb": "Look at the limb",
    "cameras for": "Cameras",
    "detect": "Feature points",
    "find still": "What stands still",
    "match": "Matches",
    "find poses": "Poses of the object",
    "verify": "Pairs",
    "place": "Place the photos",
    "place roughly": "Place the photos",
    "follow points": "Points at full size",
    "find board": "Find the board",
    "board of object": "The board beside the object",
    "tell sides": "What lies beside the limb",
    "find movement": "Did the limb move?",
    "find bending": "Did it keep its shape?",
    "still board": "The board as if all had kept still",
    "find marks": "Find the marks",
    "to millimetres": "Scale",
    "find region": "Find the limb",
    "estimate depth": "Depth",
    "fuse": "Points",
    "pivot": "Surface (Ball Pivoting)",
    "poisson": "Surface (Poisson)",
    "tell parts": "Parts",
    "repair": "Repair",
    "refine": "Even triangles",
    "measure": "Measure the surface",
    "draw": "Pictures",
    "hold tapes": "Taped girths",
    "deliver": "Files",
    "assess": "Accuracy",
    "assess case": "Accuracy",
    "calibrate": "Calibrate the camera",
    "make capture": "Photograph a synthetic limb",
}


def stage_title(stage: str) -> str:
    """A stage's name for people."""
    return _STAGES.get(stage.replace("_", " "), stage.replace("_", " ").capitalize())
