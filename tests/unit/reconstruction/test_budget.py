"""Budget: what is decided from the memory allowed, and what is refused before the work."""

import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from limbgram.core.errors import BudgetError, PhotoError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Run, budget_mb, in_parallel, machine_mb, resident_megabytes
from limbgram.findings import told
from limbgram.reconstruction.budget import Resolution, depth_share, refuse_beyond, resolution_for
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.measuring.imagery import imagery_mb, load_crops
from limbgram.reconstruction.measuring.measurement_pass import face_points
from limbgram.reconstruction.photos.decoding import decoding_mb, load_colour, load_luma
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.reconstruction.surface.remeshing import refine

WIDTH_PX, HEIGHT_PX, FOCAL_PX, AWAY_MM = 4000, 3000, 4000.0, 1000.0
PIXEL_MM = AWAY_MM / FOCAL_PX
SIDE_MM = 400.0
AREA_MM2 = SIDE_MM**2


def photo(width_px: int = WIDTH_PX, height_px: int = HEIGHT_PX, name: str = "a.jpg") -> Photo:
    return Photo(
        name=name,
        path=Path(name),
        width_px=width_px,
        height_px=height_px,
        exif=Exif(),
        sha256=name,
        camera_idx=0,
    )


def photo_set(count: int, megapixels: float) -> PhotoSet:
    side_px = round((megapixels * 1e6) ** 0.5)
    group = CameraGroup(label="", width_px=side_px, height_px=side_px, exif=Exif())
    return PhotoSet(tuple(photo(side_px, side_px, f"{k}.jpg") for k in range(count)), (group,))


def sheet(cells: int = 20) -> Mesh:
    """A square in the plane z = 0, seen whole by every photo."""
    steps = np.linspace(-SIDE_MM / 2, SIDE_MM / 2, cells + 1)
    x, y = np.meshgrid(steps, steps)
    at = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    return Mesh(
        vertices_mm=np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()]),
        faces=np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])]).astype(
            np.int32
        ),
    )


def metric(count: int = 10) -> MetricScene:
    """Photos a metre above the sheet, looking straight down."""
    down = np.diag([1.0, -1.0, -1.0])
    points = sheet().vertices_mm
    camera = Camera(
        width_px=WIDTH_PX, height_px=HEIGHT_PX, fx=FOCAL_PX, fy=FOCAL_PX, cx=1999.5, cy=1499.5
    )
    pose = Rigid(down, np.array([0.0, 0.0, AWAY_MM]))
    view = View("", camera, pose)
    scene = Scene(
        names=tuple(f"{k}.jpg" for k in range(count)),
        cameras=(camera,),
        camera_idx=(0,) * count,
        camera_from_world=(pose,) * count,
        points_in_world=points,
        observations=Observations(
            np.repeat(np.arange(count, dtype=np.int32), len(points)),
            np.tile(np.arange(len(points), dtype=np.int32), count),
            np.tile(view.project(points), (count, 1)),
        ),
        verdicts=(),
    )
    return MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))


def resolution(
    surface: Mesh,
    most_triangles: int = 400_000,
    memory_mb: float = 1e5,
    beside_mm2: float = 0.0,
) -> Resolution:
    return resolution_for(
        metric(),
        surface,
        edge_px=4.5,
        most_triangles=most_triangles,
        depth_share=1.0,
        memory_mb=memory_mb,
        beside_mm2=beside_mm2,
    )


def test_pixels_too_fine_for_the_triangles_are_halved_where_they_take_much_memory() -> None:
    """Ten photos take 150 MB here, sixty 900; edges of 30,000 triangles are 3.5 mm long."""

    def of(count: int, most_triangles: int) -> Resolution:
        return resolution_for(
            metric(count),
            sheet(),
            edge_px=4.5,
            most_triangles=most_triangles,
            depth_share=1.0,
            memory_mb=1e5,
        )

    assert of(10, 30_000).photo_halvings == 0
    many = of(60, 30_000)
    assert many.photo_halvings == 1
    assert many.edge_mm == of(10, 30_000).edge_mm
    assert "too large for smaller pixels" in told(many.notes[0])
    views = [metric().scene.view(0)] * 60
    assert (
        imagery_mb(views, sheet().vertices_mm, 0) > 600 > imagery_mb(views, sheet().vertices_mm, 1)
    )
    assert of(60, 200_000).photo_halvings == 0  # pixels that such triangles can follow are kept


def test_pixels_set_the_edges_where_triangles_suffice() -> None:
    """To the bit: a limb under the cap is measured as without one."""
    small = replace(sheet(), vertices_mm=sheet().vertices_mm * 0.5)
    found = resolution(small)
    assert found.edge_mm == 4.5 * PIXEL_MM
    assert (found.face_parts, found.photo_halvings, found.notes) == (1, 0, ())


@pytest.mark.parametrize("most", [20_000, 60_000])
def test_edges_grow_where_pixels_would_make_too_many_triangles(most: int) -> None:
    found = resolution(sheet(), most)
    assert found.edge_mm > 4.5 * PIXEL_MM
    made = len(refine(sheet(), found.edge_mm).faces)
    assert 0.7 * most < made < 1.3 * most
    assert f"{most:,} triangles" in told(found.notes[0])


def test_parts_share_the_triangles_by_their_areas() -> None:
    """A sheet beside another one of three times its area has a quarter of the triangles."""
    area = 0.5 * float(np.linalg.norm(sheet().face_normals(), axis=1).sum())
    alone, beside = resolution(sheet(), 20_000), resolution(sheet(), 80_000, 1e5, 3 * area)
    assert beside.edge_mm == pytest.approx(alone.edge_mm, rel=1e-12)
    assert "80,000 triangles on all parts together" in told(beside.notes[0])
    small = replace(sheet(), vertices_mm=sheet().vertices_mm * 0.2)
    assert resolution(small, beside_mm2=1000.0).edge_mm == 4.5 * PIXEL_MM


def test_long_edges_are_sampled_as_densely_as_short_ones() -> None:
    found = resolution(sheet(), 60_000)
    assert found.face_parts == round(found.edge_mm / (4.5 * PIXEL_MM)) == 2
    dense, plain = face_points(2), face_points(1)
    assert len(dense) == 4 * len(plain)
    for points in (dense, plain):  # nor is a round surface lifted by where its samples lie
        a, b, c = points.T
        assert np.mean(a * b + b * c + c * a) == pytest.approx(0.25)
        assert points.min() > 0


def test_photos_are_halved_until_the_measurement_fits() -> None:
    """Ten photos of 12 MP, filled by a sheet of 100,000 triangles."""
    assert resolution(sheet(), 100_000).photo_halvings == 0
    crops_mb = [imagery_mb(metric().scene.views, sheet().vertices_mm, k) for k in range(3)]
    # The sheet's width shows in 1600 + 48 px of each photo, and so does its height.
    assert crops_mb[0] == pytest.approx(10 * 1648**2 * 6 / 2**20, rel=0.02)
    assert crops_mb[0] > 3 * crops_mb[1] > 9 * crops_mb[2]
    halvings: list[int] = []
    for memory_mb in (1200.0, 800.0, 600.0, 520.0):
        found = resolution(sheet(), 100_000, memory_mb)
        halvings.append(found.photo_halvings)
        assert found.edge_mm >= 4.5 * PIXEL_MM * 2**found.photo_halvings
        reduced = any("reduced to 1/" in told(one) for one in found.notes)
        assert reduced == (found.photo_halvings > 0)
    assert halvings == sorted(halvings)
    assert (halvings[0], halvings[-1]) == (0, 2)


def test_what_cannot_fit_is_refused_with_numbers() -> None:
    with pytest.raises(BudgetError, match=r"0\.\d GB of memory even in photos .*0\.3 GB may be"):
        resolution(sheet(), memory_mb=300.0)


def test_captures_beyond_the_budget_are_refused_before_the_work() -> None:
    refuse_beyond(photo_set(15, 4.0), 1024.0)
    with pytest.raises(BudgetError, match=r"8 photos of up to 144 megapixels need .*1\.0 GB may"):
        refuse_beyond(photo_set(8, 144.0), 1024.0)
    with pytest.raises(BudgetError, match="placing all photos"):
        refuse_beyond(photo_set(200, 1.0), 1024.0)


def test_depth_takes_the_pixels_that_fit() -> None:
    photos = photo_set(15, 4.0)
    assert depth_share(photos, 8_000_000, 12_000.0) == 1.0
    shares = [depth_share(photos, 8_000_000, memory_mb) for memory_mb in (800, 650, 550, 100)]
    assert shares == sorted(shares, reverse=True)
    assert 0.25 == shares[-1] < shares[2] < shares[1] < 1.0
    few = photo_set(10, 0.3)  # three megapixels in all: they fit where eight would not
    assert depth_share(few, 8_000_000, 550.0) == 1.0 > depth_share(photos, 8_000_000, 550.0)


def test_no_more_is_in_flight_than_there_is_room_for() -> None:
    def most_at_a_time(each_mb: float, room_mb: float) -> int:
        lock, now, most = threading.Lock(), [0], [0]
        gate = threading.Barrier(2)

        def work(_: int) -> None:
            with lock:
                now[0] += 1
                most[0] = max(most[0], now[0])
            try:
                gate.wait(0.2)  # two meet here if two may run
            except threading.BrokenBarrierError:
                gate.reset()
            with lock:
                now[0] -= 1

        def stage() -> int:
            in_parallel(work, range(4), 2, each_mb=each_mb)
            return most[0]

        return Run(memory_mb=resident_megabytes() + room_mb)(stage)

    assert most_at_a_time(100.0, 1000.0) == 2
    assert most_at_a_time(600.0, 1000.0) == 1
    assert most_at_a_time(5000.0, 1000.0) == 1


def test_the_budget_is_half_of_the_machine_unless_told() -> None:
    assert budget_mb() == 0.5 * machine_mb()
    assert Run(memory_mb=777.0)(budget_mb) == 777.0
    assert 256 < machine_mb() < 1e8


def test_a_photo_that_cannot_be_decoded_within_the_budget_is_told_so(tmp_path: Path) -> None:
    for k in range(2):
        Image.new("L", (6000, 5000), 9 + k).save(tmp_path / f"{k}.png")
    assert decoding_mb(tmp_path / "0.png", 30_000_000) > 150
    with pytest.raises(PhotoError, match=r"6000 x 5000 pixels take 0\.\d GB to decode.*0\.4 GB"):
        Run(memory_mb=0.44 * 1024)(read_photos, [tmp_path])  # as --memory 0.44


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "P", "1", "LA", "CMYK"])
def test_decoding_band_by_band_gives_the_pixels_of_the_whole(
    tmp_path: Path, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("limbgram.reconstruction.photos.decoding._BAND_PX", 1000)
    rng = np.random.default_rng(5)
    picture = Image.fromarray(rng.integers(0, 256, (97, 131, 3), np.uint8)).convert(mode)
    path = tmp_path / ("a.tif" if mode in ("CMYK", "LA") else "a.png")
    picture.save(path)
    one = replace(photo(131, 97), path=path)
    with Image.open(path) as again:
        np.testing.assert_array_equal(load_luma(one), np.asarray(again.convert("L")))
        np.testing.assert_array_equal(load_colour(one), np.asarray(again.convert("RGB")))


@pytest.mark.parametrize("halvings", [1, 2])
def test_crops_halved_when_loaded_hold_the_sums_of_pixels(tmp_path: Path, halvings: int) -> None:
    """Nothing is rounded on the way, and pixel centres stay."""
    rng = np.random.default_rng(3)
    pixels = rng.integers(0, 256, (HEIGHT_PX // 4, WIDTH_PX // 4), np.uint8)
    Image.fromarray(pixels).save(tmp_path / "a.png")
    one = replace(photo(WIDTH_PX // 4, HEIGHT_PX // 4), path=tmp_path / "a.png")
    whole = metric(1).scene.views[0]
    view = View("", whole.camera.scaled(0.25), whole.camera_from_world)
    (crop,) = load_crops([one], [view], sheet().vertices_mm * 0.5, halvings)
    assert crop.halvings == halvings
    (height, width), side = crop.pixels.shape, 2**halvings
    assert min(width, height) >= 40
    rows, columns = (
        slice(first * side, (first + count) * side)
        for first, count in ((crop.y0, height), (crop.x0, width))
    )
    sums = pixels[rows, columns].astype(int).reshape(height, side, width, side).sum((1, 3))
    np.testing.assert_array_equal(crop.pixels, sums)
