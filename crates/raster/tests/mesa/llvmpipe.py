"""Draws a job with Mesa's software rasteriser, for comparison.

llvmpipe.py FOLDER [FRAMES]

FOLDER holds job.json and the little-endian arrays vertices.bin (position and
normal, six 32-bit floats a vertex) and indices.bin (32-bit). Writes color.bin
(RGBA, 8 bits, the top row first) and depth.bin (32-bit floats), and prints as
JSON the renderer's name and, with FRAMES, the time of each frame in seconds,
from clearing to having finished, and the processor time of all of them.
"""

import json
import os
import resource
import sys
import time

os.environ.setdefault("EGL_PLATFORM", "surfaceless")
os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
os.environ.setdefault("GALLIUM_DRIVER", "llvmpipe")

import moderngl
import numpy

VERTEX = """
#version 330
uniform mat4 world_to_clip;
in vec3 position;
in vec3 normal;
out vec3 point;
out vec3 direction;
void main() {
    gl_Position = world_to_clip * vec4(position, 1.0);
    point = position;
    direction = normal;
}
"""

# The Phong reflection model in linear light, encoded as sRGB.
FRAGMENT = """
#version 330
uniform vec4 viewer;
uniform vec3 towards;
uniform float ambient;
uniform float intensity;
uniform vec3 diffuse;
uniform vec3 specular;
uniform float shininess;
in vec3 point;
in vec3 direction;
out vec4 color;
void main() {
    vec3 n = normalize(direction);
    vec3 v = normalize(viewer.xyz - point * viewer.w);
    float n_l = dot(n, towards);
    vec3 light = diffuse * ambient;
    if (n_l > 0.0) {
        vec3 r = 2.0 * n_l * n - towards;
        light += intensity * (diffuse * n_l + specular * pow(max(dot(r, v), 0.0), shininess));
    }
    light = clamp(light, 0.0, 1.0);
    vec3 curve = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    color = vec4(mix(curve, 12.92 * light, lessThanEqual(light, vec3(0.0031308))), 1.0);
}
"""


def main():
    folder = sys.argv[1]
    frames = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with open(os.path.join(folder, "job.json")) as file:
        job = json.load(file)
    context = moderngl.create_context(
        standalone=True, backend="egl", libgl="libGL.so.1", libegl="libEGL.so.1"
    )
    program = context.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
    for name in ("viewer", "towards", "diffuse", "specular"):
        program[name].value = tuple(job[name])
    for name in ("ambient", "intensity", "shininess"):
        program[name].value = job[name]
    matrix = numpy.array(job["world_to_clip"], dtype="f4")
    program["world_to_clip"].write(matrix.tobytes())
    with open(os.path.join(folder, "vertices.bin"), "rb") as file:
        vertices = context.buffer(file.read())
    with open(os.path.join(folder, "indices.bin"), "rb") as file:
        indices = context.buffer(file.read())
    mesh = context.vertex_array(
        program, [(vertices, "3f 3f", "position", "normal")], indices, index_element_size=4
    )
    size = (job["width"], job["height"])
    plain = context.framebuffer([context.texture(size, 4)], context.depth_texture(size))
    target = plain
    if job.get("samples", 0):
        target = context.framebuffer(
            [context.renderbuffer(size, 4, samples=job["samples"])],
            context.depth_renderbuffer(size, samples=job["samples"]),
        )
    context.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)

    def draw():
        target.use()
        target.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)
        mesh.render(moderngl.TRIANGLES)
        if target is not plain:
            context.copy_framebuffer(plain, target)
        context.finish()

    draw()
    times = []
    before = resource.getrusage(resource.RUSAGE_SELF)
    for _ in range(frames):
        start = time.perf_counter()
        draw()
        times.append(time.perf_counter() - start)
    after = resource.getrusage(resource.RUSAGE_SELF)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    color = numpy.frombuffer(plain.color_attachments[0].read(), dtype="u1")
    color.reshape(size[1], size[0], 4)[::-1].tofile(os.path.join(folder, "color.bin"))
    if target is plain:
        depth = numpy.frombuffer(plain.depth_attachment.read(), dtype="f4")
        depth.reshape(size[1], size[0])[::-1].tofile(os.path.join(folder, "depth.bin"))
    print(json.dumps({"renderer": context.info["GL_RENDERER"], "times": times, "cpu": cpu}))


main()
