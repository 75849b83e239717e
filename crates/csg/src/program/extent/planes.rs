//! The box of what a few planes bound together, by its corners: however sharp the edges are in
//! which they meet, where pruning by one plane at a time finds no end.

use glam::DVec3;
use smallvec::SmallVec;

use crate::numeric::tolerance::NEAR;
use crate::surface::{Bounds, Surface};

/// Of more planes all corners are too many. Tunes only what is told to be bounded at once.
const MOST: usize = 16;

/// The planes of a conjunction: the points with f <= 0 for each of them.
#[derive(Default)]
pub(super) struct Wedge(SmallVec<[Surface; 8]>);

impl Wedge {
    pub fn add(&mut self, plane: Surface) {
        self.0.push(plane);
    }

    /// A box around all points of it; infinite where it is not seen to be bounded. Tries all
    /// triples of planes.
    pub fn bounds(&self) -> Bounds {
        let planes = &self.0;
        if !(4..=MOST).contains(&planes.len()) || !self.is_bounded() {
            return Bounds::EVERYTHING;
        }
        let corners = triples(planes.len()).filter_map(|[i, j, k]| {
            let [a, b, c] = [&planes[i], &planes[j], &planes[k]];
            let [bc, ca, ab] = [(b, c), (c, a), (a, b)].map(|(p, q)| p.linear.cross(q.linear));
            let offset = |plane: &Surface| plane.linear.dot(plane.anchor);
            let corner = (offset(a) * bc + offset(b) * ca + offset(c) * ab) / a.linear.dot(bc);
            let passes = |plane: &Surface| {
                let scale = corner.length() + plane.anchor.length();
                plane.value(corner) <= NEAR * scale
            };
            (corner.is_finite() && planes.iter().all(passes)).then_some(corner)
        });
        corners.fold(Bounds::NOTHING, |all, corner| {
            let slack = NEAR * corner.abs().max_element();
            Bounds {
                min: all.min.min(corner - slack),
                max: all.max.max(corner + slack),
            }
        })
    }

    /// Whether it goes on along no direction: it would along one in which two of its planes meet.
    fn is_bounded(&self) -> bool {
        let planes = &self.0;
        let goes_on = |along: DVec3, [i, j]: [usize; 2]| {
            let mut others = (0..planes.len()).filter(|&k| k != i && k != j);
            others.all(|k| planes[k].linear.dot(along) <= NEAR)
        };
        let mut directions = pairs(planes.len())
            .filter_map(|pair| {
                let [a, b] = pair.map(|k| planes[k].linear);
                Some((a.cross(b).try_normalize()?, pair))
            })
            .peekable();
        // Planes that are all parallel have none.
        directions.peek().is_some()
            && directions.all(|(along, pair)| !goes_on(along, pair) && !goes_on(-along, pair))
    }
}

fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> + Clone {
    (0..count).flat_map(|j| (0..j).map(move |i| [i, j]))
}

fn triples(count: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..count).flat_map(|k| pairs(k).map(move |[i, j]| [i, j, k]))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use crate::{Program, Solid};

    /// A slice of a cake, turned, of planes alone.
    fn slice(angle: f64) -> Solid {
        let across = DVec2::from_angle(angle);
        let planes = [
            [0.0, -1.0, 0.0, 0.0],
            [-across.y, across.x, 0.0, 0.0],
            [1.0, 0.3, 0.1, 2.0],
            [0.0, 0.0, 1.0, 1.0],
            [0.1, 0.0, -1.0, 1.0],
        ];
        let sides = planes.map(|[x, y, z, offset]| Solid::half_space([x, y, z], offset));
        let slice = sides.into_iter().reduce(|a, b| a & b).expect("five");
        slice
            .rotate_x(0.4)
            .rotate_z(1.1)
            .translate([3.0, -2.0, 1.0])
    }

    /// Pruning finds no end at these angles.
    #[test]
    fn what_planes_bound_at_sharp_angles_has_a_tight_box() {
        for power in 4..=7 {
            let angle = 10f64.powi(-power);
            let program = Program::lower(&slice(angle)).expect("valid");
            let bounds = program.bounds().expect("bounded").expect("not empty");
            let mesh = crate::Mesher::new().mesh(&program).expect("a mesh").mesh;
            let (low, high) = mesh.bounds().expect("not empty");
            let slack = 0.02 * bounds.size().max_element();
            assert!(
                (low - bounds.min).abs().max_element() < slack,
                "{angle}: {bounds:?}"
            );
            assert!(
                (high - bounds.max).abs().max_element() < slack,
                "{angle}: {bounds:?}"
            );
        }
    }

    #[test]
    fn what_planes_leave_open_is_unbounded() {
        let side = |normal: [f64; 3]| Solid::half_space(normal, 1.0);
        let open = side([1.0, 0.0, 0.1]) & side([-1.0, 1e-4, 0.0]) & side([0.0, -1.0, 1e-4]);
        let slab = [1.0, 2.0, 3.0, -1.0].map(|z| side([0.0, 1e-3, z]));
        let slab = slab.into_iter().reduce(|a, b| a & b).expect("four");
        let tunnel = open.clone() & side([0.5, 1.0, 0.05]);
        for solid in [open, slab, tunnel] {
            assert!(Program::lower(&solid).expect("valid").bounds().is_err());
        }
    }
}
