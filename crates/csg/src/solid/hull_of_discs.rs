//! Hulls of discs and points in parallel planes: cones and cylinders around two of them, straight
//! or oblique, and planes that touch three.
//!
//! A convex solid is what is behind the planes that touch it along its faces. Here these are planes
//! that touch three discs, each for itself, and planes that touch two, one for each direction in an
//! arc of the circle. What is behind all planes of an arc, as far as it is behind those at both its
//! ends, is the cone around the two discs and all behind the plane through the cone's rulings at
//! both ends: the arc and its chord.
//!
//! Which planes touch two discs at different heights is told by the direction, one angle, that they
//! face along the discs. How far a third disc is beyond them is a constant and a cosine of that angle,
//! so that each third disc leaves an arc.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DAffine3, DMat3, DVec3};

use super::hull::{corners_of_hull, hull_planes};
use super::polyhedron::FEW_FACES;
use super::primitive::Plane;
use super::tree::Solid;
use crate::elementary;
use crate::numeric::tolerance::{ON_FACE, SAME_ANGLE};

/// Of pairs with a disc, each held against all discs and points: less than a second's work.
const MOST_STEPS: usize = 50_000_000;
/// Two discs whose heights differ by less than this much of their distance are not told from two
/// at one height.
const LEAST_RISE: f64 = 1e-5;

impl Solid {
    /// The least convex solid around discs in planes across `normal`, each a centre and a
    /// radius, which may be 0: of planes and of cones and cylinders, straight or oblique. `None` if
    /// all are in one plane, if that would take more than 48 planes and cones, if it cannot be told for
    /// rounding, or if a number is not finite or a radius less than 0.
    #[must_use]
    pub fn hull_of_discs(discs: &[(DVec3, f64)], normal: impl Into<DVec3>) -> Option<Self> {
        let normal: DVec3 = normal.into();
        let axis = normal.try_normalize()?;
        let is_valid = |&(center, radius): &(DVec3, f64)| {
            center.is_finite() && radius.is_finite() && radius >= 0.0
        };
        if !discs.iter().all(is_valid) {
            return None;
        }
        let (x, y) = axis.any_orthonormal_pair();
        let frame = DMat3::from_cols(x, y, axis);
        let back = frame.transpose();
        let discs = discs.iter().map(|&(center, radius)| Disc {
            center: back * center,
            radius,
        });
        let hull = Discs::of(discs.collect())?.hull()?;
        Some(hull.affine(DAffine3::from_mat3(frame)))
    }
}

/// Across the z axis; a point if the radius is 0.
#[derive(Clone, Copy, PartialEq)]
struct Disc {
    center: DVec3,
    radius: f64,
}

impl Disc {
    /// Whether another one is within it.
    fn holds(&self, other: &Self, slack: f64) -> bool {
        let away = (other.center - self.center).truncate().length();
        self.center.z == other.center.z && away + other.radius <= self.radius + slack
    }

    /// How far it reaches along a direction.
    fn reach(&self, along: DVec3) -> f64 {
        along.dot(self.center) + along.truncate().length() * self.radius
    }
}

/// Discs, then points, none within another one.
struct Discs {
    all: Vec<Disc>,
    /// How many are no points.
    round: usize,
    /// Around all.
    within: [DVec3; 2],
    /// Below it lengths are nothing.
    slack: f64,
}

/// A plane that touches three discs, with all others behind it.
struct Facet {
    plane: Plane,
    /// The direction of its normal seen along the z axis.
    angle: f64,
    touched: [usize; 3],
    /// The more, the less it moves with what it is computed of.
    firmness: f64,
}

/// Of the planes that touch two discs those that have all others behind them.
struct Edge {
    pair: [Disc; 2],
    from: f64,
    to: f64,
}

impl Discs {
    fn of(mut discs: Vec<Disc>) -> Option<Self> {
        let [least, greatest] = around(&discs);
        let slack = ON_FACE * least.abs().max(greatest.abs()).max_element();
        if discs.is_empty() || greatest.z - least.z <= slack {
            return None;
        }
        one_for_same(discs.iter_mut().map(|disc| &mut disc.center.z), slack);
        one_for_same(discs.iter_mut().map(|disc| &mut disc.radius), slack);
        let is_round = |disc: &Disc| disc.radius > 0.0;
        let (mut discs, points): (Vec<Disc>, Vec<Disc>) = discs.into_iter().partition(is_round);
        discs.sort_by(|a, b| b.radius.total_cmp(&a.radius));
        let points: Vec<DVec3> = points.iter().map(|point| point.center).collect();
        let radius = 0.0;
        let points = corners_of_hull(&points).unwrap_or(points);
        let points = points.into_iter().map(|center| Disc { center, radius });
        let most = discs.len() + points.len();
        if discs.len().checked_mul(most)?.checked_mul(most)? > MOST_STEPS {
            return None;
        }
        let mut all: Vec<Disc> = Vec::new();
        for disc in discs.into_iter().chain(points) {
            if !all.iter().any(|other| other.holds(&disc, slack)) {
                all.push(disc);
            }
        }
        let round = all.iter().filter(|disc| is_round(disc)).count();
        let within = around(&all);
        Some(Self {
            all,
            round,
            within,
            slack,
        })
    }

    fn hull(&self) -> Option<Solid> {
        let mut facets = self.facets_of_points();
        let mut edges = Vec::new();
        for i in 0..self.round {
            for j in i + 1..self.all.len() {
                self.add([i, j], &mut facets, &mut edges)?;
            }
        }
        let facets = distinct(facets, |facet, plane| self.touches(facet, plane));
        let mut planes: Vec<Plane> = facets.iter().map(|facet| facet.plane).collect();
        planes.extend(self.ends());
        if planes.len() + edges.len() > FEW_FACES {
            return None;
        }
        let height = self.within[0].z..self.within[1].z;
        let settled = |angle: f64| {
            let same = facets.iter().find(|facet| is_same(facet.angle, angle));
            same.map_or(angle, |facet| facet.angle)
        };
        let mut parts: Vec<Solid> = Vec::new();
        if !planes.is_empty() {
            parts.push(Solid::convex_polyhedron(planes));
        }
        for edge in edges {
            let edge = if edge.is_whole() {
                edge
            } else {
                let from = settled(edge.from);
                let turn = (settled(edge.to) - from).rem_euclid(TAU);
                let to = from + turn;
                Edge { from, to, ..edge }
            };
            parts.push(edge.solid(&height));
        }
        let solid = Solid::intersection(parts);
        Some(Solid::made("hull_of_discs", Ok((solid, self.within))))
    }

    /// The planes at both ends that hold more than a point or an edge.
    fn ends(&self) -> impl Iterator<Item = Plane> {
        let heights = [(-1.0, self.within[0].z), (1.0, self.within[1].z)];
        let planes = heights.into_iter().map(|(sign, z)| Plane {
            normal: sign * DVec3::Z,
            offset: sign * z,
        });
        planes.filter(|plane| {
            let on = |disc: &&Disc| plane.normal.z * disc.center.z == plane.offset;
            let on: Vec<&Disc> = self.all.iter().filter(on).collect();
            on.len() > 2 || on.iter().any(|disc| disc.radius > 0.0)
        })
    }

    /// Planes that touch three points and no disc.
    fn facets_of_points(&self) -> Vec<Facet> {
        let points: Vec<DVec3> = self.all[self.round..]
            .iter()
            .map(|point| point.center)
            .collect();
        let planes = match hull_planes(&points) {
            Ok(planes) => planes,
            Err(_) => plane_of(&points),
        };
        let mut facets = Vec::new();
        for plane in planes {
            let reach = |disc: &Disc| disc.reach(plane.normal) - plane.offset;
            let is_behind = self.all[..self.round]
                .iter()
                .all(|disc| reach(disc) <= self.slack);
            if !is_behind || plane.normal.truncate().length() <= SAME_ANGLE {
                continue;
            }
            let mut nearest: Vec<usize> = (self.round..self.all.len()).collect();
            nearest.sort_by(|&a, &b| reach(&self.all[b]).total_cmp(&reach(&self.all[a])));
            if let [a, b, c, ..] = nearest[..] {
                facets.push(Facet {
                    plane,
                    angle: elementary::atan2(plane.normal.y, plane.normal.x),
                    touched: [a, b, c],
                    firmness: f64::INFINITY,
                });
            }
        }
        facets
    }

    /// Adds what two discs are on the hull's boundary.
    fn add(&self, pair: [usize; 2], facets: &mut Vec<Facet>, edges: &mut Vec<Edge>) -> Option<()> {
        let [one, other] = pair.map(|k| self.all[k]);
        let to = other.center - one.center;
        if to.z == 0.0 {
            return Some(());
        }
        for ends in self.free(pair) {
            if to.z.abs() <= LEAST_RISE * (to.length() + one.radius + other.radius) {
                return None;
            }
            for end in ends {
                let Some(third) = end.third else { continue };
                let across = elementary::direction(end.angle);
                let growth = other.radius - one.radius;
                let rise = -(across.dot(to.truncate()) + growth) / to.z;
                let normal = across.extend(rise).normalize();
                facets.push(Facet {
                    plane: Plane {
                        normal,
                        offset: one.reach(normal),
                    },
                    angle: end.angle,
                    touched: [pair[0], pair[1], third],
                    firmness: end.firmness,
                });
            }
            let [from, until] = ends;
            if until.angle - from.angle > same_angle() {
                edges.push(Edge {
                    pair: [one, other],
                    from: from.angle,
                    to: until.angle,
                });
            }
        }
        Some(())
    }

    /// Whether a plane touches what another one does.
    fn touches(&self, facet: &Facet, plane: &Plane) -> bool {
        let off = |&disc: &usize| self.all[disc].reach(plane.normal) - plane.offset;
        facet
            .touched
            .iter()
            .all(|disc| off(disc).abs() <= 10.0 * self.slack)
    }

    /// The arcs in which planes that touch both of two discs have all others behind them.
    fn free(&self, pair: [usize; 2]) -> Vec<[End; 2]> {
        let [one, other] = pair.map(|k| self.all[k]);
        let to = other.center - one.center;
        let growth = other.radius - one.radius;
        let slack = self.slack * (to.abs().element_sum() + growth.abs());
        let mut blocked = Vec::new();
        for (third, disc) in self.all.iter().enumerate() {
            if pair.contains(&third) {
                continue;
            }
            // How far it is beyond the plane, times the height between the two.
            let from = disc.center - one.center;
            let wave = to.z.signum() * (to.z * from.truncate() - from.z * to.truncate());
            let mean = to.z.signum() * (to.z * (disc.radius - one.radius) - from.z * growth);
            let swing = wave.length();
            if mean + swing <= slack {
                continue;
            }
            if mean - swing > slack {
                return Vec::new();
            }
            let half = elementary::acos((-mean / swing).clamp(-1.0, 1.0));
            blocked.push(Blocked {
                middle: elementary::atan2(wave.y, wave.x),
                half,
                third,
                firmness: swing * elementary::sin(half),
            });
        }
        free_between(&blocked)
    }
}

/// Of some facets those that are not others but for rounding.
fn distinct(mut facets: Vec<Facet>, touches: impl Fn(&Facet, &Plane) -> bool) -> Vec<Facet> {
    facets.sort_by(|a, b| b.firmness.total_cmp(&a.firmness));
    let mut kept: Vec<Facet> = Vec::new();
    for facet in facets {
        let is_same = |other: &Facet| {
            other.plane.normal.distance(facet.plane.normal) <= same_angle().sqrt()
                && touches(&facet, &other.plane)
        };
        if !kept.iter().any(is_same) {
            kept.push(facet);
        }
    }
    kept
}

/// Both sides of the plane of points that are in one; none of points in line.
fn plane_of(points: &[DVec3]) -> Vec<Plane> {
    let Some(&first) = points.first() else {
        return Vec::new();
    };
    let crosses = points
        .iter()
        .flat_map(|p| points.iter().map(move |q| (p - first).cross(q - first)));
    let Some(normal) = crosses.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    else {
        return Vec::new();
    };
    let size = points.iter().map(|p| p.distance(first)).fold(0.0, f64::max);
    if normal.length() <= ON_FACE * size * size {
        return Vec::new();
    }
    let normal = normal.normalize();
    [normal, -normal]
        .map(|normal| Plane::through(first, normal))
        .into()
}

/// The corners of a box around discs.
fn around(discs: &[Disc]) -> [DVec3; 2] {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    discs.iter().fold(nothing, |[least, greatest], disc| {
        let across = DVec3::new(disc.radius, disc.radius, 0.0);
        [
            least.min(disc.center - across),
            greatest.max(disc.center + across),
        ]
    })
}

/// Makes numbers that are the same but for rounding one.
fn one_for_same<'a>(numbers: impl Iterator<Item = &'a mut f64>, slack: f64) {
    let mut numbers: Vec<&mut f64> = numbers.collect();
    numbers.sort_by(|a, b| a.total_cmp(b));
    let mut first = f64::NEG_INFINITY;
    for number in numbers {
        if *number - first <= slack {
            *number = first;
        } else {
            first = *number;
        }
    }
}

/// Over a smaller angle an arc is off its tangent by less than a corner may be off its plane.
fn same_angle() -> f64 {
    (2.0 * ON_FACE).sqrt()
}

/// Whether two directions are one but for rounding.
fn is_same(one: f64, other: f64) -> bool {
    let turn = (one - other).rem_euclid(TAU);
    turn.min(TAU - turn) <= same_angle()
}

/// Directions in which a third disc is beyond the planes that touch two others.
struct Blocked {
    middle: f64,
    half: f64,
    third: usize,
    firmness: f64,
}

/// An end of an arc, and the disc that it ends at; none if it is the whole circle.
#[derive(Clone, Copy)]
struct End {
    angle: f64,
    third: Option<usize>,
    firmness: f64,
}

/// What is left of the circle, seen from where one of the arcs that are blocked begins.
fn free_between(blocked: &[Blocked]) -> Vec<[End; 2]> {
    let begin = |blocked: &Blocked| blocked.middle - blocked.half;
    let Some(origin) = blocked.first().map(begin) else {
        let third = None;
        let open = |angle| End {
            angle,
            third,
            firmness: 0.0,
        };
        return vec![[open(0.0), open(TAU)]];
    };
    let mut arcs: Vec<[End; 2]> = Vec::new();
    for blocked in blocked {
        let end = |angle| End {
            angle,
            third: Some(blocked.third),
            firmness: blocked.firmness,
        };
        let from = origin + (begin(blocked) - origin).rem_euclid(TAU);
        let to = from + 2.0 * blocked.half;
        arcs.push([end(from), end(to)]);
        arcs.push([end(from - TAU), end(to - TAU)]);
        arcs.push([end(from + TAU), end(to + TAU)]);
    }
    arcs.sort_by(|a, b| a[0].angle.total_cmp(&b[0].angle));
    let mut free = Vec::new();
    let mut reached: Option<End> = None;
    for [from, to] in arcs {
        if let Some(reached) = reached
            && from.angle > reached.angle
            && (origin..origin + TAU).contains(&reached.angle)
        {
            free.push([reached, from]);
        }
        if reached.is_none_or(|reached| to.angle > reached.angle) {
            reached = Some(to);
        }
    }
    free
}

impl Edge {
    fn is_whole(&self) -> bool {
        self.to - self.from >= TAU - same_angle()
    }

    /// What is behind its planes, of what is behind those at both its ends and between these heights.
    fn solid(&self, height: &Range<f64>) -> Solid {
        let is_wide = self.to - self.from >= PI;
        let cone = cone(self.pair, height, is_wide);
        if self.is_whole() {
            return cone;
        }
        let [one, other] = self.pair;
        let to = other.center - one.center;
        let (middle, half) = (0.5 * (self.from + self.to), 0.5 * (self.to - self.from));
        let across = elementary::direction(middle);
        let share = elementary::cos(half);
        let rise = -(across.dot(to.truncate()) + share * (other.radius - one.radius)) / to.z;
        let on_chord = one.center + (share * one.radius * across).extend(0.0);
        let behind = Solid::half_space_through(on_chord, across.extend(rise));
        Solid::union([cone, behind])
    }
}

/// The cone or cylinder around two discs, at these heights. Its apex, if it is between these, ends it
/// if it is wide; else it goes on into its other half there.
fn cone([one, other]: [Disc; 2], height: &Range<f64>, is_wide: bool) -> Solid {
    let (from, to) = if one.radius < other.radius {
        (one, other)
    } else {
        (other, one)
    };
    let between = to.center - from.center;
    let along = (between.truncate() / between.z).extend(1.0);
    let at = |center: DVec3| DAffine3 {
        matrix3: DMat3::from_cols(DVec3::X, DVec3::Y, along),
        translation: center,
    };
    if from.radius == to.radius {
        return Solid::infinite_cylinder(from.radius).affine(at(from.center));
    }
    let slope = (to.radius - from.radius) / between.z;
    let apex = -from.radius / slope;
    let [low, high] = [height.start, height.end].map(|z| z - from.center.z);
    if !is_wide && low <= apex && apex <= high {
        let coefficients = [1.0, 1.0, -slope * slope, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        return Solid::quadric(coefficients).affine(at(from.center + apex * along));
    }
    let ends = if slope > 0.0 {
        low.max(apex)..high
    } else {
        low..high.min(apex)
    };
    let radius = |z: f64| {
        if z == apex {
            0.0
        } else {
            (from.radius + slope * z).max(0.0)
        }
    };
    Solid::frustum(radius(ends.start), radius(ends.end), ends).affine(at(from.center))
}
