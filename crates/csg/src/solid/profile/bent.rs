//! Bent sides of contours: arcs and parabolas, and chords instead.

use glam::DVec2;

use super::arcs::{Arc, Sagitta, chords};
use super::parabola::Parabola;
use super::plane_set::{Leaf, PlaneSet};
use super::{Bend, Contour, Corner};
use crate::elementary;

/// A side that is no straight line.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bent {
    Arc(Arc),
    Parabola(Parabola),
}

impl Bent {
    /// The side from corner k of a contour to the next one, if it is bent.
    pub(super) fn of(contour: &[Corner], k: usize) -> Option<Self> {
        let Corner { point, bend } = contour[k];
        let to = contour[(k + 1) % contour.len()].point;
        match bend {
            Bend::Straight => None,
            Bend::Arc(bulge) => Some(Self::Arc(Arc::new(point, to, bulge))),
            Bend::Parabola { control, of } => Some(Self::Parabola(Parabola {
                from: point,
                control,
                to,
                of,
            })),
        }
    }

    /// What its circle, or its parabola, encloses.
    pub(super) fn leaf(&self) -> Leaf {
        match self {
            Self::Arc(arc) => Leaf::Disc(arc.disc()),
            Self::Parabola(parabola) => Leaf::Parabola(parabola.map()),
        }
    }

    fn ends(&self) -> [DVec2; 2] {
        match self {
            Self::Arc(arc) => [arc.from, arc.to],
            Self::Parabola(parabola) => [parabola.from, parabola.to],
        }
    }

    pub(super) fn turns_left(&self) -> bool {
        match self {
            Self::Arc(arc) => arc.sweep > 0.0,
            Self::Parabola(parabola) => parabola.turn() > 0.0,
        }
    }

    /// A convex polygon around the side and its chord, both ends its corners.
    pub(super) fn around(&self) -> Vec<DVec2> {
        match self {
            Self::Arc(arc) => arc.around(),
            Self::Parabola(parabola) => vec![parabola.from, parabola.control, parabola.to],
        }
    }

    /// What lies between the side and its chord.
    pub(super) fn segment(&self) -> PlaneSet {
        // On the right of the chord if it turns left.
        let [mut from, mut to] = self.ends();
        if self.turns_left() {
            (from, to) = (to, from);
        }
        PlaneSet::all(vec![
            PlaneSet::leaf(self.leaf()),
            PlaneSet::leaf(Leaf::HalfPlane { from, to }),
        ])
    }

    /// The corners of both halves.
    pub(super) fn halved(&self) -> [Corner; 2] {
        match self {
            Self::Arc(arc) => {
                let bulge = elementary::tan(arc.sweep / 8.0);
                [arc.from, arc.at(0.5)].map(|point| Corner::arc(point, bulge))
            }
            Self::Parabola(parabola) => parabola.halves().map(|half| Corner {
                point: half.from,
                bend: half.bend(),
            }),
        }
    }

    /// The corners between chords that keep so near to it under a map that stretches by `stretch`.
    fn inner_points(&self, stretch: f64, sagitta: Sagitta) -> Vec<DVec2> {
        let points = |count: usize, at: &dyn Fn(f64) -> DVec2| {
            (1..count).map(|i| at(i as f64 / count as f64)).collect()
        };
        match self {
            Self::Arc(arc) => {
                let count = chords(arc.radius * stretch, arc.sweep, sagitta);
                points(count, &|share| arc.at(share))
            }
            Self::Parabola(parabola) => {
                let count = parabola.chords(stretch, sagitta);
                points(count, &|share| parabola.at(share))
            }
        }
    }

    fn doubled_segment(&self) -> f64 {
        match self {
            Self::Arc(arc) => arc.doubled_segment(),
            Self::Parabola(parabola) => parabola.doubled_segment(),
        }
    }
}

/// The contour with the bent sides cut into chords that keep so near to them under a map that
/// stretches by `stretch`, but for those of which `keeps` wants what their curves enclose.
pub(super) fn cut(
    contour: &[Corner],
    stretch: f64,
    sagitta: Sagitta,
    mut keeps: impl FnMut(Leaf) -> bool,
) -> Contour {
    let mut corners = Vec::with_capacity(contour.len());
    for (k, &corner) in contour.iter().enumerate() {
        match Bent::of(contour, k) {
            Some(side) if !keeps(side.leaf()) => {
                corners.push(Corner::straight(corner.point));
                let inner = side.inner_points(stretch, sagitta).into_iter();
                corners.extend(inner.map(Corner::straight));
            }
            _ => corners.push(corner),
        }
    }
    corners
}

/// Twice the area, bent sides included: positive if counter-clockwise.
pub(super) fn doubled_area(contour: &[Corner]) -> f64 {
    let base = contour.first().map_or(DVec2::ZERO, |corner| corner.point);
    (0..contour.len())
        .map(|k| {
            let next = contour[(k + 1) % contour.len()].point;
            let chord = (contour[k].point - base).perp_dot(next - base);
            chord + Bent::of(contour, k).map_or(0.0, |side| side.doubled_segment())
        })
        .sum()
}

/// The same contour the other way round.
pub(super) fn reversed(contour: &[Corner]) -> Contour {
    let count = contour.len();
    (0..count)
        .map(|k| Corner {
            point: contour[count - 1 - k].point,
            bend: match contour[(2 * count - 2 - k) % count].bend {
                Bend::Arc(bulge) => Bend::Arc(-bulge),
                same => same,
            },
        })
        .collect()
}
