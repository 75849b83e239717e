//! Options for a view by its reference point and window.

use glam::{DVec2, DVec3};
use raster::view_reference::{ProjectionType, ViewReference};
use raster::{Camera, Frame, Mesh};

use super::parse::{numbers, point};

/// A view as GKS-3D and PHIGS have it. Where one is given, its window is mapped to
/// the picture, and must have its proportions.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "View reference")]
pub(super) struct Reference {
    /// View-plane normal, towards the viewer, in place of a camera
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = place,
          conflicts_with_all = ["camera", "fov", "up", "near", "far", "sheet", "turntable"])]
    vpn: Option<DVec3>,
    /// View reference point, the origin of the view plane
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = place,
          default_value = "0,0,0", requires = "vpn")]
    vrp: DVec3,
    /// View-up vector [default: Z, or Y for a normal along Z]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = place, requires = "vpn")]
    vup: Option<DVec3>,
    /// Projection reference point; u, v and n are measured in the view plane and
    /// along its normal. A parallel projection is along the way from there to the
    /// window's middle: its direction of projection, DOP [default: before the
    /// window's middle, one and a half times the model's size from it]
    #[arg(long, value_name = "U,V,N", allow_hyphen_values = true, value_parser = place, requires = "vpn")]
    prp: Option<DVec3>,
    /// The window in the view plane [default: around the model]
    #[arg(long, value_name = "UMIN,UMAX,VMIN,VMAX", allow_hyphen_values = true,
          value_parser = window, requires = "vpn")]
    window: Option<[DVec2; 2]>,
    /// n of the front and of the back clipping plane [default: around the model]
    #[arg(long, value_name = "FRONT,BACK", allow_hyphen_values = true,
          value_parser = planes, requires = "vpn")]
    clip_planes: Option<[f64; 2]>,
}

fn place(text: &str) -> Result<DVec3, String> {
    point(text).ok_or_else(|| "give three numbers like 0,0,1".into())
}

fn window(text: &str) -> Result<[DVec2; 2], String> {
    match numbers(text) {
        Some([a, b, c, d]) if a < b && c < d => Ok([DVec2::new(a, c), DVec2::new(b, d)]),
        _ => Err("give two ranges like -2,2,-1.5,1.5".into()),
    }
}

fn planes(text: &str) -> Result<[f64; 2], String> {
    match numbers(text) {
        Some([front, back]) if front > back => Ok([front, back]),
        _ => Err("give n of the front and the back, the greater one first, like 3,-3".into()),
    }
}

impl Reference {
    /// Along which one looks, if a view is given.
    pub(super) fn direction(&self) -> Option<DVec3> {
        self.vpn.map(|normal| -normal)
    }

    /// What is upwards, if that is given.
    pub(super) fn up(&self) -> Option<DVec3> {
        self.vup
    }

    /// The view of a mesh that is asked for, if one is; `framed` sees all of it.
    pub(super) fn view(
        &self,
        mesh: &Mesh,
        framed: &Camera,
        parallel: bool,
        aspect: f64,
    ) -> Option<ViewReference> {
        let vpn = self.vpn?;
        let frame = Frame::right_handed(-vpn, framed.up);
        let relative = |p: DVec3| {
            let p = p - self.vrp;
            DVec3::new(p.dot(frame.u), p.dot(frame.v), p.dot(frame.n))
        };
        let points = || {
            mesh.positions
                .iter()
                .filter(|p| p.is_finite())
                .map(|&p| relative(p))
        };
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, size) = ((low + high) / 2.0, high - low);
        let centre = match self.window {
            Some([low, high]) => (low + high) / 2.0,
            None => middle.truncate(),
        };
        let prp = self.prp.unwrap_or_else(|| {
            let before = high.z.max(0.0) + 1.5 * size.max_element();
            centre.extend(before)
        });
        let [window_low, window_high] = self.window.unwrap_or_else(|| {
            let along = centre.extend(0.0) - prp;
            let on_plane = |p: DVec3| {
                if parallel {
                    p - along * (p.z / along.z)
                } else {
                    prp + (p - prp) * (prp.z / (prp.z - p.z))
                }
            };
            let before = points().filter(|p| parallel || p.z < prp.z);
            let reach = before.map(|p| (on_plane(p).truncate() - centre).abs());
            let reach = reach.fold(DVec2::ZERO, DVec2::max);
            let half = reach.y.max(reach.x / aspect) / 0.9;
            let half = DVec2::new(half * aspect, half);
            [centre - half, centre + half]
        });
        let [front, back] = self.clip_planes.unwrap_or_else(|| {
            let margin = size.length() * 0.01;
            let front = high.z + margin;
            let nearest = if parallel {
                front
            } else {
                front.min(prp.z * 0.999)
            };
            [nearest, (low.z - margin).min(nearest - margin)]
        });
        Some(ViewReference {
            vrp: self.vrp,
            vpn,
            vup: framed.up,
            prp,
            window_low,
            window_high,
            front,
            back,
            projection: if parallel {
                ProjectionType::Parallel
            } else {
                ProjectionType::Perspective
            },
        })
    }
}

/// The side of a pixel of a picture so many pixels high, where that is least.
pub(super) fn least_pixel(view: &ViewReference, height: u32) -> f64 {
    let pixel = (view.window_high.y - view.window_low.y) / f64::from(height.max(1));
    match view.projection {
        ProjectionType::Perspective => pixel * (view.prp.z - view.front) / view.prp.z,
        ProjectionType::Parallel => pixel,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_and_planes() {
        let corners = [DVec2::new(-2.0, -1.5), DVec2::new(2.0, 1.0)];
        assert_eq!(window("-2,2,-1.5,1"), Ok(corners));
        assert_eq!(planes("3,-3"), Ok([3.0, -3.0]));
        for faulty in ["", "1,2", "2,1,0,1", "0,1,1,1", "0,1,0,nan"] {
            assert!(window(faulty).is_err(), "{faulty}");
        }
        for faulty in ["", "1", "-3,3", "1,1", "1,2,3"] {
            assert!(planes(faulty).is_err(), "{faulty}");
        }
    }
}
