//! Boxes around primitives in closed form, by the map that puts them in place: they hold
//! however flat or long that makes them, when coefficients tell no more of it.

use glam::{DAffine3, DVec2, DVec3};

use super::Bounds;
use crate::numeric::tolerance::MAPPED;
use crate::solid::Primitive;

impl Bounds {
    pub(super) const NOTHING: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    pub(super) const EVERYTHING: Self = Self {
        min: DVec3::NEG_INFINITY,
        max: DVec3::INFINITY,
    };

    pub(super) fn is_finite(self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// By a distance to all sides.
    pub(crate) fn grown(self, by: f64) -> Self {
        Self {
            min: self.min - by,
            max: self.max + by,
        }
    }

    /// The box around the images of points.
    fn of_points(map: &DAffine3, points: impl Iterator<Item = DVec3>) -> Self {
        points.fold(Self::NOTHING, |all, point| {
            let image = map.transform_point3(point);
            all.united(Self::around(image, DVec3::ZERO))
        })
    }

    /// The box around the image of a box, rounding allowed for.
    pub(super) fn of_box(map: &DAffine3, [min, max]: [DVec3; 2]) -> Self {
        Self::of_points(map, corners(min, max)).rounded_outward(map)
    }

    /// The box around the image of an ellipse across z, about a point of the z axis.
    fn of_ellipse(map: &DAffine3, radii: DVec2, z: f64) -> Self {
        let linear = map.matrix3;
        let (u, v) = (radii.x * linear.x_axis, radii.y * linear.y_axis);
        let half = (u * u + v * v).map(f64::sqrt);
        Self::around(map.transform_point3(z * DVec3::Z), half)
    }

    /// Grown by what rounding may have taken.
    fn rounded_outward(self, map: &DAffine3) -> Self {
        let magnitude = self.min.abs().max(self.max.abs()) + map.translation.abs();
        let slack = MAPPED * DVec3::splat(magnitude.max_element());
        Self {
            min: self.min - slack,
            max: self.max + slack,
        }
    }
}

fn corners(min: DVec3, max: DVec3) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |k| {
        let is_upper = [1, 2, 4].map(|bit| k & bit != 0);
        DVec3::select(is_upper.into(), max, min)
    })
}

/// A box around a primitive put in place by a map; infinite for those without end, and
/// for some that only their planes together bound.
pub(super) fn reach(primitive: &Primitive, map: &DAffine3) -> Bounds {
    let bounds = match primitive {
        Primitive::Empty => Bounds::NOTHING,
        Primitive::Cuboid { min, max } => Bounds::of_points(map, corners(*min, *max)),
        Primitive::Ellipsoid { radii } => {
            let linear = map.matrix3;
            let (u, v, w) = (
                radii.x * linear.x_axis,
                radii.y * linear.y_axis,
                radii.z * linear.z_axis,
            );
            let half = (u * u + v * v + w * w).map(f64::sqrt);
            Bounds::around(map.translation, half)
        }
        Primitive::Cylinder { radii, z: Some(z) } => {
            let [low, high] = [z.start, z.end].map(|z| Bounds::of_ellipse(map, *radii, z));
            low.united(high)
        }
        Primitive::Frustum { bottom, top, z } => {
            let ends = [(*bottom, z.start), (*top, z.end)];
            let [low, high] =
                ends.map(|(radius, z)| Bounds::of_ellipse(map, DVec2::splat(radius), z));
            low.united(high)
        }
        Primitive::Prism { polygon, z } => {
            let ends = [z.start, z.end];
            let at = |z: f64| polygon.iter().map(move |corner| corner.extend(z));
            Bounds::of_points(map, ends.into_iter().flat_map(at))
        }
        Primitive::Polyhedron(polyhedron) => {
            Bounds::of_points(map, polyhedron.vertices().iter().copied())
        }
        _ => return Bounds::EVERYTHING,
    };
    bounds.rounded_outward(map)
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, EulerRot};

    use super::*;
    use crate::random::Random;
    use crate::{Program, Solid};

    /// No point of a primitive lies outside its box, and points of it come near each of
    /// the box's sides.
    #[test]
    fn boxes_fit_tightly() {
        let mut random = Random(11);
        let polygon = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.5]].map(DVec2::from);
        let primitives = [
            Solid::cuboid([1.0, 2.0, 3.0]),
            Solid::ellipsoid([1.0, 0.3, 2.0]),
            Solid::cylinder(0.7, -1.0..2.0),
            Solid::frustum(1.0, 0.2, 0.0..1.5),
            Solid::prism(polygon, -0.5..1.0),
        ];
        for round in 0..10 {
            let mut angle = || 6.0 * random.unit();
            let turn = DQuat::from_euler(EulerRot::XYZ, angle(), angle(), angle());
            let map = DAffine3::from_scale_rotation_translation(
                DVec3::new(1.0, 1.0, 0.5 + random.unit()),
                turn,
                DVec3::new(3.0, f64::from(round), 0.0),
            );
            for solid in &primitives {
                let program = Program::lower(&solid.affine(map)).expect("valid");
                let bounds = program.reach();
                let mut inside = Bounds::NOTHING;
                for _ in 0..60_000 {
                    let share = DVec3::from_array(std::array::from_fn(|_| random.unit()));
                    let point = bounds.center() + 1.2 * (share - 0.5) * bounds.size();
                    if program.contains(point) {
                        inside = inside.united(Bounds::around(point, DVec3::ZERO));
                    }
                }
                let grown = bounds.size() * 1e-9;
                assert!(inside.min.cmpge(bounds.min - grown).all());
                assert!(inside.max.cmple(bounds.max + grown).all());
                let gap = (inside.min - bounds.min).max(bounds.max - inside.max);
                assert!(
                    gap.cmplt(0.2 * bounds.size()).all(),
                    "{inside:?} {bounds:?}"
                );
            }
        }
    }

    #[test]
    fn boxes_combine_like_solids() {
        let [a, b] = [0.0, 1.5].map(|x| Solid::sphere(1.0).translate([x, 0.0, 0.0]));
        let reach = |solid: &Solid| Program::lower(solid).expect("valid").reach();
        let is = |bounds: Bounds, low: f64, high: f64| {
            assert!((bounds.min.x - low).abs() < 1e-12 && (bounds.max.x - high).abs() < 1e-12);
        };
        is(reach(&(&a | &b)), -1.0, 2.5);
        is(reach(&(&a & &b)), 0.5, 1.0);
        is(reach(&(&a - &b)), -1.0, 1.0);
        is(reach(&(&a - (&b - &a))), -1.0, 1.0);
        assert!(!reach(&(Solid::space() - &a)).is_finite());
        // Negated twice.
        is(reach(&(&a - (Solid::space() - &b))), 0.5, 1.0);
    }

    #[test]
    fn needles_and_sheets_are_bounded_however_thin() {
        for exponent in [2, 4, 6, 9] {
            let thin = 10f64.powi(-exponent);
            for solid in [
                Solid::ellipsoid([1.0, 0.7, thin]),
                Solid::ellipsoid([1.0, thin, thin]),
                Solid::elliptic_cylinder([1.0, thin], 0.0..1.0),
                Solid::frustum(1.0, 0.0, 0.0..1.0).scale_xyz([1.0, thin, 1.0]),
            ] {
                let turned = solid.rotate_x(0.4).rotate_y(0.7).rotate_z(0.3);
                let program = Program::lower(&turned).expect("valid");
                let bounds = program.bounds().expect("bounded").expect("not empty");
                assert!(bounds.size().max_element() < 4.0);
            }
        }
    }
}
