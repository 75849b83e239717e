"""Work for more than one process or machine: one huge mesh in shards, and tables of variants.

Whoever has a cluster gives its client: the module `ray` after `ray.init()`, or a
`dask.distributed.Client`; without one, processes of this machine do the work. A worker that
dies is replaced by the engine, and what it did is done again. The result is the same, to the
byte, for any number of workers and shards.

    import stereotomy as st
    from dask.distributed import Client

    with Client("scheduler:8786") as client:
        st.distributed.mesh(solid, cells=4096, client=client, out="huge.ply")

Ctrl-C stops the work, and so does an exception of `progress`: what no worker has begun is
cancelled, and files are whole or not there. Processes of this machine and Ray's workers stop
what they are doing; a worker of Dask or of an executor finishes its part first, which nobody
waits for but the executor's own end.

The package must be installed where the workers are, in the same version. Processes of this
machine start a script anew, as `multiprocessing` does: what a script does by itself belongs
below `if __name__ == "__main__":`.
"""

from __future__ import annotations

import contextlib
import os
import pickle
from collections.abc import Callable, Iterable, Mapping, Sequence

from . import _engines
from ._stereotomy import Solid, _check_name, _merge, _shard, _write_file
from ._stereotomy import empty as _empty

# Type checkers know the names; `typing` itself would be most of the time that an import takes.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeAlias, Unpack

    from ._stereotomy import Mesh, _MeshOptions

    _Table: TypeAlias = (
        Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]] | str | os.PathLike[str]
    )

__all__ = ["mesh", "sweep"]

# Parts of the work for each worker: some are done sooner than others.
_PARTS = 4
# The most threads of a worker.
_THREADS = 1024
# The share of the work that is done when all shards are there.
_MADE = 0.9


def mesh(
    solid: Solid,
    *,
    client: object = None,
    shards: int | None = None,
    out: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    threads: int = 1,
    **options: Unpack[_MeshOptions],
) -> Mesh | None:
    """The mesh that `solid.mesh(cells=...)` makes, made in shards by workers: slabs of the
    lattice, none of which needs anything of another one.

    With `out` it is written to that file and not given back: .ply and .stl come piece by
    piece, with a shard at a time in memory; the bytes are those of `solid.save(out, ...)`.
    `shards` says in how many parts the work is done (some for each worker, unless it is said),
    and `threads` how many each worker uses. With `folder`, one that all workers share, they
    put their shards there, and the engine need not carry them; the shards stay.

    Of the options of `mesh` there must be `cells` or `cell_size`; `tolerance`, `draft`,
    `feature_edges` and `partial` are not for shards. With `check` a mesh that is given back is
    checked. `progress` is called with the share that is done: nine tenths for the shards, and
    the rest for putting them together. A GLB file of more than 1,048,576 triangles is one of
    chunks, and of more than 64 of these several files (`a.glb`, `a-2.glb`, …).

    >>> import stereotomy as st
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> solid = st.cube(2) - st.sphere(1.2)
    >>> with ThreadPoolExecutor(2) as client:
    ...     mesh = st.distributed.mesh(solid, cells=40, client=client, shards=5)
    >>> mesh.triangles.tolist() == solid.mesh(cells=40).triangles.tolist()
    True
    """
    import tempfile

    if not isinstance(solid, Solid):
        raise TypeError(f"mesh: solid is a {type(solid).__name__}: give a Solid")
    _check_count("mesh: shards", shards, 2**32 - 1)
    _check_count("mesh: threads", threads, _THREADS)
    if out is not None:
        _check_name(out, False)
        _check_folder("mesh: out", out, os.path.dirname(out))
    if folder is not None:
        _check_folder("mesh: folder", folder, folder)
    given: dict[str, Any] = dict(options)
    progress = given.pop("progress", None)
    normals, check = given.pop("normals", True), given.pop("check", True)
    # What is wrong with the options is told here, of nothing.
    _shard(_empty(), (0, 1), None, 1, given)
    engine = _engines.engine(client)
    count = shards or _PARTS * engine.workers
    with tempfile.TemporaryDirectory(prefix="stereotomy-") as own:
        place = os.fspath(own if folder is None else folder)
        paths = [os.path.join(place, f"part-{part + 1}-of-{count}.shard") for part in range(count)]
        items = [
            ((part, count), None if folder is None else path, threads, given)
            for part, path in enumerate(paths)
        ]
        with contextlib.closing(engine.run(_shard, pickle.dumps(solid), items)) as results:
            for done, (part, data) in enumerate(results, 1):
                if data is not None:
                    with open(paths[part], "wb") as file:
                        file.write(data)
                if progress is not None:
                    progress(_MADE * done / count)

        def merged(share: float) -> None:
            if progress is not None:
                progress(_MADE + (1 - _MADE) * share)

        return _merge(paths, out, normals, check, merged)


def _check_count(name: str, value: object, most: int) -> None:
    if value is not None and not (isinstance(value, int) and 1 <= value <= most):
        raise ValueError(f"{name} is {value!r}: give a whole number from 1 to {most}")


def _check_folder(name: str, path: object, folder: str | os.PathLike[str]) -> None:
    if not os.path.isdir(folder or "."):
        raise FileNotFoundError(f"{name} is {str(path)!r}: there is no folder {str(folder)!r}")


_MEASURES = (
    "volume", "volume_error", "area", "centroid_x", "centroid_y", "centroid_z",
)  # fmt: skip


def sweep(
    model: Callable[..., Solid],
    table: _Table,
    *,
    client: object = None,
    out: str | os.PathLike[str] | None = None,
    write: str | Sequence[str] = (),
    rows_at_once: int | None = None,
    **options: Unpack[_MeshOptions],
) -> list[dict[str, Any]]:
    """A row of measures of each variant of a model: `model(**row)` is the solid of a row of the
    table, which is a mapping of columns, rows as mappings, or the name of a .csv file (whose
    numbers become numbers).

    The rows come back in order, each with its number from 1 as `row`, its variables, `volume`,
    `volume_error`, `area` and the centroid, `files`, and in `error` what went wrong, if
    anything did: then the measures are None, and the other rows go on. With `write`, a name or
    several such as `"part-{row}.step"` in which a variable's name in braces stands for its
    value, each variant is saved there, too, with the options of `mesh`, where its worker is.
    `out` names a .csv or (with pyarrow) .parquet file for the table.

    The model goes to the workers as a pickle: for processes of this machine it must be a
    function of a module. `rows_at_once` says how many rows a worker takes at a time, and
    `progress` is called with the share that is done.

    >>> import stereotomy as st
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> def washer(bore):
    ...     return st.cylinder(1, z=0.1) - st.infinite_cylinder(bore)
    >>> with ThreadPoolExecutor(2) as client:
    ...     rows = st.distributed.sweep(washer, {"bore": [0.3, 0.5, -1]}, client=client)
    >>> [round(row["volume"], 6) for row in rows[:2]]
    [0.285885, 0.235619]
    >>> rows[2]["error"]
    'ValueError: infinite_cylinder(radius=-1.0): a radius is -1: it must be positive and finite'
    """
    if not callable(model):
        raise TypeError(f"sweep: model is a {type(model).__name__}: give a function")
    given: dict[str, Any] = dict(options)
    progress = given.pop("progress", None)
    # What is wrong with the options is told here, of nothing.
    _empty().mesh(**given)
    rows = _rows(table)
    _check_count("sweep: rows_at_once", rows_at_once, 2**32 - 1)
    names = (write,) if isinstance(write, str) else tuple(write)
    _check_files(names, rows)
    taken = sorted({"row", "files", "error", *_MEASURES} & set(rows[0] if rows else ()))
    if taken:
        raise ValueError(
            f"sweep: the table's column {taken[0]!r} is one of those that are written: "
            "give it another name"
        )
    if out is not None:
        _check_table(out, rows)
    engine = _engines.engine(client)
    some = rows_at_once or max(1, min(256, -(-len(rows) // (_PARTS * engine.workers))))
    items = [(first + 1, rows[first : first + some]) for first in range(0, len(rows), some)]
    made: dict[int, list[dict[str, Any]]] = {}
    shared = _pickled((model, names, given), client)
    with contextlib.closing(engine.run(_measure_rows, shared, items)) as results:
        for at, chunk in results:
            made[at] = chunk
            if progress is not None:
                progress(len(made) / len(items))
    result = [row for at in range(len(items)) for row in made[at]]
    if out is not None:
        is_parquet = os.fspath(out).lower().endswith(".parquet")
        _write_file(out, _parquet(result) if is_parquet else _csv(result))
    return result


def _pickled(shared: object, client: object) -> bytes:
    """With a cluster functions of a script or a notebook can be pickled, too."""
    try:
        if client is not None:
            import importlib

            pickler = importlib.import_module("cloudpickle")
            data: bytes = pickler.dumps(shared)
            return data
    except ModuleNotFoundError:
        pass
    try:
        return pickle.dumps(shared)
    except Exception as error:
        raise TypeError(
            f"sweep: the model cannot be pickled for the workers ({error}): "
            "give a function of a module"
        ) from error


def _rows(table: _Table) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]]
    if isinstance(table, Mapping):
        for name, column in table.items():
            if isinstance(column, str) or not isinstance(column, Iterable):
                raise TypeError(
                    f"sweep: the table's column {name!r} is a {type(column).__name__}: give a list"
                )
        columns: dict[str, list[Any]] = {str(name): list(column) for name, column in table.items()}
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"sweep: the table's columns differ in length: {lengths}")
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    elif isinstance(table, (str, os.PathLike)):
        rows = _read(table)
    elif isinstance(table, Iterable):
        rows = []
        for number, row in enumerate(table, 1):
            if not isinstance(row, Mapping):
                raise TypeError(
                    f"sweep: row {number} of the table is a {type(row).__name__}: give a mapping"
                )
            rows.append(dict(row))
    else:
        raise TypeError(
            f"sweep: table is a {type(table).__name__}: give a mapping of columns, rows as "
            "mappings, or the name of a .csv file"
        )
    for number, row in enumerate(rows, 1):
        if set(row) != set(rows[0]):
            raise ValueError(f"sweep: row {number} of the table has other columns than row 1")
    # Plain numbers, however they came.
    return [
        {name: getattr(value, "item", lambda value=value: value)() for name, value in row.items()}
        for row in rows
    ]


def _value(text: str) -> int | float | str:
    for kind in (int, float):
        try:
            return kind(text)
        except (TypeError, ValueError):
            pass
    return text


def _read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """The rows of a .csv file, as `csg sweep` reads them."""
    import csv

    with open(path, newline="", encoding="utf-8-sig") as file:
        lines = csv.reader(line for line in file if not line.startswith("#"))
        cells = [[cell.strip() for cell in line] for line in lines if line]
    names, values = (cells[0], cells[1:]) if cells else ([], [])
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"sweep: {os.fspath(path)}: two columns are called {name!r}")
    for number, row in enumerate(values, 1):
        if len(row) != len(names):
            raise ValueError(
                f"sweep: {os.fspath(path)}: row {number} has {len(row)} values, "
                f"and there are {len(names)} columns"
            )
    return [dict(zip(names, map(_value, row), strict=True)) for row in values]


def _check_files(names: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Refuses names of files that cannot be, or are the same for several rows."""
    import string

    known = {"row", *(rows[0] if rows else ())}
    for name in names:
        try:
            parts = list(string.Formatter().parse(name))
        except ValueError as error:
            raise ValueError(f"sweep: write is {name!r}: {error}") from None
        fields = {field for _, field, _, _ in parts if field is not None}
        if any(spec or conversion for _, _, spec, conversion in parts):
            raise ValueError(f"sweep: write is {name!r}: only names of variables go into braces")
        if not fields:
            raise ValueError(
                f"sweep: all variants would have one file {name!r}: put {{row}} into it"
            )
        if fields - known:
            raise ValueError(
                f"sweep: {{{min(fields - known)}}} is no variable of the table: it has "
                + ", ".join(sorted(known))
            )
        _check_name(name, True)
    of: dict[str, int] = {}
    for number, row in enumerate(rows, 1):
        for file in _files(names, number, row):
            if file in of:
                raise ValueError(
                    f"sweep: rows {of[file]} and {number} would have one file {file!r}: "
                    "put {row} into its name"
                )
            of[file] = number


def _files(names: Sequence[str], number: int, row: dict[str, Any]) -> list[str]:
    """The files of a row. A value must not name another folder."""
    safe = {}
    for name, value in row.items():
        text = str(value).replace("/", "_").replace("\\", "_")
        safe[name] = text if text.strip(".") else "_" * len(text)
    return [name.format(**safe, row=number) for name in names]


def _measure_rows(
    shared: tuple[Callable[..., Solid], Sequence[str], dict[str, Any]],
    first: int,
    rows: list[dict[str, Any]],
) -> list[dict[str, Any]]:
    model, names, options = shared
    return [
        _measured(model, names, options, number, row) for number, row in enumerate(rows, first)
    ]


def _measured(
    model: Callable[..., Solid],
    names: Sequence[str],
    options: dict[str, Any],
    number: int,
    row: dict[str, Any],
) -> dict[str, Any]:
    made: dict[str, Any] = {"row": number, **row}
    made |= dict.fromkeys(_MEASURES) | {"files": "", "error": ""}
    try:
        solid = model(**row)
        if not isinstance(solid, Solid):
            raise TypeError(f"the model gave a {type(solid).__name__}, not a Solid")
        measure = solid.measure()
        numbers = (measure.volume, measure.volume_error, measure.area, *(measure.centroid or ()))
        files = _files(names, number, row)
        for file in files:
            # What is not meshed takes none of them, but for a STEP file's unit.
            ending = os.path.splitext(file)[1].lower()
            fitting = {".csg": set[str](), ".step": {"unit"}, ".stp": {"unit"}}.get(ending, set(options))
            solid.save(file, **{name: options[name] for name in fitting & set(options)})
        made |= dict(zip(_MEASURES, numbers))
        made["files"] = " ".join(files)
    except Exception as error:
        made["error"] = f"{type(error).__name__}: {error}"
    return made


def _check_table(path: str | os.PathLike[str], rows: Sequence[dict[str, Any]]) -> None:
    path = os.fspath(path)
    ending = os.path.splitext(path)[1].lower()
    if ending not in (".csv", ".parquet"):
        raise ValueError(f"sweep: out is {path!r}: give a .csv or a .parquet file")
    _check_folder("sweep: out", path, os.path.dirname(path))
    if ending == ".parquet":
        try:
            _parquet(rows)
        except ModuleNotFoundError:
            raise ModuleNotFoundError(
                "pyarrow is not installed: pip install pyarrow, or give a .csv file",
                name="pyarrow",
            ) from None
        except (TypeError, ValueError) as error:
            raise ValueError(f"sweep: the table cannot be a .parquet file: {error}") from None


def _parquet(rows: Sequence[dict[str, Any]]) -> bytes:
    import importlib
    import io

    pyarrow = importlib.import_module("pyarrow")
    parquet = importlib.import_module("pyarrow.parquet")
    data = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_pylist(list(rows)), data)
    return data.getvalue()


def _csv(rows: Sequence[dict[str, Any]]) -> bytes:
    import csv
    import io

    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else ["row"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()
