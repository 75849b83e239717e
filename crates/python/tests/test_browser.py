"""The view that turns in a real browser.

Switched on by STEREOTOMY_CHROMIUM, the name of the program (Debian: chromium); off, the
tests say so and do nothing.
"""

import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
import scenes
from numpy.typing import NDArray

import stereotomy as st

# Presses keys, and tells which pixels of the canvas are drawn then. All at once, so that
# nothing depends on when the browser draws its frames.
PRESS = """<script>
window.requestAnimationFrame = (draw) => draw();
const canvas = document.querySelector("canvas");
for (const key of KEYS) canvas.dispatchEvent(new KeyboardEvent("keydown", { key }));
const gl = canvas.getContext("webgl"), { width, height } = canvas;
const pixels = new Uint8Array(4 * width * height);
gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
const drawn = Array.from({ length: width * height }, (_, k) => (pixels[4 * k + 3] ? 1 : 0));
const image = document.querySelector("img").style.visibility;
document.body.innerHTML = `drawn ${drawn.join("")} image ${image} error ${gl.getError()}`;
</script>"""


def drawn(view: st.View, folder: pathlib.Path, keys: list[str]) -> NDArray[np.bool_]:
    """Whether each pixel is drawn after these keys, the top row first."""
    page = folder / "view.html"
    view.save(page)
    press = PRESS.replace("KEYS", str(keys))
    page.write_text(page.read_text().replace("</body>", press + "</body>"))
    done = subprocess.run(
        [
            os.environ["STEREOTOMY_CHROMIUM"],
            "--headless",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            f"--user-data-dir={folder / 'profile'}",
            "--dump-dom",
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    found = re.search(r"drawn ([01]+) image hidden error 0", done.stdout)
    assert found, done.stdout[-2000:] + done.stderr[-2000:]
    letters = np.frombuffer(found[1].encode(), dtype="uint8").reshape(240, 320)
    shown: NDArray[np.bool_] = letters[::-1] == ord("1")
    return shown


def test_the_view_turns(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    if "STEREOTOMY_CHROMIUM" not in os.environ:
        with capsys.disabled():
            print("STEREOTOMY_CHROMIUM is not set: the view is not tried in a browser")
        return
    flange = scenes.flange()
    view = flange.view(size=(320, 240))
    # It begins where the picture is, but for the picture's shadow.
    picture = flange.render(size=(320, 240)).pixels[..., 3] == 255
    first = drawn(view, tmp_path, ["Home"])
    assert (first != picture).mean() < 0.01
    assert 0.2 < first.mean() < 0.9
    # A key turns it, and the opposite one turns it back.
    turned = drawn(view, tmp_path, ["ArrowUp", "ArrowUp", "ArrowUp"])
    assert (turned != first).mean() > 0.05
    back = drawn(view, tmp_path, ["ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight"])
    assert (back != first).mean() < 0.001
    near = drawn(view, tmp_path, ["-", "-", "-"])
    # Three steps of 1.1 back: about 1.1 to the sixth less.
    assert near.sum() == pytest.approx(first.sum() / 1.1**6, rel=0.1)
