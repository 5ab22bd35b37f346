"""A limb that never was, for the examples: a tapering tube with a rounded end, open at the top."""

import numpy as np

import limbgram


def stump(top_mm: float = 58.0, bottom_mm: float = 50.0, length_mm: float = 220.0) -> limbgram.Limb:
    """An aligned left limb; its axis is z, its front y."""
    spokes = np.radians(np.arange(0, 360, 3))
    dome = np.linspace(0, np.pi / 2, 18)[1:]
    heights = np.concatenate(
        [bottom_mm * (1 - np.cos(dome)), np.linspace(bottom_mm, length_mm, 60)[1:]]
    )
    share = np.clip((heights - bottom_mm) / (length_mm - bottom_mm), 0, 1)
    radii = np.where(heights < bottom_mm, 0, bottom_mm + share * (top_mm - bottom_mm))
    radii[: len(dome)] = bottom_mm * np.sin(dome)
    rings = np.stack(
        [
            radii[:, None] * np.cos(spokes),
            radii[:, None] * np.sin(spokes),
            np.repeat(heights[:, None], len(spokes), axis=1),
        ],
        axis=-1,
    )
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], rings.reshape(-1, 3)])
    count, here = len(spokes), np.arange(len(spokes))
    ahead = (here + 1) % count
    faces = [np.stack([np.zeros(count), 1 + ahead, 1 + here], axis=1)]
    for row in range(len(heights) - 1):
        low, high = 1 + row * count, 1 + (row + 1) * count
        faces.append(np.stack([low + here, low + ahead, high + ahead], axis=1))
        faces.append(np.stack([low + here, high + ahead, high + here], axis=1))
    mesh = limbgram.Mesh(vertices_mm=vertices, faces=np.concatenate(faces).astype(np.int32))
    forwards, up = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    options = limbgram.AlignOptions(side="left", kind="transtibial", axis=up, anterior=forwards)
    fibula = limbgram.Landmark(name="fibula head", position_mm=np.array([-56.0, 0.0, 165.0]))
    patella = limbgram.Landmark(name="patellar tendon", position_mm=np.array([0.0, 57.0, 195.0]))
    return limbgram.align(
        limbgram.with_landmarks(limbgram.Limb(mesh=mesh), (fibula, patella)), options
    )
