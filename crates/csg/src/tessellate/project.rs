//! Points put on surfaces.

use glam::DVec3;

use crate::program::Surface;

/// A point of a surface near `start`, along the gradient there, on which a quadric is
/// a quadratic polynomial; where that has no root near by, by steps of Newton's method
/// until it has. None if that does not end there.
pub(super) fn project(surface: &Surface, start: DVec3) -> Option<DVec3> {
    const MOST_STEPS: usize = 12;
    let mut point = start;
    for _ in 0..MOST_STEPS {
        let (value, gradient) = (surface.value(point), surface.gradient(point));
        let square = gradient.length_squared();
        // Of f - t |∇f|² + t² ∇fᵀ H ∇f / 2.
        let discriminant = square * square - 2.0 * surface.curvature_along(gradient) * value;
        let is_near = discriminant >= 0.25 * square * square;
        let slope = if is_near {
            0.5 * (square + discriminant.sqrt())
        } else {
            square
        };
        let step = value / slope * gradient;
        if !step.is_finite() {
            return None;
        }
        point -= step;
        if is_near {
            return Some(point);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrangement::random_quadric;
    use crate::random::Random;
    use crate::surface::solve;

    #[test]
    fn points_come_to_lie_on_quadrics_hardly_farther_than_they_are_off() {
        let mut random = Random(23);
        let mut near = 0;
        for _ in 0..4000 {
            let surface = random_quadric(&mut random);
            let start = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
            let Some(point) = project(&surface, start) else {
                continue;
            };
            let size = surface.gradient(point).length().max(1e-3);
            assert!(
                surface.value(point).abs() <= 1e-14 * size,
                "{surface:?} {start}"
            );
            let closest = solve::common_point(&[&surface], start, 1.0).point;
            let distance = start.distance(closest);
            // Where the surface bends little on the way.
            if distance < 0.1 * surface.gradient(start).length() {
                assert!(
                    start.distance(point) <= 1.2 * distance,
                    "{surface:?} {start}"
                );
                near += 1;
            }
        }
        assert!(near > 500, "{near}");
    }
}
