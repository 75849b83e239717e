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
        if RAY in os.environ and not request.session.testsfailed:
            # Ray's processes end with the one that asked for them; an orderly end takes over a
            # minute on a busy machine, and is not what is tested.
            os._exit(0)


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
    # Where tasks were cancelled as they ended, Ray ended this process, after twelve such errors.
    for _ in range(40 if RAY in os.environ else 1):
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
        (ValueError, "threads is 100000: give a whole number from 1 to 1024", {"cells": 9, "threads": 100_000}),
        (st.FileError, "no mesh format has this extension", {"cells": 9, "out": "a.xyz"}),
        (FileNotFoundError, "out is 'nowhere/a.ply': there is no folder 'nowhere'", {"cells": 9, "out": "nowhere/a.ply"}),
        (FileNotFoundError, "folder is 'nowhere'", {"cells": 9, "folder": "nowhere"}),
        (TypeError, "client: int is none", {"cells": 9, "client": 7}),
        (TypeError, "unexpected keyword", {"cells": 9, "size": 7}),
    ]
    for kind, said, options in wrong:
        with pytest.raises(kind, match=said):
            st.distributed.mesh(cube, **options)
    bore = {"bore": [1]}
    with ThreadPoolExecutor(1) as client:
        faulty: list[tuple[type[Exception], str, Any, dict[str, Any]]] = [
            (ValueError, "differ in length", {"bore": [1], "bolts": [1, 2]}, {}),
            (ValueError, "other columns", [{"bore": 1}, {"bolts": 1}], {}),
            (ValueError, "'volume' is one of those", {"volume": [1]}, {}),
            (TypeError, "column 'bore' is a int", {"bore": 5}, {}),
            (TypeError, "row 1 of the table is a int", [5], {}),
            (TypeError, "table is a int", 5, {}),
            (ValueError, r"put \{row\}", bore, {"write": "a.stl"}),
            (ValueError, r"\{hole\} is no variable", bore, {"write": "{hole}.stl"}),
            (ValueError, r"write is 'a-\{row.stl': expected '\}'", bore, {"write": "a-{row.stl"}),
            (ValueError, "only names of variables", bore, {"write": "{bore:.2f}.stl"}),
            (ValueError, "rows 1 and 2 would have one file '3.stl'", {"bore": [3, 3]}, {"write": "{bore}.stl"}),
            (st.FileError, "no mesh format", bore, {"write": "{row}.xyz"}),
            (ValueError, "a .csv or a .parquet", bore, {"out": "a.txt"}),
            (FileNotFoundError, "there is no folder 'nowhere'", bore, {"out": "nowhere/a.csv"}),
            (ValueError, "cannot be a .parquet file", {"bore": [0.1, "wide"]}, {"out": "a.parquet"}),
            (TypeError, "unexpected keyword argument 'size'", bore, {"size": 7}),
            (ValueError, "a tolerance of -1", bore, {"tolerance": -1}),
            (ValueError, "rows_at_once is 'all'", bore, {"rows_at_once": "all"}),
        ]
        for kind, said, table, options in faulty:
            with pytest.raises(kind, match=said):
                st.distributed.sweep(flange, table, client=client, **options)
        with pytest.raises(TypeError, match="model is a str: give a function"):
            st.distributed.sweep("flange", bore, client=client)  # type: ignore[arg-type]


def test_wrong_tables_are_told_at_once(tmp_path: pathlib.Path) -> None:
    table = tmp_path / "table.csv"
    for text, said in {
        "bore,bolts\n0.3\n": "row 1 has 1 values, and there are 2 columns",
        "bore\n0.3\n0.3,4\n": "row 2 has 2 values, and there are 1 columns",
        "bore,bore\n0.3,4\n": "two columns are called 'bore'",
    }.items():
        table.write_text(text)
        with pytest.raises(ValueError, match=said):
            st.distributed.sweep(flange, table)


def test_a_table_is_written_as_parquet(tmp_path: pathlib.Path) -> None:
    parquet: Any = importlib.import_module("pyarrow.parquet")
    variants: dict[str, list[Any]] = {"bore": [0.3, -1.0, 0.25], "bolts": [3, 4, 6], "note": ["a", "b", "c"]}
    written = []
    with ThreadPoolExecutor(2) as client:
        for some in (1, 3):
            out = tmp_path / f"{some}.parquet"
            rows = st.distributed.sweep(
                flange, variants, client=client, out=out, rows_at_once=some
            )
            written.append(out.read_bytes())
            assert parquet.read_table(out).to_pylist() == rows
    assert rows[1]["volume"] is None and rows[2]["volume"] > 0
    assert written[0] == written[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1.parquet", "3.parquet"]


def test_many_workers_may_die_one_after_another(tmp_path: pathlib.Path) -> None:
    notes = [str(tmp_path / str(row)) for row in range(12)]
    bolts = [5 if row % 2 else 4 for row in range(12)]
    table: dict[str, list[Any]] = {"bore": [0.3] * 12, "bolts": bolts, "note": notes}
    rows = st.distributed.sweep(flange, table, rows_at_once=1)
    assert [row["error"] for row in rows] == [""] * 12
    assert len(list(tmp_path.iterdir())) == 6


def test_a_table_of_a_file_and_files_of_variants(tmp_path: pathlib.Path) -> None:
    table = tmp_path / "table.csv"
    # (As a spreadsheet writes it, and with a comment.)
    table.write_text(
        f"\ufeffbore, bolts, note\n# Variants\n0.3, 6, {tmp_path}\n0.25, 8, {tmp_path}\n",
        encoding="utf-8",
    )
    with ThreadPoolExecutor(2) as client:
        rows = st.distributed.sweep(
            flange,
            table,
            client=client,
            write=[
                f"{tmp_path}/{{row}}-{{bolts}}.step",
                f"{tmp_path}/{{row}}.stl",
                f"{tmp_path}/{{note}}-{{row}}.csg",
            ],
            out=tmp_path / "out.csv",
            tolerance=0.01,
            unit="cm",
        )
    assert [row["error"] for row in rows] == ["", ""]
    assert "SI_UNIT(.CENTI.,.METRE.)" in (tmp_path / "1-6.step").read_text()
    assert [row["bolts"] for row in rows] == [6, 8]
    assert (tmp_path / "1-6.step").exists() and (tmp_path / "2-8.step").exists()
    # A value names no other folder.
    assert (tmp_path / f"{str(tmp_path).replace('/', '_')}-1.csg").exists()
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
