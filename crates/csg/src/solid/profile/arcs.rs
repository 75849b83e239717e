//! Arcs: what a bulge says, chords instead, and segments of discs.

use crate::elementary;
use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DAffine2, DMat2, DVec2};

use super::plane_set::{Leaf, PlaneSet};
use super::{Contour, Corner};
use crate::error::ProfileFault;
use crate::numeric::tolerance::IN_PROFILE;

/// An arc from one point to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub from: DVec2,
    pub to: DVec2,
    pub center: DVec2,
    pub radius: f64,
    /// The angle turned through, counter-clockwise positive.
    pub sweep: f64,
}

impl Arc {
    /// The arc of a bulge that is not zero.
    pub(super) fn new(from: DVec2, to: DVec2, bulge: f64) -> Self {
        let chord = to - from;
        // The centre is (1 - b²) / 4b chords to the left of the chord's middle.
        let left = chord.perp() * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let center = from.midpoint(to) + left;
        let radius = chord.length() * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
        Self {
            from,
            to,
            center,
            radius,
            sweep: 4.0 * elementary::atan(bulge),
        }
    }

    pub(super) fn disc(&self) -> DAffine2 {
        DAffine2::from_scale_angle_translation(DVec2::splat(self.radius), 0.0, self.center)
    }

    /// The point after a share of the arc.
    pub(super) fn at(&self, share: f64) -> DVec2 {
        let turned = elementary::direction(self.sweep * share).rotate(self.from - self.center);
        self.center + turned
    }

    /// The direction of travel after a share of the arc.
    pub(super) fn tangent(&self, share: f64) -> DVec2 {
        let outward = elementary::direction(self.sweep * share).rotate(self.from - self.center);
        (outward.perp() * self.sweep.signum()).normalize_or_zero()
    }

    /// A convex polygon around the arc and its chord, both ends its corners.
    fn around(&self) -> Vec<DVec2> {
        let pieces = (self.sweep.abs() / FRAC_PI_4).ceil().max(1.0);
        let stretch = 1.0 / elementary::cos(0.5 * self.sweep / pieces);
        let mut points = vec![self.from];
        for piece in 0..pieces as usize {
            let middle = self.at((piece as f64 + 0.5) / pieces);
            points.push(self.center + (middle - self.center) * stretch);
        }
        points.push(self.to);
        points
    }

    /// What lies between the arc and its chord.
    pub(super) fn segment(&self) -> PlaneSet {
        // On the right of the chord if the arc turns left.
        let [from, to] = if self.sweep > 0.0 {
            [self.to, self.from]
        } else {
            [self.from, self.to]
        };
        PlaneSet::all(vec![
            PlaneSet::leaf(Leaf::Disc(self.disc())),
            PlaneSet::leaf(Leaf::HalfPlane { from, to }),
        ])
    }
}

/// How far chords may stray from an arc: a length, and a share of its radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sagitta {
    pub length: f64,
    pub of_radius: f64,
}

impl Sagitta {
    pub(crate) const fn of_length(length: f64) -> Self {
        Self {
            length,
            of_radius: 1.0,
        }
    }
}

/// How many chords keep so near to an arc of `sweep` radians.
pub(super) fn chords(radius: f64, sweep: f64, sagitta: Sagitta) -> usize {
    const MOST: f64 = 1e6;
    let share = sagitta.of_radius.min(sagitta.length / radius);
    let half = elementary::acos((1.0 - share).clamp(0.0, 1.0));
    let count = (0.5 * sweep.abs() / half).ceil();
    count.clamp(1.0, MOST) as usize
}

/// The corner after corner k, and the arc between them if there is one.
pub(super) fn side(contour: &[Corner], k: usize) -> (DVec2, Option<Arc>) {
    let Corner { point, bulge } = contour[k];
    let next = contour[(k + 1) % contour.len()].point;
    let arc = (bulge != 0.0).then(|| Arc::new(point, next, bulge));
    (next, arc)
}

/// The contour with the arcs that `keeps` does not want cut into chords that
/// keep so near to them under a map that stretches by `stretch`.
pub(super) fn cut(
    contour: &[Corner],
    stretch: f64,
    sagitta: Sagitta,
    keeps: impl Fn(&Arc) -> bool,
) -> Contour {
    let mut corners = Vec::with_capacity(contour.len());
    for (k, &corner) in contour.iter().enumerate() {
        match side(contour, k).1 {
            Some(arc) if !keeps(&arc) => {
                let count = chords(arc.radius * stretch, arc.sweep, sagitta);
                corners.push(Corner::straight(corner.point));
                let inner = (1..count).map(|i| arc.at(i as f64 / count as f64));
                corners.extend(inner.map(Corner::straight));
            }
            _ => corners.push(corner),
        }
    }
    corners
}

/// The points of a contour, arcs cut finely enough to see what crosses.
pub(super) fn trace(contour: &[Corner]) -> Vec<DVec2> {
    const PIECES_PER_TURN: f64 = 48.0;
    let mut points = Vec::with_capacity(contour.len());
    for (k, corner) in contour.iter().enumerate() {
        points.push(corner.point);
        if let Some(arc) = side(contour, k).1 {
            let count = (arc.sweep.abs() / TAU * PIECES_PER_TURN).ceil() as usize;
            points.extend((1..count).map(|i| arc.at(i as f64 / count as f64)));
        }
    }
    points
}

/// The contour with its arcs cut into arcs whose segments meet nothing else of
/// it: then it encloses what its corners do, with the segments on its outside
/// and without those on its inside.
pub(super) fn parted(mut contour: Contour) -> Result<Contour, ProfileFault> {
    const ROUNDS: usize = 10;
    let size = extent(contour.iter().map(|corner| corner.point));
    for _ in 0..ROUNDS {
        let cut = meeting(&contour, IN_PROFILE * size);
        if !cut.contains(&true) {
            return Ok(contour);
        }
        let mut finer = Vec::with_capacity(2 * contour.len());
        for (k, &corner) in contour.iter().enumerate() {
            match side(&contour, k).1 {
                Some(arc) if cut[k] => {
                    let bulge = elementary::tan(arc.sweep / 8.0);
                    for point in [corner.point, arc.at(0.5)] {
                        finer.push(Corner { point, bulge });
                    }
                }
                _ => finer.push(corner),
            }
        }
        contour = finer;
    }
    let place = meeting(&contour, IN_PROFILE * size)
        .iter()
        .position(|&meets| meets)
        .map_or(DVec2::ZERO, |k| contour[k].point);
    Err(ProfileFault::Crossing { place })
}

fn extent(points: impl Iterator<Item = DVec2>) -> f64 {
    points.fold(0.0, |most, point| point.abs().max_element().max(most))
}

/// Which sides' arcs have segments that overlap another side or its segment.
fn meeting(contour: &[Corner], slack: f64) -> Vec<bool> {
    let around: Vec<Vec<DVec2>> = (0..contour.len())
        .map(|k| match side(contour, k) {
            (_, Some(arc)) => arc.around(),
            (next, None) => vec![contour[k].point, next],
        })
        .collect();
    let boxes: Vec<(DVec2, DVec2)> = around
        .iter()
        .map(|points| {
            let first = (points[0], points[0]);
            let grown = |(min, max): (DVec2, DVec2), &p: &DVec2| (min.min(p), max.max(p));
            points.iter().fold(first, grown)
        })
        .collect();
    let mut meets = vec![false; contour.len()];
    for k in (0..contour.len()).filter(|&k| contour[k].bulge != 0.0) {
        for other in (0..contour.len()).filter(|&other| other != k) {
            let apart = boxes[k].1.cmplt(boxes[other].0) | boxes[other].1.cmplt(boxes[k].0);
            if !apart.any() && overlap(&around[k], &around[other], slack) {
                meets[k] = true;
            }
        }
    }
    meets
}

/// Whether two convex polygons overlap by more than `slack`: no side of either
/// separates them.
fn overlap(a: &[DVec2], b: &[DVec2], slack: f64) -> bool {
    let separates = |one: &[DVec2], other: &[DVec2]| {
        (0..one.len()).any(|k| {
            let (from, to) = (one[k], one[(k + 1) % one.len()]);
            let Some(across) = (to - from).perp().try_normalize() else {
                return false;
            };
            let range = |points: &[DVec2]| {
                points
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |range, p| {
                        let value = across.dot(*p - from);
                        (range.0.min(value), range.1.max(value))
                    })
            };
            let (one, other) = (range(one), range(other));
            one.1 <= other.0 + slack || other.1 <= one.0 + slack
        })
    };
    !(separates(a, b) || separates(b, a))
}

/// Twice the area, arcs included: positive if counter-clockwise.
pub(super) fn doubled_area(contour: &[Corner]) -> f64 {
    let base = contour.first().map_or(DVec2::ZERO, |corner| corner.point);
    (0..contour.len())
        .map(|k| {
            let (next, arc) = side(contour, k);
            let chord = (contour[k].point - base).perp_dot(next - base);
            let segment = arc.map_or(0.0, |arc| {
                arc.radius * arc.radius * (arc.sweep - elementary::sin(arc.sweep))
            });
            chord + segment
        })
        .sum()
}

/// The same contour the other way round.
pub(super) fn reversed(contour: &[Corner]) -> Contour {
    let count = contour.len();
    (0..count)
        .map(|k| Corner {
            point: contour[count - 1 - k].point,
            bulge: -contour[(2 * count - 2 - k) % count].bulge,
        })
        .collect()
}

/// By how much a linear map stretches at most.
pub(super) fn stretch(map: &DMat2) -> f64 {
    let (x, y) = (map.x_axis, map.y_axis);
    let sum = x.length_squared() + y.length_squared();
    let product = map.determinant();
    let difference = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (0.5 * (sum + difference)).sqrt()
}
