//! Which shells bound one body together: its outside, and the walls of the voids in it.

use crate::elementary;
use glam::{DVec2, DVec3};

use super::bounded::Bounded;
use super::chart;
use super::data::{Brep, Patch, range};
use super::view::Shell;
use crate::numeric::tolerance::NEAR;
use crate::program::Bounds;

impl Shell<'_> {
    /// The volume that it is around: above 0 for the outside of a body, below 0 for the wall
    /// of a void.
    #[must_use]
    pub fn volume(&self) -> Bounded {
        let (brep, patches) = (self.brep(), self.patches());
        let sum = brep.sum(patches, brep.middle(patches));
        Bounded {
            value: sum.values[0] / 3.0,
            error: sum.errors[0] / 3.0,
        }
    }

    /// The least box around it, as near as [`Brep::bounds`].
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.brep().bounds_of(self.patches())
    }

    fn patches(&self) -> &[Patch] {
        let faces = self.faces();
        let mut faces = faces.map(|face| range(face.patches()));
        let first = faces.next().unwrap_or(0..0);
        let last = faces.last().unwrap_or(first.clone());
        &self.brep().patches[first.start..last.end]
    }
}

impl Brep {
    /// The shells of each body: its outside first, then the walls of the voids in it. A
    /// solid of several parts that do not touch has as many bodies.
    ///
    /// ```
    /// use csg::{Program, Solid};
    ///
    /// let hollow = Solid::sphere(2.0) - Solid::cube(1.0);
    /// let solid = hollow | Solid::sphere(1.0).translate([5.0, 0.0, 0.0]);
    /// let brep = Program::lower(&solid)?.boundary(&Default::default())?;
    /// let shells: Vec<usize> = brep.bodies().iter().map(Vec::len).collect();
    /// assert_eq!(shells.iter().max(), Some(&2));
    /// assert_eq!(shells.iter().sum::<usize>(), 3);
    /// # Ok::<(), csg::Error>(())
    /// ```
    #[must_use]
    pub fn bodies(&self) -> Vec<Vec<Shell<'_>>> {
        if self.shells().len() == 1 {
            return vec![self.shells().collect()];
        }
        let (mut outer, mut voids) = (Vec::new(), Vec::new());
        for shell in self.shells() {
            let volume = shell.volume().value;
            if volume < 0.0 {
                voids.push(shell);
            } else {
                outer.push((volume, shell));
            }
        }
        let mut bodies: Vec<Vec<Shell<'_>>> = outer.iter().map(|&(_, s)| vec![s]).collect();
        if voids.is_empty() || bodies.is_empty() {
            return bodies;
        }
        if bodies.len() == 1 {
            bodies[0].extend(voids);
            return bodies;
        }
        // From the smallest: most voids are within the first one that is around a point of theirs.
        let mut order: Vec<usize> = (0..bodies.len()).collect();
        order.sort_by(|&a, &b| outer[a].0.total_cmp(&outer[b].0));
        let boxes: Vec<Option<Bounds>> = outer.iter().map(|(_, s)| s.bounds()).collect();
        let mut known: Vec<Option<Vec<Outline<'_>>>> = outer.iter().map(|_| None).collect();
        for shell in voids {
            let point = shell.faces().flat_map(|face| face.points()).next();
            let around = order.iter().copied().find(|&k| {
                let is_near = |bounds: Bounds| {
                    let near = NEAR * self.size;
                    point.is_none_or(|p| {
                        p.cmpge(bounds.min - near).all() && p.cmple(bounds.max + near).all()
                    })
                };
                let of_body = || outlines(outer[k].1);
                boxes[k].is_none_or(is_near)
                    && is_within(known[k].get_or_insert_with(of_body), shell)
            });
            bodies[around.unwrap_or(0)].push(shell);
        }
        bodies
    }
}

/// A patch as it is seen in its chart.
struct Outline<'a> {
    brep: &'a Brep,
    patch: &'a Patch,
    sides: Vec<[DVec2; 2]>,
}

fn outlines<'a>(shell: Shell<'a>) -> Vec<Outline<'a>> {
    /// Chords of a stretch: they stray from it by less than a fifth of their length.
    const CHORDS: u32 = 16;
    let brep = shell.brep();
    let faces = shell.faces();
    let patches = faces.flat_map(|face| &brep.patches[range(face.patches())]);
    let outline = |patch: &'a Patch| {
        let sides = brep.chords(patch, &brep.chart(patch), CHORDS).collect();
        Outline { brep, patch, sides }
    };
    patches.map(outline).collect()
}

/// Whether a shell is within an outer one: most of its points are.
fn is_within(outer: &[Outline<'_>], inner: Shell<'_>) -> bool {
    const MOST: usize = 9;
    let brep = inner.brep();
    let points = inner.faces().flat_map(|face| face.points());
    let (mut within, mut outside) = (0, 0);
    for (k, point) in (1u32..).zip(points) {
        // No two along one line.
        let k = f64::from(k);
        let direction = DVec3::new(
            elementary::cos(0.7 * k),
            elementary::sin(0.9 * k),
            elementary::cos(1.1 * k) + 0.1,
        );
        match crossings(outer, point - brep.origin, direction.normalize_or_zero()) {
            Some(count) if count % 2 == 1 => within += 1,
            Some(_) => outside += 1,
            None => {}
        }
        if within + outside == MOST {
            break;
        }
    }
    within > outside
}

/// How often a ray crosses some patches; none if it passes an edge so near by that chords
/// cannot tell.
fn crossings(patches: &[Outline<'_>], from: DVec3, direction: DVec3) -> Option<usize> {
    let mut count = 0;
    for outline in patches {
        let surface = &outline.brep.surfaces[outline.patch.side.plane.index()];
        let chart = outline.brep.chart(outline.patch);
        let square = 0.5 * surface.curvature_along(direction);
        let linear = surface.gradient(from).dot(direction);
        for distance in roots(square, linear, surface.value(from)) {
            let point = from + distance * direction;
            if !(distance > 0.0 && point.is_finite()) {
                continue;
            }
            let flat = chart.flatten(point);
            for &[a, b] in &outline.sides {
                let (side, to) = (b - a, flat - a);
                let share = (to.dot(side) / side.length_squared()).clamp(0.0, 1.0);
                if (to - share * side).length() < 0.2 * side.length() {
                    return None;
                }
            }
            let is_inside = chart::is_within(outline.sides.iter().copied(), flat);
            if is_inside && chart.shows(point, flat, outline.brep.size) {
                count += 1;
            }
        }
    }
    Some(count)
}

/// The roots of a x² + b x + c, if there are any.
fn roots(a: f64, b: f64, c: f64) -> impl Iterator<Item = f64> {
    let discriminant = b * b - 4.0 * a * c;
    let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    let both = if discriminant < 0.0 {
        [f64::NAN; 2]
    } else {
        [q / a, c / q]
    };
    both.into_iter().filter(|root| root.is_finite())
}

#[cfg(test)]
mod tests {
    use crate::{BoundaryOptions, Program, Solid};

    /// Balls in balls in balls, some beside each other, each void with its body.
    #[test]
    fn voids_belong_to_the_body_around_them() {
        let onion = |radii: [f64; 5]| {
            radii
                .into_iter()
                .enumerate()
                .fold(Solid::empty(), |sum, (k, radius)| {
                    let ball = Solid::sphere(radius);
                    if k % 2 == 0 { sum | ball } else { sum - ball }
                })
        };
        let solid = onion([5.0, 4.0, 3.0, 2.0, 1.0])
            | onion([2.5, 2.0, 1.5, 1.0, 0.5]).translate([9.0, 1.0, 0.5])
            | (Solid::cube(2.0) - Solid::cylinder(0.5, -0.7..0.7)).translate([-9.0, 0.2, 0.1]);
        for options in [
            BoundaryOptions::new(),
            BoundaryOptions::new().cut_at_seams(),
        ] {
            let program = Program::lower(&solid).expect("valid");
            let brep = program.boundary(&options).expect("a boundary");
            let bodies = brep.bodies();
            let mut volumes: Vec<f64> = Vec::new();
            for body in &bodies {
                let mut shells = body.iter().map(|shell| shell.volume().value);
                let outside = shells.next().expect("an outside");
                let voids: Vec<f64> = shells.collect();
                assert!(outside > 0.0 && voids.iter().all(|&void| void < 0.0));
                assert!(voids.len() < 2);
                volumes.push(outside + voids.iter().sum::<f64>());
            }
            volumes.sort_by(f64::total_cmp);
            let ball = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
            let pipe = 8.0 - 0.25 * 1.4 * std::f64::consts::PI;
            let mut wanted = [
                ball(5.0) - ball(4.0),
                ball(3.0) - ball(2.0),
                ball(1.0),
                ball(2.5) - ball(2.0),
                ball(1.5) - ball(1.0),
                ball(0.5),
                pipe,
            ];
            wanted.sort_by(f64::total_cmp);
            assert_eq!(volumes.len(), wanted.len());
            for (found, wanted) in volumes.iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-11, "{found} {wanted}");
            }
        }
    }
}
