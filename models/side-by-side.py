"""Six models as five programs draw them without further options, side by side.

    pip install f3d pyvista pillow; apt-get install blender openscad xvfb
    xvfb-run -a python models/side-by-side.py target/release/csg models/side-by-side.png

Each program is given the same GLB file and the same direction of view, and frames
the model as it does by itself. OpenSCAD reads no GLB: it gets the same mesh as STL.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import f3d
import pyvista
from PIL import Image, ImageDraw, ImageFont

MODELS = ["flange", "drilled", "tricylinder", "menger-2", "sphere", "rotated-box"]
SIZE = (600, 450)
# From where the model is seen, Z upwards; in glTF's axes, Y upwards.
FROM = (1.0, -1.0, 1.0)
FROM_Y_UP = (FROM[0], FROM[2], -FROM[1])


def ours(csg, glb, png):
    size = f"{SIZE[0]}x{SIZE[1]}"
    subprocess.run([csg, "render", glb, "-o", png, "--size", size], check=True)


def with_pyvista(glb, png):
    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    mesh = pyvista.read(glb).combine().extract_surface(algorithm="dataset_surface")
    plotter.add_mesh(mesh, smooth_shading=True, split_sharp_edges=True)
    plotter.view_vector(FROM_Y_UP, viewup=(0, 1, 0))
    plotter.screenshot(png, transparent_background=True)


def with_f3d(glb, png):
    engine = f3d.Engine.create(offscreen=True)
    engine.window.size = SIZE
    engine.scene.add(glb)
    camera = engine.window.camera
    camera.focal_point, camera.position = (0, 0, 0), FROM_Y_UP
    camera.view_up = (0, 1, 0)
    camera.reset_to_bounds()
    engine.window.render_to_image(no_background=True).save(png)


BLENDER = """
import bpy, json, sys
import numpy
numpy.bool = bool  # which Blender's reader of glTF still asks numpy for
from mathutils import Vector
glb, png, width, height, side = json.loads(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=glb)
scene = bpy.context.scene
scene.render.engine = "BLENDER_WORKBENCH"
scene.render.film_transparent = True
scene.render.resolution_x, scene.render.resolution_y = width, height
scene.render.filepath = png
scene.world = bpy.data.worlds.new("world")
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera
towards = -Vector(side)
camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
corners = [
    part.matrix_world @ Vector(corner)
    for part in scene.objects if part.type == "MESH"
    for corner in part.bound_box
]
bpy.context.view_layer.update()
flat = [value for corner in corners for value in corner]
graph = bpy.context.evaluated_depsgraph_get()
camera.location, _ = camera.camera_fit_coords(graph, flat)
# (glTF is in metres, and parts may be millimetres small or large.)
camera.data.clip_start = (camera.location - corners[0]).length * 1e-2
camera.data.clip_end = (camera.location - corners[0]).length * 1e2
bpy.ops.render.render(write_still=True)
"""


def with_blender(glb, png):
    arguments = json.dumps([glb, png, *SIZE, FROM])
    command = ["blender", "-b", "--factory-startup", "--python-exit-code", "1"]
    with tempfile.NamedTemporaryFile("w", suffix=".py") as script:
        script.write(BLENDER)
        script.flush()
        command += ["--python", script.name, "--", arguments]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def with_openscad(csg, glb, png):
    stl = pathlib.Path(glb).with_suffix(".stl")
    subprocess.run([csg, "mesh", glb, "-o", stl], check=True)
    scad = stl.with_suffix(".scad")
    scad.write_text(f'import("{stl}");\n')
    eye = ",".join(str(100 * v) for v in FROM)
    command = ["openscad", "-o", png, f"--imgsize={SIZE[0]},{SIZE[1]}"]
    command += [f"--camera={eye},0,0,0", "--viewall", "--autocenter", "--render=true"]
    subprocess.run(command + [str(scad)], check=True, stderr=subprocess.DEVNULL)


def main():
    csg, output = sys.argv[1:]
    folder = pathlib.Path(__file__).parent
    cell = (300, 225)
    rows = ["this program", "pyvista", "f3d", "Blender's workbench", "OpenSCAD"]
    sheet = Image.new("RGB", (cell[0] * len(MODELS), (cell[1] + 20) * len(rows)), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(15)
    with tempfile.TemporaryDirectory() as made:
        for column, model in enumerate(MODELS):
            glb = f"{made}/{model}.glb"
            subprocess.run([csg, "mesh", folder / f"{model}.csg", "-o", glb], check=True)
            pictures = [f"{made}/{model}-{row}.png" for row in range(len(rows))]
            ours(csg, glb, pictures[0])
            with_pyvista(glb, pictures[1])
            with_f3d(glb, pictures[2])
            with_blender(glb, pictures[3])
            with_openscad(csg, glb, pictures[4])
            for row, picture in enumerate(pictures):
                image = Image.open(picture).convert("RGBA").resize(cell, Image.LANCZOS)
                at = (column * cell[0], row * (cell[1] + 20) + 20)
                sheet.paste(image, at, image)
    for row, name in enumerate(rows):
        draw.text((8, row * (cell[1] + 20) + 3), name, fill="black", font=font)
    sheet.save(output)


main()
