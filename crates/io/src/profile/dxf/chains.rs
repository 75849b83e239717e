//! Contours of lines and arcs that meet in their ends.
//!
//! Ends that are near each other are one place. Where an even number of pieces end, they are
//! joined two by two, whichever: by the even-odd rule the contours enclose the same. Where it is odd,
//! one stays open.

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use super::super::Bounds;
use super::super::curves::{Outline, Side};
use super::super::warnings::Warnings;

/// Of the longer side, how far ends may be apart that are joined.
const JOINED: f64 = 1e-5;
/// Of it, what is not told.
const ROUNDING: f64 = 1e-9;

/// Closed outlines, and those of open pieces; what was joined, closed or left out is told.
pub(super) fn contours(
    closed: Vec<Outline>,
    open: Vec<Outline>,
    warnings: &mut Warnings,
) -> Vec<Outline> {
    let whole = || "the drawing".to_owned();
    let mut seen = HashSet::new();
    let mut twice = 0;
    let mut once = |outline: &Outline, is_closed: bool| {
        let is_new = seen.insert(key(outline, is_closed));
        twice += usize::from(!is_new);
        is_new
    };
    let mut closed: Vec<Outline> = closed.into_iter().filter(|o| once(o, true)).collect();
    let open: Vec<Outline> = open.into_iter().filter(|o| once(o, false)).collect();
    if twice > 0 {
        warnings.add(
            whole,
            format!("{twice} lines or contours are drawn twice: they count once"),
        );
    }
    let mut bounds = Bounds::default();
    let ends = open
        .iter()
        .flat_map(|outline| [outline.start, outline.end()]);
    ends.chain(closed.iter().map(|o| o.start))
        .for_each(|point| bounds.add(point));
    let side = bounds
        .0
        .map_or(0.0, |[low, high]| (high - low).max_element());
    let reach = JOINED * side;
    let places = Places::of(&open, reach);
    let mut meeting: Vec<Vec<usize>> = vec![Vec::new(); places.count];
    for (end, &place) in places.of_end.iter().enumerate() {
        meeting[place].push(end);
    }
    // Ends are twice the piece, and one more for the other.
    let mut is_used = vec![false; open.len()];
    let mut widest = (0.0, DVec2::ZERO);
    let mut joints = 0;
    let mut gap: Option<(f64, DVec2, DVec2)> = None;
    let (mut gaps, mut lone) = (0, 0);
    // What has a loose end first, so that nothing is begun in the middle.
    let loose = (0..2 * open.len()).filter(|&end| meeting[places.of_end[end]].len() % 2 == 1);
    let starts: Vec<usize> = loose
        .chain((0..open.len()).map(|piece| 2 * piece))
        .collect();
    for start in starts {
        if is_used[start / 2] {
            continue;
        }
        let oriented = |end: usize| match end % 2 {
            0 => open[end / 2].clone(),
            _ => open[end / 2].reversed(),
        };
        is_used[start / 2] = true;
        let mut chain = oriented(start);
        let mut pieces = 1;
        let home = places.of_end[start];
        let mut here = places.of_end[start ^ 1];
        loop {
            // Back where it began.
            if here == home {
                break;
            }
            let next = pop_unused(&mut meeting[here], &is_used);
            let Some(next) = next else { break };
            is_used[next / 2] = true;
            let piece = oriented(next);
            let apart = chain.end().distance(piece.start);
            if apart > ROUNDING * side {
                joints += 1;
                if apart > widest.0 {
                    widest = (apart, piece.start);
                }
            }
            // Its first point is the last one of what is before it.
            if let Some(last) = chain.sides.last_mut() {
                last.1 = piece.start;
            }
            chain.sides.extend(piece.sides);
            pieces += 1;
            here = places.of_end[next ^ 1];
        }
        let (from, to) = (chain.end(), chain.start);
        let apart = from.distance(to);
        if here == home && (pieces > 1 || apart > 0.0 || chain.sides.len() > 1) {
            if apart > ROUNDING * side {
                joints += 1;
                if apart > widest.0 {
                    widest = (apart, from);
                }
            }
            if let Some(last) = chain.sides.last_mut() {
                last.1 = to;
            }
        } else if chain
            .sides
            .iter()
            .all(|(side, _)| matches!(side, Side::Line))
            && chain.sides.len() == 1
        {
            lone += 1;
            continue;
        } else {
            gaps += 1;
            if gap.is_none_or(|(wide, ..)| apart > wide) {
                gap = Some((apart, from, to));
            }
            chain.push(Side::Line, to);
        }
        closed.push(chain);
    }
    if joints > 0 {
        let (apart, at) = widest;
        let [x, y] = at.to_array();
        warnings.add(whole, format!(
            "{joints} ends that do not meet are joined; the farthest are {apart:.3e} apart, at ({x}, {y})"
        ));
    }
    if let Some((wide, from, to)) = gap {
        let [a, b] = [from, to].map(|point| format!("({}, {})", point.x, point.y));
        warnings.add(whole, format!(
            "{gaps} contours are open, and closed by straight sides; the widest gap is {wide}, from {a} to {b}"
        ));
    }
    if lone > 0 {
        warnings.add(
            whole,
            format!("{lone} lines that meet no other are left out"),
        );
    }
    closed
}

/// Takes ends away until one is of a piece that is not used.
fn pop_unused(ends: &mut Vec<usize>, is_used: &[bool]) -> Option<usize> {
    while let Some(end) = ends.pop() {
        if !is_used[end / 2] {
            return Some(end);
        }
    }
    None
}

/// The same for outlines that are the same, whichever way round.
fn key(outline: &Outline, is_closed: bool) -> Vec<u64> {
    let forward = numbers(outline, is_closed);
    let backward = numbers(&outline.reversed(), is_closed);
    forward.min(backward)
}

fn numbers(outline: &Outline, is_closed: bool) -> Vec<u64> {
    let mut numbers = vec![u64::from(is_closed)];
    let mut add = |values: &[f64]| {
        // (0 and -0 are one.)
        numbers.extend(values.iter().map(|value| (value + 0.0).to_bits()));
    };
    add(&outline.start.to_array());
    for (side, end) in &outline.sides {
        match side {
            Side::Line => add(&[0.0]),
            Side::Arc { bulge } => add(&[1.0, *bulge]),
            Side::Ellipse {
                center,
                axes,
                sweep,
                ..
            } => {
                add(&[
                    2.0, center.x, center.y, axes[0].x, axes[0].y, axes[1].x, axes[1].y, *sweep,
                ]);
            }
            Side::Bezier(controls) => {
                add(&[3.0]);
                controls.iter().for_each(|control| add(&control.to_array()));
            }
        }
        add(&end.to_array());
    }
    numbers
}

/// Which ends are at one place.
struct Places {
    count: usize,
    of_end: Vec<usize>,
}

impl Places {
    /// By a grid of cells as wide as ends may be apart: an end takes the place of the first one that is
    /// so near.
    fn of(open: &[Outline], reach: f64) -> Self {
        let mut places: Vec<DVec2> = Vec::new();
        let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
        let mut of_end = Vec::with_capacity(2 * open.len());
        let width = if reach > 0.0 { reach } else { 1.0 };
        for point in open
            .iter()
            .flat_map(|outline| [outline.start, outline.end()])
        {
            let [x, y] = (point / width).floor().to_array().map(|v| v as i64);
            let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [i, j]));
            let found = around
                .filter_map(|[i, j]| cells.get(&[x.saturating_add(i), y.saturating_add(j)]))
                .flatten()
                .map(|&place| (places[place].distance(point), place))
                .filter(|(apart, _)| *apart <= reach)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            of_end.push(match found {
                Some((_, place)) => place,
                None => {
                    cells.entry([x, y]).or_default().push(places.len());
                    places.push(point);
                    places.len() - 1
                }
            });
        }
        Self {
            count: places.len(),
            of_end,
        }
    }
}
