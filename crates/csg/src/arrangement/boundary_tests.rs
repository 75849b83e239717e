//! Contours linked of pieces made by hand: where curves touch, and of faces between
//! two curves.

use std::f64::consts::TAU;

use glam::DVec3;

use super::boundary::Boundary;
use super::frame::Frame;
use super::ids::HalfEdgeId;
use super::piece::{CurveId, Piece, Side};
use super::relations::Relations;
use super::scene::{Plane, Scene};
use crate::control::Control;
use crate::program::{Surface, SurfaceId};
use crate::surface::solve;
use crate::undecided::{Stop, Undecided, Why};

const WELD: f64 = 1e-11;
const NEAR: f64 = 1e-9;

fn plane(height: f64) -> Surface {
    Surface::plane(height * DVec3::Z, DVec3::Z)
}

/// Along the z axis.
fn cylinder(center: DVec3, radius: f64) -> Surface {
    Surface::of_terms(
        center,
        [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        DVec3::ZERO,
        -radius * radius,
    )
}

/// A face of a surface by its number.
fn side(plane: u32, along_normal: bool) -> Side {
    Side {
        plane: SurfaceId(plane),
        look: 0,
        along_normal,
        patch: 0,
    }
}

fn piece([from, to]: [DVec3; 2], sides: [Side; 2]) -> Piece {
    Piece {
        from,
        to,
        sides,
        curve: CurveId::first_of(sides.map(|side| side.plane)),
        places: [0.0; 2],
        goes_on: [false; 2],
    }
}

/// Pieces with their places on the curves of their names.
fn placed(scene: &Scene<'_>, pieces: &[Piece]) -> Vec<Piece> {
    let place = |piece: &Piece| {
        let curve = scene.curve(piece.curve)?;
        let from = curve.place(piece.from)?;
        let to = curve.place(piece.to)?;
        let turns = if curve.is_closed() {
            ((from - to) / TAU).round()
        } else {
            0.0
        };
        Some([from, to + TAU * turns])
    };
    let placed = |piece: &Piece| Piece {
        places: place(piece).expect("a known curve"),
        ..*piece
    };
    pieces.iter().map(placed).collect()
}

fn with_scene<T>(surfaces: &[Surface], run: impl FnOnce(&Scene<'_>) -> T) -> T {
    let planes: Vec<Plane> = surfaces.iter().map(Plane::of).collect();
    let frames: Vec<Option<Frame>> = surfaces.iter().map(|s| Frame::of(s, 10.0)).collect();
    let scene = Scene {
        surfaces,
        planes: &planes,
        frames: &frames,
        looks: &[0],
        on_plane: 1e-12,
        near: NEAR,
        touch: 1e-13,
        reach: 10.0,
        weld: WELD,
        rounding: 1e-15,
        given: None,
        relations: &Relations::default(),
        control: &Control::default(),
    };
    run(&scene)
}

/// The vertices of the contours of a surface's only face; none if pieces do not
/// close.
fn contours(surfaces: &[Surface], pieces: &[Piece], surface: u32) -> Option<Vec<Vec<DVec3>>> {
    let boundary = with_scene(surfaces, |scene| {
        let mut boundary = Boundary::link(scene, &placed(scene, pieces), &mut [])?;
        boundary.split_double_edges(scene)?;
        Ok::<_, Stop>(boundary)
    })
    .ok()?;
    let face = boundary
        .faces
        .iter()
        .position(|f| f.plane == SurfaceId(surface))?;
    let start = |&half_edge: &HalfEdgeId| boundary.point(boundary.at(half_edge).from);
    let contours = boundary.contours().swap_remove(face);
    let vertices = contours.iter().map(|c| c.iter().map(start).collect());
    Some(vertices.collect())
}

/// The chords of a circle about a place on the y axis that goes through the origin:
/// the rim of a hole in the plane z = 0, or else of a disc. Vertices are at these x
/// next to the origin, too.
fn rim(number: u32, center: f64, is_hole: bool, beside: &[f64]) -> Vec<Piece> {
    let near = beside.iter().map(|x| (x / center).asin());
    let far = (-3..=4).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4);
    let mut angles: Vec<f64> = near.chain(far).collect();
    angles.sort_by(f64::total_cmp);
    let place = |angle: &f64| {
        let (sin, cos) = angle.sin_cos();
        center * DVec3::new(sin, 1.0 - cos, 0.0)
    };
    let mut places: Vec<DVec3> = angles.iter().map(place).collect();
    if is_hole {
        places.reverse();
    }
    let next = places.iter().cycle().skip(1);
    let ends = places.iter().zip(next).map(|(&from, &to)| [from, to]);
    let sides = [side(0, true), side(number, !is_hole)];
    ends.map(|ends| piece(ends, sides)).collect()
}

/// How many contours two circles make that touch.
fn contours_of_circles(circles: [(f64, bool); 2], beside: &[f64]) -> Option<usize> {
    let cylinders = circles.map(|(y, _)| cylinder(y * DVec3::Y, y.abs()));
    let surfaces = [vec![plane(0.0)], cylinders.to_vec()].concat();
    let rims = (1..).zip(circles);
    let pieces: Vec<Piece> = rims
        .flat_map(|(number, (center, is_hole))| rim(number, center, is_hole, beside))
        .collect();
    contours(&surfaces, &pieces, 0).map(|contours| contours.len())
}

/// Whose tangents are the same, so that only their bends tell on which side of each
/// other they are.
#[test]
fn contours_keep_to_their_side_where_curves_touch() {
    for (circles, count) in [
        // The plane around two holes: from one it goes on to the other.
        ([(1.0, true), (-0.7, true)], 1),
        // A disc less one in it.
        ([(1.0, false), (0.5, true)], 1),
        ([(0.5, true), (1.0, false)], 1),
        // Two discs.
        ([(1.0, false), (-1.0, false)], 2),
        // A disc in a hole.
        ([(1.0, true), (0.5, false)], 2),
    ] {
        let found = contours_of_circles(circles, &[]);
        assert_eq!(found, Some(count), "{circles:?}");
    }
}

/// There they seem to cross, as they have a vertex in common.
#[test]
fn so_they_do_where_touching_curves_are_one_but_for_rounding() {
    for circles in [[(1.0, false), (-1.0, false)], [(1.0, true), (0.5, false)]] {
        for beside in [&[1e-6][..], &[-1e-6], &[-2e-6, 1e-6]] {
            let found = contours_of_circles(circles, beside);
            assert_eq!(found, Some(2), "{circles:?} {beside:?}");
        }
    }
}

/// The top of what two cylinders have in common, `width` across.
fn lens(width: f64) -> Vec<Vec<DVec3>> {
    let off = 1.0 - 0.5 * width;
    let half_length = ((1.0 - off) * (1.0 + off)).sqrt();
    let cylinders = [-off, off].map(|x| cylinder(x * DVec3::X, 1.0));
    let surfaces = [vec![plane(1.0), plane(0.0)], cylinders.to_vec()].concat();
    let [top, bottom, right, left] = [(0, true), (1, false), (2, true), (3, true)]
        .map(|(surface, along_normal)| side(surface, along_normal));
    let corner = |y: f64, z: f64| DVec3::new(0.0, y * half_length, z);
    let [a, b, c, d] = [
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(-1.0, 0.0),
        corner(1.0, 0.0),
    ];
    let pieces = [
        piece([a, b], [top, right]),
        piece([b, a], [top, left]),
        piece([d, c], [bottom, right]),
        piece([c, d], [bottom, left]),
        piece([d, b], [right, left]),
        piece([a, c], [right, left]),
    ];
    contours(&surfaces, &pieces, 0).expect("closed contours")
}

#[test]
fn a_face_of_two_corners_stays_if_it_is_wider_than_rounding() {
    for width in [0.1, 1e-5, 2.0 * NEAR] {
        let contours = lens(width);
        assert_eq!(contours.len(), 1, "{width}");
        // With vertices in the middles of its edges.
        assert_eq!(contours[0].len(), 4, "{width}");
        let x = || contours[0].iter().map(|p| p.x);
        let across = x().fold(0.0, f64::max) - x().fold(0.0, f64::min);
        assert!((across - width).abs() < WELD, "{width}: {across}");
    }
    assert!(lens(0.5 * NEAR).is_empty());
}

/// Vertices beside the chords of something thin are looked for on the edge's own stretch of
/// its curve, however near the other side is.
#[test]
fn points_of_edges_are_on_their_own_stretch() {
    let thin = Surface::of_terms(
        DVec3::ZERO,
        [1.0, 1e8, 0.0, 0.0, 0.0, 0.0],
        DVec3::ZERO,
        -1.0,
    );
    let surfaces = [plane(0.0), thin];
    let at = |angle: f64| DVec3::new(angle.cos(), 1e-4 * angle.sin(), 0.0);
    let angles = [0.2, 3.0, 3.5, 6.0];
    let ends = (0..4).map(|k| [angles[k], angles[(k + 1) % 4]].map(at));
    let sides = [side(0, true), side(1, true)];
    let pieces: Vec<Piece> = ends.map(|ends| piece(ends, sides)).collect();
    with_scene(&surfaces, |scene| {
        let boundary = Boundary::link(scene, &placed(scene, &pieces), &mut []);
        let boundary = boundary.expect("closed contours");
        for (half, side) in [(0, 1.0), (1, 1.0), (4, -1.0), (5, -1.0)] {
            for x in [-0.8, -0.3, 0.4, 0.9] {
                for beside in [-1e-4, 0.0, 1e-4] {
                    let near = DVec3::new(x, beside, 0.0);
                    let found = boundary.on_curve(scene, HalfEdgeId(half), near);
                    let found = found.expect("a point");
                    // In the plane across the chord, where the cylinder is round.
                    let round = |along: DVec3| along * DVec3::new(1.0, 1e4, 0.0);
                    let chord = boundary.chord(HalfEdgeId(half));
                    let along = round(chord[1] - chord[0]).normalize();
                    let off = round(found - near).dot(along).abs();
                    assert!(off < 1e-8, "{half}: {found}, not beside {near}");
                    assert!(side * found.y > 0.0, "{half}: {found}");
                    assert!(solve::residual(surfaces.iter(), found) < WELD);
                }
            }
        }
    });
}

/// A cylinder along the z axis touches the plane y = 0, and so does the rim of one
/// along the y axis that line, to the fourth order.
#[test]
fn contacts_of_fourth_order_are_one_for_all_three() {
    let turned = |surface: Surface| Surface {
        quadratic: [1.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        ..surface
    };
    let surfaces = [
        Surface {
            linear: DVec3::Y,
            ..plane(0.0)
        },
        cylinder(DVec3::Y, 1.0),
        turned(cylinder(DVec3::new(-0.75, 0.0, 0.0), 0.75)),
        // Crosses the others at an angle.
        plane(0.0),
    ];
    with_scene(&surfaces, |scene| {
        let found = scene.contacts([0, 1, 2].map(SurfaceId));
        assert_eq!(found.len(), 1);
        assert!(found[0].crossings.is_empty());
        // Rounding blurs a place to the fourth order to a quarter of its digits.
        let at = found[0].ball.center;
        assert!(at.length() < 1e-3, "{at}");
        for surface in &surfaces[..3] {
            let off = surface.value(at).abs() / surface.gradient(at).length();
            assert!(off <= scene.rounding, "{off}");
        }
        for ids in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let same = scene.contacts(ids.map(SurfaceId));
            assert_eq!(same.len(), 1);
            assert_eq!(same[0].ball.center, at);
        }
        // They cross.
        assert!(scene.contacts([0, 2, 3].map(SurfaceId)).is_empty());
    });
}

/// Two planes meet along one edge, and nothing goes on from its ends.
#[test]
fn pieces_that_do_not_close_are_undecided_at_their_end() {
    let across = Surface {
        linear: DVec3::X,
        ..plane(0.0)
    };
    let ends = [DVec3::ZERO, DVec3::Y];
    // The way back is another face's.
    let pieces = [
        piece(ends, [side(0, true), side(1, true)]),
        piece(ends, [side(0, true), side(1, false)]),
    ];
    let linked = with_scene(&[plane(0.0), across], |scene| {
        Boundary::link(scene, &pieces, &mut []).err()
    });
    let Some(Stop::Undecided(Undecided { why, place })) = linked else {
        panic!("{linked:?}");
    };
    assert_eq!(why, Why::Contour);
    assert!(ends.contains(&place), "{place}");
}
