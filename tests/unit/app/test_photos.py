"""Photos that come in over HTTP: whole, in pieces, in zips; and what is taken out of them."""

import hashlib
import io
import os
import shutil
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app.state import AppState
from limbgram.cases.uploads import GIVEN_UP_S, Intake
from limbgram.core.errors import CaseError
from limbgram.reconstruction.photos.reading import read_photos

API = "/api/v1"


def jpeg(seed: int = 0, exif: Image.Exif | None = None) -> bytes:
    pixels = np.random.default_rng(seed).integers(0, 255, (66, 88, 3), np.uint8)
    made = io.BytesIO()
    Image.fromarray(pixels).save(made, "JPEG", exif=exif or Image.Exif(), quality=90)
    return made.getvalue()


@pytest.fixture
def photos(client: TestClient) -> str:
    """Where the photos of a new case are."""
    case = client.post(f"{API}/cases", json={"side": "left"}).json()
    return f"{API}/cases/{case['id']}/photos"


def test_a_photo_is_here_with_the_hash_of_what_was_sent(client: TestClient, photos: str) -> None:
    content = jpeg()
    sent = client.put(f"{photos}/IMG_1.jpg", content=content).json()
    assert sent["whole"]
    assert sent["new"]
    assert sent["photos"][0]["sha256"] == hashlib.sha256(content).hexdigest()
    listed = client.get(photos).json()
    assert [one["name"] for one in listed["photos"]] == ["IMG_1.jpg"]
    assert (listed["photos"][0]["width_px"], listed["photos"][0]["height_px"]) == (88, 66)


def test_the_same_photo_again_does_no_harm_and_another_is_refused(
    client: TestClient, photos: str
) -> None:
    client.put(f"{photos}/IMG_1.jpg", content=jpeg(1))
    again = client.put(f"{photos}/IMG_1.jpg", content=jpeg(1))
    assert again.status_code == 200
    assert not again.json()["new"]
    other = client.put(f"{photos}/IMG_1.jpg", content=jpeg(2))
    assert other.status_code == 409
    assert "rename" in other.json()["message"]
    kept = client.get(photos).json()["photos"][0]["sha256"]
    assert kept == hashlib.sha256(jpeg(1)).hexdigest()
    replaced = client.put(f"{photos}/IMG_1.jpg?replace=true", content=jpeg(2)).json()
    assert replaced["photos"][0]["sha256"] == hashlib.sha256(jpeg(2)).hexdigest()


def test_two_files_of_one_shot_count_as_one_photo_as_they_do_in_a_run(
    client: TestClient, app_state: AppState, photos: str
) -> None:
    """A camera that stores raw and JPEG, or a phone with a TIFF beside: two places less."""
    for number in range(3):
        client.put(f"{photos}/IMG_{number}.jpg", content=jpeg(number))
    for number in range(2):
        made = io.BytesIO()
        Image.open(io.BytesIO(jpeg(number))).save(made, "TIFF")
        client.put(f"{photos}/IMG_{number}.tif", content=made.getvalue())
    listed = client.get(photos).json()
    assert listed["here"] == 3
    spare = {one["name"]: one["same_shot"] for one in listed["photos"] if one["same_shot"]}
    assert spare == {"IMG_0.tif": "IMG_0.jpg", "IMG_1.tif": "IMG_1.jpg"}
    case = photos.rpartition("/")[0]
    assert client.get(case).json()["photos"] == 3
    assert client.post(f"{case}/check", json={"board": None}).json()["photos"] == 3

    # The run reads the same three, and so does a case that the command line made of these files.
    folder = app_state.shelf.case(case[-7:])
    used = read_photos([folder.received])
    assert [one.name for one in used.photos] == ["IMG_0.jpg", "IMG_1.jpg", "IMG_2.jpg"]
    made_elsewhere = app_state.shelf.root / "222-CKA" / "photos"
    shutil.copytree(folder.received, made_elsewhere)
    shutil.rmtree(made_elsewhere / ".records")
    assert client.get(f"{API}/cases/222-CKA").json()["photos"] == 3
    assert client.get(f"{API}/cases/222-CKA/photos").json()["here"] == 3


def test_a_file_that_cannot_be_used_is_no_photo_that_is_here(
    client: TestClient, photos: str
) -> None:
    client.put(f"{photos}/IMG_1.jpg", content=jpeg(1))
    client.put(f"{photos}/IMG_2.jpg", content=b"no photo")
    listed = client.get(photos).json()
    assert (listed["here"], len(listed["photos"])) == (1, 2)
    assert client.get(photos.rpartition("/")[0]).json()["photos"] == 1


def test_an_upload_that_broke_goes_on_from_what_is_here(client: TestClient, photos: str) -> None:
    content = jpeg(3)
    cut, total = len(content) // 3, len(content)
    first = client.put(
        f"{photos}/IMG_1.jpg",
        content=content[:cut],
        headers={"content-range": f"bytes 0-{cut - 1}/{total}"},
    ).json()
    assert first == {"whole": False, "new": True, "bytes": cut, "photos": []}
    listed = client.get(photos).json()["photos"][0]
    assert (listed["state"], listed["bytes"], listed["total"]) == ("arriving", cut, total)
    too_far = client.put(
        f"{photos}/IMG_1.jpg",
        content=content[cut + 10 :],
        headers={"content-range": f"bytes {cut + 10}-{total - 1}/{total}"},
    )
    assert too_far.status_code == 422
    assert f"from byte {cut}" in too_far.json()["message"]
    rest = client.put(
        f"{photos}/IMG_1.jpg",
        content=content[cut:],
        headers={"content-range": f"bytes {cut}-{total - 1}/{total}"},
    ).json()
    assert rest["whole"]
    assert rest["photos"][0]["sha256"] == hashlib.sha256(content).hexdigest()


def piece(
    client: TestClient, place: str, content: bytes, span: tuple[int, int], upload: str = ""
) -> Any:
    first, end = span
    headers = {"content-range": f"bytes {first}-{end - 1}/{len(content)}"}
    if upload:
        headers["upload-id"] = upload
    return client.put(place, content=content[first:end], headers=headers)


@pytest.mark.parametrize("ids", [("", ""), ("of-the-first", "of-the-second")])
def test_two_senders_of_one_name_make_no_mixed_photo(
    client: TestClient, photos: str, ids: tuple[str, str]
) -> None:
    one, other = (jpeg(seed).ljust(8000, b"\0") for seed in (1, 2))
    place = f"{photos}/IMG_1.jpg"
    assert piece(client, place, one, (0, 3000), ids[0]).json()["bytes"] == 3000
    second = piece(client, place, other, (0, 3000), ids[1])
    assert second.status_code == 409
    assert "rename" in second.json()["message"]
    assert client.get(photos).json()["photos"][0]["bytes"] == 3000
    if ids[1]:
        assert piece(client, place, other, (3000, 8000), ids[1]).status_code == 409
    assert client.put(place, content=other).status_code == 409
    ended = piece(client, place, one, (3000, 8000), ids[0]).json()
    assert ended["photos"][0]["sha256"] == hashlib.sha256(one).hexdigest()
    late = piece(client, place, other, (0, 8000), ids[1])
    assert (late.status_code, "Another photo" in late.json()["message"]) == (409, True)


def test_an_upload_begins_again_and_is_given_up_in_time(
    client: TestClient, app_state: AppState, photos: str
) -> None:
    one, other = (jpeg(seed).ljust(8000, b"\0") for seed in (1, 2))
    place = f"{photos}/IMG_1.jpg"
    for _ in range(2):  # its own sender may begin again at once
        assert piece(client, place, one, (0, 3000), "of-the-first").status_code == 200
    (part,) = app_state.shelf.root.rglob("IMG_1.jpg.part")
    quiet = part.stat().st_mtime - GIVEN_UP_S - 1
    os.utime(part, (quiet, quiet))
    assert piece(client, place, other, (0, 3000), "of-the-second").status_code == 200
    assert piece(client, place, one, (3000, 8000), "of-the-first").status_code == 409
    ended = piece(client, place, other, (3000, 8000), "of-the-second").json()
    assert ended["photos"][0]["sha256"] == hashlib.sha256(other).hexdigest()


def test_a_file_that_grows_has_one_writer(tmp_path: Path) -> None:
    intake, name = Intake(tmp_path / "received", b"a secret"), "IMG_1.jpg"
    with intake.begin(name, 0, 6) as first:
        first.write(b"abc")
        for upload in ("whole", "pieces", "another-one"):
            with pytest.raises(CaseError, match="comes in just now"):
                intake.begin(name, 0, 6, upload)
        first.write(b"def")
    assert (tmp_path / "received/.records/IMG_1.jpg.part").read_bytes() == b"abcdef"
    with pytest.raises(CaseError, match="has begun to come in"):  # of another length
        intake.begin(name, 6, 9, "pieces")


def test_a_sender_whose_line_died_goes_on_and_the_dead_line_writes_nothing_more(
    tmp_path: Path,
) -> None:
    intake, name, upload = Intake(tmp_path / "received", b"a secret"), "IMG_1.jpg", "of-a-phone"
    with intake.begin(name, 0, 6, upload) as dead:
        dead.write(b"abc")
        with intake.begin(name, intake.arrived(name), 6, upload) as alive:
            alive.write(b"def")
            with pytest.raises(CaseError, match="given up"):
                dead.write(b"xyz")
            alive.close()
            with pytest.raises(CaseError, match="comes in just now"):  # it gets its name
                intake.begin(name, 0, 6, upload)
            with pytest.raises(CaseError, match="looked at"):
                intake.remove(name)
            ended, new = intake.finish(name)
    assert (ended.sha256, new) == (hashlib.sha256(b"abcdef").hexdigest(), True)
    assert ended.kept == ("the whole header",)
    assert intake.remove(name)


def test_what_is_deleted_while_it_comes_in_is_written_no_more(tmp_path: Path) -> None:
    intake = Intake(tmp_path / "received", b"a secret")
    with intake.begin("IMG_1.jpg", 0, 6) as piece_:
        piece_.write(b"abc")
        assert intake.remove("IMG_1.jpg")
        with pytest.raises(CaseError, match="deleted"):
            piece_.write(b"def")
    assert intake.arriving() == ()


def test_place_name_and_serial_number_are_gone_and_the_pixels_are_the_same(
    client: TestClient, photos: str
) -> None:
    exif = Image.Exif()
    exif[0x010E] = "Mrs Somebody, left leg"
    exif[0x0110] = "A camera"
    exif[0x0112] = 6
    exif.get_ifd(0x8769).update({0xA431: "SERIAL-4711", 0x920A: 5.9, 0x927C: b"maker SERIAL-4711"})
    exif.get_ifd(0x8825).update({1: "N", 2: (48.0, 8.0, 14.2), 3: "E", 4: (11.0, 34.0, 32.0)})
    content = jpeg(4, exif)
    assert b"SERIAL-4711" in content
    sent = client.put(f"{photos}/IMG_1.jpg", content=content).json()["photos"][0]
    assert {"place", "serial number", "description", "maker's note"} <= set(sent["removed"])
    kept = client.get(f"{photos}/IMG_1.jpg/file").content
    for told in (b"SERIAL-4711", b"Somebody"):
        assert told not in kept
    before, after = Image.open(io.BytesIO(content)), Image.open(io.BytesIO(kept))
    assert np.array_equal(np.asarray(before), np.asarray(after))
    left = after.getexif()
    assert dict(left.get_ifd(0x8825)) == {}
    assert left[0x0110] == "A camera"
    assert left[0x0112] == 6
    assert float(left.get_ifd(0x8769)[0x920A]) == pytest.approx(5.9)
    body = left.get_ifd(0x8769)[0xA431]
    other = jpeg(5, exif)
    client.put(f"{photos}/IMG_2.jpg", content=other)
    again = Image.open(io.BytesIO(client.get(f"{photos}/IMG_2.jpg/file").content)).getexif()
    assert again.get_ifd(0x8769)[0xA431] == body, "the body must still be known from others"


def test_a_zip_brings_its_photos_and_nothing_else(
    client: TestClient, app_state: AppState, photos: str
) -> None:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr("walk/IMG_1.jpg", jpeg(1))
        archive.writestr("../../IMG_2.jpg", jpeg(2))
        archive.writestr("walk/notes.txt", "no photo")
        archive.writestr("__MACOSX/._IMG_1.jpg", b"no photo")
    sent = client.put(f"{photos}/walk.zip", content=made.getvalue()).json()
    assert [one["name"] for one in sent["photos"]] == ["IMG_1.jpg", "IMG_2.jpg"]
    names = {file.name for file in app_state.shelf.root.parent.rglob("*.jpg")}
    assert names == {"IMG_1.jpg", "IMG_2.jpg"}
    assert {one["state"] for one in client.get(photos).json()["photos"]} == {"here"}


def test_photos_of_one_name_in_two_folders_of_a_zip_are_two(
    client: TestClient, photos: str
) -> None:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for seed, name in enumerate(("100APPLE/IMG_1.jpg", "101APPLE/IMG_1.jpg", "IMG_1.jpg")):
            archive.writestr(name, jpeg(seed))
    sent = client.put(f"{photos}/walk.zip", content=made.getvalue()).json()
    names = ["100APPLE_IMG_1.jpg", "101APPLE_IMG_1.jpg", "walk_IMG_1.jpg"]
    assert [one["name"] for one in sent["photos"]] == names
    assert {one["state"] for one in sent["photos"]} == {"here"}


def test_a_zip_that_would_fill_the_disk_is_refused(client: TestClient, photos: str) -> None:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("IMG_1.jpg", bytes(40_000_000))
    refused = client.put(f"{photos}/bomb.zip", content=made.getvalue())
    assert refused.status_code == 422
    assert client.get(photos).json()["photos"] == []


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_damaged_zip_is_refused_whatever_packed_it(
    client: TestClient, photos: str, method: int
) -> None:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", method) as archive:
        archive.writestr("IMG_1.jpg", jpeg(1))
    content = bytearray(made.getvalue())
    content[60:80] = bytes(255 - one for one in content[60:80])
    refused = client.put(f"{photos}/walk.zip", content=bytes(content))
    assert refused.status_code == 422
    assert "cannot be unpacked" in refused.text
    assert client.get(photos).json()["photos"] == []


@pytest.mark.parametrize(
    "name",
    ["notes.txt", "..jpg", ".hidden.jpg", "a%5Cb.jpg", "con.jpg", "a%00.jpg", "x" * 130 + ".jpg"],
)
def test_names_that_can_be_no_photo_are_refused(
    client: TestClient, app_state: AppState, photos: str, name: str
) -> None:
    refused = client.put(f"{photos}/{name}", content=jpeg())
    assert refused.status_code == 422
    assert not list(app_state.shelf.root.rglob("*.jpg"))


def test_more_than_was_announced_or_is_taken_is_refused(client: TestClient, photos: str) -> None:
    content = jpeg()
    longer = client.put(
        f"{photos}/IMG_1.jpg", content=content, headers={"content-range": "bytes 0-9/10"}
    )
    assert longer.status_code == 422
    large = client.put(
        f"{photos}/IMG_2.jpg", content=b"x", headers={"content-range": "bytes 0-0/400000000"}
    )
    assert large.status_code == 422
    assert "300 MB" in large.json()["message"]


@pytest.mark.parametrize("left", [0.9, 0.5])
def test_a_photo_that_is_cut_off_is_not_good(client: TestClient, photos: str, left: float) -> None:
    """Its header is whole and tells its size; the reader of the run says the same of it."""
    content = jpeg()[: round(left * len(jpeg()))]
    (sent,) = client.put(f"{photos}/IMG_1.jpg", content=content).json()["photos"]
    assert sent["state"] == "unusable"
    assert "cut off: copy it again" in sent["problem"]["sentence"]


def test_what_cannot_be_opened_is_named(client: TestClient, photos: str) -> None:
    sent = client.put(f"{photos}/IMG_1.jpg", content=b"no picture at all").json()
    assert sent["photos"][0]["state"] == "unusable"
    assert sent["photos"][0]["problem"]["code"] == "photo.unusable"


def test_a_picture_is_turned_for_people_and_not_for_measuring(
    client: TestClient, photos: str
) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    client.put(f"{photos}/IMG_1.jpg", content=jpeg(1, exif))
    shown = Image.open(io.BytesIO(client.get(f"{photos}/IMG_1.jpg/picture?width=40").content))
    assert shown.size == (40, 53)
    stored = client.get(f"{photos}/IMG_1.jpg/picture?width=40&upright=false").content
    assert Image.open(io.BytesIO(stored)).size == (40, 30)


@pytest.mark.parametrize("channels", [1, 3])
def test_a_photo_of_12_bits_is_shown_as_bright_as_it_is(
    client: TestClient, photos: str, channels: int
) -> None:
    """As converters write them: at the lower end of sixteen bits."""
    ramp = np.tile(np.linspace(0, 4095, 320).astype(np.uint16), (240, 1))
    deep = ramp if channels == 1 else np.dstack([ramp] * channels)
    content = cv2.imencode(".png", deep)[1].tobytes()
    assert client.put(f"{photos}/deep.png", content=content).json()["whole"]
    picture = client.get(f"{photos}/deep.png/picture?width=320").content
    shown = np.asarray(Image.open(io.BytesIO(picture)).convert("L")).astype(int)
    assert np.abs(shown[120] - np.linspace(0, 255, 320)).max() < 6


def test_photos_that_the_command_line_was_given_are_neither_hidden_nor_taken_out(
    client: TestClient, app_state: AppState
) -> None:
    """One that was sent hid the others, and the next run set them aside."""
    given = app_state.shelf.root / "222-CKA" / "photos"
    given.mkdir(parents=True)
    for number in range(3):
        (given / f"IMG_{number}.jpg").write_bytes(jpeg(number))
    case = f"{API}/cases/222-CKA"
    sent = client.put(f"{case}/photos/IMG_7.jpg", content=jpeg(7))
    taken_out = client.delete(f"{case}/photos/IMG_1.jpg")
    for refused in (sent, taken_out):
        assert refused.status_code == 409
        assert refused.json()["finding"]["code"] == "case.upload.given"
    assert client.get(f"{case}/photos").json()["here"] == client.get(case).json()["photos"] == 3


def test_photos_that_were_taken_out_do_not_come_back_from_the_copies_of_a_run(
    client: TestClient, app_state: AppState, photos: str
) -> None:
    case = photos.rpartition("/")[0]
    client.put(f"{photos}/IMG_1.jpg", content=jpeg(1))
    copies = app_state.shelf.case(case[-7:]).folder.photos
    copies.mkdir()
    (copies / "IMG_1.jpg").write_bytes(jpeg(1))
    assert client.delete(f"{photos}/IMG_1.jpg").status_code == 204
    assert client.get(photos).json()["photos"] == []
    assert client.get(case).json()["photos"] == 0
    assert client.post(f"{case}/job", json={}).json()["finding"]["code"] == "app.no_photos_yet"
