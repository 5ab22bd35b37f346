"""Words that nobody knows are refused where an option is made, with the one that was meant."""

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
import trimesh

import limbgram
from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.mapping.placement import MappingOptions


@pytest.mark.parametrize(
    ("made", "name", "meant"),
    [
        (limbgram.AlignOptions, "side", "left"),
        (partial(limbgram.AlignOptions, side="left"), "kind", "foot"),
        (partial(limbgram.LimbFrame, limb_from_mesh=Rigid.identity()), "side", "right"),
        (limbgram.AopOptions, "axis", "fit"),
        (limbgram.AopOptions, "profile", "omega"),
        (limbgram.AopOptions, "line_end", "crlf"),
        (limbgram.CarveOptions, "pattern", "rings"),
        (limbgram.CarveOptions, "a_turns", "work"),
        (limbgram.RegistrationOptions, "way", "icp"),
        (partial(limbgram.Order, device="ucbl"), "made", "printed"),
        (partial(limbgram.Board, columns=14, rows=10, square_mm=10.0), "kind", "checkerboard"),
        (limbgram.PipelineOptions, "surface", "poisson"),
        (MappingOptions, "board_lenses", "hold"),
    ],
)
def test_a_word_in_capitals_or_unknown_is_refused(
    made: Callable[..., object], name: str, meant: str
) -> None:
    """'Left' ended with a KeyError; a_turns='Work' silently carved the other way round."""
    for given in (meant.capitalize(), meant + "s"):
        with pytest.raises(OptionsError) as refused:
            made_with(made(**{name: meant}), name, given)
        said = refused.value.finding
        assert said.code == "options.word"
        assert (said.values["option"], said.values["given"]) == (name, given)
        assert said.values["meant"] == meant
        assert meant in said.values["known"]
    with pytest.raises(OptionsError) as refused:
        made_with(made(**{name: meant}), name, 7)
    assert refused.value.finding.values["meant"] is None


def made_with(options: Any, name: str, given: object) -> None:
    """Make options with a value that the checks of types in these tests would stop."""
    object.__setattr__(options, name, given)
    options.__post_init__()


def test_a_limb_of_an_unknown_kind_is_refused(cube: Mesh) -> None:
    limb = limbgram.Limb(mesh=cube)
    assert limb.kind is None
    with pytest.raises(OptionsError, match=r"kind = 'Foot' is not known\. Was 'foot' meant\?"):
        made_with(limb, "kind", "Foot")


@pytest.fixture
def cube() -> Mesh:
    box = trimesh.creation.box()
    return Mesh(vertices_mm=box.vertices.copy(), faces=box.faces.astype("int32"))
