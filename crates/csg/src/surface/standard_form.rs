//! The equation of each kind of quadric in its own axes.

use glam::DVec3;

use super::kind::Kind;
use super::{Side, Surface};
use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::ROUND;

/// f = Σ values_k x_k² + slope x_2 + constant, with x measured along the axes from the
/// centre, the vertex, or a point of the axis or plane of symmetry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StandardForm {
    pub center: DVec3,
    /// Of unit length, at right angles.
    pub axes: [DVec3; 3],
    /// As many as the rank are not 0, and these come first; of an indefinite form the last
    /// of them has the sign that the others do not have.
    pub values: [f64; 3],
    pub slope: f64,
    pub constant: f64,
}

impl StandardForm {
    /// Those of an ellipsoid; not numbers, or infinite, if it is none.
    pub(crate) fn half_axes(&self) -> [f64; 3] {
        self.values.map(|value| (-self.constant / value).sqrt())
    }

    /// The radius of a sphere: of an ellipsoid whose half axes are the same but for rounding.
    pub(crate) fn radius(&self) -> Option<f64> {
        let [a, b, c] = self.half_axes();
        let (least, most) = (a.min(b).min(c), a.max(b).max(c));
        (most.is_finite() && most - least <= ROUND * least).then_some(most)
    }
}

impl Surface {
    /// The side on which the quadratic form alone never crosses zero: outside if it is
    /// positive semidefinite, inside if negative.
    pub(crate) fn definiteness(&self) -> Option<Side> {
        let [xx, yy, zz, ..] = self.quadratic;
        match self.kind {
            kind if kind.is_indefinite() => None,
            _ if xx + yy + zz >= 0.0 => Some(Side::Outside),
            _ => Some(Side::Inside),
        }
    }

    /// The equation of a quadric in its own axes.
    pub(crate) fn standard_form(&self) -> StandardForm {
        let (mut values, vectors) = eigen_symmetric(self.quadratic);
        let mut axes = [vectors.x_axis, vectors.y_axis, vectors.z_axis];
        let rank = self.kind.rank();
        arrange(self.kind, &mut values, &mut axes);
        let mut slope = 0.0;
        if self.kind.has_slope() {
            let flat = axes[rank..]
                .iter()
                .map(|&axis| self.linear.dot(axis) * axis);
            let along: DVec3 = flat.sum();
            slope = along.length();
            if rank < 2 {
                axes[2] = along.normalize_or(axes[2]);
                axes[1] = axes[2].cross(axes[0]);
            } else {
                slope = self.linear.dot(axes[2]);
            }
        }
        let off = axes.iter().zip(values).take(rank);
        let off = off.map(|(&axis, value)| self.linear.dot(axis) / (2.0 * value) * axis);
        let center = self.anchor - off.sum::<DVec3>();
        let constant = match self.kind {
            Kind::Cone => 0.0,
            _ if center == self.anchor => self.constant,
            _ => self.value(center),
        };
        StandardForm {
            center,
            axes,
            values,
            slope,
            constant,
        }
    }

    /// f of the given coefficients, none of which is 0 but for rounding. Where it is 0
    /// nowhere, nobody may ask for its kind.
    #[cfg(test)]
    pub(crate) fn of_terms(
        anchor: DVec3,
        quadratic: [f64; 6],
        linear: DVec3,
        constant: f64,
    ) -> Self {
        let kind = super::quadric::kind_of(quadratic, linear, constant).unwrap_or(Kind::Ellipsoid);
        Self {
            anchor,
            quadratic,
            linear,
            constant,
            kind,
        }
    }
}

/// Brings values and axes into the order of [`StandardForm`], which is left as it is
/// otherwise, with the signs and zeros of the kind where rounding took these.
fn arrange(kind: Kind, values: &mut [f64; 3], axes: &mut [DVec3; 3]) {
    let mut swap = |values: &mut [f64; 3], from: usize, to: usize| {
        values.swap(from, to);
        axes.swap(from, to);
    };
    let by_size =
        |values: &[f64; 3], i: usize, j: usize| values[i].abs().total_cmp(&values[j].abs());
    let rank = kind.rank();
    match rank {
        1 => {
            let largest = (0..3).max_by(|&i, &j| by_size(values, i, j));
            swap(values, largest.unwrap_or(0), 0);
        }
        2 => {
            let least = (0..3).min_by(|&i, &j| by_size(values, i, j));
            swap(values, least.unwrap_or(2), 2);
        }
        _ => {}
    }
    values[rank..].fill(0.0);
    if rank == 0 {
        return;
    }
    let of_sign = |value: f64, sign: f64| value.abs().max(f64::MIN_POSITIVE).copysign(sign);
    if !kind.is_indefinite() {
        let sign = values.iter().sum::<f64>();
        for value in &mut values[..rank] {
            *value = of_sign(*value, sign);
        }
        return;
    }
    let last = rank - 1;
    if rank == 3 {
        let differs = |k: &usize| {
            let others = [(k + 1) % 3, (k + 2) % 3].map(|i| values[i].signum());
            others[0] == others[1] && others[0] != values[*k].signum()
        };
        let odd = (0..3).find(differs);
        let least = (0..3).min_by(|&i, &j| by_size(values, i, j));
        swap(values, odd.or(least).unwrap_or(2), 2);
    }
    let sign = values[0];
    for value in &mut values[..last] {
        *value = of_sign(*value, sign);
    }
    values[last] = of_sign(values[last], -sign);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::solid::Primitive;
    use crate::{Program, Solid};

    fn surface(solid: &Solid) -> Surface {
        let program = Program::lower(solid).expect("valid");
        let curved = program.surfaces().iter().find(|s| !s.is_plane());
        *curved.expect("a quadric")
    }

    /// One solid of each kind that is curved.
    fn solids() -> [(Kind, Solid); 10] {
        // Of x², y², z², xy and z, and the constant.
        let quadric = |xx: f64, yy: f64, xy: f64, z: f64, constant: f64| {
            Solid::quadric([xx, yy, 0.0, xy, 0.0, 0.0, 0.0, 0.0, z, constant])
        };
        [
            (Kind::Ellipsoid, Solid::ellipsoid([1.0, 2.0, 3.0])),
            (
                Kind::HyperboloidOneSheet,
                Solid::hyperboloid_one_sheet([1.0, 2.0, 3.0]),
            ),
            (
                Kind::HyperboloidTwoSheets,
                Solid::hyperboloid_two_sheets([1.0, 2.0, 3.0]),
            ),
            (Kind::Cone, Solid::infinite_cone(0.5)),
            (Kind::EllipticParaboloid, Solid::paraboloid([1.0, 2.0])),
            (
                Kind::HyperbolicParaboloid,
                quadric(1.0, -2.0, 0.5, 1.0, 0.3),
            ),
            (
                Kind::EllipticCylinder,
                Solid::elliptic_cylinder([1.0, 2.0], -1.0..1.0),
            ),
            (Kind::HyperbolicCylinder, quadric(0.0, 1.0, 1.0, 0.0, -1.0)),
            (Kind::ParabolicCylinder, quadric(1.0, 0.0, 0.0, 1.0, 0.5)),
            // (As the surface that it is: authors get half-spaces.)
            (
                Kind::ParallelPlanes,
                Solid::primitive(Primitive::Quadric([
                    1.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0,
                ])),
            ),
        ]
    }

    proptest! {
        /// Whatever map a solid goes through, its kind is the same, and so is its function
        /// in its own axes.
        #[test]
        fn kinds_outlive_affine_maps(
            turn in prop::array::uniform3(-3.0..3.0f64),
            scales in prop::array::uniform3(0.2..5.0f64),
            offset in prop::array::uniform3(-5.0..5.0f64),
            at in prop::array::uniform3(-3.0..3.0f64),
        ) {
            for (kind, solid) in solids() {
                let solid = solid
                    .rotate_z(turn[0])
                    .scale_xyz(scales)
                    .rotate_x(turn[1])
                    .rotate_y(turn[2])
                    .translate(offset);
                let surface = surface(&solid);
                prop_assert_eq!(surface.kind, kind);
                let form = surface.standard_form();
                let rank = kind.rank();
                prop_assert!(form.values[..rank].iter().all(|v| *v != 0.0));
                prop_assert!(form.values[rank..].iter().all(|v| *v == 0.0));
                let x = form.axes.map(|axis| axis.dot(DVec3::from(at) - form.center));
                let squares: f64 = (0..3).map(|k| form.values[k] * x[k] * x[k]).sum();
                let short = squares + form.slope * x[2] + form.constant;
                let long = surface.value(at.into());
                let reach = (DVec3::from(at) - surface.anchor()).length()
                    + form.center.distance(surface.anchor()) + 1.0;
                prop_assert!((short - long).abs() < 1e-12 * reach * reach, "{kind:?}: {short}, {long}");
            }
        }

        /// However thin.
        #[test]
        fn needles_and_sheets_keep_their_kind(
            turn in prop::array::uniform2(-3.0..3.0f64),
            thin in -12.0..0.0f64,
            is_needle in prop::bool::ANY,
        ) {
            let thin = 10f64.powf(thin);
            let scales = if is_needle { [thin, thin, 1.0] } else { [1.0, 1.0, thin] };
            for (kind, solid) in solids() {
                let solid = solid.rotate_x(1.0).scale_xyz(scales).rotate_x(turn[0]).rotate_z(turn[1]);
                prop_assert_eq!(surface(&solid).kind, kind);
            }
        }
    }

    #[test]
    fn a_cone_far_from_its_apex_has_none() {
        let rod = surface(&Solid::frustum(1.0, 1.0 - 1e-9, 0.0..1.0));
        assert_eq!((rod.kind, rod.apex()), (Kind::Cone, None));
        let cone = surface(&Solid::frustum(1.0, 0.0, 0.0..1.0));
        assert_eq!((cone.kind, cone.apex()), (Kind::Cone, Some(DVec3::Z)));
    }
}
