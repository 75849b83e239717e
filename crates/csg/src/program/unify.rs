//! Canonical surfaces: the same plane or quadric, reached through different
//! transforms or seen from its two sides, becomes one surface.

use glam::{DAffine3, DMat3, DVec3};

use crate::surface::Surface;

const EPS: f64 = f64::EPSILON;

/// An affine map with running bounds on what rounding did to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorldMap {
    pub map: DAffine3,
    /// Bound on the norm of E A⁻¹, E the error of the linear part A: what rounding does in front
    /// of further inner maps these do not change, so that it adds up and does not multiply
    /// however many maps there are.
    relative_error: f64,
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
        relative_error: 0.0,
        offset_error: 0.0,
    };

    /// This map after `inner`: points go through `inner` first.
    pub fn then_inner(&self, inner: &DAffine3) -> Self {
        let map = self.map * *inner;
        let outer_norm = norm(&self.map.matrix3);
        let inner_offset = inner.translation.length();
        // A caller's own entries (a cosine, say) are right to 2 eps; each
        // product below adds fewer than 4.
        let product = 6.0 * EPS * outer_norm * norm(&inner.matrix3);
        Self {
            map,
            relative_error: self.relative_error + product * norm(&map.matrix3.inverse()),
            offset_error: self.offset_error
                + self.linear_error() * inner_offset
                + 6.0 * EPS * (outer_norm * inner_offset + self.map.translation.length()),
        }
    }

    /// Bound on the error of the linear part, as a matrix norm.
    fn linear_error(&self) -> f64 {
        self.relative_error * norm(&self.map.matrix3)
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
        self.placing()(local)
    }

    /// The same for many surfaces.
    pub fn placing(&self) -> impl Fn(&Surface) -> Option<Placed> + Sync {
        let map = self.map;
        let is_identity = self.is_identity();
        let linear = map.matrix3;
        let inverse = if is_identity {
            linear
        } else {
            linear.inverse()
        };
        let shape_error = 8.0 * EPS + 4.0 * self.relative_error;
        let per_length = self.linear_error() + 8.0 * EPS * norm(&linear);
        let offset_error = self.offset_error + 8.0 * EPS * map.translation.length();
        move |local| {
            let surface = if is_identity {
                *local
            } else {
                local.pulled_back(&inverse, map.transform_point3(local.anchor))
            };
            Some(Placed {
                surface: normalised(&surface)?,
                errors: Errors {
                    position: per_length * local.anchor.length() + offset_error,
                    shape: shape_error,
                },
            })
        }
    }
}

fn normalised(surface: &Surface) -> Option<Surface> {
    if surface.is_plane() {
        let largest = surface.linear.abs().max_element();
        let size = largest * (surface.linear / largest).length();
        let linear = surface.linear / size;
        let finite = size > 0.0 && surface.anchor.is_finite() && linear.is_finite();
        return finite.then_some(Surface { linear, ..*surface });
    }
    let size = surface.quadratic.iter().fold(0.0f64, |m, c| m.max(c.abs()));
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
    errors: Errors,
}

/// Bounds on what rounding did to a surface.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// How far the anchor is off, as a length.
    position: f64,
    /// The relative error of the coefficients.
    shape: f64,
}

impl Placed {
    /// A number that is the same but for its sign, up to the tolerance given with it, for all
    /// descriptions of one surface, and most likely different for different surfaces.
    pub fn key(&self) -> (f64, f64) {
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
                (LINEAR.dot(s.linear) + QUADRATIC[0] * offset).abs(),
                2.0 * self.errors.position + 4.0 * (self.errors.shape + 8.0 * EPS) * (1.0 + far),
            );
        }
        let linear = s.gradient(DVec3::ZERO);
        let form: f64 = QUADRATIC.iter().zip(s.quadratic).map(|(w, q)| w * q).sum();
        (
            (form + LINEAR.dot(linear)).abs(),
            8.0 * self.errors.position
                + 16.0 * (self.errors.shape + 8.0 * EPS) * (1.0 + far + s.linear.length()),
        )
    }

    /// Whether both may be one surface, as far as their errors can tell.
    fn coincides(&self, other: &Self) -> bool {
        let (a, b) = (&self.surface, &other.surface);
        if a.is_plane() != b.is_plane() {
            return false;
        }
        let shape = self.errors.shape + other.errors.shape;
        let position = self.errors.position + other.errors.position;
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

/// Numbers from 0 on, found by nearness: a grid of cells, which share slots.
#[derive(Debug, Default)]
struct NearNumbers {
    all: Vec<f64>,
    width: f64,
    /// The last number in each slot, and the one before each in the same. There are as many
    /// slots as numbers or more, a power of two.
    last: Vec<u32>,
    before: Vec<u32>,
}

impl NearNumbers {
    const NONE: u32 = u32::MAX;

    fn reserve(&mut self, more: usize) {
        self.all.reserve(more);
        self.before.reserve(more);
        self.spread(self.width, self.all.len() + more);
    }

    /// (Whatever is too large is in a cell at the end.)
    fn cell_of(&self, number: f64) -> u64 {
        (number / self.width) as u64
    }

    fn slot_of(&self, cell: u64) -> usize {
        /// The golden ratio's part of 2⁶⁴ (D. E. Knuth, *The Art of Computer Programming* 3,
        /// 6.4: multiplicative hashing).
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        let bits = self.last.len().trailing_zeros();
        (cell.wrapping_mul(GOLDEN).rotate_left(bits) as usize) & self.last.len().wrapping_sub(1)
    }

    /// Readies it for being asked at a distance.
    fn widen(&mut self, reach: f64) {
        /// In distances: one that is asked for is hardly ever in two cells then, and different
        /// surfaces are hardly ever in one. Tunes speed only.
        const WIDTH: f64 = 64.0;
        if reach > 0.5 * self.width {
            self.spread(WIDTH * reach, self.all.len());
        }
    }

    /// Puts all numbers in cells of a width, and in slots enough for more.
    fn spread(&mut self, width: f64, count: usize) {
        let slots = count.next_power_of_two().max(self.last.len()).max(1);
        if width == self.width && slots == self.last.len() {
            return;
        }
        self.width = width;
        self.last.clear();
        self.last.resize(slots, Self::NONE);
        self.before.clear();
        for index in 0..self.all.len() {
            self.link(index);
        }
    }

    fn link(&mut self, index: usize) {
        let slot = self.slot_of(self.cell_of(self.all[index]));
        let before = std::mem::replace(&mut self.last[slot], index as u32);
        self.before.push(before);
    }

    fn push(&mut self, number: f64) -> u32 {
        let index = self.all.len();
        if index >= self.last.len() {
            self.spread(self.width, index + 1);
        }
        self.all.push(number);
        self.link(index);
        index as u32
    }

    /// All within a distance of a number, and some more, each with its place.
    fn near(&self, number: f64, reach: f64) -> impl Iterator<Item = (f64, u32)> {
        let [low, high] = [number - reach, number + reach].map(|end| self.cell_of(end));
        (low..=high).flat_map(move |cell| {
            let last = self.last.get(self.slot_of(cell)).copied();
            let some = |index: &u32| *index != Self::NONE;
            let before = move |&index: &u32| Some(self.before[index as usize]).filter(some);
            let in_slot = std::iter::successors(last.filter(some), before);
            let in_slot = in_slot.map(|index| (self.all[index as usize], index));
            in_slot.filter(move |&(other, _)| self.cell_of(other) == cell)
        })
    }
}

/// The table of canonical surfaces under construction.
#[derive(Debug, Default)]
pub(super) struct SurfaceTable {
    surfaces: Vec<Surface>,
    errors: Vec<Errors>,
    by_key: NearNumbers,
    widest_tolerance: f64,
}

impl SurfaceTable {
    /// The index of the surface, and whether the table holds it the other way
    /// round (so that f <= 0 of the caller is the outside of the table's).
    pub fn insert(&mut self, placed: Placed) -> (u32, bool) {
        self.insert_with_key(placed, placed.key())
    }

    /// The same of one whose key is known.
    pub fn insert_with_key(&mut self, placed: Placed, (key, tolerance): (f64, f64)) -> (u32, bool) {
        self.widest_tolerance = self.widest_tolerance.max(tolerance);
        let reach = tolerance + self.widest_tolerance;
        self.by_key.widen(reach);
        if let Some(found) = self.find(&placed, key, reach) {
            return found;
        }
        self.surfaces.push(placed.surface);
        self.errors.push(placed.errors);
        (self.by_key.push(key), false)
    }

    /// Of those that coincide with a surface the one with the least key, the same way round if
    /// there is such.
    fn find(&self, placed: &Placed, key: f64, reach: f64) -> Option<(u32, bool)> {
        let flipped = |index: u32| {
            let other = self.at(index as usize);
            let negated = Placed {
                surface: placed.surface.negated(),
                ..*placed
            };
            let is_flipped = !other.coincides(placed);
            (!is_flipped || other.coincides(&negated)).then_some(is_flipped)
        };
        let near = self.by_key.near(key, reach);
        let coinciding = near.filter_map(|(key, index)| Some((flipped(index)?, key, index)));
        let first = coinciding.min_by(|a, b| {
            let by_key = a.1.total_cmp(&b.1);
            a.0.cmp(&b.0).then(by_key).then(a.2.cmp(&b.2))
        });
        first.map(|(is_flipped, _, index)| (index, is_flipped))
    }

    fn at(&self, index: usize) -> Placed {
        Placed {
            surface: self.surfaces[index],
            errors: self.errors[index],
        }
    }

    /// Makes room for so many more.
    pub fn reserve(&mut self, more: usize) {
        self.surfaces.reserve(more);
        self.errors.reserve(more);
        self.by_key.reserve(more);
    }

    pub fn len(&self) -> usize {
        self.surfaces.len()
    }

    pub fn into_surfaces(self) -> Vec<Surface> {
        self.surfaces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// As far as they are asked for at growing distances.
    #[test]
    fn all_numbers_near_another_are_found() {
        let mut random = Random(3);
        let mut numbers = NearNumbers::default();
        let mut found = 0;
        for step in 0..600 {
            let reach = 1e-3 * f64::from(1 + step / 100);
            numbers.widen(reach);
            let asked = random.unit();
            let is_near = |number: f64| (number - asked).abs() <= reach;
            let told: Vec<u32> = numbers
                .near(asked, reach)
                .filter(|&(number, _)| is_near(number))
                .map(|(_, index)| index)
                .collect();
            let mut told_once = told.clone();
            told_once.sort_unstable();
            told_once.dedup();
            let all = (0u32..).zip(&numbers.all);
            let truth: Vec<u32> = all.filter(|&(_, &n)| is_near(n)).map(|(k, _)| k).collect();
            assert_eq!(told_once, truth);
            assert_eq!(told.len(), truth.len());
            found += truth.len();
            numbers.push(asked);
        }
        assert!(found > 200, "{found}");
    }

    /// Whatever is beyond what integers tell is in a cell at the end, together with others.
    #[test]
    fn numbers_of_any_size_are_taken() {
        let mut numbers = NearNumbers::default();
        for number in [0.0, 1e300, 2e300, f64::INFINITY, f64::NAN] {
            numbers.widen(1e-15);
            let _ = numbers.near(number, 1e-15).count();
            numbers.push(number);
        }
        numbers.widen(f64::INFINITY);
        assert_eq!(numbers.near(0.0, 1.0).count(), 5);
    }
}
