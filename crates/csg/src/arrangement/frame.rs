//! The frame in which a quadric has a simple shape, and its patches: parts cut
//! out by planes through its centre or axis, each of which is seen from one
//! direction without overlap.
//!
//! In coordinates (u, v, w) of the frame an ellipsoid is a sphere, a cone or a
//! cylinder circular. The planes, *seams*, are turned by irrational angles so
//! that no face of a model lies in them.

use crate::elementary;
use glam::{DMat3, DVec2, DVec3};
use smallvec::SmallVec;

use crate::program::{Kind, StandardForm, Surface};
use crate::surface::is_far;
use crate::surface::round::{Round, like_cylinder};

/// Of the reach of a scene, near its middle, but where no models are placed.
const BESIDE_ORIGIN: DVec3 = DVec3::new(0.012_34, 0.035_71, 0.021_13);

/// How a quadric is cut into patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// Closed: eight octants, seen along their diagonals.
    Closed,
    /// Around the axis w: four quadrants, seen along their diagonals.
    Around,
    /// A graph over the plane across w: seen along w.
    Graph,
}

/// A quadric in its own coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    shape: Shape,
    center: DVec3,
    /// From directions in space to directions in the frame; its determinant is
    /// positive.
    to_frame: DMat3,
    /// And back.
    from_frame: DMat3,
    /// The directions across the seams, in the frame.
    across: [DVec3; 3],
    /// Planes along which faces are cut.
    pub seams: SmallVec<[Surface; 3]>,
    /// A plane that meets the surface in no curve, but parts it in two.
    pub divider: Option<Surface>,
    /// The sign of the gradient along the direction of view, below the divider
    /// and above.
    facing: [f64; 2],
    /// How an elongated quadric is made round.
    pub round: Option<Round>,
}

impl Frame {
    /// None for planes, and for quadrics that are pairs of planes or empty. No
    /// point of the scene is farther from the origin than `reach`.
    pub fn of(surface: &Surface, reach: f64) -> Option<Self> {
        if surface.is_plane() {
            return None;
        }
        let form = surface.standard_form();
        let on_axis = like_cylinder(surface, &form, reach);
        let StandardForm {
            mut center,
            mut axes,
            mut values,
            slope,
            constant,
        } = form;
        let outward = values[0].signum();
        let mut facing = [outward; 2];
        let mut is_divided = false;
        let shape = if let Some(on_axis) = on_axis {
            (center, values[2]) = (on_axis, 0.0);
            Shape::Around
        } else {
            match surface.kind {
                Kind::Ellipsoid => Shape::Closed,
                Kind::HyperboloidOneSheet | Kind::EllipticCylinder => Shape::Around,
                Kind::Cone => {
                    is_divided = true;
                    Shape::Around
                }
                Kind::HyperboloidTwoSheets => {
                    is_divided = true;
                    facing = [outward, -outward];
                    Shape::Graph
                }
                Kind::HyperbolicCylinder => {
                    is_divided = true;
                    // Across the plane between its two sheets.
                    let apart = usize::from((constant > 0.0) == (values[0] > 0.0));
                    axes.swap(apart, 2);
                    values.swap(apart, 2);
                    let outward = -values[2].signum();
                    facing = [outward, -outward];
                    Shape::Graph
                }
                Kind::EllipticParaboloid | Kind::HyperbolicParaboloid | Kind::ParabolicCylinder => {
                    facing = [slope.signum(); 2];
                    if surface.kind == Kind::ParabolicCylinder && is_far(center.length(), reach) {
                        // Seen along its axis it is a graph about any place.
                        center = BESIDE_ORIGIN * reach;
                    }
                    Shape::Graph
                }
                Kind::Plane | Kind::ParallelPlanes => return None,
            }
        };
        // (Along an axis any scale would do: that of where it is widest.)
        let sizes = values.map(f64::abs);
        let least = sizes.iter().filter(|&&v| v != 0.0);
        let least = least.fold(f64::INFINITY, |m, &v| m.min(v));
        let scales = sizes.map(|v| if v == 0.0 { least } else { v }.sqrt());
        if axes[0].cross(axes[1]).dot(axes[2]) < 0.0 {
            axes[0] = -axes[0];
        }
        let rows = DMat3::from_cols(
            scales[0] * axes[0],
            scales[1] * axes[1],
            scales[2] * axes[2],
        );
        let to_frame = rows.transpose();
        let from_frame = to_frame.inverse();
        let across = match shape {
            Shape::Closed => {
                let turn = elementary::rotation_x(0.414_213_562)
                    * elementary::rotation_y(0.618_033_989)
                    * elementary::rotation_z(0.302_775_638);
                [turn.x_axis, turn.y_axis, turn.z_axis]
            }
            Shape::Around | Shape::Graph => {
                let turn = elementary::rotation_z(0.618_033_989);
                [turn.x_axis, turn.y_axis, DVec3::Z]
            }
        };
        let plane = |normal: DVec3| Surface::plane(center, (rows * normal).normalize_or_zero());
        // Cylinders that are graphs close around nothing: there is nothing to cut.
        let seams = match (shape, surface.kind) {
            (_, Kind::ParabolicCylinder | Kind::HyperbolicCylinder) => 0,
            (Shape::Closed, _) => 3,
            (Shape::Around | Shape::Graph, _) => 2,
        };
        Some(Self {
            shape,
            center,
            to_frame,
            from_frame,
            across,
            seams: across[..seams].iter().map(|&n| plane(n)).collect(),
            divider: is_divided.then(|| plane(DVec3::Z)),
            facing,
            round: Round::of(surface, reach),
        })
    }

    /// From directions in space to directions in the frame.
    pub fn to_frame(&self) -> DMat3 {
        self.to_frame
    }

    /// All planes that part the surface: seams, then the divider.
    pub fn planes(&self) -> impl Iterator<Item = &Surface> {
        self.seams.iter().chain(&self.divider)
    }

    /// The patch of a point: for each of the planes a bit that is set beyond it.
    /// Where the point lies in a plane, the direction in which the patch extends
    /// from it decides.
    pub fn patch(&self, point: DVec3, towards: DVec3, tolerance: f64) -> u8 {
        let bit = |plane: &Surface| {
            let value = plane.value(point);
            if value.abs() <= tolerance {
                plane.linear.dot(towards) > 0.0
            } else {
                value > 0.0
            }
        };
        (0..)
            .zip(self.planes())
            .fold(0, |bits, (k, plane)| bits | u8::from(bit(plane)) << k)
    }

    /// The direction, in the frame, along which a patch is seen, and whether the
    /// gradient points that way.
    fn view(&self, patch: u8) -> (DVec3, bool) {
        let sign = |k: usize| if patch >> k & 1 == 1 { 1.0 } else { -1.0 };
        let is_above = usize::from(self.divider.is_some() && patch >> self.seams.len() & 1 == 1);
        let across = |count: usize| (0..count).map(|k| sign(k) * self.across[k]).sum::<DVec3>();
        let view = match self.shape {
            Shape::Closed => across(3).normalize_or_zero(),
            Shape::Around => across(2).normalize_or_zero(),
            Shape::Graph => DVec3::Z,
        };
        (view, self.facing[is_above] > 0.0)
    }

    /// Coordinates in which a patch is a graph: the centre from which they count, and the
    /// directions of x, y and z in space, right-handed. On the segment from x = 0 to a point
    /// of the patch along x the graph goes on and on. And whether the gradient points along z.
    pub fn chart(&self, patch: u8) -> (DVec3, DMat3, bool) {
        let (view, faces) = self.view(patch);
        let (x, y) = match self.shape {
            Shape::Around => (DVec3::Z.cross(view), DVec3::Z),
            Shape::Closed | Shape::Graph => view.any_orthonormal_pair(),
        };
        let axes = self.from_frame * DMat3::from_cols(x, y, view);
        (self.center, axes, faces)
    }

    /// A point of a patch as seen along the patch's direction of view, from
    /// outside of the surface's half-space, or from inside.
    pub fn flatten(&self, patch: u8, from_outside: bool, point: DVec3) -> DVec2 {
        self.flatten_direction(patch, from_outside, point - self.center)
    }

    /// The same of a direction.
    pub fn flatten_direction(&self, patch: u8, from_outside: bool, direction: DVec3) -> DVec2 {
        let place = self.to_frame * direction;
        let (view, faces) = self.view(patch);
        // The pair and the view are right-handed, and so is the frame.
        let (u, v) = view.any_orthonormal_pair();
        let (x, y) = (place.dot(u), place.dot(v));
        if faces == from_outside {
            DVec2::new(x, y)
        } else {
            DVec2::new(y, x)
        }
    }

    /// The point of the surface that is seen where another point is, on the side
    /// of it that a patch is on.
    pub fn lift(&self, surface: &Surface, patch: u8, point: DVec3) -> DVec3 {
        let (view, faces) = self.view(patch);
        let view = self.from_frame * view;
        let square = 0.5 * surface.curvature_along(view);
        let linear = surface.gradient(point).dot(view);
        let constant = surface.value(point);
        // Where f grows along the view, if it should.
        let root = (linear * linear - 4.0 * square * constant).max(0.0).sqrt();
        let slope = if faces { root } else { -root };
        let step = if (slope > 0.0) == (linear > 0.0) {
            -2.0 * constant / (linear + slope)
        } else {
            (slope - linear) / (2.0 * square)
        };
        if step.is_finite() {
            point + step * view
        } else {
            point
        }
    }
}
