"""A case is brought whole, accepted once, and never by who was given up for lost."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from limbgram.batch.storage import (
    ATTEMPTS,
    CaptureUrl,
    Cases,
    CasesAtUrl,
    CasesInFolder,
    _Bucket,
    captures_at,
    cases_at,
    read_from,
    write_to,
)
from limbgram.cases.folder import CaseFolder, locked
from limbgram.core.errors import Cancelled, CaseError, OptionsError

BUCKET = "limbs"


@pytest.fixture(params=["folder", "s3"])
def cases(request: pytest.FixtureRequest, tmp_path: Path) -> Cases:
    """Cases in a folder, and the same behind a URL."""
    if request.param == "folder":
        found = cases_at(str(tmp_path / "out"))
    else:
        found = cases_at(f"{request.getfixturevalue('s3')}/{tmp_path.name}")
    found.begin()
    return found


def made(folder: Path, text: str) -> Path:
    """A case with a file at its root and one deeper."""
    (folder / "deliverables").mkdir(parents=True)
    (folder / "case.json").write_text(text)
    (folder / "deliverables" / "a ü.ply").write_bytes(text.encode() * 1000)
    (folder / ".lock").touch()
    return folder


def go_on() -> None:
    """Nobody asked to stop."""


def found(cases: Cases, name: str, to: Path) -> dict[str, str]:
    """What a machine that fetches the case finds."""
    cases.fetch(name, to, go_on)
    return {
        file.relative_to(to).as_posix(): file.read_text()[:1]
        for file in to.rglob("*")
        if file.is_file()
    }


def test_a_case_is_brought_whole_and_the_next_one_replaces_it(cases: Cases, tmp_path: Path) -> None:
    nothing = cases.fetch("P 1", tmp_path / "none", go_on)
    assert not (tmp_path / "none").exists()
    total = cases.bring(made(tmp_path / "a", "A"), "P 1", "aaaa", go_on)
    assert total == 1001
    assert found(cases, "P 1", tmp_path / "early") == {}
    cases.accept("P 1", "aaaa", nothing, total)
    first = {"case.json": "A", "deliverables/a ü.ply": "A"}
    assert found(cases, "P 1", tmp_path / "first") == first
    seen = cases.fetch("P 1", tmp_path / "again", go_on)
    cases.bring(made(tmp_path / "b", "B"), "P 1", "bbbb", go_on)
    cases.accept("P 1", "bbbb", seen, total)
    assert set(found(cases, "P 1", tmp_path / "second").values()) == {"B"}


def test_only_one_of_two_that_began_from_the_same_case_is_accepted(
    cases: Cases, tmp_path: Path
) -> None:
    seen = cases.fetch("P1", tmp_path / "none", go_on)
    total = 0
    for letter in "ab":
        total = cases.bring(made(tmp_path / letter, letter), "P1", letter * 4, go_on)
    cases.accept("P1", "bbbb", seen, total)
    with pytest.raises(CaseError, match="changed by somebody else"):
        cases.accept("P1", "aaaa", seen, total)
    assert set(found(cases, "P1", tmp_path / "kept").values()) == {"b"}


def test_an_attempt_that_is_not_whole_is_never_accepted(cases: Cases, tmp_path: Path) -> None:
    def stop() -> None:
        raise Cancelled("Stopped.")

    seen = cases.fetch("P1", tmp_path / "none", go_on)
    with pytest.raises(Cancelled):
        cases.bring(made(tmp_path / "a", "A"), "P1", "aaaa", stop)
    total = cases.bring(made(tmp_path / "b", "B"), "P1", "bbbb", go_on)
    for token, size in (("aaaa", total), ("bbbb", total + 1), ("cccc", total)):
        with pytest.raises(CaseError, match="Not all files"):
            cases.accept("P1", token, seen, size)
    assert found(cases, "P1", tmp_path / "nothing") == {}
    cases.accept("P1", "bbbb", seen, total)
    assert set(found(cases, "P1", tmp_path / "whole").values()) == {"B"}


def test_a_case_that_was_changed_by_hand_meanwhile_is_left_as_it_is(tmp_path: Path) -> None:
    cases = CasesInFolder(tmp_path / "out")
    cases.begin()
    case = made(tmp_path / "out" / "P1", "A")
    seen = cases.fetch("P1", tmp_path / "copy", go_on)
    time.sleep(0.02)
    (case / "case.json").write_text("by hand")
    total = cases.bring(made(tmp_path / "b", "B"), "P1", "bbbb", go_on)
    with pytest.raises(CaseError, match="changed by somebody else"):
        cases.accept("P1", "bbbb", seen, total)
    assert (case / "case.json").read_text() == "by hand"
    seen = cases.fetch("P1", tmp_path / "later", go_on)
    with locked(CaseFolder(case)), pytest.raises(CaseError, match="Another run"):
        cases.accept("P1", "bbbb", seen, total)
    cases.accept("P1", "bbbb", seen, total)
    assert (case / "case.json").read_text() == "B"


def test_what_comes_after_the_end_finds_no_place(tmp_path: Path) -> None:
    cases = CasesInFolder(tmp_path / "out")
    cases.begin()
    cases.end()
    with pytest.raises(CaseError, match="not there"):
        cases.bring(made(tmp_path / "a", "A"), "P1", "aaaa", go_on)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_case_whose_exchange_was_cut_off_is_put_back(tmp_path: Path) -> None:
    cases = CasesInFolder(tmp_path / "out")
    cases.begin()
    made(tmp_path / "out" / ATTEMPTS / "old-P1", "A")
    made(tmp_path / "out" / ATTEMPTS / "try-aaaa", "B")
    cases.begin()
    assert (tmp_path / "out" / "P1" / "case.json").read_text() == "A"
    assert list((tmp_path / "out" / ATTEMPTS).iterdir()) == []


def test_attempts_behind_a_url_that_no_record_names_are_removed(s3: str, tmp_path: Path) -> None:
    cases = CasesAtUrl(f"{s3}/left")
    total = 0
    for token in ("aaaa", "bbbb"):
        total = cases.bring(made(tmp_path / token, token), "P1", token, go_on)
    cases.accept("P1", "aaaa", "0", total)
    cases.bring(made(tmp_path / "cccc", "c"), "P2", "cccc", go_on)
    cases.end()
    import s3fs

    keys = [key.removeprefix("limbs/left/") for key in s3fs.S3FileSystem().find("limbs/left")]
    names = ("00000001.json", "aaaa/case.json", "aaaa/deliverables/a ü.ply")
    assert sorted(keys) == [f"P1/{name}" for name in names]
    assert cases.read("P1", "case.json") == b"aaaa"
    assert cases.read("P2", "case.json") is None


def test_captures_behind_a_url_are_planned_from_names_and_fetched_whole(
    s3: str, tmp_path: Path
) -> None:
    folder = tmp_path / "in"
    (folder / "P1" / "masks").mkdir(parents=True)
    for name in ("batch.toml", "P1/a.jpg", "P1/masks/a.png", "P1/capture.toml", "P2.zip", "b.jpg"):
        (folder / name).write_text(name)
    url = f"{s3}/captures"
    import s3fs

    s3fs.S3FileSystem().put(str(folder), f"{BUCKET}/captures", recursive=True)
    captures = captures_at(url + "/")
    assert isinstance(captures, CaptureUrl)
    (tmp_path / "outline").mkdir()
    captures.outline(tmp_path / "outline")
    outline = {
        file.relative_to(tmp_path / "outline").as_posix(): file.read_bytes()
        for file in (tmp_path / "outline").rglob("*")
        if file.is_file()
    }
    assert outline == {
        "batch.toml": b"batch.toml",
        "P1/capture.toml": b"P1/capture.toml",
        "P2.zip": b"",
        "b.jpg": b"\xff\xd8\xff",
    }
    for place, names in (("P1", ["a.jpg", "capture.toml", "masks", "a.png"]), ("P2.zip", [])):
        there = captures.fetch(place, tmp_path / "fetched", go_on)
        assert there == tmp_path / "fetched" / place
        assert sorted(file.name for file in there.rglob("*")) == sorted(names)
    assert (tmp_path / "fetched" / "P2.zip").read_text() == "P2.zip"


def test_of_two_that_create_the_same_record_at_once_one_does(s3: str) -> None:
    bucket = _Bucket(f"{s3}/records")
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda k: bucket.create("1.json", b"%d" % k), range(8)))
    assert sum(made) == 1
    assert bucket.read("1.json") == b"%d" % made.index(True)


def test_a_table_is_put_behind_a_url_and_read_again(s3: str, tmp_path: Path) -> None:
    assert read_from(f"{s3}/table", "batch.json") is None
    (tmp_path / "batch.json").write_text("{}")
    where = write_to(f"{s3}/table/", [tmp_path / "batch.json"])
    assert where == (f"{s3}/table/batch.json",)
    assert read_from(f"{s3}/table", "batch.json") == b"{}"


def test_a_store_that_does_not_answer_is_told_with_what_to_do(s3: str) -> None:
    with pytest.raises(CaseError, match="rights of this machine"):
        CasesAtUrl("s3://no-such-bucket/cases").bring(Path(__file__).parent, "P1", "aaaa", go_on)
    with pytest.raises(OptionsError, match="nothing-such"):
        cases_at("nothing-such://a/b").begin()
    assert s3
