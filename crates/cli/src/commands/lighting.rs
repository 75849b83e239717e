//! Options for lights and for how surfaces reflect.

use std::str::FromStr;

use csg::{Color, Surface};
use glam::{DVec3, Vec3};
use raster::{Finish, Light, Prepared, RenderOptions, Texture};

use super::parse::{color, length, point};

/// Options for light.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Light and material")]
pub(super) struct Lighting {
    /// How surfaces reflect: Ka, Kd, Ks and n of the Phong model [default:
    /// 1,1,0.15,30]
    #[arg(long, value_name = "KA,KD,KS,N", value_parser = finish)]
    material: Option<Finish>,
    /// A light in place of the three that follow the camera: the direction
    /// towards it, and its colour; up to 16
    #[arg(long, value_name = "X,Y,Z[:COLOR]", allow_hyphen_values = true)]
    light: Vec<Placed>,
    /// A light at a place, likewise
    #[arg(long, value_name = "X,Y,Z[:COLOR]", allow_hyphen_values = true)]
    point_light: Vec<Placed>,
    /// The light from everywhere
    #[arg(long, value_name = "COLOR", value_parser = color)]
    ambient: Option<Color>,
    /// Light from a sky and a ground, in place of that from everywhere
    #[arg(long, value_name = "SKY:GROUND", value_parser = environment, conflicts_with = "ambient")]
    environment: Option<(Color, Color)>,
    /// Dye the model in cubes of this side length, or squares about so long, light
    /// and dark in turn
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    checker: Option<f64>,
    /// What the checker goes by: the place of points, or the parameters of the
    /// surface that each lies on
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = By::Position, requires = "checker")]
    checker_by: By,
}

/// What a pattern goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum By {
    /// Cubes
    Position,
    /// Squares along and around each surface of a solid
    Surface,
}

/// A light's place or direction, and its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placed(DVec3, Color);

impl FromStr for Placed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (place, own) = match text.split_once(':') {
            Some((place, own)) => (place, color(own)?),
            None => (text, Color::from_linear([1.0; 3])),
        };
        let place = point(place).ok_or("give a light like 1,-1,2 or 1,-1,2:ffeedd")?;
        Ok(Self(place, own))
    }
}

fn finish(text: &str) -> Result<Finish, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([ka, kd, ks, n]) if [ka, kd, ks, n].iter().all(|v| (0.0..=1e4).contains(*v)) => {
            Ok(Finish::new(*ka, *kd, *ks, *n))
        }
        _ => Err("give four numbers from 0 like 0.5,0.5,0.8,4".into()),
    }
}

fn environment(text: &str) -> Result<(Color, Color), String> {
    let (sky, ground) = text
        .split_once(':')
        .ok_or("give two colours like ddeeff:887755")?;
    Ok((color(sky)?, color(ground)?))
}

impl Lighting {
    /// Changes the options as they say.
    pub(super) fn apply(&self, options: &mut RenderOptions) {
        if let Some(finish) = self.material {
            options.finish = finish;
        }
        let rgb = |color: Color| Vec3::from_array(color.rgb);
        let own = |placed: &Placed| rgb(placed.1);
        let directions = self.light.iter().map(|light| Light::Directional {
            towards: light.0,
            intensity: own(light),
        });
        let places = self.point_light.iter().map(|light| Light::Point {
            position: light.0,
            intensity: own(light),
        });
        let given: Vec<Light> = directions.chain(places).take(16).collect();
        let is_ambient = |light: &Light| matches!(light, Light::Ambient { .. });
        if !given.is_empty() {
            options.lights.retain(is_ambient);
            options.lights.extend(given);
        }
        let around = match (self.ambient, self.environment) {
            (Some(color), _) => Light::Ambient {
                intensity: rgb(color),
            },
            (None, Some((sky, ground))) => Light::Environment {
                up: DVec3::Z,
                sky: rgb(sky),
                ground: rgb(ground),
            },
            (None, None) => return,
        };
        options.lights.retain(|light| !is_ambient(light));
        options.lights.push(around);
    }

    /// Dyes the surfaces of a solid, or the whole scene, in the pattern asked for.
    pub(super) fn dye(
        &self,
        scene: Prepared,
        surfaces: &[Surface],
        options: &RenderOptions,
    ) -> Prepared {
        let Some(side) = self.checker else {
            return scene;
        };
        let light = options.default_color;
        let colors = [light, Color::from_linear(light.rgb.map(|c| c * 0.35))];
        match self.checker_by {
            By::Position => scene.textured(Texture::checker(side, colors)),
            By::Surface => {
                let patterns = surfaces.iter();
                scene.with_textures(patterns.map(|s| Texture::on_surface(s, side, colors)))
            }
        }
    }

    /// Whether the pattern goes by what only a solid knows.
    pub(super) fn needs_solid(&self) -> bool {
        self.checker_by == By::Surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_and_finishes() {
        let red = Color::from_srgb([1.0, 0.0, 0.0]);
        assert_eq!(
            "1,-2,3:ff0000".parse(),
            Ok(Placed(DVec3::new(1.0, -2.0, 3.0), red))
        );
        for faulty in ["", "1,2", "1,2,3:reddish", "1,2,3:"] {
            assert!(faulty.parse::<Placed>().is_err(), "{faulty}");
        }
        assert_eq!(finish("0.5,0.5,0.8,4"), Ok(Finish::new(0.5, 0.5, 0.8, 4.0)));
        for faulty in ["", "1,1,1", "1,1,1,-1", "1,1,1,nan"] {
            assert!(finish(faulty).is_err(), "{faulty}");
        }
        assert!(environment("ffffff").is_err());
    }
}
