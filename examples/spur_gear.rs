//! A spur gear with involute flanks: `cargo run --release --example spur_gear -- render -o gear.png`,
//! with other teeth `-- 31 render -o gear.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::glam::DVec2;
use stereotomy::csg::{Profile, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// How many teeth
    #[arg(default_value_t = 24, value_parser = clap::value_parser!(u32).range(8..))]
    teeth: u32,
}

const MODULE: f64 = 2.0;
const PRESSURE_ANGLE: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Chords along one flank.
const CHORDS: u32 = 6;

/// One tooth's half above the x axis: from the root circle up an involute of
/// the base circle to the tip circle.
fn flank(teeth: f64) -> Vec<DVec2> {
    let pitch = 0.5 * MODULE * teeth;
    let (base, tip, root) = (
        pitch * PRESSURE_ANGLE.cos(),
        pitch + MODULE,
        pitch - 1.25 * MODULE,
    );
    // On the involute the radius is base √(1 + t²), at the angle t - atan t.
    let involute = |t: f64| t - t.atan();
    let half = std::f64::consts::FRAC_PI_2 / teeth + involute(PRESSURE_ANGLE.tan());
    let last = ((tip / base).powi(2) - 1.0).sqrt();
    let first = ((root / base).powi(2) - 1.0).max(0.0).sqrt();
    let mut points = vec![DVec2::from_angle(half - involute(first)) * root];
    for k in 0..=CHORDS {
        let t = first + (last - first) * f64::from(k) / f64::from(CHORDS);
        let radius = base * (1.0 + t * t).sqrt();
        if radius > root * 1.0001 {
            points.push(DVec2::from_angle(half - involute(t)) * radius);
        }
    }
    points
}

fn gear(arguments: Arguments) -> Solid {
    let teeth = f64::from(arguments.teeth);
    let flank = flank(teeth);
    let below = flank.iter().map(|p| DVec2::new(p.x, -p.y));
    let tooth: Vec<DVec2> = below.chain(flank.iter().rev().copied()).collect();
    let outline = (0..arguments.teeth).flat_map(|k| {
        let turn = DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / teeth);
        tooth
            .iter()
            .map(move |point| turn.rotate(*point))
            .collect::<Vec<_>>()
    });
    let pitch = 0.5 * MODULE * teeth;
    let bore = Profile::circle(0.25 * pitch);
    let keyway = Profile::rectangle_between([0.0, -1.5], [0.25 * pitch + 1.5, 1.5]);
    let web = Profile::circle(0.78 * pitch) - Profile::circle(0.42 * pitch);
    let blank = Solid::extrude(&(Profile::polygon(outline) - bore - keyway), 0.0..10.0);
    let recess = Solid::extrude(&web, 0.0..3.0);
    blank.named("gear") - recess.translate([0.0, 0.0, 7.5]) - recess.translate([0.0, 0.0, -0.5])
}

fn main() -> ExitCode {
    cli::run_with(gear)
}
