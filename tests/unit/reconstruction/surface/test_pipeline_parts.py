"""Every part is measured like the first one; one that refuses does not stop the others."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import SurfaceError
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.run import Run
from limbgram.findings import fault
from limbgram.reconstruction import pipeline
from limbgram.reconstruction.budget import Resolution
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.pipeline import Capture, PipelineOptions, Reconstruction
from limbgram.reconstruction.poses import Poses
from limbgram.reconstruction.surface.parts import PartOptions


class FromTheCloud(Run):
    """A run whose stages before the surface are done: they give a cloud."""

    def __init__(self, cloud: Cloud, refused: int) -> None:
        super().__init__()
        self.cloud = cloud
        self.refused = refused

    def __call__(self, stage: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        match stage.__name__:
            case "fuse":
                return self.cloud
            case "pivot" | "tell_parts" | "repair":
                return stage(*args, **kwargs)
            case "refine":
                return args[0]
            case "measure":
                return self._measured(args[2])
            case _:
                return SimpleNamespace(
                    scene=SimpleNamespace(views=()),
                    floor_z_mm=None,
                    set_aside=(),
                    quarter_turns=(),
                )

    def _measured(self, mesh: Mesh) -> Mesh:
        assert mesh.repairs is not None
        if mesh.repairs.part == self.refused:
            raise SurfaceError("Hardly a vertex looks alike.")
        return mesh


@pytest.fixture
def balls(sphere_cloud: Cloud) -> Cloud:
    """Two balls, the nearer one with two thirds of the other's radius."""
    small = sphere_cloud.points_mm[::2] * np.float32(2 / 3) + np.array([80, 0, 0], np.float32)
    return replace(
        sphere_cloud,
        points_mm=np.concatenate([sphere_cloud.points_mm, small]),
        normals=np.concatenate([sphere_cloud.normals, sphere_cloud.normals[::2]]),
        colours=np.concatenate([sphere_cloud.colours, sphere_cloud.colours[::2]]),
        views=np.concatenate([sphere_cloud.views, sphere_cloud.views[::2]]),
    )


def done(
    monkeypatch: pytest.MonkeyPatch, cloud: Cloud, *, chosen: int | None = None, refused: int = 0
) -> Reconstruction:
    fine = Resolution(edge_mm=1.0, face_parts=1, photo_halvings=0, depth_share=1.0, notes=())
    monkeypatch.setattr(pipeline, "resolution_for", lambda *_, **__: fine)
    monkeypatch.setattr(pipeline, "depth_share", lambda *_: 1.0)
    monkeypatch.setattr(pipeline, "refuse_beyond", lambda *_: None)
    nothing = SimpleNamespace(
        features=None,
        matches=None,
        pairs=None,
        scene=SimpleNamespace(lens_explanations=()),
        still=StaticBackground(),
        poses=Poses(),
        lenses=None,
    )
    monkeypatch.setattr(pipeline, "place_photos", lambda *_: nothing)
    monkeypatch.setattr(pipeline, "by_the_limb", lambda placed, *_: placed)
    options = PipelineOptions(parts=PartOptions(chosen=chosen))
    return pipeline.reconstruct(Capture(sources=()), options, FromTheCloud(cloud, refused))


def middle_mm(mesh: Mesh | None) -> float:
    assert mesh is not None
    return float(mesh.vertices_mm[:, 0].mean())


def test_the_other_body_is_measured_too(monkeypatch: pytest.MonkeyPatch, balls: Cloud) -> None:
    found = done(monkeypatch, balls)
    assert middle_mm(found.mesh) == pytest.approx(0, abs=0.5)
    (other,) = found.others
    assert (other.part.number, other.reason) == (2, None)
    assert middle_mm(other.mesh) == pytest.approx(80, abs=0.5)


def test_the_chosen_one_is_the_surface(monkeypatch: pytest.MonkeyPatch, balls: Cloud) -> None:
    found = done(monkeypatch, balls, chosen=2)
    assert middle_mm(found.mesh) == pytest.approx(80, abs=0.5)
    assert [one.part.number for one in found.others] == [1]


def test_a_body_that_refuses_is_told_with_its_reason(
    monkeypatch: pytest.MonkeyPatch, balls: Cloud
) -> None:
    (other,) = done(monkeypatch, balls, refused=2).others
    assert other.mesh is None
    assert other.reason == fault("said.as_is", message="Hardly a vertex looks alike.")
    assert other.part.area_mm2 == pytest.approx(4 * np.pi * 20**2, rel=0.05)
    with pytest.raises(SurfaceError):
        done(monkeypatch, balls, refused=1)
