//! Points that are near each other as one.

use glam::{BVec3, DVec3, I64Vec3};
use rustc_hash::FxHashMap;

/// Numbers points, the same for all within a distance of the first of them.
pub(crate) struct Welder {
    distance: f64,
    /// The first point in each cube of a grid, which is much wider than the
    /// distance.
    first: FxHashMap<I64Vec3, u32>,
    /// The next point in the same cube, or [`NONE`].
    next: Vec<u32>,
    pub points: Vec<DVec3>,
    /// The point asked for last, and its number: most edges begin where the one
    /// before ends.
    last: Option<(DVec3, u32)>,
}

const NONE: u32 = u32::MAX;

impl Welder {
    pub fn new(distance: f64) -> Self {
        Self {
            distance,
            first: FxHashMap::default(),
            next: Vec::new(),
            points: Vec::new(),
            last: None,
        }
    }

    /// The number of a point.
    pub fn number(&mut self, point: DVec3) -> u32 {
        if let Some((last, number)) = self.last
            && last == point
        {
            return number;
        }
        let number = self.look_up(point);
        self.last = Some((point, number));
        number
    }

    fn look_up(&mut self, point: DVec3) -> u32 {
        /// The sides of cubes, in distances. Tunes speed only.
        const WIDTH: f64 = 16.0;
        /// Points nearer to a side of a cube than this share of it may have others
        /// within the distance beyond: twice as near as they must be.
        const NEAR_SIDE: f64 = 2.0 / WIDTH;
        let place = point / (WIDTH * self.distance);
        let floor = place.floor();
        let (own, within) = (floor.as_i64vec3(), place - floor);
        let step = |is_near: BVec3| I64Vec3::select(is_near, I64Vec3::ONE, I64Vec3::ZERO);
        let low = own.saturating_sub(step(within.cmplt(DVec3::splat(NEAR_SIDE))));
        let high = own.saturating_add(step(within.cmpgt(DVec3::splat(1.0 - NEAR_SIDE))));
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
