//! Profiles, and the solids made of them.

use csg::elementary;
use std::f64::consts::PI;
use std::ops::Range;

use csg::glam::{DAffine2, DAffine3, DMat3, DVec2, DVec3};
use csg::{FillRule, Join, Profile, Solid, Twist};

use super::build::{Builder, is_size};
use super::error::SceneError;
use super::facets::Fineness;
use super::parse::{NodeText, Value};
use super::pieces::Piece;
use super::values::{array, list, number, sizes};

/// What is told where arcs cannot be kept.
/// Of a flat shape's size, how far chords stray from its arcs unless options say.
const CHORDS: f64 = 1e-4;

/// `linear_extrude`, but for what it extrudes.
pub(super) struct Extrusion {
    height: f64,
    /// How far it goes along x and y for each step along z.
    lean: DVec2,
    center: bool,
    /// In degrees, clockwise.
    twist: f64,
    scale: DVec2,
    slices: Option<f64>,
    fineness: Fineness,
}

impl Extrusion {
    /// By how much it makes what it extrudes wider, if it does.
    pub(super) fn widest(&self) -> f64 {
        self.scale.max_element().max(1.0)
    }
}

/// `rotate_extrude`, but for what it turns.
pub(super) struct Revolution {
    /// In degrees.
    angle: f64,
    /// Where it begins, in degrees; if nothing is said a whole turn does on the far side.
    start: Option<f64>,
    fineness: Fineness,
}

/// `offset`, but for what it grows.
pub(super) struct Growth {
    distance: f64,
    join: Join,
}

const LEGACY: [&str; 4] = ["file", "layer", "origin", "timestamp"];

/// What is extruded of a circle, as hulls know it.
fn frustum(center: DVec2, radius: f64, z: Range<f64>, scale: f64) -> Solid {
    let lean = (scale - 1.0) / (z.end - z.start) * center;
    let at_bottom = center - z.start * lean;
    let solid = if scale == 1.0 {
        Solid::cylinder(radius, z)
    } else {
        Solid::frustum(radius, scale * radius, z)
    };
    solid.affine(DAffine3 {
        matrix3: DMat3::from_cols(DVec3::X, DVec3::Y, lean.extend(1.0)),
        translation: at_bottom.extend(0.0),
    })
}

impl Builder<'_> {
    pub(super) fn circle(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [fn_, fa, fs, radius, diameter] =
            self.arguments(node, &["$fn", "$fa", "$fs", "r", "d"])?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let radius = match self.radius(node, ["r", "d"], [radius, diameter])? {
            Some(radius) => radius,
            None => self.number(node, "r", None)?,
        };
        if !is_size(radius) {
            return Ok(self.empty(node, "the radius"));
        }
        if !(self.is_faceted() || fineness.is_polygon()) {
            return Ok(Piece::Flat(Profile::circle(radius)));
        }
        let fragments = self.fragments(&fineness, radius);
        let fragments = self.facets(node, fragments, fragments)?;
        Ok(Piece::Flat(Profile::regular_polygon(fragments, radius)))
    }

    pub(super) fn square(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [size, center] = self.arguments(node, &["size", "center"])?;
        let Some(size) = size.and_then(sizes) else {
            return Err(self.fault(node, "it needs `size = [x, y]`"));
        };
        let center = self.flag(node, "center", center)?;
        if !size.iter().all(|&side| is_size(side)) {
            return Ok(self.empty(node, "a side"));
        }
        let size = DVec2::from_array(size);
        Ok(Piece::Flat(if center {
            Profile::rectangle(size)
        } else {
            Profile::rectangle_between(DVec2::ZERO, size)
        }))
    }

    pub(super) fn polygon(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [points, paths, _] = self.arguments(node, &["points", "paths", "convexity"])?;
        let points = points.and_then(|value| list(value, |item| array(item, number)));
        let Some(points) = points else {
            return Err(self.fault(node, "it needs `points = [[x, y], ..]`"));
        };
        let points: Vec<DVec2> = points.into_iter().map(DVec2::from_array).collect();
        if !points.iter().all(|point| point.abs().max_element() < 1e100) {
            return Ok(self.nothing(node, "a coordinate is not finite"));
        }
        let paths = match paths {
            None | Some(Value::Undefined) => vec![(0..points.len()).collect()],
            Some(value) => {
                let index = |item: &Value| {
                    let index = number(item)?;
                    (0.0..points.len() as f64)
                        .contains(&index)
                        .then_some(index as usize)
                };
                let paths = list(value, |path| list(path, index));
                paths.ok_or_else(|| {
                    let problem = "`paths` must be lists of numbers of points, from 0";
                    self.fault(node, problem)
                })?
            }
        };
        let contours: Vec<Vec<DVec2>> = paths
            .into_iter()
            .filter(|path| path.len() >= 3)
            .map(|path| path.into_iter().map(|index| points[index]).collect())
            .collect();
        if contours.is_empty() {
            return Ok(self.nothing(node, "it has fewer than three corners"));
        }
        let corners = contours.iter().map(Vec::len).sum::<usize>() as f64;
        self.facets(node, corners, corners)?;
        let profile = Profile::polygons_of(contours, FillRule::EvenOdd);
        self.flat(node, profile)
    }

    /// The profile, or nothing if it has no points.
    pub(super) fn flat(
        &mut self,
        node: &NodeText<'_>,
        profile: Profile,
    ) -> Result<Piece, SceneError> {
        let bounds = profile
            .bounds(1.0)
            .map_err(|e| self.fault(node, &e.to_string()))?;
        Ok(match bounds {
            Some(_) => Piece::Flat(profile),
            None => Piece::Nothing,
        })
    }

    pub(super) fn growth(&mut self, node: &NodeText<'_>) -> Result<Growth, SceneError> {
        let keys = ["r", "delta", "chamfer", "$fn", "$fa", "$fs"];
        let [r, delta, chamfer, fn_, fa, fs] = self.arguments(node, &keys)?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let chamfer = self.flag(node, "chamfer", chamfer)?;
        let (key, value) = if r.is_some() {
            ("r", r)
        } else {
            ("delta", delta)
        };
        let distance = self.number(node, key, value)?;
        if !distance.is_finite() {
            return Err(self.fault(node, "the distance must be finite"));
        }
        let join = if r.is_none() {
            if chamfer {
                Join::Square
            } else {
                Join::Mitre(1e6)
            }
        } else if self.is_faceted() || fineness.is_polygon() {
            let fragments = self.fragments(&fineness, distance.abs());
            Join::Chords(self.facets(node, fragments, fragments)?)
        } else {
            Join::Round
        };
        Ok(Growth { distance, join })
    }

    pub(super) fn grown(
        &mut self,
        node: &NodeText<'_>,
        profile: &Profile,
        growth: &Growth,
    ) -> Result<Piece, SceneError> {
        let grown = match profile.exact_offset(growth.distance, growth.join) {
            Some(grown) => grown,
            None => {
                let chords = self.in_chords(node, profile)?;
                chords.offset(growth.distance, growth.join)
            }
        };
        self.flat(node, grown)
    }

    /// A flat shape with chords for its arcs, with a warning.
    pub(super) fn in_chords(
        &mut self,
        node: &NodeText<'_>,
        profile: &Profile,
    ) -> Result<Profile, SceneError> {
        let within = match self.within() {
            Some(within) => within,
            None => CHORDS * self.size_of(node, profile)?,
        };
        self.warn(
            node,
            format!("its arcs are taken for chords within {within:.0e}"),
        );
        self.strayed(within);
        Ok(profile.flattened(within))
    }

    /// The farthest of a flat shape's coordinates.
    fn size_of(&self, node: &NodeText<'_>, profile: &Profile) -> Result<f64, SceneError> {
        let bounds = profile
            .bounds(1e-3)
            .map_err(|e| self.fault(node, &e.to_string()))?;
        Ok(bounds.map_or(1.0, |(min, max)| min.abs().max(max.abs()).max_element()))
    }

    pub(super) fn extrusion(&mut self, node: &NodeText<'_>) -> Result<Extrusion, SceneError> {
        let keys = [
            "height",
            "v",
            "center",
            "convexity",
            "twist",
            "slices",
            "scale",
            "$fn",
            "$fa",
            "$fs",
            LEGACY[0],
            LEGACY[1],
            LEGACY[2],
            LEGACY[3],
        ];
        let [
            height,
            along,
            center,
            _,
            twist,
            slices,
            scale,
            fn_,
            fa,
            fs,
            ..,
        ] = self.arguments(node, &keys)?;
        let scale = match scale {
            None => DVec2::ONE,
            Some(&Value::Number(scale)) => DVec2::splat(scale),
            Some(value) => match array(value, number) {
                Some(scale) => DVec2::from_array(scale),
                None => return Err(self.fault(node, "`scale` must be [x, y]")),
            },
        };
        let optional = |key, value: Option<&Value>| match value {
            Some(_) => self.number(node, key, value).map(Some),
            None => Ok(None),
        };
        let twist = optional("twist", twist)?.unwrap_or(0.0);
        if !(twist.is_finite() && scale.is_finite()) {
            return Err(self.fault(node, "`twist` and `scale` must be finite"));
        }
        let (height, lean) = match along {
            None | Some(Value::Undefined) => (self.number(node, "height", height)?, DVec2::ZERO),
            Some(value) => {
                let along = array(value, number).map(DVec3::from_array);
                let along = along.filter(|along| along.is_finite());
                let along =
                    along.ok_or_else(|| self.fault(node, "`v` must be [x, y, z], all finite"))?;
                // With a height it is a direction.
                let along = match optional("height", height)? {
                    Some(height) => height * along.normalize_or_zero(),
                    None => along,
                };
                (along.z, along.truncate() / along.z)
            }
        };
        Ok(Extrusion {
            height,
            lean,
            center: self.flag(node, "center", center)?,
            twist,
            scale: scale.max(DVec2::ZERO),
            slices: optional("slices", slices)?,
            fineness: self.fineness(node, [fn_, fa, fs])?,
        })
    }

    pub(super) fn extruded(
        &mut self,
        node: &NodeText<'_>,
        profile: &Profile,
        extrusion: &Extrusion,
    ) -> Result<Piece, SceneError> {
        let &Extrusion {
            height,
            scale,
            twist,
            lean,
            ..
        } = extrusion;
        if !is_size(height) {
            return Ok(self.empty(node, "the height"));
        }
        let z = if extrusion.center {
            -0.5 * height..0.5 * height
        } else {
            0.0..height
        };
        let round = profile
            .as_circle()
            .filter(|_| twist == 0.0 && scale.x == scale.y);
        let solid = if let Some((center, radius)) = round {
            frustum(center, radius, z, scale.x)
        } else if twist == 0.0 && scale == DVec2::ONE {
            Solid::extrude(profile, z)
        } else if twist == 0.0
            && (scale.x == scale.y || !self.is_faceted() && profile.is_straight())
        {
            Solid::extrude_scaled(profile, z, scale)
        } else if !self.is_faceted() {
            let radians = -twist.to_radians();
            let within = self.within();
            if let Ok(near) = Solid::twist_accuracy(profile, radians, scale, within) {
                self.facets(node, 1.0, near.faces as f64)?;
                let off = near.deviation;
                self.warn(
                    node,
                    format!("it is taken for flat faces within {off:.1e} of it"),
                );
            }
            match within {
                Some(within) => Solid::extrude_twisted_within(profile, z, radians, scale, within),
                None => Solid::extrude_twisted(profile, z, radians, scale),
            }
        } else {
            let steps = self.slices(node, profile, extrusion)?;
            let radians = -twist.to_radians();
            Solid::extrude_in_steps(
                profile,
                z,
                Twist {
                    radians,
                    scale,
                    steps,
                },
            )
        };
        self.strays = self.strays.map(|strays| strays * extrusion.widest());
        let solid = self.standing_in(solid);
        let solid = if lean == DVec2::ZERO {
            solid
        } else {
            let shear = DMat3::from_cols(DVec3::X, DVec3::Y, lean.extend(1.0));
            solid.affine(DAffine3::from_mat3(shear))
        };
        self.made(node, solid)
    }

    /// How many layers an extrusion has that does not go straight: the rules of
    /// OpenSCAD's `Calc::get_helix_slices`, `get_conical_helix_slices` and
    /// `get_diagonal_slices`.
    fn slices(
        &mut self,
        node: &NodeText<'_>,
        profile: &Profile,
        extrusion: &Extrusion,
    ) -> Result<usize, SceneError> {
        const GRID_FINE: f64 = 1.0 / (1 << 20) as f64;
        let &Extrusion {
            height,
            scale,
            fineness,
            ..
        } = extrusion;
        let twist = extrusion.twist.abs();
        let Fineness {
            number,
            angle,
            size,
        } = fineness;
        let contours = self.contours_of(node, profile)?;
        let corners = contours.iter().map(Vec::len).sum::<usize>() as f64;
        let furthest = |length: &dyn Fn(DVec2) -> f64| {
            contours
                .iter()
                .flatten()
                .map(|&p| length(p))
                .fold(0.0, f64::max)
        };
        let least = (twist / 120.0).ceil().max(1.0);
        let slices = if let Some(slices) = extrusion.slices {
            slices.trunc().max(1.0)
        } else if twist == 0.0 {
            let delta = furthest(&|p| (p - p * scale).length());
            if delta < GRID_FINE || !number.is_finite() {
                1.0
            } else if number > 0.0 {
                number.trunc().max(1.0)
            } else {
                (elementary::hypot(delta, height) / size).ceil().max(1.0)
            }
        } else {
            let radius = furthest(&|p| p.length());
            let radians = twist.to_radians();
            if radius < GRID_FINE || !number.is_finite() {
                least
            } else if number > 0.0 {
                (twist / 360.0 * number).ceil().max(least)
            } else {
                let length = if scale == DVec2::ONE || scale.x != scale.y {
                    radians * elementary::hypot(radius, height / radians)
                } else {
                    let end = if scale.x > 1.0 {
                        radians * scale.x / (scale.x - 1.0)
                    } else {
                        radians / (1.0 - scale.x)
                    };
                    let spiral = |t: f64| {
                        0.5 * radius / end * (t * (1.0 + t * t).sqrt() + elementary::asinh(t))
                    };
                    elementary::hypot(spiral(end) - spiral(end - radians), height)
                };
                (twist / angle)
                    .ceil()
                    .min((length / size).ceil())
                    .max(least)
            }
        };
        self.facets(node, slices, 2.0 * slices * corners)
    }

    fn contours_of(
        &self,
        node: &NodeText<'_>,
        profile: &Profile,
    ) -> Result<Vec<Vec<DVec2>>, SceneError> {
        let contours = profile.contours(CHORDS * self.size_of(node, profile)?);
        contours.map_err(|e| self.fault(node, &e.to_string()))
    }

    pub(super) fn revolution(&mut self, node: &NodeText<'_>) -> Result<Revolution, SceneError> {
        let keys = [
            "angle",
            "start",
            "convexity",
            "$fn",
            "$fa",
            "$fs",
            "scale",
            LEGACY[0],
            LEGACY[1],
            LEGACY[2],
            LEGACY[3],
        ];
        let [angle, start, _, fn_, fa, fs, ..] = self.arguments(node, &keys)?;
        let angle = match angle {
            Some(_) => self.number(node, "angle", angle)?,
            None => 360.0,
        };
        let start = match start {
            None | Some(Value::Undefined) => None,
            Some(_) => Some(self.number(node, "start", start)?),
        };
        if start.is_some_and(|start| !start.is_finite()) {
            return Err(self.fault(node, "`start` must be finite"));
        }
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        Ok(Revolution {
            angle,
            start,
            fineness,
        })
    }

    pub(super) fn revolved(
        &mut self,
        node: &NodeText<'_>,
        profile: &Profile,
        revolution: &Revolution,
    ) -> Result<Piece, SceneError> {
        let Revolution {
            angle,
            start,
            fineness,
        } = *revolution;
        if angle == 0.0 {
            return Ok(self.nothing(node, "the angle is 0"));
        }
        // OpenSCAD's rule: all that is no angle within a turn is a whole one.
        let whole = !(angle > -360.0 && angle < 360.0);
        let contours = self.contours_of(node, profile)?;
        let (least, most) = contours
            .iter()
            .flatten()
            .fold((0.0_f64, 0.0_f64), |(least, most), p| {
                (least.min(p.x), most.max(p.x))
            });
        let slack = 1e-12 * most.max(-least);
        if least < -slack && most > slack {
            // (Chords of arcs tell four digits of their extent.)
            let decimals = 2.0 - elementary::log10(most - least).floor();
            let decimals = decimals.clamp(0.0, 15.0) as usize;
            let problem = format!(
                "all points must be on the same side of the axis, but x goes from \
                 {least:.decimals$} to {most:.decimals$}"
            );
            return Ok(self.nothing(node, &problem));
        }
        let mirrored = least < -slack;
        let profile = if mirrored {
            profile.affine(DAffine2::from_scale(DVec2::new(-1.0, 1.0)))
        } else {
            profile.clone()
        };
        let radians = if whole { 2.0 * PI } else { angle.to_radians() };
        let solid = if self.is_faceted() || fineness.is_polygon() {
            let fragments = self.fragments(&fineness, most - least);
            let share = if whole { 1.0 } else { angle.abs() / 360.0 };
            let steps = (fragments * share).trunc().max(1.0);
            let corners = contours.iter().map(Vec::len).sum::<usize>() as f64;
            let steps = self.facets(node, steps, steps * corners)?;
            Solid::revolve_in_steps(&profile, radians, steps)
        } else {
            let solid = match self.within() {
                Some(within) => Solid::revolve_within(&profile, radians, within),
                None => Solid::revolve_by(&profile, radians),
            };
            if let Some(within) = solid.strays() {
                let problem = format!(
                    "there are no tori: of circles and arcs off the axis chords are turned, \
                     within {within:.0e} of them"
                );
                self.warn(node, problem);
            }
            solid
        };
        let solid = self.standing_in(solid);
        // Whole turns begin on the far side.
        let start = start.unwrap_or(if whole { 180.0 } else { 0.0 });
        let start = (start + if mirrored { 180.0 } else { 0.0 }).rem_euclid(360.0);
        let turned = if start == 0.0 {
            solid.clone()
        } else {
            solid.rotate_z(start.to_radians())
        };
        match self.made(node, solid)? {
            Piece::Nothing => Ok(Piece::Nothing),
            _ => Ok(Piece::Solid(turned)),
        }
    }
}
