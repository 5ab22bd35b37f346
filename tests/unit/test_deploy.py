"""What is given for clusters and containers fits the program that it starts."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SLURM, DOCKER = ROOT / "deploy" / "slurm.sh", ROOT / "deploy" / "Dockerfile"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a script of bash")
def test_jobs_of_an_array_do_each_capture_once(tmp_path: Path) -> None:
    for name in ("P1", "P2", "P3"):
        (tmp_path / "in" / name).mkdir(parents=True)
    call = tmp_path / "limbgram"
    code = "import sys; sys.argv[0] = 'limbgram'; from limbgram.cli.main import app; app()"
    call.write_text(f'#!/bin/bash\nexec "{sys.executable}" -P -c "{code}" "$@"\n')
    call.chmod(0o755)
    jobs = [
        subprocess.Popen(
            ["bash", str(SLURM), str(tmp_path / "in"), str(tmp_path / "out"), "--dry-run"],
            env={
                **os.environ,
                "PATH": f"{tmp_path}:{os.environ['PATH']}",
                "SLURM_ARRAY_TASK_ID": str(job),
                "SLURM_ARRAY_TASK_MIN": "5",
                "SLURM_ARRAY_TASK_COUNT": "2",
            },
            stdout=subprocess.PIPE,
            text=True,
        )
        for job in (5, 6)
    ]
    told = [job.communicate()[0] for job in jobs]
    assert [job.returncode for job in jobs] == [0, 0]
    assert [re.findall(r"(P\d):", one) for one in told] == [["P1", "P3"], ["P2"]]


def test_the_image_copies_what_is_there_and_gives_up_its_rights() -> None:
    lines = DOCKER.read_text("utf-8").splitlines()
    copied = [word for line in lines if line.startswith("COPY") for word in line.split()[1:-1]]
    assert set(copied) == {"pyproject.toml", "README.md", "LICENSE", "src"}
    assert all((ROOT / name).exists() for name in copied)
    taken = DOCKER.with_name("Dockerfile.dockerignore").read_text("utf-8").splitlines()
    assert {f"!{name}" for name in copied} <= set(taken)
    users = [line.split()[1] for line in lines if line.startswith("USER")]
    assert users == ["limbgram"]
    assert lines.index("USER limbgram") < lines.index('ENTRYPOINT ["limbgram"]')
