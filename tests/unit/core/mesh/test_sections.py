"""Heights of sections: multiples of their spacing within the mesh, no closer than people read."""

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import heights_between


def test_sections_lie_a_twentieth_of_a_millimetre_apart_at_least() -> None:
    box = trimesh.creation.box((40.0, 40.0, 10.0))
    mesh = Mesh(vertices_mm=np.asarray(box.vertices), faces=box.faces.astype(np.int32))
    np.testing.assert_allclose(heights_between(mesh, 2.0), [-4, -2, 0, 2, 4])
    assert len(heights_between(mesh, 0.05)) == 199
    with pytest.raises(OptionsError) as refused:
        heights_between(mesh, 0.0499)
    assert refused.value.finding.code == "mesh.sections.close"
