//! Which contours bound one part of a patch together: outlines and the holes in them.

use std::mem::replace;

use glam::{DVec2, DVec3};

use super::chart::{self, Chart};
use super::quadrature;
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
    /// Points of the patch next to it.
    beside: Vec<DVec2>,
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
            let beside = beside(&polygon, chart.turn());
            let area = chart.turn() * area(all, curves, &chart, &half_edges);
            let first = polygon.first().copied().unwrap_or_default();
            let bounds = polygon.iter().fold([first; 2], |[low, high], &point| {
                [low.min(point), high.max(point)]
            });
            Outline {
                half_edges,
                bounds,
                polygon,
                beside,
                area,
            }
        });
        // Where others touch the patch along a line it is slit, and has both sides of that.
        let is_wider_than_rounding =
            |outline: &Outline| outline.area > 4.0 * all.rounding * perimeter(&outline.polygon);
        let (outer, holes): (Vec<Outline>, Vec<Outline>) =
            outlines.partition(is_wider_than_rounding);
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

/// The area that a contour is around, above 0 if that is on its left, to as many digits as tell
/// that: between two arcs next to each other chords would not.
fn area(all: &Arrangement, curves: &Curves, chart: &Chart<'_>, contour: &[HalfEdgeId]) -> f64 {
    const MOST_PANELS: u32 = 64;
    let Some(&first) = contour.first() else {
        return 0.0;
    };
    let flatten = |point: DVec3| chart.flatten(point);
    let about = flatten(all.points[all.at(first).from.index()]);
    let of_panels = |panels: u32| -> f64 {
        let swept = |&half: &HalfEdgeId| {
            let half_edge = all.at(half);
            if half_edge.is_line {
                let [a, b] = all.chord(half_edge).map(flatten);
                return 0.5 * (a - about).perp_dot(b - about);
            }
            let curve = &curves.all[curves.of_half_edge[half.index()] as usize];
            let at = |place: f64| flatten(curve.at(place));
            quadrature::swept(at, half_edge.places, about, panels)
        };
        contour.iter().map(swept).sum()
    };
    let mut panels = 1;
    let mut area = of_panels(panels);
    loop {
        let before = area;
        panels *= 2;
        area = of_panels(panels);
        if (area - before).abs() <= 0.1 * area.abs() || panels >= MOST_PANELS {
            return area;
        }
    }
}

fn perimeter(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a.distance(*b)).sum()
}

/// The smallest of some outlines around a hole.
fn owner(outer: &[Outline], hole: &Outline) -> Option<usize> {
    if outer.len() == 1 {
        return Some(0);
    }
    let around = (0..outer.len()).filter(|&k| is_within(&outer[k], hole));
    around.min_by(|&a, &b| outer[a].area.total_cmp(&outer[b].area))
}

/// Points beside some of a polygon's sides, where the patch is that it bounds: where the solid touches
/// itself the patch may have the same line on its other side.
fn beside(polygon: &[DVec2], turn: f64) -> Vec<DVec2> {
    const MOST: usize = 15;
    /// Of a side's length: far above rounding, and below all that is told from it by chords.
    const NEXT_TO: f64 = 1e-6;
    let step = polygon.len().div_ceil(MOST).max(1);
    let some = (0..polygon.len()).step_by(step);
    some.map(|k| {
        let [a, b] = [k, (k + 1) % polygon.len()].map(|k| polygon[k]);
        a.midpoint(b) + NEXT_TO * turn * (b - a).perp()
    })
    .collect()
}

/// Whether a contour is within another one, with which it may have points in common: most of the
/// patch beside it is.
fn is_within(outer: &Outline, inner: &Outline) -> bool {
    let middle = inner.bounds[0].midpoint(inner.bounds[1]);
    if middle.cmplt(outer.bounds[0]).any() || middle.cmpgt(outer.bounds[1]).any() {
        return false;
    }
    let (mut within, mut outside) = (0, 0);
    for &point in &inner.beside {
        if is_within_polygon(&outer.polygon, point) {
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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::{BoundaryOptions, Program, Solid};

    /// Rods that just touch both sides of a plate from within slit it: along one line, along two
    /// that cross, and from where one ends on to another one.
    #[test]
    fn slits_are_holes() {
        let rod = |from: [f64; 2], degrees: f64| {
            let rod = Solid::cylinder(0.6, 0.0..8.0).rotate_y(0.5 * PI);
            rod.rotate_z(degrees.to_radians())
                .translate([from[0], from[1], 0.0])
        };
        let plate = Solid::cuboid([30.0, 30.0, 1.2]);
        let crossing = rod([-4.0, 0.0], -120.0) | rod([-8.0, 0.0], -60.0);
        let rods = [
            rod([-4.0, 0.0], 17.0),
            crossing.clone(),
            crossing | rod([-4.0, -48f64.sqrt()], 0.0),
        ];
        for (k, rods) in rods.into_iter().enumerate() {
            for turn in [0.0, 0.7] {
                let solid = (plate.clone() - rods.clone()).rotate_x(turn).rotate_z(turn);
                let program = Program::lower(&solid).expect("valid");
                let brep = program.boundary(&BoundaryOptions::new()).expect("told");
                let genera: Vec<usize> = brep.shells().map(|shell| shell.genus()).collect();
                assert_eq!(genera, [1], "{k} {turn}");
                let flat = brep.faces().filter(|face| face.surface().is_plane());
                let loops: Vec<usize> = flat.map(|face| face.loops().len()).collect();
                // Both sides of the plate, of all that are cut.
                let cut: Vec<usize> = loops.into_iter().filter(|&count| count > 1).collect();
                assert_eq!(cut, [2, 2], "{k} {turn}");
            }
        }
    }

    /// A thin shell between a ball and an ellipsoid in any direction, cut into six sectors, no
    /// two of which touch: each plane has four faces between arcs that chords would cross.
    #[test]
    fn faces_between_close_arcs_are_no_holes_in_each_other() {
        for power in 1..8 {
            let thin = 10f64.powi(-power);
            for turn in [0.3, 1.1, 2.3] {
                let radii = [1.0 - thin, 1.0 - 2.0 * thin, 1.0 - 1.5 * thin];
                let inner = Solid::ellipsoid(radii).rotate_x(turn).rotate_z(2.0 * turn);
                let slab =
                    |k: u32| Solid::cuboid([0.3, 4.0, 4.0]).rotate_z(f64::from(k) * PI / 3.0);
                let solid = Solid::sphere(1.0) - inner - slab(0) - slab(1) - slab(2);
                let program = Program::lower(&solid).expect("valid");
                let brep = program.boundary(&BoundaryOptions::new()).expect("told");
                let genera: Vec<usize> = brep.shells().map(|shell| shell.genus()).collect();
                assert_eq!(genera, [0; 6], "{thin} {turn}");
                let mut flat = brep.faces().filter(|face| face.surface().is_plane());
                assert!(flat.all(|face| face.loops().len() == 1), "{thin} {turn}");
            }
        }
    }
}
