"""What trimesh and lib3mf find in a mesh file, as JSON: each part's name, volume and colours."""

import json
import sys

import trimesh

path = sys.argv[1]


def by_trimesh():
    scene = trimesh.load_scene(path)
    found = []
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry].copy()
        mesh.apply_transform(transform)
        material = getattr(mesh.visual, "material", None)
        color = None if material is None else material.main_color.tolist()
        above = scene.graph.transforms.parents
        names = [node]
        while names[-1] in above:
            names.append(above[names[-1]])
        found.append(
            {"names": names[::-1], "volume": mesh.volume, "closed": mesh.is_watertight, "color": color}
        )
    return found


def by_lib3mf():
    import lib3mf

    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(path)
    warnings = [reader.GetWarning(k) for k in range(reader.GetWarningCount())]

    def tell(object):
        told = {"name": object.GetName()}
        if object.IsComponentsObject():
            whole = model.GetComponentsObjectByID(object.GetResourceID())
            parts = (whole.GetComponent(k) for k in range(whole.GetComponentCount()))
            told["parts"] = [tell(part.GetObjectResource()) for part in parts]
            return told
        mesh = model.GetMeshObjectByID(object.GetResourceID())
        told["closed"] = mesh.IsManifoldAndOriented()
        told["triangles"] = mesh.GetTriangleCount()
        colors = set()
        for properties in mesh.GetAllTriangleProperties():
            if properties.ResourceID:
                group = model.GetBaseMaterialGroupByID(properties.ResourceID)
                color = group.GetDisplayColor(properties.PropertyIDs[0])
                colors.add((color.Red, color.Green, color.Blue, color.Alpha))
        told["colors"] = sorted(colors)
        return told

    items = model.GetBuildItems()
    found = []
    while items.MoveNext():
        found.append(tell(items.GetCurrent().GetObjectResource()))
    return {"warnings": warnings, "items": found, "unit": str(model.GetUnit())}


found = {"trimesh": by_trimesh()}
if path.endswith(".3mf"):
    found["lib3mf"] = by_lib3mf()
print(json.dumps(found))
