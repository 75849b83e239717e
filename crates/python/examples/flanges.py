"""A table of 10,000 flanges, measured by workers: `python flanges.py [here|dask|ray] [ROWS_AT_ONCE]`.

Writes `flanges.csv` into the folder that one is in, and says how long it took.
"""

import contextlib
import resource
import sys
import time
from collections.abc import Iterator
from typing import Any

import stereotomy as st


def flange(bore: float, bolt: float, hub: float) -> st.Solid:
    bolts = st.infinite_cylinder(bolt).translate([0.75, 0, 0]).polar_pattern(8)
    keyway = st.cuboid_between([-0.06, 0, -1], [0.06, 0.38, 1])
    body = st.cylinder(1, z=0.2) | st.cylinder(0.45, z=hub)
    return body - st.infinite_cylinder(bore) - bolts - keyway


def table() -> dict[str, list[float]]:
    """Every bore with every bolt hole and every height of the hub."""
    sizes = [(i, j, k) for i in range(25) for j in range(20) for k in range(20)]
    return {
        "bore": [round(0.2 + 0.006 * i, 6) for i, _, _ in sizes],
        "bolt": [round(0.04 + 0.004 * j, 6) for _, j, _ in sizes],
        "hub": [round(0.3 + 0.03 * k, 6) for _, _, k in sizes],
    }


@contextlib.contextmanager
def workers(engine: str) -> Iterator[Any]:
    """A client of two workers on this machine."""
    if engine == "dask":
        import distributed

        with distributed.LocalCluster(n_workers=2, threads_per_worker=1) as cluster:
            with distributed.Client(cluster) as client:
                yield client
    elif engine == "ray":
        import ray

        ray.init(num_cpus=2, include_dashboard=False)
        yield ray
        ray.shutdown()
    else:
        yield None


if __name__ == "__main__":
    engine = sys.argv[1] if len(sys.argv) > 1 else "here"
    rows_at_once = int(sys.argv[2]) if len(sys.argv) > 2 else None
    with workers(engine) as client:
        start = time.perf_counter()
        rows = st.distributed.sweep(
            flange, table(), client=client, out="flanges.csv", rows_at_once=rows_at_once
        )
        wall = time.perf_counter() - start
    # (Of the workers, too, once they have ended.)
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    user, system = (sum(getattr(one, name) for one in used) for name in ("ru_utime", "ru_stime"))
    wrong = sum(1 for row in rows if row["error"])
    print(f"{engine}: {len(rows)} rows, {wrong} with an error, {wall:.1f} s, processor {user:.1f} + {system:.1f} s")
