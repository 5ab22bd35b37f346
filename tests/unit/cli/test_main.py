"""The list of commands, and commands that come out of their files when called."""

import io
import json
import os
import subprocess
import sys
import zlib
from importlib.metadata import version
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from limbgram.cli.main import COMMANDS, app, loaded

_HEAVY = ("numpy", "scipy", "numba", "cv2", "matplotlib", "pycolmap", "trimesh")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_says_of_each_command_what_its_own_help_begins_with(name: str) -> None:
    first = " ".join(loaded(name).help.split("\n\n")[0].split())
    assert COMMANDS[name][1] == first


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_answers_by_its_own_help(name: str) -> None:
    answer = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "200"})
    assert answer.exit_code == 0
    assert f"limbgram {name}" in answer.output
    assert "--json" in answer.output or "COMMAND" in answer.output


def test_a_mistyped_command_is_refused_with_the_nearest_name() -> None:
    answer = CliRunner().invoke(app, ["measur"])
    assert answer.exit_code == 2
    assert "'measure'" in answer.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["measure", "a.stl", "--every", "bogus"], "--every"),
        (["measure", "a.stl", "--evry", "5"], "--evry"),
        (["measur", "a.stl"], "'measure'"),
        (["edit", "add"], "recipe"),
        (["edit", "swap", "a.toml"], "'swap'"),
    ],
)
def test_words_that_make_no_sense_are_refused_in_json_if_json_was_asked_for(
    words: list[str], told: str
) -> None:
    answer = CliRunner().invoke(app, [*words, "--json"])
    refusal = json.loads(answer.stdout)
    assert answer.exit_code == refusal["exit_code"] == 2
    assert refusal["error"]["kind"] == "OptionsError"
    assert told in refusal["error"]["message"]
    assert not answer.stderr


def test_json_changes_no_other_exit_code() -> None:
    assert CliRunner().invoke(app, ["measure", "none.stl", "--json"]).exit_code == 3
    assert CliRunner().invoke(app, ["edit", "kinds", "--json"]).exit_code == 0
    assert CliRunner().invoke(app, ["measure", "--help", "--json"]).exit_code == 0


def test_the_version_is_the_installed_one() -> None:
    answer = CliRunner().invoke(app, ["--version"])
    assert answer.exit_code == 0
    assert answer.output == f"limbgram {version('limbgram')}\n"


def asked_by_shell(instruction: str, words: str = "limbgram ", **more: str) -> list[str]:
    """What a shell is answered after these words, the last of them half typed."""
    asked = {
        "_LIMBGRAM_COMPLETE": instruction,
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
        "_TYPER_COMPLETE_ARGS": words,
        **more,
    }
    answer = CliRunner().invoke(app, [], prog_name="limbgram", env=asked)
    assert answer.exit_code == 0, answer.output
    return answer.stdout.splitlines()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("limbgram meas", ["measure"]),
        ("limbgram measure --ev", ["--every"]),
        ("limbgram edit ad", ["add"]),
        ("limbgram edit add --a", ["--as", "--accept"]),
    ],
)
def test_bash_completes_commands_and_options_out_of_their_files(
    words: str, offered: list[str]
) -> None:
    assert asked_by_shell("complete_bash", words) == offered


@pytest.mark.slow
def test_zsh_and_fish_complete_with_what_an_option_means() -> None:
    (line,) = asked_by_shell("complete_zsh", "limbgram measure --ev")
    assert '"--every":"Spacing of the levels' in line
    wanted = {"_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    listed = asked_by_shell("complete_fish", "limbgram edit ", **wanted)
    assert "undo\tTake the last edit off a recipe." in listed


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_is_given_its_script(shell: str) -> None:
    script = "\n".join(asked_by_shell(f"source_{shell}"))
    assert f"_LIMBGRAM_COMPLETE=complete_{shell}" in script


def test_the_list_of_commands_waits_for_no_library() -> None:
    asked = f"""
import sys
import zlib
from limbgram.cli.main import app
try:
    app(["--help"])
except SystemExit as end:
    sys.exit(str([name for name in {_HEAVY} if name in sys.modules]) if not end.code else 1)
"""
    answer = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=False
    )
    assert "reconstruct" in answer.stdout
    assert answer.stderr.strip() == "[]"


def test_jobs_and_servers_begin_without_what_drawings_need() -> None:
    asked = """
import sys
import limbgram.app.server, limbgram.cases.job_worker
print("matplotlib" in sys.modules)
"""
    told = subprocess.run([sys.executable, "-c", asked], check=True, capture_output=True, text=True)
    assert told.stdout.split() == ["False"]


def test_matrix_products_run_on_one_thread_unless_asked_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = """
import os, sys
from limbgram.cli.main import loaded
assert "numpy" not in sys.modules
loaded("measure")
assert "numpy" in sys.modules
print(os.environ["OPENBLAS_NUM_THREADS"])
"""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    told = subprocess.run([sys.executable, "-c", asked], check=True, capture_output=True, text=True)
    assert told.stdout.split() == ["1"]
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    loaded("measure")
    assert os.environ["OPENBLAS_NUM_THREADS"] == "3"


@pytest.mark.parametrize(
    "name",
    [
        "measure",
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("accuracy", "reconstruct")),
    ],
)
def test_settings_in_the_current_folder_are_left_alone(name: str, tmp_path: Path) -> None:
    asked = f"""
import warnings
warnings.simplefilter("error")
from limbgram.cli.main import loaded
loaded("{name}")  # `measure` imports its drawings later, `reconstruct` in another process
import os
from limbgram.report.drawings.drawing import png
import matplotlib, numba
print(matplotlib.rcParams["savefig.dpi"], numba.config.DISABLE_JIT, os.getcwd())
"""
    (tmp_path / "matplotlibrc").write_text("savefig.dpi: 7\nno setting: at all\n", "utf-8")
    (tmp_path / ".numba_config.yaml").write_text("disable_jit: 1\n", "utf-8")
    told = subprocess.run(
        [sys.executable, "-P", "-c", asked],
        check=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert told.stdout.split() == ["figure", "0", str(tmp_path)]
    assert not told.stderr


@pytest.mark.parametrize("silenced", [True, False])
def test_what_libraries_warn_of_is_not_told_on_the_terminal(silenced: bool, tmp_path: Path) -> None:
    """Of a header that claims 169 megapixels, of a damaged one, and of a folder for lists of fonts
    that cannot be made. Left to themselves both libraries do warn."""
    picture = io.BytesIO()
    Image.new("RGB", (40, 30)).save(picture, "PNG")
    huge = bytearray(picture.getvalue())
    huge[16:24] = (13_000).to_bytes(4, "big") * 2
    huge[29:33] = zlib.crc32(huge[12:29]).to_bytes(4, "big")
    (tmp_path / "huge.png").write_bytes(huge)
    exif = b"Exif\0\0II*\0\x08\0\0\0\xff\x00" + b"\x0f\x01\x02\0\xff\0\0\0\xff\xff\0\0"
    Image.new("RGB", (40, 30)).save(tmp_path / "damaged.jpg", exif=exif)
    ours = """
from limbgram.cli.main import loaded
loaded("check")
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.core.errors import PhotoError
try:
    read_photos([Path(sys.argv[1])])
except PhotoError:
    pass
"""
    theirs = """
from PIL import Image
for one in Path(sys.argv[1]).iterdir():
    try:
        Image.open(one).getexif()
    except OSError:
        pass
"""
    asked = f"import sys\nfrom pathlib import Path\n{ours if silenced else theirs}"
    asked += "import matplotlib\nmatplotlib.get_cachedir()"
    (tmp_path / "no folder").write_text("")
    told = subprocess.run(
        [sys.executable, "-P", "-c", asked, str(tmp_path)],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "MPLCONFIGDIR": str(tmp_path / "no folder" / "fonts")},
    )
    if silenced:
        assert (told.stdout, told.stderr) == ("", "")
    else:
        assert "DecompressionBombWarning" in told.stderr
        assert "atplotlib created a temporary" in told.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use cannot be removed there")
def test_a_current_folder_that_is_gone_is_refused(tmp_path: Path) -> None:
    asked = """
import os, sys
os.rmdir(os.getcwd())
from limbgram.cli.main import app
app(["measure", "a.stl", "--json"])
"""
    (tmp_path / "gone").mkdir()
    told = subprocess.run(
        [sys.executable, "-P", "-c", asked],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path / "gone",
    )
    assert told.returncode == 2, told.stderr
    assert "moved or deleted" in json.loads(told.stdout)["error"]["message"]


def test_without_a_place_for_what_is_compiled_the_advice_says_where_to_make_one() -> None:
    asked = """
import numba.core.caching as caching
caching.CacheImpl._locator_classes = []  # no folder of this machine may be written
from limbgram.cli.main import app
app(["measure", "a.stl", "--json"])
"""
    told = subprocess.run(
        [sys.executable, "-P", "-c", asked], check=False, capture_output=True, text=True
    )
    assert told.returncode == 2, told.stderr
    assert "NUMBA_CACHE_DIR" in json.loads(told.stdout)["error"]["message"]


def test_a_record_waits_for_nothing_that_only_edits_need() -> None:
    """Curves of scipy and the words of edits, which are read out of their source, cost a third of
    the start; a record in English without a recipe tells neither."""
    asked = """
import sys
from limbgram.cli.main import loaded
loaded("report")
from limbgram.core.request_fields import declared
from limbgram.findings.tell import terms
from limbgram.workbench.edits.offset import Offset
assert not {"scipy.interpolate", "scipy.ndimage"} & {*sys.modules}
terms("en")
before = declared.cache_info().misses
declared(Offset)
assert declared.cache_info().misses == before + 1
assert terms("de")["The offset"] != "The offset"
print("right")
"""
    answer = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=False
    )
    assert answer.stdout.strip() == "right", answer.stderr
