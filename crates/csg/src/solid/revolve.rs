//! Revolution: a profile turned about an axis.
//!
//! In the half-plane x >= 0 the side of a line is the inside or outside of a
//! cone (a cylinder, a plane), and a disc around a point of the axis a
//! spheroid: again one surface each, in the profile's own formula.

use crate::elementary;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DAffine2, DVec2, DVec3};

use super::extrude::double_cone;
use super::primitive::Plane;
use super::profile::{Formula, Leaf, PlaneSet, Profile, Sagitta, formula, turn};
use super::tree::{Node, Solid};
use super::twist::cap;
use crate::error::{NodeFault, ProfileFault};
use crate::numeric::tolerance::{IN_PROFILE, LEVEL, ON_AXIS, PROFILE_CHORD};
use crate::surface::is_far;

/// Chords stray at most so much of an arc's radius.
const BESIDE_AXIS: f64 = 5e-3;

impl Solid {
    /// The profile turned about its y axis, which becomes the z axis; its x is
    /// the distance from the axis and must not be negative. What is within 1e-9 of the profile's size
    /// of the axis is on it, on either side.
    ///
    /// Lines become planes, cylinders and cones, and circles and ellipses
    /// centred on the axis spheres and spheroids. Others would become tori: these
    /// circles and arcs become chords first, within 1e-4 of the profile's size
    /// and 5e-3 of their radius, 32 to a turn, of circles with the same area (for another tolerance, see [`Profile::flattened`]).
    /// Lines that rise by less than a millionth of their length are level. How far both stray is told by
    /// [`Solid::strays`].
    #[must_use]
    pub fn revolve(profile: &Profile) -> Self {
        turned("revolve", profile, TAU, None)
    }

    /// [`Solid::revolve`] through an angle in radians from the xz plane, up to
    /// a whole turn, counter-clockwise seen from +z; clockwise if negative.
    #[must_use]
    pub fn revolve_by(profile: &Profile, radians: f64) -> Self {
        turned("revolve_by", profile, radians, None)
    }

    /// [`Solid::revolve_by`] with chords within another distance of circles and arcs that would
    /// become tori, but not more than 5e-3 of their radius. The surfaces grow in number with the
    /// root of what that is smaller.
    #[must_use]
    pub fn revolve_within(profile: &Profile, radians: f64, distance: f64) -> Self {
        turned("revolve_within", profile, radians, Some(distance))
    }

    /// [`Solid::revolve_by`] in flat steps, as programs without curved surfaces
    /// do: the profile at `steps` + 1 angles (of a whole turn: at `steps`),
    /// joined by flat faces. Circles and arcs of the profile become chords.
    #[must_use]
    pub fn revolve_in_steps(profile: &Profile, radians: f64, steps: usize) -> Self {
        let solid = stepped(profile, radians, steps);
        Self::made("revolve_in_steps", solid)
    }
}

/// A solid, and the corners of a box around it.
type Boxed = (Solid, [DVec3; 2]);

fn turned(function: &'static str, profile: &Profile, radians: f64, within: Option<f64>) -> Solid {
    let (has_chords, levelled) = (Cell::new(false), Cell::new(0.0));
    let tolerance = match within {
        Some(within) if within > 0.0 && within.is_finite() => Ok(within),
        Some(value) => Err(NodeFault::NotPositive {
            what: "the distance of chords",
            value,
        }),
        None => profile.tolerance_of(PROFILE_CHORD).map_err(NodeFault::from),
    };
    let made = tolerance.and_then(|tolerance| {
        let whole = round(profile, tolerance, &has_chords, &levelled)?;
        Ok((within_angle(whole, radians)?, tolerance))
    });
    let chords = match made {
        Ok((_, tolerance)) if has_chords.get() => tolerance,
        _ => 0.0,
    };
    let strays = chords.max(levelled.get());
    let solid = Solid::made(function, made.map(|(boxed, _)| boxed));
    if strays > 0.0 {
        solid.standing_in(strays)
    } else {
        solid
    }
}

/// The profile turned about the axis, and whether it has chords; sides that are made level stray by
/// no more than `levelled` comes to.
fn round(
    profile: &Profile,
    tolerance: f64,
    has_chords: &Cell<bool>,
    levelled: &Cell<f64>,
) -> Result<Boxed, NodeFault> {
    let keeps = |leaf: &Leaf| match leaf {
        Leaf::Disc(map) => is_on_axis(map),
        Leaf::HalfPlane { .. } => true,
        Leaf::Parabola(_) => false,
    };
    let Turned {
        formula: Formula {
            set,
            has_chords: has,
        },
        corners,
        axis,
    } = half_plane_formula(profile, tolerance, &keeps)?;
    has_chords.set(has);
    let [low, high] = corners.map(|corner| corner.z);
    let beside = high - low;
    // Steep cones end beyond it, and so does all before these do.
    let between = low - beside..high + beside;
    let has_ends = Cell::new(false);
    let ends = flat(low - 0.5 * beside, true) & flat(high + 0.5 * beside, false);
    let solid = set.solid(|leaf| match *leaf {
        Leaf::HalfPlane { from, to } => match Side::of([from, to], axis, LEVEL) {
            Side::Flat { height, up, strays } => {
                levelled.set(strays.max(levelled.get()));
                flat(height, up)
            }
            Side::Wall {
                radius,
                slope,
                height,
                inside,
            } => {
                let wall = if slope == 0.0 {
                    Solid::infinite_cylinder(radius)
                } else {
                    let wall = nappe(radius, slope, height, &between);
                    let is_cut = matches!(wall.node(), Node::Primitive(_));
                    has_ends.set(has_ends.get() || is_cut);
                    wall
                };
                if inside { wall } else { !wall }
            }
            Side::Everything(true) => Solid::space(),
            Side::Everything(false) => Solid::empty(),
        },
        Leaf::Disc(map) => {
            let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
            let radii = DVec2::new(elementary::hypot(x.x, y.x), elementary::hypot(x.y, y.y));
            Solid::ellipsoid([radii.x, radii.x, radii.y]).translate(map.translation.y * DVec3::Z)
        }
        // Not kept.
        Leaf::Parabola(_) => Solid::empty(),
    });
    let solid = if has_ends.get() { solid & ends } else { solid };
    Ok((solid, corners))
}

/// A profile to be turned.
struct Turned {
    formula: Formula,
    /// Of a box around its revolution.
    corners: [DVec3; 2],
    axis: Axis,
}

/// How near to the axis something is on it.
#[derive(Clone, Copy)]
struct Axis(f64);

impl Axis {
    fn snapped(self, point: DVec2) -> DVec2 {
        if point.x.abs() <= self.0 {
            DVec2::new(0.0, point.y)
        } else {
            point
        }
    }
}

fn half_plane_formula(
    profile: &Profile,
    tolerance: f64,
    keeps: &dyn Fn(&Leaf) -> bool,
) -> Result<Turned, NodeFault> {
    let Some((min, max)) = profile.bounds(tolerance)? else {
        return Ok(Turned {
            formula: Formula {
                set: PlaneSet::EMPTY,
                has_chords: false,
            },
            corners: [DVec3::ZERO; 2],
            axis: Axis(0.0),
        });
    };
    let axis = Axis(ON_AXIS * max.abs().max(min.abs()).max_element());
    if min.x < -axis.0 {
        return Err(ProfileFault::BeyondAxis { x: min.x }.into());
    }
    let sagitta = Sagitta {
        length: tolerance,
        of_radius: BESIDE_AXIS,
    };
    let formula = formula(profile, sagitta, keeps)?;
    let corner = |radius: f64, height: f64| DVec3::new(radius, radius, height);
    let (min, max) = profile.reach()?.unwrap_or((min, max));
    let (radius, below, above) = (max.x + tolerance, min.y - tolerance, max.y + tolerance);
    Ok(Turned {
        formula,
        corners: [corner(-radius, below), corner(radius, above)],
        axis,
    })
}

/// Whether an ellipse is centred on the axis, with its axes along x and y.
fn is_on_axis(map: &DAffine2) -> bool {
    let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
    let size = x.length().max(y.length());
    let upright = x.x * x.y + y.x * y.y;
    map.translation.x.abs() <= IN_PROFILE * size && upright.abs() <= IN_PROFILE * size * size
}

/// What is to the left of a line in the half-plane of distances and heights.
enum Side {
    /// Below a height, or above it (`up`); the line strays from that by so much.
    Flat { height: f64, up: bool, strays: f64 },
    /// Nearer to the axis than `radius` at `height`, and by `slope` more for
    /// each height above it; or further from it.
    Wall {
        radius: f64,
        slope: f64,
        height: f64,
        inside: bool,
    },
    /// All of it, or nothing.
    Everything(bool),
}

impl Side {
    /// Lines that rise by no more than such a share of their length are level.
    fn of(ends: [DVec2; 2], axis: Axis, level: f64) -> Self {
        let [from, to] = ends.map(|end| axis.snapped(end));
        let along = to - from;
        let rise = along.y.abs();
        if rise <= level * along.x.abs() {
            let is_rounding = rise <= IN_PROFILE * along.x.abs();
            return Self::Flat {
                height: from.midpoint(to).y,
                up: along.x > 0.0,
                strays: if is_rounding { 0.0 } else { 0.5 * rise },
            };
        }
        let inside = along.y > 0.0;
        let slope = if along.x.abs() <= IN_PROFILE * along.y.abs() {
            0.0
        } else {
            along.x / along.y
        };
        let middle = from.midpoint(to);
        if slope == 0.0 && middle.x <= 0.0 {
            return Self::Everything(!inside);
        }
        Self::Wall {
            radius: middle.x,
            slope,
            height: middle.y,
            inside,
        }
    }
}

fn flat(height: f64, up: bool) -> Solid {
    let normal = if up { -DVec3::Z } else { DVec3::Z };
    Solid::half_space_through(height * DVec3::Z, normal)
}

/// The inside of a cone, the nappe that has a circle of `radius` at `height`; where its apex is
/// so far away that the cone keeps few digits about it, between two heights alone.
fn nappe(radius: f64, slope: f64, height: f64, between: &Range<f64>) -> Solid {
    let beyond = -radius / slope;
    let size = radius.abs() + between.end - between.start;
    if is_far(beyond, size) {
        let at = |z: f64| radius + slope * (z - height);
        return Solid::frustum(at(between.start), at(between.end), between.clone());
    }
    let apex = height + beyond;
    let cone = double_cone()
        .scale_xyz([slope.abs(), slope.abs(), 1.0])
        .translate(apex * DVec3::Z);
    cone & flat(apex, slope > 0.0)
}

/// The part of a solid of revolution within an angle from the xz plane.
fn within_angle((solid, corners): Boxed, radians: f64) -> Result<Boxed, NodeFault> {
    if !(radians != 0.0 && radians.abs() <= TAU) {
        return Err(NodeFault::AngleOutOfRange { value: radians });
    }
    if radians.abs() == TAU {
        return Ok((solid, corners));
    }
    let behind = |angle: f64, sign: f64| {
        let normal = sign * elementary::direction(angle).perp();
        Solid::half_space_through(DVec3::ZERO, normal.extend(0.0))
    };
    let sign = radians.signum();
    let (first, last) = (behind(0.0, -sign), behind(radians, sign));
    let wedge = if radians.abs() <= PI {
        first & last
    } else {
        first | last
    };
    Ok((solid & wedge, corners))
}

/// The polyhedron through contours at all angles; none if its faces bound no solid.
fn polyhedron(contours: &[Vec<DVec2>], axis: Axis, radians: f64, steps: usize) -> Option<Solid> {
    let is_full = radians.abs() == TAU;
    let count: usize = contours.iter().map(Vec::len).sum();
    let places = if is_full { steps } else { steps + 1 };
    let direction = |k: usize| match is_full {
        true => turn(k, steps),
        false => elementary::direction(radians.abs() * k as f64 / steps as f64),
    };
    // Clockwise it is the mirror image.
    let sign = if radians < 0.0 { -1.0 } else { 1.0 };
    let vertices = (0..places).flat_map(|k| {
        let along = direction(k);
        let points = contours.iter().flatten();
        points.map(move |point| {
            let flat = axis.snapped(*point).x * along;
            DVec3::new(flat.x, sign * flat.y, point.y)
        })
    });
    let mut faces: Vec<Vec<u32>> = Vec::with_capacity(count * steps);
    for step in 0..steps {
        let at = [step, (step + 1) % places].map(|k| k * count);
        let mut first = 0;
        for contour in contours {
            for k in 0..contour.len() {
                let [from, to] = [k, (k + 1) % contour.len()].map(|k| first + k);
                let corners = [at[0] + from, at[1] + from, at[1] + to, at[0] + to];
                faces.push(corners.map(|vertex| vertex as u32).to_vec());
            }
            first += contour.len();
        }
    }
    if !is_full {
        let last = (steps * count) as u32;
        for [a, b, c] in cap(contours)? {
            faces.extend([[a, b, c], [c + last, b + last, a + last]].map(Vec::from));
        }
    }
    if radians < 0.0 {
        for face in &mut faces {
            face.reverse();
        }
    }
    Solid::of_faces(vertices.collect(), &faces, &[])
}

fn stepped(profile: &Profile, radians: f64, steps: usize) -> Result<Boxed, NodeFault> {
    let full = radians.abs() == TAU;
    if steps < if full { 3 } else { 1 } || !full && radians.abs() / steps as f64 >= PI {
        return Err(NodeFault::TooFewSteps { steps });
    }
    let tolerance = profile.tolerance_of(PROFILE_CHORD)?;
    let Turned {
        formula: Formula { set, .. },
        corners,
        axis,
    } = half_plane_formula(profile, tolerance, &|_| false)?;
    if let Some(solid) = polyhedron(&profile.contours(tolerance)?, axis, radians, steps) {
        return Ok((solid, corners));
    }
    // The directions of the middles of steps, and how far they fall short.
    let middles: Vec<DVec2> = (0..steps)
        .map(|k| {
            if full {
                turn(2 * k + 1, 2 * steps)
            } else {
                elementary::direction(radians * (k as f64 + 0.5) / steps as f64)
            }
        })
        .collect();
    let short = elementary::cos(0.5 * radians / steps as f64);
    let solid = set.solid(|leaf| match *leaf {
        Leaf::HalfPlane { from, to } => match Side::of([from, to], axis, IN_PROFILE) {
            Side::Flat { height, up, .. } => flat(height, up),
            Side::Wall {
                radius,
                slope,
                height,
                inside,
            } => {
                let planes = middles.iter().map(|middle| {
                    let normal = middle.extend(-short * slope);
                    let point = (middle * (short * radius)).extend(height);
                    Plane::through(point, normal)
                });
                let wall = Solid::convex_polyhedron(planes);
                if inside { wall } else { !wall }
            }
            Side::Everything(true) => Solid::space(),
            Side::Everything(false) => Solid::empty(),
        },
        // Not kept.
        Leaf::Disc(_) | Leaf::Parabola(_) => Solid::empty(),
    });
    within_angle((solid, corners), radians)
}
