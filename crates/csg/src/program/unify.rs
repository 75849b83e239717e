//! Canonical surfaces: the same plane or quadric, reached through different
//! transforms or seen from its two sides, becomes one surface.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};

use crate::surface::Surface;

const EPS: f64 = f64::EPSILON;

/// An affine map with running bounds on what rounding did to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorldMap {
    pub map: DAffine3,
    /// Bound on the error of the linear part, as a matrix norm.
    linear_error: f64,
    /// Bound on the error of the translation, as a length.
    offset_error: f64,
}

/// The Frobenius norm, which bounds the stretch.
fn norm(m: &DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

impl WorldMap {
    pub const IDENTITY: Self = Self {
        map: DAffine3::IDENTITY,
        linear_error: 0.0,
        offset_error: 0.0,
    };

    /// This map after `inner`: points go through `inner` first.
    pub fn then_inner(&self, inner: &DAffine3) -> Self {
        let outer_norm = norm(&self.map.matrix3);
        let inner_norm = norm(&inner.matrix3);
        let inner_offset = inner.translation.length();
        // A caller's own entries (a cosine, say) are right to 2 eps; each
        // product below adds fewer than 4.
        Self {
            map: self.map * *inner,
            linear_error: self.linear_error * inner_norm + 6.0 * EPS * outer_norm * inner_norm,
            offset_error: self.offset_error
                + self.linear_error * inner_offset
                + 6.0 * EPS * (outer_norm * inner_offset + self.map.translation.length()),
        }
    }

    pub fn is_identity(&self) -> bool {
        self.map == DAffine3::IDENTITY
    }

    /// How well-conditioned the linear part is: its determinant over the
    /// product of its columns' lengths, 1 for a rotation, 0 when singular.
    pub fn relative_determinant(&self) -> f64 {
        let m = self.map.matrix3;
        let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        m.determinant() / lengths
    }

    /// The image of a surface: f'(p) = f(M⁻¹ p), normalised, with error
    /// bounds. `None` if a coefficient leaves the range of f64.
    pub fn apply(&self, local: &Surface) -> Option<Placed> {
        let linear = self.map.matrix3;
        let inverse = if self.is_identity() {
            linear
        } else {
            linear.inverse()
        };
        let position = local.anchor.length();
        let position_error = self.linear_error * position
            + self.offset_error
            + 8.0 * EPS * (norm(&linear) * position + self.map.translation.length());
        let shape_error = 8.0 * EPS + 4.0 * self.linear_error * norm(&inverse);
        let surface = if self.is_identity() {
            *local
        } else {
            local.pulled_back(&inverse, self.map.transform_point3(local.anchor))
        };
        Some(Placed {
            surface: normalised(&surface)?,
            position_error,
            shape_error,
        })
    }
}

fn normalised(surface: &Surface) -> Option<Surface> {
    let size = if surface.is_plane() {
        let largest = surface.linear.abs().max_element();
        largest * (surface.linear / largest).length()
    } else {
        surface.quadratic.iter().fold(0.0f64, |m, c| m.max(c.abs()))
    };
    let clean = |value: f64| value / size;
    let result = Surface {
        anchor: surface.anchor,
        quadratic: surface.quadratic.map(clean),
        linear: surface.linear / size,
        constant: clean(surface.constant),
        kind: surface.kind,
    };
    let finite = size > 0.0
        && size.is_finite()
        && result.anchor.is_finite()
        && result.linear.is_finite()
        && result.constant.is_finite()
        && result.quadratic.iter().all(|c| c.is_finite());
    finite.then_some(result)
}

/// A surface in place, with what is known of its errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub surface: Surface,
    /// Bound on how far the anchor is off, as a length.
    position_error: f64,
    /// Bound on the relative error of the coefficients.
    shape_error: f64,
}

impl Placed {
    /// A number that is the same, up to the tolerance given with it, for all
    /// descriptions of one surface with the same orientation, and most likely
    /// different for different surfaces.
    fn key(&self) -> (f64, f64) {
        // Irrational weights: distinct coefficients rarely collide.
        const QUADRATIC: [f64; 6] = [
            0.618_033_988_749_894_9,
            0.414_213_562_373_095_1,
            0.732_050_807_568_877_2,
            0.236_067_977_499_789_7,
            0.645_751_311_064_590_7,
            0.316_624_790_355_399_8,
        ];
        const LINEAR: DVec3 = DVec3::new(
            0.302_775_637_731_994_6,
            0.582_575_694_955_84,
            0.872_983_346_207_416_8,
        );
        let s = &self.surface;
        let far = s.anchor.length();
        if s.is_plane() {
            let offset = s.linear.dot(s.anchor);
            return (
                LINEAR.dot(s.linear) + QUADRATIC[0] * offset,
                2.0 * self.position_error + 4.0 * (self.shape_error + 8.0 * EPS) * (1.0 + far),
            );
        }
        let linear = s.gradient(DVec3::ZERO);
        let form: f64 = QUADRATIC.iter().zip(s.quadratic).map(|(w, q)| w * q).sum();
        (
            form + LINEAR.dot(linear),
            8.0 * self.position_error
                + 16.0 * (self.shape_error + 8.0 * EPS) * (1.0 + far + s.linear.length()),
        )
    }

    /// Whether both may be one surface, as far as their errors can tell.
    fn coincides(&self, other: &Self) -> bool {
        let (a, b) = (&self.surface, &other.surface);
        if a.is_plane() != b.is_plane() {
            return false;
        }
        let shape = self.shape_error + other.shape_error;
        let position = self.position_error + other.position_error;
        let apart = (a.anchor - b.anchor).length();
        if a.is_plane() {
            return (a.linear - b.linear).abs().max_element() <= shape
                && a.linear.dot(b.anchor - a.anchor).abs() <= position + shape * apart;
        }
        let forms_agree = a
            .quadratic
            .iter()
            .zip(b.quadratic)
            .all(|(x, y)| (x - y).abs() <= shape);
        if !forms_agree {
            return false;
        }
        // Both about one anchor; the quadratic form's norm is at most 3.
        let (linear, constant) = b.expanded_about(a.anchor);
        let slope = b.linear.length() + 6.0 * apart;
        let linear_error = shape * slope + 6.0 * position;
        if (linear - a.linear).abs().max_element() > linear_error {
            return false;
        }
        let terms = b.constant.abs() + b.linear.length() * apart + 3.0 * apart * apart;
        let constant_error = shape * terms + slope * position + 3.0 * position * position;
        (constant - a.constant).abs() <= constant_error
    }
}

/// The table of canonical surfaces under construction.
#[derive(Debug, Default)]
pub(super) struct SurfaceTable {
    placed: Vec<Placed>,
    by_key: BTreeMap<OrderedKey, Vec<u32>>,
    widest_tolerance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OrderedKey(f64);

impl Eq for OrderedKey {}
impl PartialOrd for OrderedKey {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for OrderedKey {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl SurfaceTable {
    /// The index of the surface, and whether the table holds it the other way
    /// round (so that f <= 0 of the caller is the outside of the table's).
    pub fn insert(&mut self, placed: Placed) -> (u32, bool) {
        if let Some(found) = self.find(&placed) {
            return (found, false);
        }
        let flipped = Placed {
            surface: placed.surface.negated(),
            ..placed
        };
        if let Some(found) = self.find(&flipped) {
            return (found, true);
        }
        let index = self.placed.len() as u32;
        let (key, tolerance) = placed.key();
        self.placed.push(placed);
        self.by_key.entry(OrderedKey(key)).or_default().push(index);
        self.widest_tolerance = self.widest_tolerance.max(tolerance);
        (index, false)
    }

    fn find(&self, placed: &Placed) -> Option<u32> {
        let (key, tolerance) = placed.key();
        let reach = tolerance + self.widest_tolerance;
        let (from, to) = if (key.abs() + reach).is_finite() {
            (key - reach, key + reach)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        self.by_key
            .range(OrderedKey(from)..=OrderedKey(to))
            .flat_map(|(_, indices)| indices)
            .copied()
            .find(|&index| self.placed[index as usize].coincides(placed))
    }

    pub fn len(&self) -> usize {
        self.placed.len()
    }

    pub fn surfaces(&self) -> Vec<Surface> {
        self.placed.iter().map(|placed| placed.surface).collect()
    }
}
