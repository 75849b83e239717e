//! The parts of a line that lie in a solid, from the tree itself: each primitive
//! cut by its own definition, and Boolean operations on intervals.

use csg::{Node, Primitive, Solid};
use glam::{DAffine3, DVec3};
use stereotomy::csg;

/// A straight line: the points `origin + t direction`.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub origin: DVec3,
    /// Of any length but zero.
    pub direction: DVec3,
}

impl Line {
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// Disjoint intervals in ascending order.
pub type Spans = Vec<[f64; 2]>;

const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// A primitive in its place.
pub struct Leaf {
    primitive: Primitive,
    map: DAffine3,
    inverse: DAffine3,
}

/// A solid's tree with the maps handed down to its leaves.
pub enum Tree {
    Leaf(Box<Leaf>),
    Union(Vec<Tree>),
    Intersection(Vec<Tree>),
    Difference(Vec<Tree>),
}

impl Tree {
    /// Of a valid solid.
    pub fn new(solid: &Solid) -> Self {
        Self::under(solid, DAffine3::IDENTITY)
    }

    fn under(solid: &Solid, map: DAffine3) -> Self {
        let all = |operands: &[Solid]| operands.iter().map(|o| Self::under(o, map)).collect();
        match solid.node() {
            Node::Primitive(primitive) => Self::Leaf(Box::new(Leaf {
                primitive: primitive.clone(),
                map,
                inverse: map.inverse(),
            })),
            Node::Union(operands) => Self::Union(all(operands)),
            Node::Intersection(operands) => Self::Intersection(all(operands)),
            Node::Difference(operands) => Self::Difference(all(operands)),
            Node::Transform(of, operand) => {
                Self::under(operand, map * *of.as_ref().expect("a valid map"))
            }
            Node::Named(_, operand) | Node::Colored(_, operand) => Self::under(operand, map),
            other => panic!("no rule for {}", other.kind()),
        }
    }

    /// The parts of a line in the solid.
    pub fn spans(&self, line: &Line) -> Spans {
        match self {
            Self::Leaf(leaf) => within(
                &leaf.primitive,
                leaf.inverse.transform_point3(line.origin),
                leaf.inverse.transform_vector3(line.direction),
            ),
            Self::Union(parts) => {
                let each = parts.iter().map(|part| complement(&part.spans(line)));
                complement(&each.reduce(|a, b| both(&a, &b)).unwrap_or_default())
            }
            Self::Intersection(parts) => {
                let each = parts.iter().map(|part| part.spans(line));
                each.reduce(|a, b| both(&a, &b)).unwrap_or_default()
            }
            Self::Difference(parts) => {
                let mut each = parts.iter().map(|part| part.spans(line));
                let first = each.next().unwrap_or_default();
                each.fold(first, |rest, other| both(&rest, &complement(&other)))
            }
        }
    }

    /// The leaves with a box of their own: the corner and the edges of each, a
    /// parallelepiped around it.
    pub fn leaves(&self, found: &mut Vec<(DAffine3, [DVec3; 2])>) {
        match self {
            Self::Leaf(leaf) => {
                found.extend(extent(&leaf.primitive).map(|corners| (leaf.map, corners)));
            }
            Self::Union(parts) | Self::Intersection(parts) | Self::Difference(parts) => {
                parts.iter().for_each(|part| part.leaves(found));
            }
        }
    }

    /// A box around the solid; infinite, or the wrong way round, where it is all of
    /// space or nothing.
    pub fn bounds(&self) -> [DVec3; 2] {
        let infinite = [DVec3::NEG_INFINITY, DVec3::INFINITY];
        let join = |a: [DVec3; 2], b: [DVec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let meet = |a: [DVec3; 2], b: [DVec3; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        match self {
            Self::Leaf(leaf) if leaf.primitive == Primitive::Empty => {
                [DVec3::INFINITY, DVec3::NEG_INFINITY]
            }
            Self::Leaf(leaf) => {
                let Some([low, high]) = extent(&leaf.primitive) else {
                    return infinite;
                };
                let corner = |i: u32| {
                    let side = |bit: u32| f64::from(i >> bit & 1);
                    low + (high - low) * DVec3::new(side(0), side(1), side(2))
                };
                (0..8)
                    .map(|i| [leaf.map.transform_point3(corner(i)); 2])
                    .reduce(join)
                    .unwrap_or(infinite)
            }
            Self::Union(parts) => parts
                .iter()
                .map(Self::bounds)
                .reduce(join)
                .unwrap_or(infinite),
            Self::Intersection(parts) => parts.iter().map(Self::bounds).fold(infinite, meet),
            Self::Difference(parts) => parts.first().map_or(infinite, Self::bounds),
        }
    }
}

/// A box around a bounded primitive.
fn extent(primitive: &Primitive) -> Option<[DVec3; 2]> {
    let across = |r: glam::DVec2, z: &std::ops::Range<f64>| [(-r).extend(z.start), r.extend(z.end)];
    Some(match primitive {
        Primitive::Cuboid { min, max } => [*min, *max],
        Primitive::Ellipsoid { radii } => [-*radii, *radii],
        Primitive::Cylinder { radii, z: Some(z) } => across(*radii, z),
        Primitive::Frustum { bottom, top, z } => across(glam::DVec2::splat(bottom.max(*top)), z),
        Primitive::Prism { polygon, z } => {
            let low = polygon.iter().copied().reduce(glam::DVec2::min)?;
            let high = polygon.iter().copied().reduce(glam::DVec2::max)?;
            [low.extend(z.start), high.extend(z.end)]
        }
        _ => return None,
    })
}

/// The part of a line in a primitive, in whose coordinates it is given.
fn within(primitive: &Primitive, p: DVec3, d: DVec3) -> Spans {
    // Σ s (p + t d)² + c <= 0.
    let squares = |s: DVec3, c: f64| {
        let (a, b) = ((s * d).dot(d), 2.0 * (s * p).dot(d));
        quadratic(a, b, (s * p).dot(p) + c)
    };
    let slab =
        |z: &std::ops::Range<f64>| both(&linear(-d.z, z.start - p.z), &linear(d.z, p.z - z.end));
    match primitive {
        Primitive::Empty => Spans::new(),
        Primitive::Space => vec![ALL],
        Primitive::HalfSpace { point, normal } => linear(normal.dot(d), normal.dot(p - *point)),
        Primitive::Quadric([xx, yy, zz, xy, yz, zx, x, y, z, c]) => {
            let form = |u: DVec3, v: DVec3| {
                xx * u.x * v.x
                    + yy * u.y * v.y
                    + zz * u.z * v.z
                    + 0.5 * (xy * (u.x * v.y + u.y * v.x))
                    + 0.5 * (yz * (u.y * v.z + u.z * v.y) + zx * (u.z * v.x + u.x * v.z))
            };
            let slope = DVec3::new(*x, *y, *z);
            let at = form(p, p) + slope.dot(p) + c;
            quadratic(form(d, d), 2.0 * form(p, d) + slope.dot(d), at)
        }
        Primitive::Cuboid { min, max } => {
            let sides =
                (0..3).flat_map(|k| [linear(-d[k], min[k] - p[k]), linear(d[k], p[k] - max[k])]);
            sides.fold(vec![ALL], |rest, side| both(&rest, &side))
        }
        Primitive::Ellipsoid { radii } => {
            let (p, d) = (p / *radii, d / *radii);
            quadratic(d.dot(d), 2.0 * p.dot(d), p.dot(p) - 1.0)
        }
        Primitive::Cylinder { radii, z } => {
            let scale = radii.extend(f64::INFINITY).recip();
            let (p, d) = (p * scale, d * scale);
            let wall = quadratic(d.dot(d), 2.0 * p.dot(d), p.dot(p) - 1.0);
            z.as_ref().map_or(wall.clone(), |z| both(&wall, &slab(z)))
        }
        Primitive::Frustum { bottom, top, z } => {
            let slope = (top - bottom) / (z.end - z.start);
            let radius = bottom + slope * (p.z - z.start);
            let grows = slope * d.z;
            let wall = quadratic(
                d.x * d.x + d.y * d.y - grows * grows,
                2.0 * (p.x * d.x + p.y * d.y - radius * grows),
                p.x * p.x + p.y * p.y - radius * radius,
            );
            both(&wall, &slab(z))
        }
        Primitive::InfiniteCone { slope } => both(
            &squares(DVec3::new(1.0, 1.0, -slope * slope), 0.0),
            &linear(-d.z, -p.z),
        ),
        Primitive::Paraboloid { scales } => {
            let s = (*scales * *scales).recip().extend(0.0);
            quadratic(
                (s * d).dot(d),
                2.0 * (s * p).dot(d) - d.z,
                (s * p).dot(p) - p.z,
            )
        }
        Primitive::HyperboloidOneSheet { radii } => {
            squares((*radii * *radii).recip() * DVec3::new(1.0, 1.0, -1.0), -1.0)
        }
        Primitive::HyperboloidTwoSheets { radii } => {
            squares((*radii * *radii).recip() * DVec3::new(1.0, 1.0, -1.0), 1.0)
        }
        Primitive::ConvexPolyhedron(planes) => planes.iter().fold(vec![ALL], |rest, plane| {
            let side = linear(plane.normal.dot(d), plane.normal.dot(p) - plane.offset);
            both(&rest, &side)
        }),
        Primitive::Prism { polygon, z } => {
            let next = polygon.iter().cycle().skip(1);
            let edges = polygon.iter().zip(next);
            let turn: f64 = edges.clone().map(|(a, b)| a.perp_dot(*b)).sum();
            edges.fold(slab(z), |rest, (a, b)| {
                let out = -(*b - *a).perp() * turn.signum();
                let side = linear(
                    out.dot(d.truncate()),
                    out.dot(p.truncate() - a.midpoint(*b)),
                );
                both(&rest, &side)
            })
        }
        other => panic!("no rule for {}", other.kind()),
    }
}

/// Where b t + c <= 0.
fn linear(b: f64, c: f64) -> Spans {
    let root = -c / b;
    if b == 0.0 || !root.is_finite() {
        if c <= 0.0 { vec![ALL] } else { Spans::new() }
    } else if b > 0.0 {
        vec![[f64::NEG_INFINITY, root]]
    } else {
        vec![[root, f64::INFINITY]]
    }
}

/// Where a t² + b t + c <= 0, without cancellation between b² and its root.
fn quadratic(a: f64, b: f64, c: f64) -> Spans {
    let discriminant = b * b - 4.0 * a * c;
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, c / q);
    if a == 0.0 || (discriminant > 0.0 && !first.is_finite()) {
        return linear(b, c);
    }
    if discriminant <= 0.0 || q == 0.0 {
        return if a > 0.0 { Spans::new() } else { vec![ALL] };
    }
    let (low, high) = (first.min(second), first.max(second));
    if a > 0.0 {
        vec![[low, high]]
    } else {
        vec![[f64::NEG_INFINITY, low], [high, f64::INFINITY]]
    }
}

/// What lies in two lists of intervals.
fn both(one: &[[f64; 2]], other: &[[f64; 2]]) -> Spans {
    let mut found = Spans::new();
    let (mut i, mut k) = (0, 0);
    while i < one.len() && k < other.len() {
        let (a, b) = (one[i], other[k]);
        let (low, high) = (a[0].max(b[0]), a[1].min(b[1]));
        if low < high {
            found.push([low, high]);
        }
        if a[1] < b[1] {
            i += 1;
        } else {
            k += 1;
        }
    }
    found
}

/// What lies in none of the intervals.
fn complement(of: &[[f64; 2]]) -> Spans {
    let starts = [f64::NEG_INFINITY]
        .into_iter()
        .chain(of.iter().map(|s| s[1]));
    let ends = of.iter().map(|s| s[0]).chain([f64::INFINITY]);
    let gaps = starts.zip(ends).map(|(low, high)| [low, high]);
    gaps.filter(|[low, high]| low < high).collect()
}
