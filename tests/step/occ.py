"""Open CASCADE reads STEP files: a line of JSON with a path in, a line out."""

import json
import os
import sys

from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.collections import HArray1_double, HArray1_gp_Pnt2d, Sequence_TDF_Label
from OCP.Geom import (
    Geom_Parabola,
    Geom_RectangularTrimmedSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
)
from OCP.Geom2dAPI import Geom2dAPI_Interpolate
from OCP.gp import gp_Pnt2d
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.ShapeAnalysis import ShapeAnalysis_Surface
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

# Spans of an edge's image on a surface: so many if it is as long as the solid, and limits.
SPANS = 800
FEWEST, MOST = 80, 320


def all_of(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def volume(shape):
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-13)
    return properties.Mass()


def refine_images(shape):
    """Lays the images of edges on surfaces of revolution, and over parabolas, through more
    points. Those that the reader makes go through some twenty, and volumes stray with them; of
    other surfaces they are in the file."""
    builder = BRep_Builder()
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    low, high = box.CornerMin(), box.CornerMax()
    per_length = SPANS / low.Distance(high)
    for face in all_of(shape, TopAbs_FACE):
        face = TopoDS.Face(face)
        surface = BRep_Tool.Surface_s(face)
        if isinstance(surface, Geom_RectangularTrimmedSurface):
            surface = surface.BasisSurface()
        is_swept = isinstance(surface, Geom_SurfaceOfLinearExtrusion)
        is_over_parabola = is_swept and isinstance(surface.BasisCurve(), Geom_Parabola)
        if not (isinstance(surface, Geom_SurfaceOfRevolution) or is_over_parabola):
            continue
        on = ShapeAnalysis_Surface(surface)
        for edge in all_of(face, TopAbs_EDGE):
            edge = TopoDS.Edge(edge)
            # (Those of seams are lines, on both sides of the chart.)
            is_seam = BRep_Tool.IsClosed_s(edge, face)
            if not is_seam and not BRep_Tool.Degenerated_s(edge):
                builder.UpdateEdge(edge, refined(edge, face, on, per_length), face, 1e-7)


def refined(edge, face, on, per_length):
    first, last = BRep_Tool.Range_s(edge)
    curve = BRep_Tool.Curve_s(edge, first, last)
    coarse = BRep_Tool.CurveOnSurface_s(edge, face, first, last)
    corners = [curve.Value(first + (last - first) * k / 8) for k in range(9)]
    length = sum(a.Distance(b) for a, b in zip(corners, corners[1:]))
    spans = int(min(max(length * per_length, FEWEST), MOST))
    points, places = HArray1_gp_Pnt2d(1, spans + 1), HArray1_double(1, spans + 1)
    for k in range(spans + 1):
        t = first + (last - first) * k / spans
        about = coarse.Value(t)
        at = on.NextValueOfUV(about, curve.Value(t), 1e-13)
        u, v = at.X(), at.Y()
        surface = on.Surface()
        if surface.IsUPeriodic():
            u += surface.UPeriod() * round((about.X() - u) / surface.UPeriod())
        # At a pole all of them are the same point.
        if abs(u - about.X()) > 1e-3:
            u = about.X()
        points.SetValue(k + 1, gp_Pnt2d(u, v))
        places.SetValue(k + 1, t)
    image = Geom2dAPI_Interpolate(points, places, False, 1e-12)
    image.Perform()
    return image.Curve()


def written(reader, shape):
    """The name of the entity that a shape was made from."""
    # (In an assembly it is placed.)
    shape = shape.Located(TopLoc_Location())
    entity = reader.WS().TransferReader().EntityFromShapeResult(shape, 1)
    return entity.Name().ToCString() if entity is not None else None


def name_of(label):
    name = TDataStd_Name()
    label.FindAttribute(TDataStd_Name.GetID_s(), name)
    return name.Get().ToExtString()


def parts_of(label, outer=""):
    """The products that a product is put together from, each as outer/inner."""
    inner = Sequence_TDF_Label()
    XCAFDoc_ShapeTool.GetComponents_s(label, inner)
    for component in inner:
        product = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(component, product)
        name = outer + name_of(product)
        yield name
        yield from parts_of(product, name + "/")


def color_of(colors, shape):
    color = Quantity_Color()
    if not colors.GetColor(shape.Located(TopLoc_Location()), XCAFDoc_ColorSurf, color):
        return None
    return list(color.Values(Quantity_TOC_sRGB))


def read(path, of_faces):
    """What is in a file. To find a face's name and colour takes as long as there are faces."""
    document = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF"))
    with_colors = STEPCAFControl_Reader()
    with_colors.SetNameMode(True)
    with_colors.SetColorMode(True)
    if with_colors.ReadFile(path) != IFSelect_RetDone:
        return {"problem": "it cannot be read"}
    if not with_colors.Transfer(document):
        return {"problem": "nothing could be made of it"}
    reader = with_colors.ChangeReader()
    shape = reader.OneShape()
    main = document.Main()
    roots = Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(main).GetFreeShapes(roots)
    colors = XCAFDoc_DocumentTool.ColorTool_s(main)
    names = [name_of(label) for label in roots]
    solids = [
        {
            "name": written(reader, solid),
            "shells": len(list(all_of(solid, TopAbs_SHELL))),
            "color": color_of(colors, solid),
        }
        for solid in all_of(shape, TopAbs_SOLID)
    ]
    faces = [
        {"name": written(reader, face), "color": color_of(colors, face)} if of_faces else {}
        for face in all_of(shape, TopAbs_FACE)
    ]
    closed = [BRep_Tool.IsClosed_s(shell) for shell in all_of(shape, TopAbs_SHELL)]
    is_valid = BRepCheck_Analyzer(shape).IsValid()
    refine_images(shape)
    return {
        "valid": is_valid,
        "closed": all(closed),
        "products": names,
        "parts": [name for label in roots for name in parts_of(label)],
        "solids": solids,
        "faces": faces,
        "volume": volume(shape),
    }


# What the library prints shall not come between the answers.
answers = os.fdopen(os.dup(1), "w")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
for line in sys.stdin:
    print(json.dumps(read(**json.loads(line))), file=answers, flush=True)
