//! Three vectors of lanes: points, directions or colours.

use glam::Vec3;

use super::{FloatLanes, LANES, Lanes, triple};

/// x, y and z (or red, green and blue) in lanes.
pub type Triple<S> = [<S as Lanes>::F; 3];

/// The same in memory.
pub type Triple16 = [[f32; LANES]; 3];

/// The same vector in all lanes.
#[inline(always)]
pub fn splat<S: Lanes>(s: S, v: Vec3) -> Triple<S> {
    [s.f(v.x), s.f(v.y), s.f(v.z)]
}

/// Scalar products.
#[inline(always)]
pub fn dot<S: Lanes>(a: Triple<S>, b: Triple<S>) -> S::F {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// 1 / sqrt(x), finite for all x >= 0.
#[inline(always)]
pub fn inverse_sqrt<S: Lanes>(s: S, x: S::F) -> S::F {
    s.f(1.0) / x.max(s.f(f32::MIN_POSITIVE)).sqrt()
}

/// From memory.
#[inline(always)]
pub fn load<S: Lanes>(s: S, values: &Triple16) -> Triple<S> {
    triple!(|K| s.load_f(&values[K]))
}

/// To memory.
#[inline(always)]
pub fn store<S: Lanes>(v: Triple<S>, to: &mut Triple16) {
    let [a, b, c] = to;
    v[0].store(a);
    v[1].store(b);
    v[2].store(c);
}
