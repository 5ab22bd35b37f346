"""Quality: edges of known blur, and photos that stand out of their set."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.findings import fault, told
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.photos.quality import (
    assessed,
    brightest_luma,
    burnt_share,
    common_fault,
    edge_width_px,
    files_by_kind,
    remarks,
)


def discs(sigma_px: float, seed: int = 0, size_px: int = 500) -> np.ndarray:
    """Bright discs of many sizes with edges blurred by a Gaussian of known width."""
    rng = np.random.default_rng(seed)
    picture = np.full((size_px * 4, size_px * 4), 60, np.uint8)
    for x, y, radius in zip(*rng.integers(0, size_px * 4, (2, 60)), rng.integers(60, 160, 60)):
        cv2.circle(picture, (int(x), int(y)), int(radius), int(rng.integers(60, 220)), -1)
    small = cv2.resize(picture, (size_px, size_px), interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(small.astype(np.float32), (0, 0), sigma_px)
    noisy = blurred + rng.normal(0, 1.5, blurred.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("sigma_px", [1.0, 2.0, 3.0])
def test_the_width_of_blurred_edges_is_found(sigma_px: float) -> None:
    assert 0.75 * sigma_px < edge_width_px(discs(sigma_px)) < 1.25 * sigma_px


def test_blur_in_one_direction_counts() -> None:
    sharp = discs(0.8)
    across = cv2.blur(sharp, (9, 1))
    assert edge_width_px(sharp) < 1.3
    assert 2.0 < edge_width_px(across) < 4.0  # a box of 9 px has a deviation of 2.6 px


def test_edges_beside_the_limb_do_not_count() -> None:
    """Behind it lies what is out of focus, with edges as steep as those on it or steeper."""
    limb = 60 + discs(0.8)[:, :250] // 3
    soft = discs(2.5, seed=1)[:, :250].astype(float)
    behind = 255.0 * (soft - soft.min()) / np.ptp(soft)
    picture = np.hstack([limb, behind]).astype(np.uint8)
    where = np.zeros(picture.shape, np.bool_)
    where[:, :240] = True
    assert edge_width_px(picture) > 1.5
    assert edge_width_px(picture, where=where) < 1.3


def test_a_picture_without_edges_has_no_width() -> None:
    assert np.isnan(edge_width_px(np.full((300, 300), 90, np.uint8)))


def test_of_a_large_photo_the_middle_is_looked_at() -> None:
    middle = discs(2.0)
    rows, columns = (max(0, (2400 - side) // 2) for side in middle.shape)
    large = np.pad(middle, ((rows, rows), (columns, columns)), mode="edge")
    assert min(large.shape) > 1800
    assert edge_width_px(large) == pytest.approx(edge_width_px(middle), rel=0.1)


def test_light_is_measured() -> None:
    picture = np.full((400, 400), 40, np.uint8)
    picture[:100] = 255
    everywhere = np.ones(picture.shape, np.bool_)
    assert abs(burnt_share(picture, everywhere) - 0.25) < 0.01
    assert brightest_luma(picture, everywhere) == 255
    assert brightest_luma(np.full((400, 400), 40, np.uint8), everywhere) == 40
    assert np.isnan(burnt_share(picture, ~everywhere))
    assert np.isnan(brightest_luma(picture, ~everywhere))


def before_white(limb: np.ndarray) -> np.ndarray:
    """A patterned limb of 200 x 500 px that leaves the picture above, before clipped paper."""
    picture = np.full((900, 1200), 255, np.uint8)
    picture[:500, 500:700] = limb
    return picture


def test_a_burnt_backdrop_is_not_the_limb() -> None:
    """Nine tenths of the picture are burnt, and nothing of the limb is."""
    limb = np.tile(np.repeat([60, 150], 10).astype(np.uint8), (500, 10))
    seen = assessed(photo("a.jpg", 1.0), before_white(limb))
    assert seen.burnt < 0.01
    assert 145 <= seen.brightest <= 255
    assert remarks(PhotoSet((seen,), ())) == ()
    assert common_fault([seen]) is None


def test_dark_clothes_before_white_paper_are_underexposed() -> None:
    seen = assessed(photo("a.jpg", 1.0), before_white(discs(0.8)[:500, :200] // 8))
    assert seen.brightest < 40
    assert seen.burnt < 0.01


@pytest.mark.parametrize("patch_px", [40, 120])
def test_what_is_burnt_on_the_limb_counts_before_any_backdrop(patch_px: int) -> None:
    limb = np.full((500, 200), 150, np.uint8)
    limb[150 : 150 + patch_px, 40 : 40 + patch_px] = 255
    for backdrop in (255, 40):
        picture = before_white(limb)
        picture[picture == 255] = backdrop
        picture[150 : 150 + patch_px, 540 : 540 + patch_px] = 255
        whole_px = limb.size if backdrop == 255 else picture.size
        share = patch_px**2 / whole_px
        assert 0.9 * share < assessed(photo("a.jpg", 1.0), picture).burnt < 1.1 * share


def test_paint_on_a_burnt_limb_is_no_limb_before_a_backdrop() -> None:
    """Skin and wall are burnt; of the limb the paint is left, and it is the skin that lies bare."""
    limb = np.full((500, 200), 255, np.uint8)
    for x, y in np.random.default_rng(5).integers(5, 195, (160, 2)):
        cv2.circle(limb, (int(x), int(y * 500 / 200)), 4, 80, -1)
    bare = float((limb == 255).mean())
    assert assessed(photo("a.jpg", 1.0), before_white(limb)).burnt > 0.8 * bare
    nothing = assessed(photo("a.jpg", 1.0), np.full((900, 1200), 255, np.uint8))
    assert nothing.burnt == 1.0


def photo(name: str, sharpness: float, burnt: float = 0.0, brightest: float = 200.0) -> Photo:
    return Photo(
        name=name,
        path=Path(name),
        width_px=100,
        height_px=100,
        exif=Exif(),
        sha256=name,
        camera_idx=0,
        sharpness=sharpness,
        burnt=burnt,
        brightest=brightest,
    )


def test_the_odd_photos_are_remarked_on_and_no_others() -> None:
    photos = [photo(f"{index}.jpg", 1.0 + index / 20) for index in range(8)]
    odd = [
        photo("shaken.jpg", 3.0),
        photo("bright.jpg", 1.0, burnt=0.6),
        photo("dark.jpg", 1.0, brightest=30.0),
    ]
    found = {remark.name: told(remark.finding) for remark in remarks(PhotoSet((*photos, *odd), ()))}
    assert found.keys() == {"shaken.jpg", "bright.jpg", "dark.jpg"}
    assert "blurred" in found["shaken.jpg"]
    assert "overexposed" in found["bright.jpg"]
    assert "underexposed" in found["dark.jpg"]


def test_what_spoils_most_photos_is_named() -> None:
    sharp, soft = photo("a", 0.9), photo("b", 4.0)
    assert common_fault([sharp, sharp, soft]) is None
    blurred = common_fault([sharp, soft, soft])
    assert blurred == fault("photo.most_blurred", spoilt=2, photos=3, edge_px=4.0)
    burnt = common_fault([photo("c", 4.0, burnt=0.4)])
    assert burnt == fault("photo.most_overexposed", spoilt=1, photos=1, share=0.4)
    dark = common_fault([photo("d", 0.9, brightest=20.0)])
    assert dark == fault("photo.most_underexposed", spoilt=1, photos=1)
    bare = common_fault([photo("e", float("nan"))])
    assert bare == fault("photo.most_edgeless", spoilt=1, photos=1)


def codes(*of: Photo) -> list[str]:
    return [remark.finding.code for remark in remarks(PhotoSet(of, ()))]


def test_a_photo_is_remarked_on_from_its_limit_on() -> None:
    """Three tenths burnt; the brightest hundredth below luma 60."""
    assert codes(photo("a", 1.0, burnt=0.3), photo("b", 1.0, brightest=60.0)) == []
    odd = photo("a", 1.0, burnt=0.301), photo("b", 1.0, brightest=59.9)
    assert codes(*odd) == ["photo.overexposed", "photo.underexposed"]


@pytest.mark.parametrize(
    ("spoilt", "last", "beyond"),
    [
        ("photo.most_overexposed", photo("a", 1.0, burnt=0.05), photo("a", 1.0, burnt=0.051)),
        ("photo.most_underexposed", photo("a", 1.0, 0.0, 60.0), photo("a", 1.0, 0.0, 59.9)),
        ("photo.most_blurred", photo("a", 1.8), photo("a", 1.81)),
    ],
)
def test_a_fault_explains_failure_from_its_limit_on(
    spoilt: str, last: Photo, beyond: Photo
) -> None:
    assert common_fault([last]) is None
    found = common_fault([beyond])
    assert found is not None
    assert found.code == spoilt


def test_blur_is_judged_as_in_6_megapixels() -> None:
    """Of 24 megapixels edges are half as wide there; of less they are what they are."""
    large = replace(photo("a", 3.59), width_px=6000, height_px=4000)
    assert common_fault([large]) is None
    assert common_fault([replace(large, sharpness=3.61)]) is not None


def test_a_few_photos_of_another_lens_are_a_fifth_at_most() -> None:
    groups = tuple(
        CameraGroup(label=label, width_px=400, height_px=300, exif=Exif()) for label in ("A", "B")
    )
    for others, told_of in ((2, 2), (3, 0)):
        photos = [
            replace(photo(f"{k}", 1.0), camera_idx=int(k < others), exif=Exif()) for k in range(10)
        ]
        assert len(remarks(PhotoSet(tuple(photos), groups))) == told_of


@pytest.mark.parametrize(("longer", "said"), [(0.0029, 0), (0.0031, 1)])
def test_a_lens_that_was_focused_anew_is_three_thousandths_longer(longer: float, said: int) -> None:
    """A thin lens of 10 mm is longer than that at 2.01 m by 1 in 200."""
    near_m = 0.010 + 0.010 / (0.005 + longer)
    group = CameraGroup(label="A", width_px=400, height_px=300, exif=Exif())
    distances = [2.01] * 4 + [near_m]
    photos = [
        replace(photo(f"{k}", 1.0), exif=Exif(focal_mm=10.0, subject_m=metres))
        for k, metres in enumerate(distances)
    ]
    assert len(remarks(PhotoSet(tuple(photos), (group,)))) == said


def test_cameras_that_are_focused_differently_are_not_said_to_have_refocused() -> None:
    """Each of two cameras keeps its own focus, and its lens is solved for by itself."""
    groups = tuple(
        CameraGroup(label=label, width_px=400, height_px=300, exif=Exif()) for label in ("A", "B")
    )
    distances = [0.5, 0.9] * 5
    photos = [
        replace(
            photo(f"{k}", 1.0),
            camera_idx=k % 2,
            exif=Exif(model="AB"[k % 2], focal_mm=50.0, subject_m=metres),
        )
        for k, metres in enumerate(distances)
    ]
    assert remarks(PhotoSet(tuple(photos), groups)) == ()
    photos[2] = replace(photos[2], exif=replace(photos[2].exif, subject_m=0.9))
    (odd,) = remarks(PhotoSet(tuple(photos), groups))
    assert (odd.name, odd.finding.values["usual_m"]) == ("2", 0.5)


def test_five_files_that_are_no_pictures_are_named_and_more_are_counted(tmp_path: Path) -> None:
    for count, told_of in ((5, 5), (6, 1)):
        files = [tmp_path / f"{k}.txt" for k in range(count)]
        for file in files:
            file.touch()
        assert len(files_by_kind(files).others) == told_of


def test_burnt_ground_between_paint_that_placed_the_photos_spoils_nothing() -> None:
    """Of the limb, not of the picture, is the share then: most are called so when each one is."""
    ground = [photo(f"{k}", 1.0, burnt=0.08) for k in range(3)]
    assert common_fault(ground) is not None
    assert common_fault(ground, placed=True) is None
    burnt = [photo("a", 1.0, burnt=0.3), *(photo(f"{k}", 1.0, burnt=0.31) for k in range(2))]
    found = fault("photo.most_overexposed", spoilt=2, photos=3, share=0.31)
    assert common_fault(burnt, placed=True) == found
    assert common_fault(burnt[:2], placed=True) is None


def test_photos_that_their_points_placed_are_not_said_to_show_no_edge() -> None:
    bare = [photo("a", float("nan")), photo("b", float("nan")), photo("c", 1.0)]
    assert common_fault(bare) == fault("photo.most_edgeless", spoilt=2, photos=3)
    assert common_fault(bare, placed=True) is None
    soft = [photo("a", float("nan")), photo("b", 4.0), photo("c", 4.0)]
    blurred = common_fault(soft, placed=True)
    assert blurred == fault("photo.most_blurred", spoilt=2, photos=3, edge_px=4.0)


def test_blur_counts_as_far_as_keypoints_see_it() -> None:
    """Of 48 megapixels four pixels are one of three megapixels."""
    large = replace(photo("a", 4.0), width_px=8000, height_px=6000)
    assert common_fault([large]) is None


def test_a_photo_of_another_lens_or_focus_is_named() -> None:
    def photo(number: int, camera_idx: int = 0, subject_m: float | None = 1.5) -> Photo:
        return Photo(
            name=f"{number}.jpg",
            path=Path(f"{number}.jpg"),
            width_px=400,
            height_px=300,
            exif=Exif(model="Phone", focal_mm=5.7, subject_m=subject_m),
            sha256=str(number),
            camera_idx=camera_idx,
        )

    cameras = tuple(
        CameraGroup(label=label, width_px=400, height_px=300, exif=Exif())
        for label in ("Phone, 5.7 mm", "Phone, 9 mm")
    )
    usual = [photo(k) for k in range(10)]
    odd = remarks(PhotoSet((*usual, photo(10, 1), photo(11, 0, 0.4), photo(12, 0, None)), cameras))
    assert [one.name for one in odd] == ["10.jpg", "11.jpg"]
    assert "taken with Phone, 9 mm" in told(odd[0].finding)
    # f / (D - f) for 0.4 and 1.5 m: 1.45 % and 0.38 %.
    assert "its lens is 1.1% longer" in told(odd[1].finding)
    halves = PhotoSet(tuple(photo(k, k % 2) for k in range(10)), cameras)
    assert remarks(halves) == ()


def test_a_photo_whose_pixels_were_turned_is_not_called_another_lens() -> None:
    def photo(number: int, width_px: int, height_px: int, camera_idx: int) -> Photo:
        return Photo(
            name=f"{number}.jpg", path=Path(f"{number}.jpg"), width_px=width_px,
            height_px=height_px, exif=Exif(model="Phone"), sha256=str(number),
            camera_idx=camera_idx,
        )  # fmt: skip

    cameras = tuple(
        CameraGroup(label="Phone, 5.7 mm", width_px=width, height_px=height, exif=Exif())
        for width, height in ((400, 300), (300, 400))
    )
    usual = [photo(k, 400, 300, 0) for k in range(10)]
    (odd,) = remarks(PhotoSet((*usual, photo(10, 300, 400, 1)), cameras))
    assert odd.name == "10.jpg"
    assert told(odd.finding).startswith(
        "300 x 400, where 10 others are 400 x 300: a program has turned"
    )
    assert "lens" not in told(odd.finding)
