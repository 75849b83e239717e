//! Points that are nearer to each other than rounding tells become one.

use glam::{DVec3, I64Vec3};
use rustc_hash::FxHashMap;

/// Numbers points, the same for all within a distance of the first of them.
pub(super) struct Welder {
    distance: f64,
    /// The first point in each cube of a grid, which is much wider than the
    /// distance.
    first: FxHashMap<I64Vec3, u32>,
    /// The next point in the same cube, or [`NONE`].
    next: Vec<u32>,
    pub points: Vec<DVec3>,
}

const NONE: u32 = u32::MAX;

impl Welder {
    pub fn new(distance: f64) -> Self {
        Self {
            distance,
            first: FxHashMap::default(),
            next: Vec::new(),
            points: Vec::new(),
        }
    }

    fn cube(&self, point: DVec3) -> I64Vec3 {
        (point / (16.0 * self.distance)).floor().as_i64vec3()
    }

    /// The number of a point.
    pub fn number(&mut self, point: DVec3) -> u32 {
        let own = self.cube(point);
        let low = self.cube(point - self.distance);
        let high = self.cube(point + self.distance);
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    if let Some(known) = self.find(I64Vec3::new(x, y, z), point) {
                        return known;
                    }
                }
            }
        }
        let number = self.points.len() as u32;
        self.points.push(point);
        self.next
            .push(self.first.insert(own, number).unwrap_or(NONE));
        number
    }

    fn find(&self, cube: I64Vec3, point: DVec3) -> Option<u32> {
        let mut at = self.first.get(&cube).copied().unwrap_or(NONE);
        while at != NONE {
            let gap = (self.points[at as usize] - point).abs().max_element();
            if gap <= self.distance {
                return Some(at);
            }
            at = self.next[at as usize];
        }
        None
    }
}
