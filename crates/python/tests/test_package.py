"""What the package is as a whole: documentation, types, import, the notebook."""

import doctest
import inspect
import pathlib
import subprocess
import sys
from typing import Any

import nbclient
import nbformat
import pytest

import stereotomy as st

PACKAGE = pathlib.Path(__file__).parents[1]


def documented() -> dict[str, str]:
    """The docstrings of all that is public, by name."""
    found = {"stereotomy": st.__doc__ or ""}
    for name in st.__all__:
        thing = getattr(st, name)
        if not isinstance(thing, str):
            found[name] = inspect.getdoc(thing) or ""
        if inspect.isclass(thing):
            for key, member in vars(thing).items():
                if not key.startswith("_"):
                    found[f"{name}.{key}"] = inspect.getdoc(member) or ""
    for name in st.distributed.__all__:
        found[f"distributed.{name}"] = inspect.getdoc(getattr(st.distributed, name)) or ""
    return found


def test_all_that_is_public_is_documented() -> None:
    assert [name for name, text in documented().items() if not text] == []


EXAMPLES = {name: text for name, text in documented().items() if ">>>" in text}


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run(name: str) -> None:
    test = doctest.DocTestParser().get_doctest(EXAMPLES[name], {}, name, None, None)
    runner = doctest.DocTestRunner()
    said: list[str] = []
    runner.run(test, out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)


def test_there_are_examples() -> None:
    # Of most functions; what is left out has one beside it.
    assert len(EXAMPLES) > 90


def test_readme_runs(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for page in (PACKAGE / "README.md", PACKAGE.parents[1] / "README.md"):
        blocks = page.read_text(encoding="utf-8").split("```python\n")[1:]
        assert blocks, page
        names: dict[str, Any] = {}
        for block in blocks:
            exec(block.split("```")[0], names)


def test_types_are_strict_and_true() -> None:
    for arguments in (
        ["mypy", "--strict", str(PACKAGE / "python" / "stereotomy"), str(PACKAGE / "tests")],
        # The stubs say what is there, with the same signatures.
        ["mypy.stubtest", "stereotomy"],
        ["pyright", "--pythonpath", sys.executable],
    ):
        done = subprocess.run(
            [sys.executable, "-m", *arguments], capture_output=True, text=True, cwd=PACKAGE
        )
        assert done.returncode == 0, done.stdout + done.stderr


def test_import_takes_nothing_along() -> None:
    code = "import sys, stereotomy; print(sorted({'numpy', 'trimesh', 'pyvista', 'manifold3d'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_libraries_that_are_missing_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = st.cube(1).mesh()
    for module, convert in {
        "trimesh": mesh.to_trimesh,
        "manifold3d": mesh.to_manifold,
        "pyvista": mesh.to_pyvista,
    }.items():
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ModuleNotFoundError, match=f"pip install {module}"):
            convert()


def test_pyvista_has_the_same_mesh() -> None:
    mesh = (st.cube(2) - st.sphere(1.2)).mesh()
    theirs = mesh.to_pyvista()
    assert theirs.n_points == len(mesh.vertices) and theirs.n_cells == len(mesh.triangles)
    assert theirs.volume == pytest.approx(mesh.volume, rel=1e-9)
    assert theirs.is_manifold
    assert theirs.cell_data["surface"].tolist() == mesh.triangle_surfaces.tolist()


def test_colours_and_surfaces_reach_trimesh() -> None:
    solid = st.cube(2).colored("#ff0000") - st.sphere(1.2)
    mesh = solid.mesh()
    theirs = mesh.to_trimesh()
    assert theirs.face_attributes["surface"].tolist() == mesh.triangle_surfaces.tolist()
    reds = [surface.color is not None for surface in mesh.surfaces]
    for surface, color in zip(mesh.triangle_surfaces, theirs.visual.face_colors, strict=True):
        assert (color.tolist() == [255, 0, 0, 255]) == reds[surface]


def test_the_notebook_runs() -> None:
    notebook = nbformat.read(  # type: ignore[no-untyped-call]
        PACKAGE / "tour.ipynb", as_version=4
    )
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) == 10
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    shown = {kind for cell in code for out in cell.outputs for kind in out.get("data", {})}
    assert {"image/png", "image/svg+xml", "text/html", "text/plain"} <= shown
