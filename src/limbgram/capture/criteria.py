"""Criteria by which a capture counts as good."""

from limbgram.reconstruction.features.detection import FeatureOptions

FEATURES = FeatureOptions(max_keypoints=4000, max_megapixels=0.8)
MAX_GAP_DEG = 40.0
"""Widest angle between neighbouring photos that count, unless"""
MAX_GAP_RATIO = 1.4
"""the mean gap of the fullest ring is nearly as wide: few photos, evenly spread, up to"""
WIDEST_GAP_DEG = 60.0
"""this angle, up to which the verdict of a case stays green; where nothing else is amiss, wider
gaps than those two are advice up to here."""
STEP_DEG = 24.0
"""Between the photos that are asked for."""
MIN_BOARD_PHOTOS = 3
"""Photos in which the scale board must be found."""
LEAST_PHOTOS = 2
"""That a place must be seen by: fewer do not measure it;"""
WANTED_PHOTOS = 3
"""and so many where photos are asked for anyway."""
MAX_UNSEEN = 0.05
"""Share of the limb that fewer photos may see: what the verdict of a case allows."""
MAX_SIGMA_MM = 0.3
"""Expected sigma beyond which a place is called unsure: 0.6 mm in 95 of 100, the same."""
WIDEST_PAIR_DEG = 35.0
"""Between two photos that show a place squarely: up to here depth is found in most places."""
FEWEST_ROUND = 10
"""Photos that must count all the way round. Three rings of 9 were refused or red, one of them after
a GO; of 11 rings of 10 the six that showed the board well came out good."""
MAX_THIN = 0.3
"""Share of the limb for which all of them may stand wider. Ten good captures of 10 to 12 photos
have 0.11 at most; one of 9, with 0.73, came out full of holes."""
MOST_ADDED = 6
"""Photos that are asked for at a time because of places that too few see."""
