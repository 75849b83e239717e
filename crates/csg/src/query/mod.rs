//! Questions about a solid's boundary: what a ray meets, and what is nearest to points.

mod nearest;
mod ray;

pub use nearest::Nearest;
pub use ray::RayHit;
