# SPDX-License-Identifier: BSD-3-Clause
"""Triangle meshes in PLY files, as viewer_offscreen and lmo write them: binary, colours and labels per vertex."""

import os
from dataclasses import dataclass

import numpy

from covey_tools.errors import Failure

_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "char": "i1", "ushort": "<u2", "short": "<i2", "int": "<i4",
          "uint": "<u4"}
_VERTEX = numpy.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1"),
                       ("label", "<u2")])
_FACE = numpy.dtype([("n", "u1"), ("corners", "<i4", 3)])
_NAMES = {"<f4": "float", "|u1": "uchar", "<u2": "ushort"}
NO_LABEL = 255


@dataclass
class Mesh:
    vertices: numpy.ndarray  # of _VERTEX
    corners: numpy.ndarray  # three indices for each face

    def moved(self, motion):
        """By a motion (motion.py)."""
        q, t = motion
        points = numpy.stack([self.vertices[name] for name in "xyz"], axis=1).astype(float) @ _rotation(q).T + t
        vertices = self.vertices.copy()
        for axis, name in enumerate("xyz"):
            vertices[name] = points[:, axis]
        return Mesh(vertices, self.corners)


def merged(meshes):
    """All in one."""
    firsts = numpy.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    return Mesh(numpy.concatenate([mesh.vertices for mesh in meshes]),
                numpy.concatenate([mesh.corners + first for mesh, first in zip(meshes, firsts)]).astype("<i4"))


def read(path):
    """Failure where the file is not such a mesh."""
    try:
        with open(path, "rb") as file:
            elements = _header(file, path)
            vertices = numpy.fromfile(file, elements["vertex"][1], elements["vertex"][0])
            faces = numpy.fromfile(file, _FACE, elements["face"][0])
    except (OSError, KeyError, ValueError) as error:
        raise Failure(f"{path}: {error}; expected a binary PLY file of triangles") from None
    if len(vertices) < elements["vertex"][0] or len(faces) < elements["face"][0] or (faces["n"] != 3).any():
        raise Failure(f"{path}: ends early, or has faces that are no triangles")
    mesh = Mesh(numpy.zeros(len(vertices), _VERTEX), faces["corners"])
    mesh.vertices["label"] = NO_LABEL
    for name in _VERTEX.names:
        if name in (vertices.dtype.names or ()):
            mesh.vertices[name] = vertices[name]
    return mesh


def write(path, mesh):
    """Whole or not at all."""
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.vertices)}"]
    head += [f"property {_NAMES[_VERTEX[name].str]} {name}" for name in _VERTEX.names]
    head += [f"element face {len(mesh.corners)}", "property list uchar int vertex_indices", "end_header\n"]
    faces = numpy.zeros(len(mesh.corners), _FACE)
    faces["n"], faces["corners"] = 3, mesh.corners
    with open(f"{path}.new", "wb") as file:
        file.write("\n".join(head).encode("ascii"))
        mesh.vertices.tofile(file)
        faces.tofile(file)
    os.rename(f"{path}.new", path)


def _header(file, path):
    """{element: (count, numpy type)}; leaves the file at its data."""
    elements, name = {}, ""
    for _ in range(100):
        words = file.readline().decode("ascii").split()
        if words[:1] == ["end_header"]:
            return {each: (count, numpy.dtype(properties)) for each, (count, properties) in elements.items()}
        if words[:1] == ["format"] and words[1] != "binary_little_endian":
            raise ValueError(f"its format is {words[1]}")
        if words[:1] == ["element"]:
            name = words[1]
            elements[name] = (int(words[2]), [])
        elif words[:1] == ["property"] and words[1] != "list":
            elements[name][1].append((words[2], _TYPES[words[1]]))
    raise ValueError("its header has no end")


def _rotation(q):
    w, x, y, z = q
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
