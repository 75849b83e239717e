//! Coordinates in which a quadric is of revolution, or a unit sphere, and how far a face goes in them.

use csg::Placement;
use csg::brep::{Edge, Face};
use csg::elementary;
use glam::{DVec2, DVec3};

/// Coordinates about a placement in which a surface has unit radii.
#[derive(Clone, Debug)]
pub(super) struct Scaled {
    pub placement: Placement,
    pub scales: [f64; 3],
}

impl Scaled {
    pub fn point(&self, p: DVec3) -> DVec3 {
        let axes = self
            .placement
            .axes
            .iter()
            .zip(self.scales)
            .zip(p.to_array());
        let off: DVec3 = axes.map(|((&axis, scale), x)| x * scale * axis).sum();
        self.placement.origin + off
    }

    pub fn coordinates(&self, point: DVec3) -> DVec3 {
        let off = point - self.placement.origin;
        let [x, y, z] = self.placement.axes;
        DVec3::new(off.dot(x), off.dot(y), off.dot(z)) / DVec3::from(self.scales)
    }

    /// How many times the shortest scale the longest one is.
    pub fn stretch(&self) -> f64 {
        let scales = DVec3::from(self.scales).abs();
        scales.max_element() / scales.min_element()
    }

    /// The coordinates of points around a face.
    fn samples(&self, face: &Face<'_>) -> Vec<DVec3> {
        const SAMPLES: u32 = 16;
        let along = |edge: Edge<'_>| {
            let [from, to] = edge.range();
            let share = |k: u32| f64::from(k) / f64::from(SAMPLES);
            let point = |k: u32| self.coordinates(edge.at(from + share(k) * (to - from)));
            (0..=SAMPLES).map(point).collect::<Vec<_>>()
        };
        face.edges().flat_map(along).collect()
    }

    /// What a function of coordinates takes for values on a face, and somewhat more.
    pub fn range(&self, face: &Face<'_>, value: impl Fn(DVec3) -> f64) -> [f64; 2] {
        wider(self.samples(face).into_iter().map(value))
    }

    /// The most that a function takes on any of some faces, and somewhat more.
    pub fn farthest(&self, faces: &[Face<'_>], value: impl Fn(DVec3) -> f64) -> f64 {
        let most = faces.iter().map(|face| self.range(face, &value)[1]);
        most.fold(f64::NEG_INFINITY, f64::max)
    }

    /// From which angle around z to which a face goes, and somewhat more: less than a half
    /// turn, as seams are at right angles, as coordinates see them.
    pub fn sector(&self, face: &Face<'_>) -> [f64; 2] {
        let samples = self.samples(face);
        let sum: DVec3 = samples.iter().sum();
        let ahead = DVec2::new(sum.x, sum.y);
        let farthest = samples
            .iter()
            .map(|p| elementary::hypot(p.x, p.y))
            .fold(0.0, f64::max);
        // On the axis there is no angle.
        let off_axis = samples
            .iter()
            .filter(|p| elementary::hypot(p.x, p.y) > 1e-6 * farthest);
        let turns = off_axis.map(|p| elementary::turn(ahead, DVec2::new(p.x, p.y)));
        wider(turns).map(|turn| elementary::atan2(ahead.y, ahead.x) + turn)
    }
}

/// The least and the greatest of some values, and a twentieth beyond.
fn wider(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let margin = 0.05 * (high - low);
    [low - margin, high + margin]
}
