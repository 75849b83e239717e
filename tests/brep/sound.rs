//! What holds for every boundary.

use csg::brep::{Coedge, Face};
use csg::{Brep, Program};
use glam::DVec3;
use stereotomy::csg;

/// Panics where a boundary is not one: loops that do not close, edges off their surfaces or
/// vertices. Of points beside its edges the share that are not on the program's boundary.
pub fn assert_sound(brep: &Brep, program: &Program, name: &str) -> f64 {
    let size = size(brep);
    assert_eq!(brep.coedges().len(), 2 * brep.edges().len(), "{name}");
    for face in brep.faces() {
        assert!(face.shell().faces().any(|other| other == face), "{name}");
        for around in face.loops() {
            assert!(around.face() == face, "{name}");
            assert_closed(&around.coedges().collect::<Vec<_>>(), name);
        }
    }
    for edge in brep.edges() {
        let [forward, back] = edge.coedges();
        assert!(forward.twin() == back && back.twin() == forward, "{name}");
        assert!(forward.edge() == edge && back.edge() == edge, "{name}");
        assert!(forward.is_forward() && !back.is_forward(), "{name}");
        let [start, end] = edge.range();
        assert!(start < end, "{name}: {start} {end}");
        let ends = [start, end].map(|t| edge.at(t));
        match edge.vertices() {
            Some(vertices) => {
                for (vertex, end) in vertices.iter().zip(ends) {
                    let off = vertex.point().distance(end);
                    assert!(off <= 1e-8 * size, "{name}: {off:e} at {end}");
                }
            }
            None => assert!(ends[0].distance(ends[1]) <= 1e-8 * size, "{name}"),
        }
        for face in edge.faces() {
            for k in 0..=8 {
                let at = edge.at(start + f64::from(k) / 8.0 * (end - start));
                let off = distance(&face, at);
                assert!(
                    off <= 1e-8 * size,
                    "{name}: {off:e} at {at} {:?}",
                    edge.curve()
                );
            }
        }
    }
    let (mut wrong, mut all) = (0, 0);
    for coedge in brep.coedges() {
        all += 1;
        wrong += usize::from(!is_beside(&coedge, program, size));
    }
    f64::from(wrong as u32) / f64::from(all.max(1))
}

fn assert_closed(around: &[Coedge<'_>], name: &str) {
    let mut before = around[around.len() - 1].vertices().map(|[_, to]| to);
    for coedge in around {
        let [from, to] = match coedge.vertices() {
            Some(ends) => ends.map(Some),
            None => {
                assert_eq!(around.len(), 1, "{name}: a closed edge is alone");
                [None, None]
            }
        };
        assert!(from == before, "{name}");
        before = to;
    }
}

fn size(brep: &Brep) -> f64 {
    let points = brep.faces().flat_map(|face| face.points());
    let largest = points.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    2.0 * largest
}

/// Of a point from a face's surface, to first order.
fn distance(face: &Face<'_>, at: DVec3) -> f64 {
    let surface = face.surface();
    let (value, slope) = (surface.value(at).abs(), surface.gradient(at).length());
    // At an apex f grows with the square.
    value / slope.max(value.sqrt()).max(f64::MIN_POSITIVE)
}

/// Whether the program's boundary is on the left of a coedge, as seen from outside.
fn is_beside(coedge: &Coedge<'_>, program: &Program, size: f64) -> bool {
    let edge = coedge.edge();
    let [start, end] = edge.range();
    // Not in the middle, where symmetric things meet.
    let t = start + 0.471 * (end - start);
    let step = 1e-4 * (end - start);
    let along = (edge.at(t + step) - edge.at(t - step)).normalize_or_zero();
    let along = if coedge.is_forward() { along } else { -along };
    let face = coedge.face();
    let at = edge.at(t);
    let left = face.normal(at).cross(along);
    let surface = face.surface();
    let mut beside = at + 1e-5 * size * left;
    for _ in 0..3 {
        let gradient = surface.gradient(beside);
        beside -= surface.value(beside) / gradient.length_squared() * gradient;
    }
    let normal = 1e-7 * size * face.normal(beside);
    program.contains(beside - normal) && !program.contains(beside + normal)
}
