//! Contours of lines, arcs and curves, and what becomes of them: lines, arcs of circles and parabolas.

use csg::elementary;
use std::f64::consts::{PI, TAU};

use csg::Path;
use glam::{DAffine2, DMat2, DVec2, DVec3};

use super::MOST_SIDES;
use crate::scene::Fineness;

/// Of its radius, by how much a circle may be an ellipse, or an axis off the other's normal, that
/// only rounding makes so.
const ROUND: f64 = 1e-12;
/// An arc is not one side beyond this: its centre would depend on rounding.
pub(super) const LONGEST: f64 = 1.5 * PI;
/// The most that a curve is halved: into 65,536 chords.
const DEEPEST: u32 = 16;

/// How a contour goes on to its next point.
#[derive(Clone, Debug)]
pub(super) enum Side {
    Line,
    /// The tangent of a quarter of the angle turned through, from x towards y positive.
    Arc {
        bulge: f64,
    },
    /// The points `center + cos t a + sin t b`.
    Ellipse {
        center: DVec2,
        axes: [DVec2; 2],
        from: f64,
        sweep: f64,
    },
    /// Control points of a rational Bézier curve, times their weights, and these; ends included.
    Bezier(Vec<DVec3>),
}

/// Sides that follow each other.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub(super) start: DVec2,
    pub(super) sides: Vec<(Side, DVec2)>,
}

impl Outline {
    pub(super) fn from(start: DVec2) -> Self {
        Self {
            start,
            sides: Vec::new(),
        }
    }

    /// Closed, of straight sides.
    pub(super) fn polygon(points: &[DVec2]) -> Self {
        let mut outline = Self::from(points.first().copied().unwrap_or_default());
        let rest = points.iter().skip(1).chain(points.first());
        rest.for_each(|&point| outline.push(Side::Line, point));
        outline
    }

    pub(super) fn push(&mut self, side: Side, end: DVec2) {
        self.sides.push((side, end));
    }

    /// Three and more arcs that make a whole circle but for the decimals of their ends become two
    /// halves of one, about the mean of their centres.
    pub(super) fn join_circle(&mut self, slack: f64) {
        let mut start = self.start;
        let mut arcs = Vec::with_capacity(self.sides.len());
        for (side, end) in &self.sides {
            let Side::Arc { bulge } = *side else {
                return;
            };
            let center = arc_center(start, *end, bulge);
            let radius = 0.5 * (center.distance(start) + center.distance(*end));
            arcs.push((center, radius, 4.0 * elementary::atan(bulge)));
            start = *end;
        }
        let count = arcs.len() as f64;
        let mean = |sum: f64| sum / count;
        let center = arcs.iter().map(|arc| arc.0).sum::<DVec2>() / count;
        let radius = mean(arcs.iter().map(|arc| arc.1).sum());
        let turn: f64 = arcs.iter().map(|arc| arc.2).sum();
        let is_one = arcs.iter().all(|(about, own, _)| {
            about.distance(center) <= slack && (own - radius).abs() <= slack
        });
        // (The ends of a whole turn are as near as points are rounded.)
        let is_whole =
            (turn.abs() - TAU).abs() * radius <= slack && start.distance(self.start) <= slack;
        if arcs.len() > 2 && is_one && is_whole {
            let out = radius * (self.start - center).normalize_or(DVec2::X);
            let half = Side::Arc {
                bulge: turn.signum(),
            };
            self.start = center + out;
            self.sides = vec![(half.clone(), center - out), (half, center + out)];
        }
    }

    /// Arcs that make a whole ellipse, but for how far their axes, centres and ends may be off, become
    /// one, about the mean of their centres.
    pub(super) fn join_ellipse(&mut self, slack: f64) {
        let [
            (
                Side::Ellipse {
                    center, axes, from, ..
                },
                _,
            ),
            _,
            ..,
        ] = self.sides[..]
        else {
            return;
        };
        let matrix = |[a, b]: [DVec2; 2]| DMat2::from_cols(a, b);
        let back = matrix(axes).inverse();
        let longest = longest_axis(axes);
        let shortest = matrix(axes).determinant().abs() / longest;
        let slack = slack + ROUND * (longest + center.length());
        let (mut turn, mut centers) = (0.0, DVec2::ZERO);
        for (side, _) in &self.sides {
            let Side::Ellipse {
                center: about,
                axes,
                sweep,
                ..
            } = *side
            else {
                return;
            };
            // One ellipse if the first one's circle is turned or mirrored between them.
            let between = back * matrix(axes);
            let off = (between.transpose() * between - DMat2::IDENTITY).to_cols_array();
            let is_one = off
                .into_iter()
                .all(|off| off.abs() * shortest <= 2.0 * slack);
            if !is_one || about.distance(center) > slack {
                return;
            }
            turn += sweep * between.determinant().signum();
            centers += about;
        }
        let is_whole = (turn.abs() - TAU).abs() * shortest <= slack;
        if is_whole && self.end().distance(self.start) <= slack {
            let center = centers / self.sides.len() as f64;
            let sweep = TAU.copysign(turn);
            self.start = on_ellipse(center, axes, from);
            let whole = Side::Ellipse {
                center,
                axes,
                from,
                sweep,
            };
            self.sides = vec![(whole, self.start)];
        }
    }

    /// A cubic Bézier curve.
    pub(super) fn cubic(&mut self, first: DVec2, second: DVec2, end: DVec2) {
        let controls = [self.end(), first, second, end].map(|point| point.extend(1.0));
        self.push(Side::Bezier(controls.to_vec()), end);
    }

    pub(super) fn end(&self) -> DVec2 {
        self.sides.last().map_or(self.start, |(_, end)| *end)
    }

    /// Points whose hull holds it.
    pub(super) fn hull(&self) -> impl Iterator<Item = DVec2> {
        let mut from = self.start;
        let sides = self.sides.iter().flat_map(move |(side, end)| {
            let points = match side {
                Side::Line => Vec::new(),
                Side::Arc { bulge } => arc_extremes(from, *end, *bulge).collect(),
                Side::Ellipse {
                    center,
                    axes,
                    from,
                    sweep,
                } => extremes(*center, *axes, *from, *sweep).collect(),
                Side::Bezier(controls) => controls.iter().map(|c| c.truncate() / c.z).collect(),
            };
            from = *end;
            points.into_iter().chain([*end])
        });
        std::iter::once(self.start).chain(sides)
    }

    /// The image under a map: arcs stay such where it keeps circles.
    pub(super) fn mapped(&self, map: &DAffine2) -> Self {
        let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
        let keeps_circles = is_circle([x, y]);
        let turn = map.matrix2.determinant().signum();
        let mut image = Self::from(map.transform_point2(self.start));
        let mut from = self.start;
        for (side, end) in &self.sides {
            let ellipse = |center: DVec2, axes: [DVec2; 2], from, sweep| Side::Ellipse {
                center: map.transform_point2(center),
                axes: axes.map(|axis| map.transform_vector2(axis)),
                from,
                sweep,
            };
            let side = match side {
                Side::Line => Side::Line,
                Side::Arc { bulge } if keeps_circles => Side::Arc {
                    bulge: turn * bulge,
                },
                Side::Arc { bulge } => {
                    let center = arc_center(from, *end, *bulge);
                    let axis = from - center;
                    ellipse(
                        center,
                        [axis, axis.perp()],
                        0.0,
                        4.0 * elementary::atan(*bulge),
                    )
                }
                Side::Ellipse {
                    center,
                    axes,
                    from,
                    sweep,
                } => ellipse(*center, *axes, *from, *sweep),
                Side::Bezier(controls) => Side::Bezier(
                    controls
                        .iter()
                        .map(|control| {
                            let linear = map.matrix2 * control.truncate();
                            (linear + control.z * map.translation).extend(control.z)
                        })
                        .collect(),
                ),
            };
            image.push(side, map.transform_point2(*end));
            from = *end;
        }
        image
    }

    /// The other way round.
    pub(super) fn reversed(&self) -> Self {
        let mut reversed = Self::from(self.end());
        let starts = std::iter::once(self.start).chain(self.sides.iter().map(|(_, end)| *end));
        let starts: Vec<DVec2> = starts.collect();
        for ((side, _), start) in self.sides.iter().zip(starts).rev() {
            let side = match side {
                Side::Line => Side::Line,
                Side::Arc { bulge } => Side::Arc { bulge: -bulge },
                Side::Ellipse {
                    center,
                    axes,
                    from,
                    sweep,
                } => Side::Ellipse {
                    center: *center,
                    axes: *axes,
                    from: from + sweep,
                    sweep: -sweep,
                },
                Side::Bezier(controls) => Side::Bezier(controls.iter().rev().copied().collect()),
            };
            reversed.push(side, start);
        }
        reversed
    }
}

/// The centre is (1 - b²) / 4b chords to the left of the chord's middle.
fn arc_center(from: DVec2, to: DVec2, bulge: f64) -> DVec2 {
    from.midpoint(to) + (to - from).perp() * ((1.0 - bulge * bulge) / (4.0 * bulge))
}

/// Where an arc of an ellipse has its least and greatest coordinates, but for its ends.
fn extremes(center: DVec2, axes: [DVec2; 2], from: f64, sweep: f64) -> impl Iterator<Item = DVec2> {
    let [a, b] = axes;
    let x = elementary::atan2(b.x, a.x);
    let y = elementary::atan2(b.y, a.y);
    let passed = move |t: &f64| {
        let after = if sweep > 0.0 { t - from } else { from - t };
        after.rem_euclid(TAU) < sweep.abs()
    };
    let places = [x, x + PI, y, y + PI].into_iter().filter(passed);
    places.map(move |t| on_ellipse(center, axes, t))
}

fn arc_extremes(from: DVec2, to: DVec2, bulge: f64) -> impl Iterator<Item = DVec2> {
    let center = arc_center(from, to, bulge);
    let axis = from - center;
    extremes(
        center,
        [axis, axis.perp()],
        0.0,
        4.0 * elementary::atan(bulge),
    )
}

fn on_ellipse(center: DVec2, [a, b]: [DVec2; 2], t: f64) -> DVec2 {
    let direction = elementary::direction(t);
    center + direction.x * a + direction.y * b
}

/// A corner, and how the side to the next one bends.
pub(super) type Loop = Vec<(DVec2, Bend)>;

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Bend {
    Straight,
    /// An arc, by its bulge.
    Arc(f64),
    /// A quadratic Bézier curve, by its control point.
    Quadratic(DVec2),
}

/// How curves are cut into chords.
#[derive(Clone, Copy)]
pub(super) struct Cutting {
    pub(super) tolerance: f64,
    /// As OpenSCAD does, and arcs too.
    pub(super) fineness: Option<Fineness>,
    /// OpenSCAD has other numbers there.
    pub(super) of_svg: bool,
    pub(super) sides: usize,
    pub(super) has_cut: bool,
}

impl Cutting {
    /// As chords within a tolerance.
    pub(super) fn within(tolerance: f64) -> Self {
        Self {
            tolerance,
            fineness: None,
            of_svg: false,
            sides: 0,
            has_cut: false,
        }
    }

    /// The corners of chords for all sides of a closed outline; `None` if there are too many.
    pub(super) fn chords_of(&mut self, outline: &Outline) -> Option<Vec<DVec2>> {
        let corners = self.contour(outline)?.unwrap_or_default();
        let mut points = Vec::with_capacity(corners.len());
        for (k, &(point, bend)) in corners.iter().enumerate() {
            let mut chords = Loop::new();
            let end = corners[(k + 1) % corners.len()].0;
            match bend {
                Bend::Straight => chords.push((point, Bend::Straight)),
                Bend::Arc(bulge) => {
                    let center = arc_center(point, end, bulge);
                    let axis = point - center;
                    let sweep = 4.0 * elementary::atan(bulge);
                    self.chords(
                        point,
                        (center, [axis, axis.perp()]),
                        [0.0, sweep],
                        &mut chords,
                    );
                }
                Bend::Quadratic(control) => {
                    let controls = [point, control, end].map(|point| point.extend(1.0));
                    chords.push((point, Bend::Straight));
                    self.halve(&controls, DEEPEST, &mut chords);
                }
            }
            points.extend(chords.into_iter().map(|(point, _)| point));
        }
        Some(points)
    }

    /// The outline as lines, arcs and parabolas, closed; none where it encloses nothing. `None` if there
    /// are too many sides.
    pub(super) fn contour(&mut self, outline: &Outline) -> Option<Option<Loop>> {
        let mut corners: Loop = Vec::with_capacity(outline.sides.len());
        let mut at = outline.start;
        for (side, end) in &outline.sides {
            self.side(at, side, *end, &mut corners);
            if self.sides + corners.len() > MOST_SIDES {
                return None;
            }
            at = *end;
        }
        if at != outline.start {
            corners.push((at, Bend::Straight));
        }
        // Sides without a length.
        let count = corners.len();
        let is_side = |k: usize| corners[k].0 != corners[(k + 1) % count].0;
        let kept: Loop = (0..count)
            .filter(|&k| is_side(k))
            .map(|k| corners[k])
            .collect();
        self.sides += kept.len();
        let is_bent = kept.iter().any(|(_, bend)| *bend != Bend::Straight);
        let least = if is_bent { 2 } else { 3 };
        Some((kept.len() >= least).then_some(kept))
    }

    /// A disc, if it is to be cut.
    pub(super) fn disc(&mut self, map: &DAffine2) -> Option<Loop> {
        let fineness = self.fineness?;
        let [x, y] = [map.matrix2.x_axis, map.matrix2.y_axis];
        // (OpenSCAD's radius is that before any map of SVG; the longer one is here what it comes to.)
        let fragments = fineness.fragments(x.length().max(y.length()));
        let count = bounded(if self.of_svg {
            fragments.max(40.0)
        } else {
            fragments
        });
        self.sides += count;
        // (In SVG from y on, towards x.)
        let corner = |k: usize| {
            let turn = if self.of_svg {
                let turn = csg::turn(k + 1, count);
                DVec2::new(turn.y, turn.x)
            } else {
                csg::turn(k, count)
            };
            (map.transform_point2(turn), Bend::Straight)
        };
        Some((0..count).map(corner).collect())
    }

    /// Adds corners from the side's start on, without its end.
    fn side(&mut self, start: DVec2, side: &Side, end: DVec2, corners: &mut Loop) {
        match side {
            Side::Line => corners.push((start, Bend::Straight)),
            Side::Arc { bulge } if *bulge == 0.0 => corners.push((start, Bend::Straight)),
            Side::Arc { bulge } if self.fineness.is_some() => {
                let center = arc_center(start, end, *bulge);
                let axis = start - center;
                let sweep = 4.0 * elementary::atan(*bulge);
                self.chords(start, (center, [axis, axis.perp()]), [0.0, sweep], corners);
            }
            Side::Arc { bulge } => corners.push((start, Bend::Arc(*bulge))),
            Side::Ellipse {
                center,
                axes: [a, b],
                from,
                sweep,
            } => {
                let axes = [*a, *b];
                match circle_turn(axes) {
                    Some(turn) if self.fineness.is_none() => {
                        let parts = if sweep.abs() > LONGEST { 2 } else { 1 };
                        let part = sweep / f64::from(parts);
                        for k in 0..parts {
                            let at = match k {
                                0 => start,
                                _ => on_ellipse(*center, axes, from + part * f64::from(k)),
                            };
                            corners.push((at, Bend::Arc(turn * elementary::tan(0.25 * part))));
                        }
                    }
                    _ => self.chords(start, (*center, axes), [*from, *sweep], corners),
                }
            }
            Side::Bezier(controls) => match self.fineness {
                Some(fineness) => {
                    let count = bounded(fineness.number.max(20.0));
                    corners.push((start, Bend::Straight));
                    let inner = (1..count).map(|k| k as f64 / count as f64);
                    corners.extend(inner.map(|t| (halves(controls, t).2, Bend::Straight)));
                }
                None => match quadratic(controls) {
                    Some(control) => corners.push((start, Bend::Quadratic(control))),
                    None => {
                        let chords = corners.len();
                        corners.push((start, Bend::Straight));
                        self.halve(controls, DEEPEST, corners);
                        self.has_cut |= corners.len() > chords + 1;
                    }
                },
            },
        }
    }

    fn chords(
        &mut self,
        start: DVec2,
        (center, axes): (DVec2, [DVec2; 2]),
        [from, sweep]: [f64; 2],
        corners: &mut Loop,
    ) {
        let count = match self.fineness {
            Some(fineness) => {
                let radius = axes[0].length().max(axes[1].length());
                let share = sweep.abs() / TAU;
                let count = (fineness.fragments(radius) * share).ceil();
                if self.of_svg {
                    count.max((20.0 * share + 4.0).floor())
                } else {
                    count
                }
            }
            None => {
                self.has_cut = true;
                let longest = longest_axis(axes);
                let share = (self.tolerance / longest).min(1.0);
                (0.5 * sweep.abs() / elementary::acos(1.0 - share)).ceil()
            }
        };
        let count = bounded(count);
        corners.push((start, Bend::Straight));
        let inner = (1..count).map(|k| from + sweep * (k as f64 / count as f64));
        corners.extend(inner.map(|t| (on_ellipse(center, axes, t), Bend::Straight)));
    }

    /// Adds the inner corners of chords: the curve is in the hull of its control points, and so no
    /// farther from a chord than these. Halves by de Casteljau's algorithm.
    fn halve(&self, controls: &[DVec3], depth: u32, corners: &mut Loop) {
        let point = |control: &DVec3| control.truncate() / control.z;
        let [Some(first), Some(last)] = [controls.first(), controls.last()] else {
            return;
        };
        let [a, b] = [first, last].map(point);
        let along = b - a;
        let square = along.length_squared();
        let far = controls.iter().any(|control| {
            let from = point(control) - a;
            let share = if square > 0.0 {
                (from.dot(along) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            from.distance(share * along) > self.tolerance
        });
        if !far || depth == 0 || self.sides + corners.len() > MOST_SIDES {
            return;
        }
        let (left, right, middle) = halves(controls, 0.5);
        self.halve(&left, depth - 1, corners);
        corners.push((middle, Bend::Straight));
        self.halve(&right, depth - 1, corners);
    }
}

/// (cos, sin) of an angle in degrees, exact at multiples of 90.
pub(super) fn direction(degrees: f64) -> DVec2 {
    let turned = degrees.rem_euclid(360.0);
    match turned {
        0.0 => DVec2::X,
        90.0 => DVec2::Y,
        180.0 => DVec2::NEG_X,
        270.0 => DVec2::NEG_Y,
        _ => elementary::direction(turned * (PI / 180.0)),
    }
}

/// Whether conjugate axes are those of a circle, but for rounding.
pub(super) fn is_circle(axes: [DVec2; 2]) -> bool {
    circle_turn(axes).is_some()
}

/// Of conjugate axes of a circle, 1 if the second is counter-clockwise from the first, or else -1.
fn circle_turn([a, b]: [DVec2; 2]) -> Option<f64> {
    let reach = ROUND * a.length();
    let turns = [1.0, -1.0].into_iter();
    let mut same = turns.filter(|turn| b.abs_diff_eq(turn * a.perp(), reach));
    same.next()
}

/// The control points of both parts of a curve, and the point where it is cut.
fn halves(controls: &[DVec3], t: f64) -> (Vec<DVec3>, Vec<DVec3>, DVec2) {
    let mut row = controls.to_vec();
    let (mut left, mut right) = (Vec::with_capacity(row.len()), Vec::with_capacity(row.len()));
    while let (Some(&first), Some(&last)) = (row.first(), row.last()) {
        left.push(first);
        right.push(last);
        row = row
            .windows(2)
            .map(|pair| pair[0].lerp(pair[1], t))
            .collect();
    }
    right.reverse();
    let middle = right.first().copied().unwrap_or(DVec3::Z);
    (left, right, middle.truncate() / middle.z)
}

/// The greatest radius of an ellipse that is told by conjugate axes: the root of the greater
/// eigenvalue of a aᵀ + b bᵀ.
fn longest_axis([a, b]: [DVec2; 2]) -> f64 {
    let sum = a.length_squared() + b.length_squared();
    let area = a.perp_dot(b);
    let root = (sum * sum - 4.0 * area * area).max(0.0).sqrt();
    (0.5 * (sum + root)).sqrt()
}

fn bounded(count: f64) -> usize {
    count.clamp(1.0, 1e5) as usize
}

/// The control point of a quadratic curve without weights.
fn quadratic(controls: &[DVec3]) -> Option<DVec2> {
    match controls {
        [first, control, last] if first.z == control.z && control.z == last.z => {
            Some(control.truncate() / control.z)
        }
        _ => None,
    }
}

/// Points whose bounds are those of a contour.
pub(super) fn loop_bounds(corners: &Loop) -> Vec<DVec2> {
    let mut points = Vec::with_capacity(corners.len());
    for (k, &(point, bend)) in corners.iter().enumerate() {
        let end = corners[(k + 1) % corners.len()].0;
        points.push(point);
        match bend {
            Bend::Straight => {}
            Bend::Arc(bulge) => points.extend(arc_extremes(point, end, bulge)),
            Bend::Quadratic(control) => points.extend(quadratic_extremes(point, control, end)),
        }
    }
    points
}

/// Where a quadratic curve turns back in x or y.
fn quadratic_extremes(start: DVec2, control: DVec2, end: DVec2) -> impl Iterator<Item = DVec2> {
    // The derivative is (1 - t) (control - start) + t (end - control), twice.
    let (first, last) = (control - start, end - control);
    let turns = (first / (first - last)).to_array().into_iter();
    let turns = turns.filter(|t| *t > 0.0 && *t < 1.0);
    turns.map(move |t| start.lerp(control, t).lerp(control.lerp(end, t), t))
}

pub(super) fn loop_path(corners: &Loop) -> Path {
    let first = corners.first().map_or(DVec2::ZERO, |(point, _)| *point);
    let mut path = Path::from(first);
    for (k, &(_, bend)) in corners.iter().enumerate() {
        let next = corners[(k + 1) % corners.len()].0;
        path = match bend {
            Bend::Straight => path.line_to(next),
            Bend::Arc(bulge) => path.bulge_to(next, bulge),
            Bend::Quadratic(control) => path.quadratic_to(control, next),
        };
    }
    path
}
