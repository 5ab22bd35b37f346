"""Stages: their names for people, on a page and at a terminal."""

_STAGES = {
    "survey": "Video survey",
    "choose frames": "Frame selection",
    "read photos": "Reading the photos",
    "reduce photos": "Reduced photos",
    "look at limb": "Limb preview",
    "cameras for": "Cameras",
    "detect": "Keypoints",
    "find still": "Static background",
    "match": "Matching",
    "find poses": "Poses of the object",
    "verify": "Two-view geometry",
    "place": "Camera poses",
    "place roughly": "Camera poses, reduced",
    "follow points": "Full-resolution tracks",
    "find board": "Board detection",
    "board of object": "Board of the object",
    "tell sides": "Surroundings",
    "find movement": "Rigid motion of the limb",
    "find bending": "Bending of the limb",
    "still board": "Board, if nothing moved",
    "find marks": "Coded marks",
    "to millimetres": "Scale",
    "find region": "Region of the limb",
    "estimate depth": "Depth maps",
    "fuse": "Depth fusion",
    "pivot": "Surface (Ball Pivoting)",
    "poisson": "Surface (Poisson)",
    "tell parts": "Connected parts",
    "repair": "Mesh repair",
    "refine": "Remeshing",
    "measure": "Surface measurement",
    "draw": "Pictures",
    "hold tapes": "Taped girths",
    "deliver": "Files",
    "assess": "Accuracy",
    "assess case": "Accuracy",
    "calibrate": "Camera calibration",
    "make capture": "Synthetic capture",
}


def stage_title(stage: str) -> str:
    """A stage's name for people."""
    return _STAGES.get(stage.replace("_", " "), stage.replace("_", " ").capitalize())
