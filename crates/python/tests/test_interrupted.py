"""Ctrl-C while workers work: it stops soon, and leaves neither processes nor halves of files."""

import contextlib
import itertools
import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

SCRIPT = pathlib.Path(__file__).parent / "interrupted.py"


@contextlib.contextmanager
def begun(engine: str, work: str, folder: pathlib.Path) -> Iterator[subprocess.Popen[str]]:
    """The program, in a group of processes of its own, in the middle of its work."""
    command = [sys.executable, str(SCRIPT), engine, work, str(folder)]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as child:
        try:
            if work == "mesh":
                assert child.stdout is not None
                assert child.stdout.readline() == "begun\n"
            else:
                until(lambda: any(folder.glob("begun-*")))
            yield child
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)


def until(holds: object, seconds: float = 120) -> None:
    assert callable(holds)
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.02)


def is_gone(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.parametrize(
    ("engine", "work"),
    [*itertools.product(["here", "dask", "ray"], ["mesh", "sweep"]), ("here", "stubborn")],
)
def test_ctrl_c_stops_workers(engine: str, work: str, tmp_path: pathlib.Path) -> None:
    with begun(engine, work, tmp_path) as child:
        if engine == "here":
            # As a terminal does it.
            os.killpg(child.pid, signal.SIGINT)
        else:
            child.send_signal(signal.SIGINT)
        said, complaints = child.communicate(timeout=120)
        lines = [line for line in said.splitlines() if line != "begun"]
        assert lines[0] == "stopped"
        # (Ray may end the process while it shuts down.)
        assert child.returncode == 0 or engine == "ray"
        if engine == "here":
            assert lines == ["stopped", "0 processes left"]
            assert complaints == ""
        until(lambda: is_gone(child.pid))
    names = {path.name for path in tmp_path.iterdir()}
    whole = {name for name in names if name.startswith(("part-", "begun-"))}
    left = names - whole
    # Ray kills its workers: what one was writing then has no name of a result.
    assert not left or engine == "ray"
    assert all(name.startswith(".unfinished-") for name in left)
    assert len(whole) < 2000


def test_workers_end_with_the_process_that_started_them(tmp_path: pathlib.Path) -> None:
    with begun("here", "sweep", tmp_path) as child:
        child.kill()
        child.wait()
        until(lambda: is_gone(child.pid))
