"""Shards and variants by workers: processes of this machine, and real clusters of Ray and Dask
on it, workers of which are killed on the way."""

import contextlib
import csv
import importlib
import multiprocessing
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
import scenes

import stereotomy as st

# Clusters are left by processes of their own, sockets open.
pytestmark = pytest.mark.filterwarnings("ignore")

WORKERS = 3
# Set where Ray's turn is.
RAY = "STEREOTOMY_TEST_RAY"


class Cluster:
    """A client, and the processes of its workers."""

    def __init__(self, client: object, processes: Callable[[], set[int]]) -> None:
        self.client = client
        self.processes = processes


@contextlib.contextmanager
def here() -> Iterator[Cluster]:
    def processes() -> set[int]:
        return {child.pid for child in multiprocessing.active_children() if child.pid}

    yield Cluster(None, processes)


@contextlib.contextmanager
def dask_cluster() -> Iterator[Cluster]:
    distributed: Any = importlib.import_module("distributed")

    cluster = distributed.LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, processes=True, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        yield Cluster(client, lambda: set(client.run(os.getpid).values()))


@contextlib.contextmanager
def ray_cluster() -> Iterator[Cluster]:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    ray: Any = importlib.import_module("ray")
    ray.init(
        num_cpus=WORKERS,
        include_dashboard=False,
        log_to_driver=False,
        object_store_memory=200_000_000,
        # Where workers find this module.
        runtime_env={"env_vars": {"PYTHONPATH": os.path.dirname(__file__)}},
    )

    @ray.remote  # type: ignore[untyped-decorator]
    def process() -> int:
        time.sleep(0.1)
        return os.getpid()

    try:
        yield Cluster(ray, lambda: set(ray.get([process.remote() for _ in range(WORKERS)])))
    finally:
        ray.shutdown()


ENGINES = [ray_cluster] if RAY in os.environ else [here, dask_cluster]


@pytest.fixture(scope="module", params=ENGINES)
def cluster(request: pytest.FixtureRequest) -> Iterator[Cluster]:
    with request.param() as made:
        yield made


def cheese() -> st.Solid:
    holes = [st.sphere(0.11).translate([x, y, 0.9 * x * y]) for x in (-0.7, 0, 0.6) for y in (-0.6, 0.1, 0.8)]
    return (st.cube(2).named("block") - st.union(holes)).colored("#ff8000") | st.cylinder(0.2, z=3)


def test_a_mesh_in_shards_is_the_whole_to_the_byte(
    cluster: Cluster, tmp_path: pathlib.Path
) -> None:
    solid = cheese()
    solid.save(tmp_path / "whole.ply", cells=60)
    solid.save(tmp_path / "whole.glb", cells=60)
    for shards in (1, 7):
        for kind in ("ply", "glb"):
            out = tmp_path / f"merged.{kind}"
            made = st.distributed.mesh(
                solid, cells=60, client=cluster.client, shards=shards, out=out
            )
            assert made is None
            assert out.read_bytes() == (tmp_path / f"whole.{kind}").read_bytes()


def test_a_worker_that_dies_is_replaced(cluster: Cluster, tmp_path: pathlib.Path) -> None:
    solid = cheese()
    shares: list[float] = []
    killed: list[int] = []
    known = cluster.processes()

    def kill(share: float) -> None:
        shares.append(share)
        if not killed and share > 0.1:
            killed.append(min(known or cluster.processes()))
            os.kill(killed[0], signal.SIGKILL)

    made = st.distributed.mesh(
        solid, cells=150, client=cluster.client, shards=40, progress=kill, folder=tmp_path
    )
    assert made is not None and len(killed) == 1
    assert shares == sorted(shares) and shares[-1] == 1
    assert killed[0] not in cluster.processes()
    whole = solid.mesh(cells=150)
    for name in ("vertices", "triangles", "triangle_surfaces", "corner_normals"):
        assert getattr(made, name).tobytes() == getattr(whole, name).tobytes(), name
    assert made.surfaces == whole.surfaces and made.unit == whole.unit
    assert made.report is not None and made.report.check.is_manifold
    # They shared a folder: every shard is there.
    assert len(list(tmp_path.glob("part-*-of-40.shard"))) == 40


def flange(bore: float, bolts: int, note: str) -> st.Solid:
    """A model that kills its worker once."""
    if bolts == 5 and not os.path.exists(note):
        pathlib.Path(note).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    hole = st.infinite_cylinder(0.08).translate([0.75, 0, 0])
    return st.cylinder(1, z=0.2) - st.infinite_cylinder(bore) - hole.polar_pattern(bolts)


def test_variants_are_measured_in_order(cluster: Cluster, tmp_path: pathlib.Path) -> None:
    note = tmp_path / "died"
    bores = [0.2 + 0.01 * (i % 30) for i in range(60)] + [-1.0]
    bolts = [3 + i // 12 for i in range(61)]
    table: dict[str, list[Any]] = {"bore": bores, "bolts": bolts, "note": [str(note)] * 61}
    rows = st.distributed.sweep(
        flange, table, client=cluster.client, rows_at_once=4, out=tmp_path / "all.csv"
    )
    assert note.exists()
    assert [row["row"] for row in rows] == list(range(1, 62))
    for row in rows[:60]:
        alone = flange(row["bore"], row["bolts"], row["note"]).measure()
        assert (row["volume"], row["area"], row["error"]) == (alone.volume, alone.area, "")
    assert rows[60]["volume"] is None and "radius is -1" in rows[60]["error"]
    again = st.distributed.sweep(
        flange, table, client=cluster.client, rows_at_once=50, out=tmp_path / "again.csv"
    )
    assert again == rows
    assert (tmp_path / "all.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()


def test_errors_come_from_workers_as_they_are(cluster: Cluster) -> None:
    with pytest.raises(ValueError, match="70000 cells: ask for 1 to 65536"):
        st.distributed.mesh(st.cube(1), cells=70000, client=cluster.client)
    with pytest.raises(st.Unbounded, match="unbounded towards"):
        st.distributed.mesh(st.infinite_cylinder(1), cells=20, client=cluster.client)


@pytest.mark.skipif(RAY in os.environ, reason="it would ask itself")
def test_so_it_is_on_ray(tmp_path: pathlib.Path) -> None:
    """In a process of its own: where Ray's core takes too long to shut down on a busy machine,
    Ray ends the process that asked for it, without a word."""
    command = [sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", "ray_cluster"]
    child = subprocess.run(
        [*command, f"--basetemp={tmp_path / 'ray'}", __file__],
        env={**os.environ, RAY: "1"},
        capture_output=True,
        text=True,
        timeout=600,
    )
    outcomes = re.findall("PASSED|FAILED|ERROR|SKIPPED", child.stdout)
    assert outcomes == ["PASSED"] * 4, child.stdout + child.stderr


def test_wrong_options_are_told_at_once() -> None:
    cube = st.cube(1)
    wrong: list[tuple[type[Exception], str, dict[str, Any]]] = [
        (ValueError, "without cells", {}),
        (ValueError, "tolerance", {"cells": 9, "tolerance": 0.1}),
        (ValueError, "draft", {"cells": 9, "draft": True}),
        (ValueError, "feature edges", {"cells": 9, "feature_edges": 30}),
        (ValueError, "shards is 0", {"cells": 9, "shards": 0}),
        (TypeError, "client: int is none", {"cells": 9, "client": 7}),
        (TypeError, "unexpected keyword", {"cells": 9, "size": 7}),
    ]
    for kind, said, options in wrong:
        with pytest.raises(kind, match=said):
            st.distributed.mesh(cube, **options)
    with ThreadPoolExecutor(1) as client:
        faulty: list[tuple[str, Any, dict[str, Any]]] = [
            ("differ in length", {"bore": [1], "bolts": [1, 2]}, {}),
            ("other columns", [{"bore": 1}, {"bolts": 1}], {}),
            ("'volume' is one of those", {"volume": [1]}, {}),
            (r"put \{row\}", {"bore": [1]}, {"write": "a.stl"}),
            (r"\{hole\} is no variable", {"bore": [1]}, {"write": "{hole}.stl"}),
            ("a .csv or a .parquet", {"bore": [1]}, {"out": "a.txt"}),
        ]
        for said, table, options in faulty:
            with pytest.raises(ValueError, match=said):
                st.distributed.sweep(flange, table, client=client, **options)


def test_a_table_of_a_file_and_files_of_variants(tmp_path: pathlib.Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text(f"bore, bolts, note\n0.3, 6, {tmp_path}\n0.25, 8, {tmp_path}\n")
    with ThreadPoolExecutor(2) as client:
        rows = st.distributed.sweep(
            flange,
            table,
            client=client,
            write=[f"{tmp_path}/{{row}}-{{bolts}}.step", f"{tmp_path}/{{row}}.stl"],
            out=tmp_path / "out.csv",
            tolerance=0.01,
        )
    assert [row["bolts"] for row in rows] == [6, 8]
    assert (tmp_path / "1-6.step").exists() and (tmp_path / "2-8.step").exists()
    mesh = st.load_mesh(tmp_path / "2.stl")
    assert mesh.volume == pytest.approx(rows[1]["volume"], rel=0.02)
    with (tmp_path / "out.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert [float(row["volume"]) for row in read] == [row["volume"] for row in rows]


def test_a_shard_that_is_damaged_is_named(tmp_path: pathlib.Path) -> None:
    with ThreadPoolExecutor(2) as client:
        st.distributed.mesh(
            scenes.drilled(), cells=20, client=client, shards=2, folder=tmp_path
        )
    paths = sorted(tmp_path.glob("*.shard"))
    paths[1].write_bytes(paths[1].read_bytes()[:-1])
    from stereotomy._stereotomy import _merge

    with pytest.raises(st.FileError, match="part-2-of-2.shard: it was cut off"):
        _merge(paths, None, False, False, None)
