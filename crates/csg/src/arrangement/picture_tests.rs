//! Faces as they are seen from one side, and faces that are unfolded: long
//! narrow strips on curved surfaces.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::frame::Frame;
use super::picture::{NONE, Picture, Slits};
use super::piece::Side;
use super::relations::Relations;
use super::scene::{Plane, Scene};
use super::unfold::{faces_out, unfold};
use crate::control::Control;
use crate::mesh::predicates::orient;
use crate::mesh::triangulate::{Named, Scratch, triangulate};
use crate::program::{Surface, SurfaceId};
use crate::random::Random;

/// All that a scene of one surface about the z axis refers to.
struct Stage {
    surfaces: [Surface; 1],
    planes: [Plane; 1],
    frames: [Option<Frame>; 1],
    relations: Relations,
    control: Control,
}

/// x² + y² + zz z² + constant.
fn stage(zz: f64, constant: f64) -> Stage {
    let surface = Surface::of_terms(
        DVec3::ZERO,
        [1.0, 1.0, zz, 0.0, 0.0, 0.0],
        DVec3::ZERO,
        constant,
    );
    Stage {
        planes: [Plane::of(&surface)],
        frames: [Frame::of(&surface, 10.0)],
        surfaces: [surface],
        relations: Relations::default(),
        control: Control::default(),
    }
}

impl Stage {
    fn scene(&self) -> Scene<'_> {
        Scene {
            surfaces: &self.surfaces,
            planes: &self.planes,
            frames: &self.frames,
            looks: &[0],
            on_plane: 1e-12,
            near: 1e-9,
            touch: 1e-13,
            reach: 10.0,
            weld: 1e-11,
            rounding: 1e-15,
            given: None,
            relations: &self.relations,
            control: &self.control,
        }
    }

    /// The side, seen from outside, on which a point is.
    fn side(&self, at: DVec3) -> Side {
        let frame = self.frames[0].as_ref().expect("a frame");
        Side {
            plane: SurfaceId(0),
            look: 0,
            along_normal: true,
            patch: frame.patch(at, DVec3::ZERO, 0.0),
        }
    }
}

/// The middle of the quadrant between two seams, in radians about the axis.
const MIDDLE: f64 = 0.618_033_989 + std::f64::consts::FRAC_PI_4;

/// Where the plane z = height + slope (x, y)·(middle of the quadrant) meets the
/// cylinder of radius 1 or, else, the cone of slope 1.
fn on_rim(is_cone: bool, height: f64, slope: f64, angle: f64) -> DVec3 {
    let across = slope * angle.cos();
    let radius = if is_cone {
        height / (1.0 - across)
    } else {
        1.0
    };
    let (sin, cos) = (MIDDLE + angle).sin_cos();
    DVec3::new(radius * cos, radius * sin, height + across * radius)
}

/// A strip between two parallel oblique planes, counter-clockwise as seen from
/// outside, its rims cut into chords at random places.
fn strip(random: &mut Random, is_cone: bool) -> Vec<DVec3> {
    let half = 0.3 + 0.45 * random.unit();
    let slope = 0.8 * (2.0 * random.unit() - 1.0);
    // Where a chord strays farther than the strip is wide nothing could help.
    let chord = 0.05 + 0.15 * random.unit();
    let width = chord * chord * (1.0 + random.unit());
    let mut rim = |height: f64| -> Vec<DVec3> {
        let chords = (2.0 * half / chord).ceil() as u32;
        let place = |k: u32| -half + 2.0 * half * f64::from(k) / f64::from(chords);
        let mut angles: Vec<f64> = (0..=chords).map(place).collect();
        for angle in &mut angles[1..chords as usize] {
            *angle += 0.4 * chord * (2.0 * random.unit() - 1.0);
        }
        let at = |angle| on_rim(is_cone, height, slope, angle);
        angles.into_iter().map(at).collect()
    };
    let (lower, upper) = (rim(1.0), rim(1.0 + width));
    // About the axis, to the left as seen from outside, and back above.
    lower.into_iter().chain(upper.into_iter().rev()).collect()
}

fn area(corners: [DVec2; 3]) -> f64 {
    0.5 * orient(corners[0], corners[1], corners[2])
}

/// The directed edges of triangles that have no other side.
fn rim_of(triangles: &[[u32; 3]]) -> HashSet<[u32; 2]> {
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let all: HashSet<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    assert_eq!(all.len(), 3 * triangles.len(), "an edge occurs twice");
    let is_rim = |&&[a, b]: &&[u32; 2]| !all.contains(&[b, a]);
    all.iter().filter(is_rim).copied().collect()
}

#[test]
fn long_narrow_strips_face_outwards_everywhere_once_they_are_unfolded() {
    let mut random = Random(1);
    let (mut folded, mut strips) = (0, 0);
    for case in 0..600 {
        let is_cone = case % 2 == 0;
        let stage = if is_cone {
            stage(-1.0, 0.0)
        } else {
            stage(0.0, -1.0)
        };
        let scene = stage.scene();
        let mut positions = strip(&mut random, is_cone);
        let corners = positions.len();
        let side = stage.side(positions[0]);
        let seen = |p: &DVec3| scene.flatten(&side, *p);
        let contour: Vec<Named> = positions.iter().map(seen).zip(0..).collect();
        // Where chords run across each other there is nothing to cut up.
        let Some(mut triangles) =
            triangulate(&[contour], scene.weld, &|| true, &mut Scratch::default())
        else {
            continue;
        };
        strips += 1;
        let is_out = |corners: &[u32; 3], positions: &[DVec3]| {
            let corners = corners.map(|c| positions[c as usize]);
            faces_out(&stage.surfaces[0], None, true, corners)
        };
        folded += usize::from(!triangles.iter().all(|t| is_out(t, &positions)));
        let total = |triangles: &[[u32; 3]], positions: &[DVec3]| -> f64 {
            let areas = triangles.iter().map(|t| {
                let area = area(t.map(|c| seen(&positions[c as usize])));
                assert!(area > 0.0, "case {case}");
                area
            });
            areas.sum()
        };
        let before = total(&triangles, &positions);
        let rim = rim_of(&triangles);
        let coarse = unfolded(&scene, &side, &mut triangles, &mut positions);
        assert!(coarse.is_empty(), "case {case}");
        for corners in &triangles {
            assert!(is_out(corners, &positions), "case {case}");
        }
        // They fill the same contour, without overlap, and lie on the surface.
        assert_eq!(rim_of(&triangles), rim, "case {case}");
        let after = total(&triangles, &positions);
        assert!((after / before - 1.0).abs() < 1e-12, "case {case}");
        for p in &positions[corners..] {
            assert!(stage.surfaces[0].value(*p).abs() < 1e-13, "case {case}");
        }
    }
    assert!(strips > 400 && folded > 100, "{folded} of {strips}");
}

/// Unfolds a face without slits; the chords that are too coarse for it.
fn unfolded(
    scene: &Scene<'_>,
    side: &Side,
    triangles: &mut Vec<[u32; 3]>,
    positions: &mut Vec<DVec3>,
) -> Vec<[u32; 2]> {
    let mut coarse = Vec::new();
    let slits = Slits::default();
    unfold(scene, side, triangles, positions, &slits, &mut coarse);
    coarse
}

/// A narrow lens on a cylinder, between an arc and a flat curve above it, by how
/// far along its contour a point is: 1 from tip to tip.
fn on_lens(along: f64) -> DVec3 {
    const HALF: f64 = 0.4;
    const WIDTH: f64 = 0.01;
    let across = 1.0 - (2.0 * along.fract() - 1.0).powi(2);
    if along < 1.0 {
        on_rim(false, 0.0, 0.0, HALF * (2.0 * along - 1.0))
    } else {
        on_rim(false, WIDTH * across, 0.0, HALF * (3.0 - 2.0 * along))
    }
}

/// A chord of the arc leaves the cylinder by more than the lens is wide: no vertex
/// inside helps, and the chords at fault are told until they are short enough.
#[test]
fn chords_that_turn_a_narrow_face_over_are_told() {
    let stage = stage(0.0, -1.0);
    let scene = stage.scene();
    let mut contour = vec![0.0, 1.0, 1.5];
    let mut rounds = 0;
    loop {
        let mut positions: Vec<DVec3> = contour.iter().map(|&along| on_lens(along)).collect();
        let side = stage.side(positions[0]);
        let seen = positions.iter().map(|p| scene.flatten(&side, *p));
        let named: Vec<Named> = seen.zip(0..).collect();
        let triangles = triangulate(&[named], scene.weld, &|| true, &mut Scratch::default());
        let mut triangles = triangles.expect("it is convex");
        let coarse = unfolded(&scene, &side, &mut triangles, &mut positions);
        let is_out = |corners: &[u32; 3]| {
            let corners = corners.map(|c| positions[c as usize]);
            faces_out(&stage.surfaces[0], None, true, corners)
        };
        assert_eq!(triangles.iter().all(is_out), coarse.is_empty());
        if coarse.is_empty() {
            break;
        }
        let rim = rim_of(&triangles);
        assert!(coarse.iter().all(|ends| rim.contains(ends)), "{coarse:?}");
        if rounds == 0 {
            assert!(coarse.contains(&[0, 1]), "{coarse:?}");
        }
        rounds += 1;
        assert!(rounds < 8, "{} chords", contour.len());
        let ends = contour.iter().copied();
        let middle = |from: u32| {
            let from = from as usize;
            0.5 * (contour[from] + contour.get(from + 1).unwrap_or(&2.0))
        };
        let split = coarse.iter().map(|&[from, _]| middle(from));
        contour = ends.chain(split).collect();
        contour.sort_by(f64::total_cmp);
        contour.dedup();
    }
    assert!(rounds > 1, "{rounds}");
}

/// Whether a point is inside the circle through three others, from the
/// determinant alone, and not next to it.
fn is_in_circle([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    let [a, b, c] = [a, b, c].map(|q| q - p);
    let determinant = a.length_squared() * b.perp_dot(c)
        + b.length_squared() * c.perp_dot(a)
        + c.length_squared() * a.perp_dot(b);
    determinant > 1e-9
}

/// The long diagonal of a kite is flipped, unless other faces touch this one along it.
#[test]
fn slits_are_not_flipped() {
    let stage = stage(0.0, -1.0);
    let scene = stage.scene();
    let at = |angle: f64, z: f64| on_rim(false, z, 0.0, angle);
    let positions = [at(-0.5, 0.0), at(0.0, -0.1), at(0.5, 0.0), at(0.0, 0.1)];
    let side = stage.side(positions[0]);
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let joins = |picture: &Picture<'_>, [a, b]: [u32; 2]| {
        let has_both = |corners: &&[u32; 3]| corners.contains(&a) && corners.contains(&b);
        picture.triangles.iter().filter(has_both).count() == 2
    };
    for (slits, diagonal) in [(vec![], [1, 3]), (vec![[0, 2], [2, 0]], [0, 2])] {
        let slits = slits.into_iter().collect();
        let mut picture = Picture::new(&scene, &side, triangles.clone(), &slits);
        picture.make_delaunay(&positions);
        assert!(joins(&picture, diagonal), "{slits:?}");
    }
}

/// Points put into a square on a cylinder, at random, on edges and on corners:
/// no other point is inside any triangle's circle, as they are seen.
#[test]
fn inserted_points_make_a_delaunay_triangulation() {
    let stage = stage(0.0, -1.0);
    let scene = stage.scene();
    for seed in 0..50 {
        let random = &mut Random(seed);
        let at = |angle: f64, z: f64| on_rim(false, z, 0.0, angle);
        let mut positions = vec![at(-0.5, 0.0), at(0.5, 0.0), at(0.5, 1.0), at(-0.5, 1.0)];
        let side = stage.side(positions[0]);
        let mut picture =
            Picture::new(&scene, &side, vec![[0, 1, 2], [0, 2, 3]], &Slits::default());
        let mut inside = 0;
        for _ in 0..60 {
            let point = match random.below(8) {
                // On a corner and at the rim there is nothing to insert.
                0 => positions[random.below(positions.len())],
                1 => at(random.unit() - 0.5, 0.0),
                // In the middle of an edge, as it is seen.
                2 => {
                    let half = random.below(picture.twins.len()) as u32;
                    let [p, q] = picture.ends(half).map(|end| positions[end as usize]);
                    inside += usize::from(picture.twins[half as usize] != NONE);
                    let frame = stage.frames[0].as_ref().expect("a frame");
                    frame.lift(&stage.surfaces[0], side.patch, p.midpoint(q))
                }
                _ => {
                    inside += 1;
                    at(random.unit() - 0.5, random.unit())
                }
            };
            picture.insert(point, &mut positions);
        }
        assert_eq!(positions.len(), 4 + inside, "seed {seed}");
        assert_eq!(picture.triangles.len(), 2 + 2 * inside, "seed {seed}");
        let rim: HashSet<[u32; 2]> = [[0, 1], [1, 2], [2, 3], [3, 0]].into();
        assert_eq!(rim_of(&picture.triangles), rim, "seed {seed}");
        for (half, &twin) in (0u32..).zip(&picture.twins) {
            let [from, to] = picture.ends(half);
            assert_eq!(twin == NONE, rim.contains(&[from, to]), "seed {seed}");
            if twin != NONE {
                assert_eq!(picture.ends(twin), [to, from], "seed {seed}");
            }
        }
        let seen: Vec<DVec2> = positions.iter().map(|p| scene.flatten(&side, *p)).collect();
        for corners in &picture.triangles {
            let circle = corners.map(|c| seen[c as usize]);
            assert!(area(circle) > 0.0, "seed {seed}");
            let others = (0..).zip(&seen).filter(|(c, _)| !corners.contains(c));
            for (_, other) in others {
                assert!(!is_in_circle(circle, *other), "seed {seed}");
            }
        }
    }
}
