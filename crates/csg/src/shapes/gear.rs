//! Spur gears with involute flanks (ISO 53: tips one module above the pitch circle,
//! roots one and a quarter below).

use crate::elementary;
use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use crate::error::ProfileFault;
use crate::solid::profile::Profile;

/// A spur gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// The pitch circle's diameter over the number of teeth; gears that mesh have the
    /// same.
    pub module: f64,
    /// How many teeth, at least 5.
    pub teeth: usize,
    /// The pressure angle in degrees, from 10 to 30: mostly 20.
    pub pressure_degrees: f64,
    /// Chords along each flank.
    pub chords: usize,
}

impl Gear {
    /// A gear of the usual pressure angle of 20°.
    #[must_use]
    pub const fn new(module: f64, teeth: usize) -> Self {
        Self {
            module,
            teeth,
            pressure_degrees: 20.0,
            chords: 6,
        }
    }

    /// The radius of the circle on which two gears roll.
    #[must_use]
    pub fn pitch_radius(&self) -> f64 {
        0.5 * self.module * self.teeth as f64
    }

    /// The radii of the circles of roots, of which the flanks are involutes, and of tips.
    #[must_use]
    pub fn radii(&self) -> [f64; 3] {
        let pitch = self.pitch_radius();
        let base = pitch * elementary::cos(self.pressure_degrees.to_radians());
        [pitch - 1.25 * self.module, base, pitch + self.module]
    }

    /// The outline, centred at the origin, a tooth on +x. Flanks go straight inwards
    /// below the base circle; of a module or an angle out of range it is an error.
    #[must_use]
    pub fn profile(&self) -> Profile {
        if let Err(fault) = self.check() {
            return Profile::faulty(fault);
        }
        let flank = self.flank();
        let below = flank.iter().map(|p| DVec2::new(p.x, -p.y));
        let tooth: Vec<DVec2> = below.chain(flank.iter().rev().copied()).collect();
        let outline = (0..self.teeth).flat_map(|k| {
            let turn = crate::solid::profile::turn(k, self.teeth);
            let turned = tooth.iter().map(move |point| turn.rotate(*point));
            turned.collect::<Vec<_>>()
        });
        Profile::polygon(outline)
    }

    fn check(&self) -> Result<(), ProfileFault> {
        if !(self.module > 0.0 && self.module.is_finite()) {
            let what = "the module";
            let value = self.module;
            return Err(ProfileFault::NotPositive { what, value });
        }
        let range = [10.0, 30.0];
        let value = self.pressure_degrees;
        if !(value >= range[0] && value <= range[1]) {
            let what = "the pressure angle in degrees";
            return Err(ProfileFault::OutOfRange { what, value, range });
        }
        if self.teeth < 5 {
            let what = "the number of teeth";
            let (value, range) = (self.teeth as f64, [5.0, f64::INFINITY]);
            return Err(ProfileFault::OutOfRange { what, value, range });
        }
        Ok(())
    }

    /// The half of a tooth above the x axis: from the root circle up to the tip circle.
    fn flank(&self) -> Vec<DVec2> {
        let [root, base, tip] = self.radii();
        // On the involute the radius is base √(1 + t²), at the angle t - atan t.
        let involute = |t: f64| t - elementary::atan(t);
        let pressure = self.pressure_degrees.to_radians();
        let half = FRAC_PI_2 / self.teeth as f64 + involute(elementary::tan(pressure));
        let parameter = |radius: f64| ((radius / base).powi(2) - 1.0).max(0.0).sqrt();
        let (first, last) = (parameter(root), parameter(tip));
        let mut points = Vec::with_capacity(self.chords + 2);
        if root < base {
            points.push(elementary::direction(half) * root);
        }
        let chords = self.chords.max(1);
        points.extend((0..=chords).map(|k| {
            let t = first + (last - first) * k as f64 / chords as f64;
            elementary::direction(half - involute(t)) * (base * (1.0 + t * t).sqrt())
        }));
        points
    }
}
