"""What of a rim is believed."""

import numpy as np

from limbgram.reconstruction.measuring.measurement import as_alike_as_inside


def test_a_rim_is_held_to_how_alike_the_surface_is_elsewhere() -> None:
    """Sound patches correlate by 0.9 to 1; those past an edge by 0.6 to 0.88, by chance."""
    alike = np.concatenate([np.linspace(0.9, 1.0, 500), np.linspace(0.6, 0.88, 50), np.zeros(50)])
    rim = np.arange(600) >= 400
    believed = as_alike_as_inside(alike.astype(np.float32), rim)
    assert believed[400:500].all()
    assert not believed[500:].any()


def test_with_nothing_but_a_rim_every_believed_patch_counts() -> None:
    alike = np.array([0.0, 0.62, 0.9], np.float32)
    everywhere = np.ones(3, bool)
    assert as_alike_as_inside(alike, everywhere).tolist() == [False, True, True]
