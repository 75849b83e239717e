//! Points that are nearer to each other than rounding tells become one.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::contacts::Contact;
use super::ids::VertexId;
use super::piece::Piece;
use super::scene::Scene;
use crate::numeric::Welder;
use crate::program::Surface;
use crate::surface::solve;
use crate::undecided::Stop;

/// Of the distances that rounding makes: farther from a surface a point is off it.
const OFF: f64 = 100.0;

/// The vertices of all pieces.
pub(super) struct Welded {
    pub points: Vec<DVec3>,
    /// The two that each piece joins.
    pub ends: Vec<[VertexId; 2]>,
}

/// Finds the vertices of pieces, and moves contacts to those at the same places.
/// Ends early only if the caller does not want to go on.
pub(super) fn weld(
    scene: &Scene<'_>,
    pieces: &[Piece],
    contacts: &mut [Contact],
) -> Result<Welded, Stop> {
    let mut welder = Welder::new(scene.weld);
    // Vertices at apexes of cones are there to the last bit.
    for apex in scene.surfaces.iter().filter_map(Surface::apex) {
        welder.number(apex);
    }
    for contact in contacts.iter_mut() {
        let vertex = welder.number(contact.at);
        contact.at = welder.points[vertex as usize];
    }
    let mut ends = Vec::with_capacity(pieces.len());
    // Pieces by vertices in which points are together that differ.
    let mut mixed: FxHashMap<VertexId, SmallVec<[usize; 8]>> = FxHashMap::default();
    for piece in pieces {
        scene.go_on()?;
        ends.push([piece.from, piece.to].map(|point| {
            let vertex = VertexId(welder.number(point));
            if welder.points[vertex.index()].distance(point) > OFF * scene.rounding {
                mixed.entry(vertex).or_default();
            }
            vertex
        }));
    }
    let points = welder.points;
    let mut welded = Welded { points, ends };
    if !mixed.is_empty() {
        for (index, end) in (0..)
            .zip(&welded.ends)
            .flat_map(|(k, e)| e.map(|end| (k, end)))
        {
            if let Some(pieces) = mixed.get_mut(&end) {
                pieces.push(index);
            }
        }
        let mut mixed: Vec<(VertexId, SmallVec<[usize; 8]>)> = mixed.into_iter().collect();
        mixed.sort_unstable();
        welded.contract(scene, pieces, mixed);
    }
    Ok(welded)
}

impl Welded {
    /// Moves vertices that are off the surfaces of their pieces to where these touch
    /// next to them, until that is done: a block's side has cut curves there in points
    /// that are nearer to each other than what is told apart, but in no vertex.
    fn contract(
        &mut self,
        scene: &Scene<'_>,
        pieces: &[Piece],
        mut mixed: Vec<(VertexId, SmallVec<[usize; 8]>)>,
    ) {
        loop {
            let before = mixed.len();
            mixed.retain(|(vertex, around)| !self.put_right(scene, pieces, *vertex, around));
            if mixed.len() == before {
                break;
            }
        }
    }

    /// Puts pieces around a vertex that is off their surfaces to the nearest one to
    /// which two of their curves lead and that is on all of them, too; whether there is
    /// nothing left to be done.
    fn put_right(
        &mut self,
        scene: &Scene<'_>,
        pieces: &[Piece],
        vertex: VertexId,
        around: &[usize],
    ) -> bool {
        let is_on = |vertex: VertexId| {
            let ids = around.iter().flat_map(|&k| pieces[k].curve.surfaces());
            let off = solve::residual(ids.map(|id| scene.surface(id)), self.points[vertex.index()]);
            off <= OFF * scene.rounding
        };
        if is_on(vertex) {
            return true;
        }
        let at = self.points[vertex.index()];
        let distance = |v: VertexId| self.points[v.index()].distance(at);
        let beyond = |k: usize| self.ends[k][usize::from(self.ends[k][0] == vertex)];
        let touch = |&k: &usize| {
            let is_other = |&j: &usize| {
                let [one, other] = [j, k].map(|k| pieces[k].curve.surfaces());
                one.ne(other) && beyond(j) == beyond(k)
            };
            let is_next = beyond(k) != vertex && distance(beyond(k)) <= scene.touching_reach();
            is_next && around.iter().any(is_other) && is_on(beyond(k))
        };
        let touching = around.iter().copied().filter(touch).map(beyond);
        let nearest = touching.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        let Some(nearest) = nearest else {
            return false;
        };
        for &k in around {
            self.ends[k] = self.ends[k].map(|end| if end == vertex { nearest } else { end });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrangement::piece::{CurveId, Side};
    use crate::arrangement::relations::Relations;
    use crate::control::Control;
    use crate::program::SurfaceId;

    fn ball(center: DVec3, radius: f64) -> Surface {
        Surface::of_terms(
            center,
            [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            DVec3::ZERO,
            -radius * radius,
        )
    }

    /// A circle within another one, which it touches, both cut next to there.
    #[test]
    fn stretches_between_curves_that_touch_are_contracted() {
        let plane = Surface::plane(DVec3::ZERO, DVec3::Z);
        let [inner, outer] = [DVec3::X, 2.0 * DVec3::X];
        let surfaces = [ball(inner, 1.0), ball(outer, 2.0), plane];
        let control = Control::default();
        let scene = Scene {
            surfaces: &surfaces,
            planes: &[],
            frames: &[],
            looks: &[],
            on_plane: 1e-11,
            near: 1e-9,
            touch: 1e-13,
            reach: 10.0,
            weld: 1e-10,
            rounding: 1e-15,
            given: None,
            relations: &Relations::default(),
            control: &control,
        };
        let side = |plane| Side {
            plane: SurfaceId(plane),
            look: 0,
            along_normal: true,
            patch: 0,
        };
        let at = |radius: f64, y: f64| {
            DVec3::new(y * y / (radius + (radius * radius - y * y).sqrt()), y, 0.0)
        };
        let pieces = |first: f64| -> Vec<Piece> {
            let along = |(index, radius)| {
                let piece = move |from, to| Piece {
                    from: at(radius, from),
                    to: at(radius, to),
                    sides: [side(index), side(2)],
                    curve: CurveId::first_of([index, 2].map(SurfaceId)),
                    places: [0.0; 2],
                    goes_on: [false; 2],
                };
                [piece(0.0, first), piece(first, 0.5)]
            };
            [(0, 1.0), (1, 2.0)].into_iter().flat_map(along).collect()
        };
        // Apart by a quarter of the square.
        for (first, is_contracted) in [(1e-5, true), (1e-7, false), (1e-4, false)] {
            let pieces = pieces(first);
            let welded = weld(&scene, &pieces, &mut []);
            let Welded { points, ends } = welded.expect("not to be stopped");
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| ends[k]);
            assert_eq!(a[0], c[0]);
            assert_eq!(a[0] == a[1] && c[0] == c[1], is_contracted, "{first}");
            for (piece, ends) in pieces.iter().zip(&ends) {
                for &end in ends {
                    let surfaces = piece.curve.surfaces().map(|id| scene.surface(id));
                    let off = solve::residual(surfaces, points[end.index()]);
                    assert!(off < 1e-13, "{first}: {off}");
                }
            }
            assert!(a[1] == b[0] && c[1] == d[0] && b[1] != d[1]);
        }
    }
}
