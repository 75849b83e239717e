//! Holes for screws and nuts, threads and knurls. Holes are tools to be
//! subtracted: they go down from z = 0.

use crate::elementary;
use std::f64::consts::{FRAC_PI_6, TAU};

use glam::{DVec2, dvec2};

use super::{below, positive};
use crate::error::NodeFault;
use crate::numeric::tolerance::NEAR;
use crate::solid::profile::Profile;
use crate::solid::{Solid, Twist};

/// A screw thread with the profile of ISO 68-1: a triangle of 60°, an eighth of its
/// height cut off at the crest and a quarter at the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    /// The nominal (major) diameter: 8 for M8.
    pub diameter: f64,
    /// The way up in one turn: 1.25 for M8.
    pub pitch: f64,
    /// Flat steps in one turn: 16 and more look round.
    pub steps: usize,
}

impl Screw {
    /// The coarse metric thread of ISO 261 of a nominal diameter between 1.6 and 24,
    /// in millimetres, if the standard prefers it.
    #[must_use]
    pub fn metric(diameter: f64) -> Option<Self> {
        const COARSE: [(f64, f64); 14] = [
            (1.6, 0.35),
            (2.0, 0.4),
            (2.5, 0.45),
            (3.0, 0.5),
            (4.0, 0.7),
            (5.0, 0.8),
            (6.0, 1.0),
            (8.0, 1.25),
            (10.0, 1.5),
            (12.0, 1.75),
            (14.0, 2.0),
            (16.0, 2.0),
            (20.0, 2.5),
            (24.0, 3.0),
        ];
        let &(diameter, pitch) = COARSE.iter().find(|(known, _)| *known == diameter)?;
        Some(Self {
            diameter,
            pitch,
            steps: 16,
        })
    }

    /// The height of the thread's profile, from root to crest: 5/8 of the triangle's.
    #[must_use]
    pub fn depth(&self) -> f64 {
        0.625 * 0.75_f64.sqrt() * self.pitch
    }

    /// Every cross-section: the radius over an angle as the axial profile has it over
    /// the way up. An eighth of the pitch is crest, a quarter root.
    fn cross_section(&self) -> Profile {
        let (crest, depth) = (0.5 * self.diameter, self.depth());
        let radius = |share: f64| {
            // From the middle of the crest, in pitches.
            let from_crest = (share - share.round()).abs();
            crest - depth * ((from_crest - 0.0625) / 0.3125).clamp(0.0, 1.0)
        };
        // Kinks of the profile are corners.
        let mut shares: Vec<f64> = (0..self.steps)
            .map(|k| k as f64 / self.steps as f64)
            .chain([0.0625, 0.375, 0.625, 0.9375])
            .collect();
        shares.sort_by(f64::total_cmp);
        shares.dedup_by(|a, b| (*a - *b).abs() < NEAR);
        let corners = shares.into_iter().map(|share| {
            let direction = elementary::direction(-TAU * share);
            radius(share) * direction
        });
        Profile::polygon(corners)
    }

    fn check(&self) -> Result<(), NodeFault> {
        positive("the diameter", self.diameter)?;
        below("the pitch", self.pitch, 0.5 * self.diameter)?;
        if self.steps < 3 {
            return Err(NodeFault::TooFewSteps { steps: self.steps });
        }
        Ok(())
    }
}

/// Holes, threads and grips.
impl Solid {
    /// A right-handed threaded rod around the z axis from z = 0, in flat steps
    /// ([`Solid::extrude_in_steps`], which says what that costs).
    #[must_use]
    pub fn threaded_rod(screw: Screw, length: f64) -> Self {
        let made = || {
            screw.check()?;
            let turns = positive("the length", length)? / screw.pitch;
            let twist = Twist {
                radians: TAU * turns,
                scale: DVec2::ONE,
                steps: (turns * screw.steps as f64).ceil().max(1.0) as usize,
            };
            Ok(Self::extrude_in_steps(
                &screw.cross_section(),
                0.0..length,
                twist,
            ))
        };
        Self::shaped("threaded_rod", made())
    }

    /// A hole of a screw with a cylindrical head: a bore of `depth`, and a wider one of
    /// `head_depth` from the top.
    #[must_use]
    pub fn counterbore(radius: f64, depth: f64, head_radius: f64, head_depth: f64) -> Self {
        let made = || {
            below("the radius", radius, head_radius)?;
            below("the head's depth", head_depth, depth)?;
            let bore = Self::cylinder(radius, -depth..0.0);
            Ok(bore | Self::cylinder(head_radius, -head_depth..0.0))
        };
        Self::shaped("counterbore", made())
    }

    /// A hole of a screw with a conical head: a bore of `depth`, widened to
    /// `head_radius` at the top by a cone of 90°.
    #[must_use]
    pub fn countersink(radius: f64, depth: f64, head_radius: f64) -> Self {
        let made = || {
            below("the radius", radius, head_radius)?;
            let sink = head_radius - radius;
            below("the head's depth", sink, depth)?;
            let bore = Self::cylinder(radius, -depth..0.0);
            Ok(bore | Self::frustum(radius, head_radius, -sink..0.0))
        };
        Self::shaped("countersink", made())
    }

    /// A pocket for a hexagonal nut, two of its corners on the x axis.
    #[must_use]
    pub fn nut_trap(across_flats: f64, depth: f64) -> Self {
        let made = || {
            let flats = positive("the width across flats", across_flats)?;
            positive("the depth", depth)?;
            let circumradius = 0.5 * flats / elementary::cos(FRAC_PI_6);
            Ok(Self::regular_prism(6, circumradius, -depth..0.0))
        };
        Self::shaped("nut_trap", made())
    }

    /// A slotted hole: all that a cutter of `radius` takes away on its way of `length`
    /// along x, centred.
    #[must_use]
    pub fn slot(length: f64, radius: f64, depth: f64) -> Self {
        let made = positive("the depth", depth)
            .map(|depth| Self::extrude(&Profile::slot(length, radius), -depth..0.0));
        Self::shaped("slot", made)
    }
}

/// Grips.
impl Profile {
    /// A circle with notches of 90° side by side: straight knurling, to be extruded.
    /// The tips are on the circle.
    #[must_use]
    pub fn knurled(radius: f64, notches: usize) -> Self {
        let half = std::f64::consts::PI / notches.max(1) as f64;
        // Down 45° from a tip half a notch aside.
        let root = radius * (elementary::cos(half) - elementary::sin(half));
        let corners = (0..2 * notches).map(|k| {
            let length = if k % 2 == 0 { radius } else { root };
            let turn = crate::solid::profile::turn(k, 2 * notches);
            dvec2(length * turn.x, length * turn.y)
        });
        Self::polygon(corners)
    }
}
