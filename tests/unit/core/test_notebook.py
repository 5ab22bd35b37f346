"""What products show of themselves in a notebook, and as other libraries take them."""

import dataclasses
import inspect
import sys
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
import trimesh

import limbgram
from limbgram.core.errors import MissingError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief, html_of, library
from limbgram.core.spreadsheet import Table
from limbgram.workbench.compare import compare
from limbgram.workbench.compare.over_time import Visit, follow
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import LimbMeasureOptions, Measures, measure_limb

RADIUS_MM, SIGMA_MM = 50.0, 0.1
UP, FORWARDS = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """A tube, closed below and open above; its errors are alike everywhere."""
    tube = trimesh.creation.cylinder(radius=RADIUS_MM, height=200, sections=720)
    tube.update_faces(tube.face_normals[:, 2] < 0.5)
    tube.remove_unreferenced_vertices()
    count = len(tube.vertices)
    return Mesh(
        vertices_mm=np.asarray(tube.vertices, np.float64),
        faces=np.asarray(tube.faces, np.int32),
        colours=np.full((count, 3), 200, np.uint8),
        sigma_mm=np.full(count, SIGMA_MM, np.float32),
        shared_mm=np.full((count, 1), SIGMA_MM, np.float32),
    )


@pytest.fixture(scope="module")
def measures(mesh: Mesh) -> Measures:
    limb = align(
        Limb(mesh=mesh, name="tube.ply"), AlignOptions(side="none", axis=UP, anterior=FORWARDS)
    )
    return measure_limb(limb, LimbMeasureOptions(heights_mm=(50.0, 100.0, 500.0)))


def test_texts_of_products_are_short(mesh: Mesh, measures: Measures) -> None:
    assert repr(mesh).startswith(f"Mesh(vertices_mm=float64[{len(mesh)} x 3], faces=int32[")
    for product in (mesh, measures, measures.limb, *measures.rows):
        assert len(repr(product)) < 600
    assert brief(np.array([1.5, 2.0])) == "[1.5, 2]"
    assert brief((1, 2, 3, 4)) == "<4 x int>"
    assert brief("x" * 1000) == repr("x" * 60 + "...")


def test_public_products_that_hold_a_surface_or_lists_tell_their_form_alone() -> None:
    """Options, and what is named by somebody in a few words, stay as they were written."""
    public = (getattr(limbgram, name) for name in limbgram.__all__)
    large = ("ndarray, 'n", "Mesh'", ".Limb'", "Scene'")
    long = [
        one.__name__
        for one in public
        if inspect.isclass(one) and dataclasses.is_dataclass(one) and one.__repr__ is not brief
        for field in dataclasses.fields(one)
        if field.repr and any(word in str(field.type) for word in large)
    ]
    assert not long


def test_a_table_with_reach_is_shown_as_html(measures: Measures) -> None:
    shown = measures._repr_html_()
    assert shown.count("<tr>") == 4
    assert "tape [mm]" in shown
    tape = 2 * np.pi * RADIUS_MM
    # Radius and its error are alike everywhere: a girth's is 2 pi of it, 95 of 100 at 1.96.
    assert f"{tape:.1f} ± {1.96 * 2 * np.pi * SIGMA_MM:.1f}" in shown
    table = Table(title="t", columns=("name",), rows=(("<b>",), (None,)))
    assert "&lt;b&gt;" in html_of(table)


def test_measures_as_a_data_frame(measures: Measures) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    frame = measures.to_frame()
    assert list(frame.height_mm) == [50, 100, 500]
    assert frame.tape_mm[0] == pytest.approx(2 * np.pi * RADIUS_MM, rel=1e-4)
    assert frame.sigma_tape_mm[1] == pytest.approx(2 * np.pi * SIGMA_MM, rel=0.01)
    assert np.isnan(frame.tape_mm[2])  # beyond the limb


def test_a_plot_has_the_figures_and_their_band(measures: Measures) -> None:
    from matplotlib.figure import Figure

    axes = measures.plot("tape_mm", Figure().subplots())
    (line,) = axes.lines
    np.testing.assert_allclose(line.get_ydata(), [50, 100])
    np.testing.assert_allclose(line.get_xdata(), 2 * np.pi * RADIUS_MM, rtol=1e-4)
    band = axes.collections[0].get_paths()[0].get_extents()
    assert band.width == pytest.approx(2 * 1.96 * 2 * np.pi * SIGMA_MM, rel=0.05)
    assert axes.get_xlabel() == "tape [mm]"


def test_a_landmark_with_dollar_signs_is_no_formula_in_a_plot(measures: Measures) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure()
    axes = replace(measures, reference="$__$").plot("tape_mm", figure.subplots())
    FigureCanvasAgg(figure).draw()
    assert axes.get_ylabel() == "height from $__$ [mm]"


def test_a_mesh_for_trimesh_and_pyvista(mesh: Mesh) -> None:
    other = mesh.to_trimesh()
    np.testing.assert_array_equal(other.vertices, mesh.vertices_mm)
    np.testing.assert_array_equal(other.visual.vertex_colors[:, :3], mesh.colours)
    np.testing.assert_array_equal(other.vertex_attributes["sigma_mm"], mesh.sigma_mm)
    pytest.importorskip("pyvista", reason="pyvista is not installed")
    surface = mesh.to_pyvista()
    assert surface.n_cells == len(mesh.faces)
    np.testing.assert_array_equal(surface["sigma_mm"], mesh.sigma_mm)


def test_a_library_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, mesh: Mesh) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingError, match="pip install pyvista"):
        mesh.to_pyvista()
    assert library("math").pi == np.pi


def test_a_comparison_and_a_series_as_tables(mesh: Mesh, measures: Measures) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    wider = mesh.with_vertices(mesh.vertices_mm * (1.02, 1.02, 1.0))
    limbs = [measures.limb, replace(measures.limb, mesh=wider)]
    frame = compare(*limbs).to_frame()
    whole = frame.dropna(subset=["change_tape_mm"])
    np.testing.assert_allclose(whole.change_tape_mm, 0.02 * whole.first_tape_mm, rtol=1e-3)
    np.testing.assert_allclose(whole.sigma_tape_mm, np.sqrt(2) * 2 * np.pi * SIGMA_MM, rtol=0.05)
    days = (date(2026, 3, 2), date(2026, 3, 16), date(2026, 3, 30))
    series = follow([Visit(limb=limbs[k], day=day) for k, day in zip((0, 1, 1), days)])
    visits = series.to_frame()
    assert list(visits.day) == [day.isoformat() for day in days]
    assert visits.volume_ml[1] / visits.volume_ml[0] == pytest.approx(1.02**2, rel=1e-3)
    assert series._repr_html_().count("<tr>") == 4
    assert len(repr(series)) < 1000
