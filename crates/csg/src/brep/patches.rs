//! Which contours bound one part of a patch together: outlines and the holes in them.

use std::mem::replace;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashSet;

use super::chart::{self, Chart};
use crate::arrangement::{Arrangement, Curve, HalfEdgeId, Side};
use crate::program::Surface;
use crate::undecided::{Undecided, Why};

/// A connected part of a patch: its contours, the outline first, each as half-edges.
pub(super) struct Region {
    pub side: Side,
    pub contours: Vec<Vec<HalfEdgeId>>,
}

/// A contour as it is seen.
struct Outline {
    half_edges: Vec<HalfEdgeId>,
    polygon: Vec<DVec2>,
    bounds: [DVec2; 2],
    area: f64,
}

/// The curve of each half-edge, by number, and all curves.
pub(super) struct Curves {
    pub of_half_edge: Vec<u32>,
    pub all: Vec<Curve>,
}

/// All parts of all patches.
pub(super) fn regions(
    all: &Arrangement,
    surfaces: &[Surface],
    curves: &Curves,
) -> Result<Vec<Region>, Undecided> {
    let mut regions = Vec::new();
    for (&side, contours) in all.faces.iter().zip(contours(all)) {
        if contours.is_empty() {
            continue;
        }
        if contours.len() == 1 {
            regions.push(Region { side, contours });
            continue;
        }
        let surface = &surfaces[side.plane];
        let frame = all.frame(side.plane);
        let about = all.points[all.at(contours[0][0]).from.index()];
        let chart = Chart::new(surface, frame, &side, about);
        let outlines = contours.into_iter().map(|half_edges| {
            let polygon = polygon(all, curves, &chart, &half_edges);
            // What is touched along a line goes on on both sides of it.
            let is_slit = {
                let halves: FxHashSet<HalfEdgeId> = half_edges.iter().copied().collect();
                let twin = |half: &HalfEdgeId| all.at(*half).twin;
                half_edges.iter().all(|half| halves.contains(&twin(half)))
            };
            let area = if is_slit {
                0.0
            } else {
                chart.turn() * area(&polygon)
            };
            let first = polygon.first().copied().unwrap_or_default();
            let bounds = polygon.iter().fold([first; 2], |[low, high], &point| {
                [low.min(point), high.max(point)]
            });
            Outline {
                half_edges,
                bounds,
                polygon,
                area,
            }
        });
        let (outer, holes): (Vec<Outline>, Vec<Outline>) =
            outlines.partition(|outline| outline.area > 0.0);
        let first = regions.len();
        let mut owners = Vec::with_capacity(holes.len());
        for hole in &holes {
            let owner = owner(&outer, hole).ok_or_else(|| {
                let at = all.at(hole.half_edges[0]).from;
                Undecided {
                    why: Why::Contour,
                    place: all.points[at.index()],
                }
            })?;
            owners.push(owner);
        }
        regions.extend(outer.into_iter().map(|outline| Region {
            side,
            contours: vec![outline.half_edges],
        }));
        for (owner, hole) in owners.into_iter().zip(holes) {
            regions[first + owner].contours.push(hole.half_edges);
        }
    }
    Ok(regions)
}

/// The half-edges around each face in succession.
fn contours(all: &Arrangement) -> Vec<Vec<Vec<HalfEdgeId>>> {
    let mut of_face = vec![Vec::new(); all.faces.len()];
    let mut seen = vec![false; all.half_edges.len()];
    for start in all.halves() {
        let mut contour = Vec::new();
        let mut at = start;
        while !replace(&mut seen[at.index()], true) {
            contour.push(at);
            at = all.at(at).next;
        }
        if !contour.is_empty() {
            of_face[all.at(start).face.index()].push(contour);
        }
    }
    of_face
}

/// Points of a contour's curves, in order.
fn polygon(
    all: &Arrangement,
    curves: &Curves,
    chart: &Chart<'_>,
    contour: &[HalfEdgeId],
) -> Vec<DVec2> {
    const STEPS: u32 = 4;
    let mut polygon = Vec::with_capacity(contour.len());
    for &half in contour {
        let half_edge = all.at(half);
        let curve = &curves.all[curves.of_half_edge[half.index()] as usize];
        polygon.push(chart.flatten(all.points[half_edge.from.index()]));
        if matches!(curve, Curve::Line { .. }) {
            continue;
        }
        let [from, to] = half_edge.places;
        let between = (1..STEPS).map(|k| f64::from(k) / f64::from(STEPS));
        let points = between.map(|share| curve.at(from + share * (to - from)));
        polygon.extend(points.map(|point: DVec3| chart.flatten(point)));
    }
    polygon
}

fn area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else {
        return 0.0;
    };
    let sides = polygon
        .windows(2)
        .map(|w| (w[0] - first).perp_dot(w[1] - first));
    0.5 * sides.sum::<f64>()
}

/// The smallest of some outlines around a hole.
fn owner(outer: &[Outline], hole: &Outline) -> Option<usize> {
    if outer.len() == 1 {
        return Some(0);
    }
    let around = (0..outer.len()).filter(|&k| is_within(&outer[k], hole));
    around.min_by(|&a, &b| outer[a].area.total_cmp(&outer[b].area))
}

/// Whether a polygon is within another one, with which it may have some points in common: most
/// of its sides' middles are.
fn is_within(outer: &Outline, inner: &Outline) -> bool {
    const MOST: usize = 15;
    let middle = inner.bounds[0].midpoint(inner.bounds[1]);
    if middle.cmplt(outer.bounds[0]).any() || middle.cmpgt(outer.bounds[1]).any() {
        return false;
    }
    let (outer, inner) = (&outer.polygon, &inner.polygon);
    let step = inner.len().div_ceil(MOST);
    let middles = (0..inner.len()).step_by(step).map(|k| {
        let next = (k + 1) % inner.len();
        0.5 * (inner[k] + inner[next])
    });
    let (mut within, mut outside) = (0, 0);
    for point in middles {
        if is_within_polygon(outer, point) {
            within += 1;
        } else {
            outside += 1;
        }
    }
    within > outside
}

fn is_within_polygon(polygon: &[DVec2], point: DVec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let sides = polygon.iter().zip(next).map(|(&a, &b)| [a, b]);
    chart::is_within(sides, point)
}
