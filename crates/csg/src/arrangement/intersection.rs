//! What is said of the curves of two surfaces, and those of two planes.

use glam::DVec3;
use smallvec::SmallVec;

use super::curve::Curve;
use crate::numeric::tolerance::PARALLEL_PLANES;
use crate::program::Surface;

/// Why the curves of two surfaces are not known.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unknown {
    /// They have only single points in common, where they touch.
    Touch(Contacts),
    /// There is no closed form for them here.
    NoForm,
}

pub(super) type Contacts = SmallVec<[DVec3; 2]>;

/// The line common to two planes.
pub(super) fn line(p: &Surface, q: &Surface) -> Option<Curve> {
    let direction = p.linear.cross(q.linear);
    let square = direction.length_squared();
    if square < PARALLEL_PLANES * PARALLEL_PLANES {
        return None;
    }
    let offsets = [p, q].map(|s| s.linear.dot(s.anchor));
    let point =
        (q.linear.cross(direction) * offsets[0] + direction.cross(p.linear) * offsets[1]) / square;
    Some(Curve::Line {
        point,
        direction: direction / square.sqrt(),
    })
}
