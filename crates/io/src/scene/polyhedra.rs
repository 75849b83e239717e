//! What OpenSCAD has no node for: infinite primitives cut off by a box, and
//! whatever else bounds a solid, as polyhedra.

use csg::{Made, Mesh, Mesher, Node, Placement, Primitive, Program, Solid, SurfaceShape};
use glam::{DAffine3, DMat3, DVec3};

use super::write::{list, number};

/// How far a polyhedron may stray from curved faces, as a share of its size.
const SHARE: f64 = 1e-3;
/// By how much the box is larger that cuts infinite primitives off, as a share of its
/// size: what they are subtracted from must end within it.
const MARGIN: f64 = 0.1;

/// A box from its least to its greatest corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Within {
    pub min: DVec3,
    pub max: DVec3,
}

impl Within {
    /// The box around a solid, if it is bounded; empty ones have none.
    pub(super) fn of(solid: &Solid) -> Result<Option<Self>, String> {
        let program = Program::lower(solid).map_err(|e| e.to_string())?;
        let bounds = program.bounds().map_err(|e| e.to_string())?;
        Ok(bounds.map(|bounds| Self {
            min: bounds.min,
            max: bounds.max,
        }))
    }

    /// The same box, larger on all sides.
    pub(super) fn padded(self) -> Self {
        let margin = MARGIN * (self.max - self.min).max_element();
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// The box around it in the coordinates from which `map` leads to its own.
    fn seen_through(self, map: DAffine3) -> Self {
        let back = map.inverse();
        let corners = (0..8).map(|k| {
            let greater = [1, 2, 4].map(|bit| k & bit != 0);
            back.transform_point3(DVec3::select(greater.into(), self.max, self.min))
        });
        let (min, max) = corners.fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(min, max), corner| (min.min(corner), max.max(corner)),
        );
        Self { min, max }
    }

    pub(super) fn solid(self) -> Solid {
        Solid::cuboid_between(self.min, self.max)
    }
}

/// Whether a primitive has to be cut off: OpenSCAD has a node for finite ones alone.
pub(super) fn is_infinite(primitive: &Primitive) -> bool {
    if let Primitive::ConvexPolyhedron(planes) = primitive {
        let solid = Solid::convex_polyhedron(planes.iter().copied());
        let bounds = Program::lower(&solid).and_then(|program| program.bounds());
        return matches!(bounds, Err(csg::Error::Unbounded { .. }));
    }
    matches!(
        primitive,
        Primitive::Space
            | Primitive::HalfSpace { .. }
            | Primitive::Quadric(_)
            | Primitive::Cylinder { z: None, .. }
            | Primitive::InfiniteCone { .. }
            | Primitive::Paraboloid { .. }
            | Primitive::HyperboloidOneSheet { .. }
            | Primitive::HyperboloidTwoSheets { .. }
    )
}

/// An infinite primitive within a box that is given where `map` leads: a finite one
/// that reaches beyond the box, or a polyhedron.
pub(super) fn cut_off(
    primitive: &Primitive,
    within: Within,
    map: DAffine3,
) -> Result<Solid, String> {
    let local = within.seen_through(map);
    Ok(match primitive {
        Primitive::Space => local.solid(),
        Primitive::Cylinder { radii, z: None } => {
            Solid::elliptic_cylinder(*radii, local.min.z..local.max.z)
        }
        &Primitive::InfiniteCone { slope } if slope > 0.0 && local.max.z > 0.0 => {
            Solid::frustum(0.0, slope * local.max.z, 0.0..local.max.z)
        }
        other => {
            if let Primitive::Quadric(_) = other
                && let Some(solid) = quadric(other, local)?
            {
                return Ok(solid);
            }
            let solid = Solid::primitive(other.clone()) & local.solid();
            polyhedron(&solid)?.map_or_else(Solid::empty, |mesh| {
                let positions = mesh.positions.iter().copied();
                Solid::polyhedron(positions, &mesh.triangles)
            })
        }
    })
}

/// A quadric of a kind that OpenSCAD has, as far as a box: an ellipsoid, a cylinder or a
/// cone, or what is outside of it.
fn quadric(primitive: &Primitive, within: Within) -> Result<Option<Solid>, String> {
    enum Kind {
        Ball,
        Cylinder,
        Cone,
    }
    let program =
        Program::lower(&Solid::primitive(primitive.clone())).map_err(|e| e.to_string())?;
    let [surface] = program.surfaces() else {
        return Ok(None);
    };
    let along = |origin: DVec3, axis: DVec3| {
        let (x, y) = axis.any_orthonormal_pair();
        let axes = [x, y, axis];
        Placement { origin, axes }
    };
    let flat = |[a, b]: [f64; 2]| [a, b, 1.0];
    let (kind, placement, radii) = match surface.shape() {
        SurfaceShape::Sphere { center, radius } => {
            (Kind::Ball, along(center, DVec3::Z), [radius; 3])
        }
        SurfaceShape::Ellipsoid { placement, radii } => (Kind::Ball, placement, radii),
        SurfaceShape::Cylinder {
            point,
            axis,
            radius,
        } => (Kind::Cylinder, along(point, axis), flat([radius; 2])),
        SurfaceShape::EllipticCylinder { placement, radii } => {
            (Kind::Cylinder, placement, flat(radii))
        }
        SurfaceShape::Cone {
            point,
            axis,
            radius: 0.0,
            slope,
        } => (Kind::Cone, along(point, axis), flat([slope; 2])),
        SurfaceShape::EllipticCone { placement, slopes } => (Kind::Cone, placement, flat(slopes)),
        _ => return Ok(None),
    };
    let frame = DAffine3 {
        matrix3: DMat3::from_cols_array_2d(&placement.axes.map(DVec3::into)),
        translation: placement.origin,
    };
    let Within { min, max } = within.seen_through(frame);
    let solid = match kind {
        Kind::Ball => Solid::ellipsoid(radii),
        Kind::Cylinder => Solid::elliptic_cylinder([radii[0], radii[1]], min.z..max.z),
        Kind::Cone => {
            let up = (max.z > 0.0).then(|| Solid::frustum(0.0, max.z, 0.0..max.z));
            let down = (min.z < 0.0).then(|| Solid::frustum(-min.z, 0.0, min.z..0.0));
            Solid::union(up.into_iter().chain(down)).scale_xyz(radii)
        }
    };
    let solid = solid.affine(frame);
    // On the axis, and no apex.
    let inside = placement.origin + placement.axes[2] * min.z.abs().max(max.z.abs());
    let inside = match kind {
        Kind::Ball => placement.origin,
        Kind::Cylinder | Kind::Cone => inside,
    };
    Ok(Some(if program.contains(inside) {
        solid
    } else {
        within.solid() - solid
    }))
}

/// The mesh that a bounded solid is written as; none if it has no points.
pub(super) fn polyhedron(solid: &Solid) -> Result<Option<Mesh>, String> {
    let program = Program::lower(solid).map_err(|e| e.to_string())?;
    let Some(bounds) = program.bounds().map_err(|e| e.to_string())? else {
        return Ok(None);
    };
    let mut mesher = Mesher::new();
    if !program.carriers().iter().all(csg::Surface::is_plane) {
        mesher = mesher.tolerance(SHARE * bounds.size().max_element());
    }
    let meshed = mesher.mesh(&program).map_err(|e| e.to_string())?;
    if !(meshed.report.is_proven() && meshed.report.check.is_manifold()) {
        return Err("it cannot be meshed without doubt, or touches itself".to_owned());
    }
    let mesh = meshed.mesh;
    Ok((!mesh.triangles.is_empty()).then_some(mesh))
}

/// Whether all below a node is bounded by planes.
pub(super) fn is_flat(solid: &Solid) -> bool {
    let mut pending = vec![solid];
    while let Some(solid) = pending.pop() {
        if let Node::Primitive(primitive) = solid.node() {
            let flat = matches!(
                primitive,
                Primitive::Empty
                    | Primitive::Space
                    | Primitive::HalfSpace { .. }
                    | Primitive::Cuboid { .. }
                    | Primitive::ConvexPolyhedron(_)
                    | Primitive::Prism { .. }
                    | Primitive::Polyhedron(_)
            );
            if !flat {
                return false;
            }
        }
        pending.extend(solid.node().operands());
    }
    true
}

/// Whether what a function made is better written as one polyhedron than as what it is
/// made of: flat, of half-spaces.
pub(super) fn is_one_polyhedron(made: &Made) -> bool {
    made.within.is_some() && made.solid.as_ref().is_ok_and(is_flat)
}

/// The node of a polyhedron; OpenSCAD lists corners clockwise seen from outside.
pub(super) fn node(mesh: &Mesh) -> String {
    let points: Vec<String> = mesh.positions.iter().map(|p| list(&p.to_array())).collect();
    let faces = mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| format!("[{c}, {b}, {a}]"));
    let faces: Vec<String> = faces.collect();
    format!(
        "polyhedron(points = [{}], faces = [{}], convexity = 10);",
        points.join(", "),
        faces.join(", ")
    )
}

/// The node of a prism over any polygon, and how far it is lifted.
pub(super) fn extrusion(polygon: &[glam::DVec2], z: &std::ops::Range<f64>) -> (String, f64) {
    let points: Vec<String> = polygon.iter().map(|p| list(&p.to_array())).collect();
    let node = format!(
        "linear_extrude(height = {}, center = false, convexity = 10, scale = [1, 1], $fn = 0, $fa = 12, $fs = 2) {{ polygon(points = [{}], paths = undef, convexity = 1); }}",
        number(z.end - z.start),
        points.join(", ")
    );
    (node, z.start)
}
