//! Whole ellipses that cross nothing: kept as such, with what is in them and what is around.
//!
//! By the even-odd rule an ellipse turns all that is in it inside out. Where nothing crosses it, that
//! is to add it, without what the contours in it enclose, if an even number of contours is around
//! it, and else to take it away.

use csg::FillRule;
use glam::{DAffine2, DMat2, DVec2};

use super::curves::{Cutting, Outline, Side, is_circle};
use super::{Figure, Step};

/// Of an ellipse's radii, how near others may come to it.
const MARGIN: f64 = 1e-2;
/// Of them, how far chords stray from others in telling that.
const CHORD: f64 = 1e-3;
/// The most sides, for each ellipse, that are held against it: those of others are cut into chords.
const MOST: usize = 1 << 22;
/// Ellipses in each other beyond this are cut into chords.
const DEEPEST: usize = 16;

/// What outlines enclose by the even-odd rule.
pub(super) fn by_ellipses(mut outlines: Vec<Outline>, depth: usize) -> Vec<Step> {
    let mut ellipses = Vec::new();
    outlines
        .iter_mut()
        .for_each(|outline| outline.join_ellipse(0.0));
    let count = outlines.iter().filter_map(ellipse).count();
    let sides: usize = outlines.iter().map(|outline| outline.sides.len()).sum();
    if depth < DEEPEST && count.saturating_mul(sides) <= MOST {
        let mut k = 0;
        while k < outlines.len() {
            let map = ellipse(&outlines[k]);
            match map.and_then(|map| Some((map, parted(&outlines, k, &map)?))) {
                Some((map, (is_inside, is_hole))) => {
                    let mut is_inside = is_inside.into_iter();
                    let mut is_in = || is_inside.next().unwrap_or(false);
                    let (mut within, mut around) = (Vec::new(), Vec::new());
                    // (From the next on: those before it have been looked at.)
                    let mut next = k;
                    for (j, outline) in outlines.into_iter().enumerate() {
                        match (j == k, is_in()) {
                            (true, _) => {}
                            (false, true) => {
                                within.push(outline);
                                next -= usize::from(j < k);
                            }
                            (false, false) => around.push(outline),
                        }
                    }
                    let figure = Figure::Disc(map, by_ellipses(within, depth + 1));
                    ellipses.push(Step { figure, is_hole });
                    (outlines, k) = (around, next);
                }
                None => k += 1,
            }
        }
    }
    let mut steps = vec![Step::added(Figure::Contours(outlines, FillRule::EvenOdd))];
    // What was told first was told of all others.
    steps.extend(ellipses.into_iter().rev());
    steps
}

/// The map of the circle of radius 1 to an outline that is one whole ellipse, but no circle.
fn ellipse(outline: &Outline) -> Option<DAffine2> {
    match outline.sides[..] {
        [(Side::Ellipse { center, axes, .. }, end)] if end == outline.start && !is_circle(axes) => {
            Some(DAffine2 {
                matrix2: DMat2::from_cols(axes[0], axes[1]),
                translation: center,
            })
        }
        _ => None,
    }
}

/// Which outlines lie in an ellipse, which is one of them, and whether an odd number of the others is
/// around it; none if some may cross it.
fn parted(outlines: &[Outline], own: usize, map: &DAffine2) -> Option<(Vec<bool>, bool)> {
    let back = map.inverse();
    if !back.is_finite() {
        return None;
    }
    let mut cutting = Cutting::within(CHORD);
    let mut is_inside = Vec::with_capacity(outlines.len());
    let mut is_hole = false;
    for (k, outline) in outlines.iter().enumerate() {
        if k == own {
            is_inside.push(false);
            continue;
        }
        let chords = cutting.chords_of(&outline.mapped(&back))?;
        let mut range = [f64::INFINITY, 0.0_f64];
        let mut is_around = false;
        let next = chords.iter().cycle().skip(1);
        for (&a, &b) in chords.iter().zip(next) {
            range = [range[0].min(distance(a, b)), range[1].max(a.length())];
            // The ray from the centre along x.
            let crosses = (a.y > 0.0) != (b.y > 0.0);
            is_around ^= crosses && (a.perp_dot(b) > 0.0) == (b.y > a.y);
        }
        if range[1] < 1.0 - MARGIN {
            is_inside.push(true);
        } else if range[0] > 1.0 + MARGIN {
            is_inside.push(false);
            is_hole ^= is_around;
        } else {
            return None;
        }
    }
    Some((is_inside, is_hole))
}

/// How far a segment is from the origin.
fn distance(a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    let share = if square > 0.0 {
        (-a.dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + share * along).length()
}
