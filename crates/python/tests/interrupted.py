"""A program that tests stop: minutes of work by the engine that is named first, a mesh or a table of
variants (one of which does not stop by itself, if it is called so) as named second, in the folder that
is named third. It says "begun" once some of the work
is done or under way, and how it ended."""

import contextlib
import os
import pathlib
import signal
import sys
import time

import scenes
from test_distributed import Cluster, dask_cluster, here, ray_cluster

import stereotomy as st

CLUSTERS = {"here": here, "dask": dask_cluster, "ray": ray_cluster}


def minutes_of_work(begun: str) -> st.Solid:
    pathlib.Path(begun).touch()
    return scenes.cheese(10_000)


def stubborn(begun: str) -> st.Solid:
    """Does not stop, in the middle of a file."""
    path = pathlib.Path(begun)
    while True:
        # (Stopped just while it opens the file it opens it again, and so has it to be put away.)
        with (
            contextlib.suppress(BaseException),
            path.with_name(f".unfinished-{path.name}").open("w"),
        ):
            path.touch()
            while True:
                with contextlib.suppress(BaseException):
                    time.sleep(60)


def do(work: str, cluster: Cluster, folder: pathlib.Path) -> None:
    if work == "mesh":
        st.distributed.mesh(
            scenes.cheese(1000),
            cells=3000,
            shards=2000,
            client=cluster.client,
            out=folder / "all.ply",
            folder=folder,
            # (Ctrl-C may come between the parts of what is printed.)
            progress=lambda share: os.write(1, b"begun\n"),
        )
    else:
        table = {"begun": [str(folder / f"begun-{row}") for row in range(1, 9)]}
        st.distributed.sweep(
            stubborn if work == "stubborn" else minutes_of_work,
            table,
            client=cluster.client,
            rows_at_once=1,
            out=folder / "all.csv",
            write=str(folder / "{row}.stl"),
            tolerance=1e-6,
        )


if __name__ == "__main__":
    # Whoever runs the tests may ignore Ctrl-C, as shells let programs in the background do.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    engine, work, folder = sys.argv[1:]
    with CLUSTERS[engine]() as cluster:
        try:
            do(work, cluster, pathlib.Path(folder))
            print("finished", flush=True)
        except KeyboardInterrupt:
            print("stopped", flush=True)
        if engine == "here":
            print(len(cluster.processes()), "processes left")
