//! The data of a path: sub-paths of lines, curves and arcs.

use std::f64::consts::{PI, TAU};

use csg::elementary;
use glam::DVec2;
use svgtypes::{PathParser, PathSegment};

use super::super::curves::{LONGEST, Outline, Side, direction};

/// Of its radius, by how much that of half an ellipse may differ from half the distance of its ends, if
/// the decimals do not tell them apart: of one alone, and of two that make a whole one.
const HALF: f64 = 1e-5;
const HALVES: f64 = 1e-2;
/// A sub-path is closed if it ends nearer to its start, as in OpenSCAD.
const CLOSED: f64 = 0.1;

pub(super) struct SubPath {
    pub(super) outline: Outline,
    pub(super) is_open: bool,
}

impl SubPath {
    pub(super) fn closed(outline: Outline) -> Self {
        Self {
            outline,
            is_open: false,
        }
    }

    /// Closed if its ends are near each other.
    pub(super) fn of(outline: Outline) -> Self {
        Self {
            is_open: outline.start.distance(outline.end()) > CLOSED,
            outline,
        }
    }
}

/// The sub-paths of some data, of so many sides at most; arcs that close an ellipse are one if asked to.
pub(super) fn sub_paths(
    data: &str,
    most: usize,
    joins_ellipses: bool,
) -> Result<Vec<SubPath>, String> {
    let mut paths: Vec<SubPath> = Vec::new();
    let mut outline: Option<Outline> = None;
    let mut at = DVec2::ZERO;
    // The control point that a smooth curve mirrors: of cubic curves, and of quadratic ones.
    let mut mirrored: [Option<DVec2>; 2] = [None; 2];
    // Where the arc before began.
    let mut half: Option<(DVec2, Arc)> = None;
    let unit = last_decimal(data);
    let mut finish = |outline: Option<Outline>, is_closed: bool| {
        if let Some(mut outline) = outline.filter(|outline| !outline.sides.is_empty()) {
            outline.join_circle(2.0 * unit);
            if joins_ellipses {
                outline.join_ellipse(2.0 * unit);
            }
            paths.push(if is_closed {
                SubPath::closed(outline)
            } else {
                SubPath::of(outline)
            });
        }
    };
    let mut start = DVec2::ZERO;
    for (count, segment) in (0..).zip(PathParser::from(data)) {
        let segment = segment.map_err(|e| format!("its path data: {e}"))?;
        if count >= most {
            return Err("with it there are too many sides".to_owned());
        }
        let base = if segment.is_abs() { DVec2::ZERO } else { at };
        let point = |x: f64, y: f64| base + DVec2::new(x, y);
        let controls = std::mem::take(&mut mirrored);
        let before = half.take();
        if let PathSegment::MoveTo { x, y, .. } = segment {
            finish(outline.take(), false);
            at = point(x, y);
            start = at;
            continue;
        }
        if let PathSegment::ClosePath { .. } = segment {
            finish(outline.take(), true);
            at = start;
            continue;
        }
        let open = outline.get_or_insert_with(|| Outline::from(at));
        match segment {
            PathSegment::MoveTo { .. } | PathSegment::ClosePath { .. } => {}
            PathSegment::LineTo { x, y, .. } => open.push(Side::Line, point(x, y)),
            PathSegment::HorizontalLineTo { x, .. } => {
                open.push(Side::Line, DVec2::new(base.x + x, at.y));
            }
            PathSegment::VerticalLineTo { y, .. } => {
                open.push(Side::Line, DVec2::new(at.x, base.y + y));
            }
            PathSegment::CurveTo {
                x1,
                y1,
                x2,
                y2,
                x,
                y,
                ..
            } => {
                let second = point(x2, y2);
                open.cubic(point(x1, y1), second, point(x, y));
                mirrored[0] = Some(second);
            }
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                let first = controls[0].map_or(at, |control| 2.0 * at - control);
                let second = point(x2, y2);
                open.cubic(first, second, point(x, y));
                mirrored[0] = Some(second);
            }
            PathSegment::Quadratic { x1, y1, x, y, .. } => {
                let control = point(x1, y1);
                quadratic(open, control, point(x, y));
                mirrored[1] = Some(control);
            }
            PathSegment::SmoothQuadratic { x, y, .. } => {
                let control = controls[1].map_or(at, |control| 2.0 * at - control);
                quadratic(open, control, point(x, y));
                mirrored[1] = Some(control);
            }
            PathSegment::EllipticalArc {
                rx,
                ry,
                x_axis_rotation,
                large_arc,
                sweep,
                x,
                y,
                ..
            } => {
                let this = Arc {
                    radii: DVec2::new(rx, ry).abs(),
                    degrees: x_axis_rotation,
                    is_large: large_arc,
                    is_positive: sweep,
                };
                arc(open, point(x, y), this, unit, before);
                half = Some((at, this));
            }
        }
        at = open.end();
        if !at.is_finite() {
            return Err("its path data: a coordinate is too large".to_owned());
        }
    }
    finish(outline, false);
    Ok(paths)
}

fn quadratic(outline: &mut Outline, control: DVec2, end: DVec2) {
    let controls = [outline.end(), control, end].map(|point| point.extend(1.0));
    outline.push(Side::Bezier(controls.to_vec()), end);
}

/// An `A` command, but for its end.
#[derive(Clone, Copy, PartialEq)]
struct Arc {
    radii: DVec2,
    degrees: f64,
    is_large: bool,
    is_positive: bool,
}

/// Adds an arc; with the one before it if that was the other half of an ellipse.
///
/// Of nearly half an ellipse the centre depends on the last digits of its numbers by their
/// square root: whole circles are written as two halves, whose ends have been rounded. If the radius
/// is half the distance but for two units of the last decimal of the path, and a small share of
/// itself, it is half an ellipse.
fn arc(outline: &mut Outline, end: DVec2, arc: Arc, unit: f64, before: Option<(DVec2, Arc)>) {
    let slack = 2.0 * unit / arc.radii.max_element();
    match before {
        Some((start, other)) if other == arc && start.distance(end) <= 2.0 * unit => {
            let slack = slack.min(HALVES);
            if let Some((_, middle)) = outline.sides.pop() {
                arc.push(outline, middle, slack);
                arc.push(outline, end, slack);
            }
        }
        _ => arc.push(outline, end, slack.min(HALF)),
    }
}

impl Arc {
    /// An arc of an ellipse by its ends (SVG 2, appendix B.2), from where in coordinates of a circle
    /// of radius 1 its ends lie half their distance from the middle.
    fn push(&self, outline: &mut Outline, end: DVec2, slack: f64) {
        let Self {
            radii,
            is_large,
            is_positive,
            ..
        } = *self;
        let start = outline.end();
        if start == end {
            return;
        }
        if radii.min_element() == 0.0 || !radii.is_finite() {
            outline.push(Side::Line, end);
            return;
        }
        let lean = direction(self.degrees);
        let mut axes = [radii.x * lean, radii.y * lean.perp()];
        let half = 0.5 * (start - end);
        let from = DVec2::new(half.dot(lean) / radii.x, half.dot(lean.perp()) / radii.y);
        let share = from.length();
        let sign = if is_positive { 1.0 } else { -1.0 };
        if share >= 1.0 - slack {
            if radii.x == radii.y {
                outline.push(Side::Arc { bulge: sign }, end);
                return;
            }
            axes = axes.map(|axis| share * axis);
            let out = from / share;
            let side = Side::Ellipse {
                center: start.midpoint(end),
                axes,
                from: elementary::atan2(out.y, out.x),
                sweep: sign * PI,
            };
            outline.push(side, end);
            return;
        }
        let rest = ((1.0 - share) * (1.0 + share)).sqrt();
        let angle = 2.0 * elementary::atan2(share, rest);
        let sweep = sign * if is_large { TAU - angle } else { angle };
        if radii.x == radii.y && sweep.abs() <= LONGEST {
            let bulge = elementary::tan(0.25 * sweep);
            outline.push(Side::Arc { bulge }, end);
            return;
        }
        // On the left of the way for a small arc that turns to the left.
        let side = if is_large == is_positive { rest } else { -rest };
        let center = side * from.perp() / share;
        let out = from - center;
        let side = Side::Ellipse {
            center: start.midpoint(end) + center.x * axes[0] + center.y * axes[1],
            axes,
            from: elementary::atan2(out.y, out.x),
            sweep,
        };
        outline.push(side, end);
    }
}

/// The unit of the last decimal that some number in a text has; 0 if they have exponents.
fn last_decimal(text: &str) -> f64 {
    if text.bytes().any(|byte| matches!(byte, b'e' | b'E')) {
        return 0.0;
    }
    let decimals = text
        .split('.')
        .skip(1)
        .map(|part| part.bytes().take_while(u8::is_ascii_digit).count());
    10.0_f64.powi(-(decimals.max().unwrap_or(0).min(300) as i32))
}
