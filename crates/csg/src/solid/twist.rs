//! Extrusion in flat steps: with a twist, or scaled unevenly.

use crate::elementary;
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::partition::{Facet, Tree};
use super::polyhedron::plane_of;
use super::primitive::Plane;
use super::profile::{Lines, Profile};
use super::tree::Solid;
use crate::error::NodeFault;
use crate::mesh::triangulate::{Named, Scratch, triangulate};
use crate::numeric::tolerance::{IN_PROFILE, ON_FACE, PROFILE_CHORD, SAME_FACE};

/// How an extrusion turns and narrows on its way up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// How far the top is turned against the bottom, in radians,
    /// counter-clockwise seen from +z.
    pub radians: f64,
    /// What the top is scaled by along x and y, before it is turned back: the
    /// scale's axes stay where they are.
    pub scale: DVec2,
    /// Into how many layers of the same height the way is divided; each must
    /// turn by less than half a turn.
    pub steps: usize,
}

impl Solid {
    /// The profile moved along z while it is turned and scaled about the z
    /// axis, in flat steps: between two of them every side is two triangles,
    /// which meet in the shorter diagonal. Circles and arcs become chords within
    /// 1e-4 of the profile's size first (for another tolerance, see
    /// [`Profile::flattened`]).
    ///
    /// It is a polyhedron ([`Solid::polyhedron`]) that is cut as fast as others, unless its faces
    /// run through each other: where they do, every triangle is an infinite plane to whatever is
    /// cut by it, of which some hundred are cheap, thousands slow.
    #[must_use]
    pub fn extrude_in_steps(profile: &Profile, z: Range<f64>, twist: Twist) -> Self {
        Self::made("extrude_in_steps", twisted(profile, &z, twist))
    }
}

/// Of a solid in flat steps that stands for a curved one: more take longer than they show.
const MOST_FACES: f64 = 2e5;
/// How far its faces may stray, of the profile's size. Tunes their number, which grows with its power
/// of -3/2: of a bar that turns by a right angle it is some 25,000.
const STRAY: f64 = 3e-4;

/// Solids whose faces are not of second degree, by flat ones.
impl Solid {
    /// The profile moved along z while it is turned and scaled about the z axis, evenly, by flat
    /// faces within 3e-4 of the profile's size, or, if these would be more than 200,000, as near as so
    /// many come: [`Solid::twist_accuracy`] tells how near. `radians` and `scale` are those of
    /// [`Twist`]. Cost as of [`Solid::extrude_in_steps`].
    #[must_use]
    pub fn extrude_twisted(
        profile: &Profile,
        z: Range<f64>,
        radians: f64,
        scale: impl Into<DVec2>,
    ) -> Self {
        even_twist(
            "extrude_twisted",
            profile,
            &z,
            (radians, scale.into()),
            None,
        )
    }

    /// The same by flat faces within another distance, or, if these would be more than 200,000, as
    /// near as so many come.
    #[must_use]
    pub fn extrude_twisted_within(
        profile: &Profile,
        z: Range<f64>,
        radians: f64,
        scale: impl Into<DVec2>,
        distance: f64,
    ) -> Self {
        let function = "extrude_twisted_within";
        even_twist(
            function,
            profile,
            &z,
            (radians, scale.into()),
            Some(distance),
        )
    }

    /// How near [`Solid::extrude_twisted`], or [`Solid::extrude_twisted_within`] a distance, comes,
    /// and by how many faces.
    ///
    /// # Errors
    /// Whatever is wrong with the profile, the angle, the scale or the distance.
    pub fn twist_accuracy(
        profile: &Profile,
        radians: f64,
        scale: impl Into<DVec2>,
        distance: Option<f64>,
    ) -> Result<TwistAccuracy, NodeFault> {
        Even::new(profile, radians, scale.into(), distance).map(|even| even.accuracy)
    }
}

/// By flat faces within a distance, if it is given.
pub(super) fn even_twist(
    function: &'static str,
    profile: &Profile,
    z: &Range<f64>,
    (radians, scale): (f64, DVec2),
    distance: Option<f64>,
) -> Solid {
    let even = Even::new(profile, radians, scale, distance);
    let strays = even.as_ref().ok().map(|even| even.accuracy.deviation);
    let made = even.and_then(|even| in_steps(&even.contours, z, even.twist));
    let solid = Solid::made(function, made);
    match strays {
        Some(strays) => solid.standing_in(strays),
        None => solid,
    }
}

/// How near flat faces come to an even twist.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TwistAccuracy {
    /// How far they are from it at most, in model units.
    pub deviation: f64,
    /// How many triangles its sides are.
    pub faces: usize,
}

/// An even twist by flat faces.
struct Even {
    /// With corners along the sides.
    contours: Vec<Vec<DVec2>>,
    twist: Twist,
    accuracy: TwistAccuracy,
}

impl Even {
    /// Within a distance, or a share of the profile's size, if so many faces do.
    fn new(
        profile: &Profile,
        radians: f64,
        scale: DVec2,
        distance: Option<f64>,
    ) -> Result<Self, NodeFault> {
        check(radians, scale)?;
        let mut deviation = match distance {
            Some(distance) if distance > 0.0 && distance.is_finite() => distance,
            Some(value) => {
                let what = "the distance of flat faces";
                return Err(NodeFault::NotPositive { what, value });
            }
            None => profile.tolerance_of(STRAY)?,
        };
        loop {
            // Half of it is for chords, half for flat faces.
            let contours = profile.contours(0.5 * deviation)?;
            let steps = Steps::within(0.5 * deviation, &contours, radians, scale);
            let sides = contours.iter().flat_map(|contour| sides_of(contour));
            let pieces = sides.map(|[from, to]| steps.pieces(from.distance(to)));
            let faces = 2.0 * steps.count * pieces.sum::<f64>();
            if faces > MOST_FACES && deviation < steps.reach {
                deviation *= (faces / MOST_FACES).max(1.1);
                continue;
            }
            // Of so many turns, or so many corners, that no chords help.
            if faces > 10.0 * MOST_FACES {
                return Err(NodeFault::TooFewSteps {
                    steps: MOST_FACES as usize,
                });
            }
            let divided = |[from, to]: [DVec2; 2]| {
                let pieces = steps.pieces(from.distance(to));
                (0..pieces as u32).map(move |k| from.lerp(to, f64::from(k) / pieces))
            };
            let divide = |contour: &Vec<DVec2>| sides_of(contour).flat_map(divided).collect();
            return Ok(Self {
                contours: contours.iter().map(divide).collect(),
                twist: Twist {
                    radians,
                    scale,
                    steps: steps.count as usize,
                },
                accuracy: TwistAccuracy {
                    deviation,
                    faces: faces as usize,
                },
            });
        }
    }
}

/// How finely the way and the sides are divided.
struct Steps {
    /// How far the farthest corner is from the axis.
    reach: f64,
    count: f64,
    /// How many pieces a side of length 1 would be if there were one step.
    pieces: f64,
}

impl Steps {
    /// As few as flat faces within a distance take.
    fn within(deviation: f64, contours: &[Vec<DVec2>], radians: f64, scale: DVec2) -> Self {
        let points = contours.iter().flatten();
        let reach = points.fold(0.0, |most, point| point.length().max(most));
        let angle = radians.abs();
        let widest = scale.max_element().max(1.0);
        // A corner's path is off its chord by an eighth of its second derivative, along the
        // whole way, times the step squared: at most a third.
        let grown = (DVec2::ONE - scale).abs().max_element();
        let bend = reach * angle * (widest * angle + 2.0 * grown);
        let curved = (3.0 / 8.0 * bend / deviation).sqrt();
        // Four corners that are out of a plane by so much of a side's length are off their
        // mean by a quarter of that: at most two thirds.
        let warp = widest * angle + (scale.x - scale.y).abs();
        let pieces = 3.0 / 8.0 * warp / deviation;
        // As many steps as make pieces as long as these are high, if all is as high as wide.
        let warped = (pieces * reach).sqrt();
        let least = (angle / MOST_TURN).max(1.0);
        Self {
            reach,
            count: curved.max(warped).max(least).ceil(),
            pieces,
        }
    }

    /// How many pieces a side of some length is.
    fn pieces(&self, length: f64) -> f64 {
        (self.pieces * length / self.count).ceil().max(1.0)
    }
}

/// The ends of each side of a polygon.
fn sides_of(contour: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> {
    let next = contour.iter().cycle().skip(1);
    contour.iter().zip(next).map(|(&from, &to)| [from, to])
}

/// What polygons enclose, moved along z and scaled evenly, as a polyhedron; none if they meet
/// so that it is none.
pub(super) fn prism(
    contours: &[Vec<DVec2>],
    lines: &Lines,
    z: &Range<f64>,
    scale: DVec2,
) -> Option<Solid> {
    let at = |(z, scale)| Level {
        turn: DVec2::X,
        scale,
        z,
    };
    let levels = [(z.start, DVec2::ONE), (z.end, scale)].map(at);
    polyhedron(contours, Some(lines), &levels, true)
}

/// By how much a step turns at most, in radians: sides of steps that turn further would pass near
/// the axis.
const MOST_TURN: f64 = 0.5;

fn check(radians: f64, scale: DVec2) -> Result<(), NodeFault> {
    if !radians.is_finite() {
        let what = "the angle of a twist";
        return Err(NodeFault::NotFinite { what });
    }
    for value in scale.to_array() {
        if !(value >= 0.0 && value.is_finite()) {
            let what = "the scale";
            return Err(NodeFault::NotPositive { what, value });
        }
    }
    Ok(())
}

fn twisted(
    profile: &Profile,
    z: &Range<f64>,
    twist: Twist,
) -> Result<(Solid, [DVec3; 2]), NodeFault> {
    check(twist.radians, twist.scale)?;
    let Twist { radians, steps, .. } = twist;
    if steps == 0 || radians.abs() / steps as f64 >= std::f64::consts::PI {
        return Err(NodeFault::TooFewSteps { steps });
    }
    let contours = profile.contours(profile.tolerance_of(PROFILE_CHORD)?)?;
    in_steps(&contours, z, twist)
}

fn in_steps(
    contours: &[Vec<DVec2>],
    z: &Range<f64>,
    twist: Twist,
) -> Result<(Solid, [DVec3; 2]), NodeFault> {
    let height = extent(z)?;
    let Twist {
        radians,
        scale,
        steps,
    } = twist;
    let at = |step: usize| Level {
        turn: elementary::direction(radians * step as f64 / steps as f64),
        scale: DVec2::ONE - (DVec2::ONE - scale) * step as f64 / steps as f64,
        z: z.start + height * step as f64 / steps as f64,
    };
    let levels: Vec<Level> = (0..=steps).map(at).collect();
    let points = contours.iter().flatten();
    let reach = points.fold(0.0, |most, point| point.length().max(most));
    let reach = DVec2::splat(reach * scale.max_element().max(1.0));
    let within = [(-reach).extend(z.start), reach.extend(z.end)];
    let solid = if contours.is_empty() {
        Solid::empty()
    } else {
        let turns_back = radians >= 0.0;
        polyhedron(contours, None, &levels, turns_back).unwrap_or_else(|| {
            let pairs = levels.windows(2);
            Solid::union(pairs.map(|pair| layer(contours, [&pair[0], &pair[1]], turns_back)))
        })
    };
    Ok((solid, within))
}

/// The height of an extrusion.
pub(super) fn extent(z: &Range<f64>) -> Result<f64, NodeFault> {
    let height = z.end - z.start;
    if !(z.start.is_finite() && z.end.is_finite()) {
        return Err(NodeFault::NotFinite {
            what: "both ends of the extent",
        });
    }
    if height > 0.0 {
        Ok(height)
    } else {
        Err(NodeFault::NotPositive {
            what: "the height",
            value: height,
        })
    }
}

/// A cross-section.
struct Level {
    turn: DVec2,
    scale: DVec2,
    z: f64,
}

impl Level {
    fn place(&self, point: DVec2) -> DVec3 {
        (self.scale * self.turn.rotate(point)).extend(self.z)
    }
}

/// The triangles of all sides of a contour between two levels, each side's two beside each
/// other, as places around it: from each corner to the next, below, then above.
fn sides<'a>(
    contour: &'a [DVec2],
    [low, high]: [&'a Level; 2],
    turns_back: bool,
) -> impl Iterator<Item = (usize, [[usize; 3]; 2])> + 'a {
    let is_hole = super::profile::doubled_area(contour) < 0.0;
    // Of diagonals of the same length the one that matches its neighbours'.
    let flip = is_hole != turns_back;
    let shrinks = high.scale.min_element() == 0.0;
    (0..contour.len()).map(move |k| {
        let [from, to] = [contour[k], contour[(k + 1) % contour.len()]];
        let [a, b, c, d] = [
            low.place(from),
            low.place(to),
            high.place(to),
            high.place(from),
        ];
        let flat = |p: DVec3, q: DVec3| (p - q).truncate().length();
        let (first, second) = (flat(a, c), flat(b, d));
        let same = 2e5 * (first - second).abs() <= first + second;
        let by_first = if same { !flip } else { first < second };
        let triangles = if by_first == shrinks {
            [[0, 1, 3], [1, 2, 3]]
        } else {
            [[0, 1, 2], [0, 2, 3]]
        };
        (k, triangles)
    })
}

/// The end of an extrusion that is scaled to nothing along one axis alone: corners on both sides of it
/// are one.
struct Ridge {
    /// With corners wherever others are on the same place of the ridge.
    contours: Vec<Vec<DVec2>>,
    points: Vec<DVec3>,
    /// Of each corner, in turn.
    number: Vec<u32>,
}

impl Ridge {
    /// None if the level is no ridge.
    fn of(contours: &[Vec<DVec2>], level: &Level) -> Option<Self> {
        let axis = match level.scale.to_array() {
            [0.0, y] if y > 0.0 => 1,
            [x, 0.0] if x > 0.0 => 0,
            _ => return None,
        };
        let along = |point: &DVec2| level.turn.rotate(*point)[axis];
        let mut places: Vec<f64> = contours.iter().flatten().map(along).collect();
        let reach = places
            .iter()
            .fold(0.0f64, |most, place| most.max(place.abs()));
        places.sort_by(f64::total_cmp);
        places.dedup_by(|next, place| *next - *place <= IN_PROFILE * reach);
        // The place at or before one, but for rounding.
        let number = |place: f64| {
            let beyond = places.partition_point(|&other| other <= place + IN_PROFILE * reach);
            beyond.saturating_sub(1)
        };
        let divided = |[from, to]: [DVec2; 2]| {
            let ends = [from, to].map(|end| along(&end));
            let [first, last] = ends.map(number);
            let between = first.min(last) + 1..first.max(last);
            let mut all = vec![from];
            let share = |k: usize| (places[k] - ends[0]) / (ends[1] - ends[0]);
            all.extend(between.map(|k| from.lerp(to, share(k))));
            if last < first {
                all[1..].reverse();
            }
            all
        };
        let divide = |contour: &Vec<DVec2>| sides_of(contour).flat_map(divided).collect();
        let contours: Vec<Vec<DVec2>> = contours.iter().map(divide).collect();
        let points = places.iter().map(|&place| {
            let mut flat = [0.0; 2];
            flat[axis] = level.scale[axis] * place;
            DVec2::from_array(flat).extend(level.z)
        });
        let numbers = contours.iter().flatten();
        let numbers = numbers.map(|point| number(along(point)) as u32);
        Some(Self {
            points: points.collect(),
            number: numbers.collect(),
            contours,
        })
    }
}

/// The polyhedron through all levels, its sides on the planes through `lines`, if these become
/// planes; none if its faces run through each other, or if it has none at its end.
fn polyhedron(
    contours: &[Vec<DVec2>],
    lines: Option<&Lines>,
    levels: &[Level],
    turns_back: bool,
) -> Option<Solid> {
    let (last, below) = levels.split_last()?;
    let ridge = Ridge::of(contours, last);
    let contours = ridge.as_ref().map_or(contours, |ridge| &ridge.contours);
    let count: usize = contours.iter().map(Vec::len).sum();
    let at = |level: &Level| {
        let points = contours.iter().flatten();
        points.map(|&point| level.place(point)).collect()
    };
    let mut vertices: Vec<DVec3> = below.iter().flat_map(at).collect();
    let top = vertices.len() as u32;
    vertices.extend(match &ridge {
        Some(ridge) => ridge.points.clone(),
        None => at(last),
    });
    let number = |corner: u32| match &ridge {
        Some(ridge) if corner >= top => top + ridge.number[(corner - top) as usize],
        _ => corner,
    };
    let mut faces: Vec<Vec<u32>> = Vec::with_capacity(2 * count * levels.len());
    let mut planes: Vec<Option<Plane>> = Vec::with_capacity(faces.capacity());
    for (step, pair) in levels.windows(2).enumerate() {
        let mut first = step * count;
        for contour in contours {
            for (k, triangles) in sides(contour, [&pair[0], &pair[1]], turns_back) {
                let next = (k + 1) % contour.len();
                let corners = [k, next, next + count, k + count];
                let corners = corners.map(|at| number((first + at) as u32));
                let triangles = triangles.map(|triangle| triangle.map(|at| corners[at]));
                let has_area = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
                let triangles = triangles.into_iter().filter(has_area);
                faces.extend(triangles.map(Vec::from));
                let [low, high] = [&pair[0], &pair[1]];
                let plane = lines.and_then(|lines| {
                    let [from, to] = lines.of(contour[k], contour[next]);
                    upright([from, to], [low, high])
                });
                planes.resize(faces.len(), plane);
            }
            first += contour.len();
        }
    }
    for [a, b, c] in cap(contours)? {
        faces.push(vec![c, b, a]);
        if ridge.is_none() {
            faces.push(vec![a + top, b + top, c + top]);
        }
    }
    Solid::of_faces(vertices, &faces, &planes)
}

/// The plane through a line at two levels, the same but for its sign both ways along the line.
fn upright([from, to]: [DVec2; 2], [low, high]: [&Level; 2]) -> Option<Plane> {
    if (from.x, from.y) > (to.x, to.y) {
        let Plane { normal, offset } = upright([to, from], [low, high])?;
        return Some(Plane {
            normal: -normal,
            offset: -offset,
        });
    }
    let places = [(low, from), (low, to), (high, to), (high, from)];
    plane_of(&places.map(|(level, corner)| level.place(corner)))
}

/// The triangles of what contours enclose, counter-clockwise, by the numbers of their corners.
pub(super) fn cap(contours: &[Vec<DVec2>]) -> Option<Vec<[u32; 3]>> {
    let mut names = 0..;
    let named: Vec<Vec<Named>> = contours
        .iter()
        .map(|contour| contour.iter().copied().zip(&mut names).collect())
        .collect();
    let points = contours.iter().flatten();
    let reach = points.fold(0.0, |most, point| point.length().max(most));
    triangulate(&named, ON_FACE * reach, &|| true, &mut Scratch::default())
}

/// What is between two levels, by the triangles of its sides.
fn layer(contours: &[Vec<DVec2>], levels: [&Level; 2], turns_back: bool) -> Solid {
    let [low, high] = levels;
    let mut facets = Vec::new();
    let mut size: f64 = low.z.abs().max(high.z.abs());
    for contour in contours {
        for (k, triangles) in sides(contour, levels, turns_back) {
            let [from, to] = [contour[k], contour[(k + 1) % contour.len()]];
            let corners = [
                low.place(from),
                low.place(to),
                high.place(to),
                high.place(from),
            ];
            size = corners
                .iter()
                .fold(size, |size, p| size.max(p.abs().max_element()));
            for triangle in triangles {
                let points = triangle.map(|at| corners[at]);
                if let Some(plane) = plane_of(&points) {
                    facets.push(Facet {
                        face: facets.len() as u32,
                        plane,
                        corners: points.into(),
                    });
                }
            }
        }
    }
    Solid::intersection([
        Tree::of(&facets, SAME_FACE * size).solid(),
        Solid::half_space_through(low.z * DVec3::Z, -DVec3::Z),
        Solid::half_space_through(high.z * DVec3::Z, DVec3::Z),
    ])
}
