//! Extrusion in flat steps: with a twist, or scaled unevenly.

use crate::elementary;
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::extrude::extent;
use super::partition::{Facet, Tree};
use super::polyhedron::plane_of;
use super::profile::Profile;
use super::tree::Solid;
use crate::error::NodeFault;
use crate::numeric::tolerance::{PROFILE_CHORD, SAME_FACE};

/// How an extrusion turns and narrows on its way up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// How far the top is turned against the bottom, in radians,
    /// counter-clockwise seen from +z.
    pub radians: f64,
    /// What the top is scaled by along x and y, before it is turned back: the
    /// scale's axes stay where they are.
    pub scale: DVec2,
    /// Into how many layers of the same height the way is divided; each must
    /// turn by less than half a turn.
    pub steps: usize,
}

impl Solid {
    /// The profile moved along z while it is turned and scaled about the z
    /// axis, in flat steps: between two of them every side is two triangles,
    /// which meet in the shorter diagonal. Circles and arcs become chords within
    /// 1e-4 of the profile's size first (for another tolerance, see
    /// [`Profile::flattened`]).
    ///
    /// Every triangle is an infinite plane to whatever is cut by it: some
    /// hundred are cheap, thousands slow.
    #[must_use]
    pub fn extrude_in_steps(profile: &Profile, z: Range<f64>, twist: Twist) -> Self {
        Self::made("extrude_in_steps", twisted(profile, &z, twist))
    }
}

fn twisted(
    profile: &Profile,
    z: &Range<f64>,
    twist: Twist,
) -> Result<(Solid, [DVec3; 2]), NodeFault> {
    let height = extent(z)?;
    let Twist {
        radians,
        scale,
        steps,
    } = twist;
    if !radians.is_finite() {
        let what = "the angle of a twist";
        return Err(NodeFault::NotFinite { what });
    }
    if steps == 0 || radians.abs() / steps as f64 >= std::f64::consts::PI {
        return Err(NodeFault::TooFewSteps { steps });
    }
    for value in scale.to_array() {
        if !(value >= 0.0 && value.is_finite()) {
            let what = "the scale";
            return Err(NodeFault::NotPositive { what, value });
        }
    }
    let contours = profile.contours(profile.tolerance_of(PROFILE_CHORD)?)?;
    let at = |step: usize| Level {
        turn: elementary::direction(radians * step as f64 / steps as f64),
        scale: DVec2::ONE - (DVec2::ONE - scale) * step as f64 / steps as f64,
        z: z.start + height * step as f64 / steps as f64,
    };
    let layers = (0..steps).map(|step| layer(&contours, &at(step), &at(step + 1), radians >= 0.0));
    let points = contours.iter().flatten();
    let reach = points.fold(0.0, |most, point| point.length().max(most));
    let reach = DVec2::splat(reach * scale.max_element().max(1.0));
    let within = [(-reach).extend(z.start), reach.extend(z.end)];
    let solid = if contours.is_empty() {
        Solid::empty()
    } else {
        Solid::union(layers)
    };
    Ok((solid, within))
}

/// A cross-section.
struct Level {
    turn: DVec2,
    scale: DVec2,
    z: f64,
}

impl Level {
    fn place(&self, point: DVec2) -> DVec3 {
        (self.scale * self.turn.rotate(point)).extend(self.z)
    }
}

/// What is between two levels, by the triangles of its sides.
fn layer(contours: &[Vec<DVec2>], low: &Level, high: &Level, turns_back: bool) -> Solid {
    let mut facets = Vec::new();
    let mut size: f64 = low.z.abs().max(high.z.abs());
    for contour in contours {
        let is_hole = super::profile::doubled_area(contour) < 0.0;
        // Of diagonals of the same length the one that matches its neighbours'.
        let flip = is_hole != turns_back;
        let shrinks = high.scale.min_element() == 0.0;
        for (&from, &to) in contour.iter().zip(contour.iter().cycle().skip(1)) {
            let corners = [
                low.place(from),
                low.place(to),
                high.place(to),
                high.place(from),
            ];
            size = corners
                .iter()
                .fold(size, |size, p| size.max(p.abs().max_element()));
            let [a, b, c, d] = corners;
            let flat = |p: DVec3, q: DVec3| (p - q).truncate().length();
            let (first, second) = (flat(a, c), flat(b, d));
            let same = 2e5 * (first - second).abs() <= first + second;
            let by_first = if same { !flip } else { first < second };
            let triangles = if by_first == shrinks {
                [[a, b, d], [b, c, d]]
            } else {
                [[a, b, c], [a, c, d]]
            };
            for points in triangles {
                if let Some(plane) = plane_of(&points) {
                    facets.push(Facet {
                        face: facets.len() as u32,
                        plane,
                        corners: points.into(),
                    });
                }
            }
        }
    }
    Solid::intersection([
        Tree::of(&facets, SAME_FACE * size).solid(),
        Solid::half_space_through(low.z * DVec3::Z, -DVec3::Z),
        Solid::half_space_through(high.z * DVec3::Z, DVec3::Z),
    ])
}
