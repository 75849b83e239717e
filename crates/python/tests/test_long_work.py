"""Threads, progress, Ctrl-C and memory."""

import gc
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
import scenes

import stereotomy as st


def test_threads_get_the_same_mesh() -> None:
    solid = scenes.drilled()
    first = solid.mesh(tolerance=1e-3)
    with ThreadPoolExecutor(8) as pool:
        meshes = list(pool.map(lambda _: solid.mesh(tolerance=1e-3), range(16)))
    for mesh in meshes:
        assert mesh.vertices.tobytes() == first.vertices.tobytes()
        assert mesh.triangles.tobytes() == first.triangles.tobytes()


def test_other_threads_go_on_meanwhile() -> None:
    ticks = 0
    stop = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not stop.wait(0.001):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        before = ticks
        scenes.cheese(1000).mesh(tolerance=1e-3)
        meanwhile = ticks - before
    finally:
        stop.set()
        thread.join()
    # With the interpreter held there would be one at most.
    assert meanwhile > 20


def test_progress_is_told_by_the_calling_thread() -> None:
    told: list[float] = []
    threads = set()

    def progress(share: float) -> None:
        told.append(share)
        threads.add(threading.get_ident())

    scenes.cheese(10_000).mesh(tolerance=1e-2, progress=progress)
    assert told == sorted(set(told)) and told[-1] == 1.0 and len(told) > 2
    assert threads == {threading.get_ident()}


def test_an_exception_of_progress_stops_the_work() -> None:
    class Enough(Exception):
        pass

    def progress(share: float) -> None:
        raise Enough(share)

    with pytest.raises(Enough) as raised:
        scenes.cheese(10_000).mesh(tolerance=1e-2, progress=progress)
    assert raised.value.args[0] < 1.0


LONG = """
import sys
sys.path.insert(0, sys.argv[1])
import scenes, stereotomy as st
try:
    # Minutes of work.
    scenes.cheese(10_000).mesh(tolerance=1e-6, progress=lambda share: print("begun", flush=True))
    print("finished")
except KeyboardInterrupt:
    print("stopped")
print(st.cube(2).mesh().volume)
"""


def test_ctrl_c_stops_the_work() -> None:
    import pathlib

    folder = str(pathlib.Path(__file__).parent)
    with subprocess.Popen(
        [sys.executable, "-c", LONG, folder], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "begun\n"
        child.send_signal(signal.SIGINT)
        said, _ = child.communicate(timeout=120)
    lines = [line for line in said.splitlines() if line != "begun"]
    # And the next mesh is as good as ever.
    assert lines == ["stopped", "8.0"]
    assert child.returncode == 0


def resident() -> int:
    """Bytes of memory that the process holds."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096


def test_a_thousand_meshes_leave_nothing() -> None:
    solid = scenes.flange()
    size = 0

    def once() -> None:
        nonlocal size
        mesh = solid.mesh(tolerance=1e-4)
        arrays = (mesh.vertices, mesh.triangles, mesh.corner_normals, mesh.triangle_surfaces)
        size = sum(array.nbytes for array in arrays)
        mesh.surfaces, mesh.report, mesh.measure()

    for _ in range(100):
        once()
    gc.collect()
    before = resident()
    for _ in range(1000):
        once()
    gc.collect()
    # A twentieth of what the arrays together had.
    assert resident() - before < 1000 * size / 20
