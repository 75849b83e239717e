//! Sides of contours, and where two of them meet.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use smallvec::SmallVec;

use super::Corner;
use super::arcs::Arc;
use super::bent::Bent;
use crate::elementary;
use crate::numeric::tolerance::IN_PROFILE;

/// A line or an arc.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub from: DVec2,
    pub to: DVec2,
    pub arc: Option<Arc>,
    /// The least coordinates.
    pub min: DVec2,
    pub max: DVec2,
}

/// The sides of a contour of lines and arcs that have a length.
pub(super) fn sides(contour: &[Corner]) -> impl Iterator<Item = Side> {
    let sides = (0..contour.len()).map(|k| Side::of(contour, k));
    sides.filter(|side| side.from != side.to)
}

/// How near sides are that meet: rounding of the farthest of their coordinates.
pub(super) fn slack<'a>(sides: impl Iterator<Item = &'a Side>) -> f64 {
    IN_PROFILE * sides.fold(0.0, |size: f64, side| side.reach().max(size))
}

/// Looks at all pairs of sides whose boxes are within `slack` of each other, until something is
/// found.
pub(super) fn find_pair<T>(
    sides: &[Side],
    slack: f64,
    mut look: impl FnMut(usize, usize) -> Option<T>,
) -> Option<T> {
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by(|&a, &b| sides[a].min.x.total_cmp(&sides[b].min.x));
    for (rank, &k) in order.iter().enumerate() {
        let one = &sides[k];
        for &j in &order[rank + 1..] {
            let other = &sides[j];
            if other.min.x > one.max.x + slack {
                break;
            }
            let near = other.min.y <= one.max.y + slack && one.min.y <= other.max.y + slack;
            if let Some(found) = near.then(|| look(k, j)).flatten() {
                return Some(found);
            }
        }
    }
    None
}

/// The direction of travel at a point of a side, and its curvature, positive to the left.
pub(super) struct Course {
    pub direction: DVec2,
    pub bend: f64,
}

impl Course {
    pub(super) fn reversed(self) -> Self {
        Self {
            direction: -self.direction,
            bend: -self.bend,
        }
    }

    /// The angle turned through from this course to the next, in radians, positive to the left.
    /// What turns back does so to that side on which it bends away from how it came.
    pub(super) fn turn_to(&self, next: &Self) -> f64 {
        let (before, after) = (self.direction, next.direction);
        let angle = elementary::atan2(before.perp_dot(after), before.dot(after));
        if angle.abs() < PI - IN_PROFILE {
            angle
        } else if self.bend + next.bend > 0.0 {
            -PI
        } else {
            PI
        }
    }
}

/// Where sides meet: an arc and another in two points and their ends.
type Meetings = SmallVec<[DVec2; 4]>;

impl Side {
    /// The side from corner k.
    pub(super) fn of(contour: &[Corner], k: usize) -> Self {
        let to = contour[(k + 1) % contour.len()].point;
        let arc = match Bent::of(contour, k) {
            Some(Bent::Arc(arc)) => Some(arc),
            // (Whoever asks cuts parabolas to chords first, or their chords will do.)
            Some(Bent::Parabola(_)) | None => None,
        };
        Self::new(contour[k].point, to, arc)
    }

    fn new(from: DVec2, to: DVec2, arc: Option<Arc>) -> Self {
        let mut side = Self {
            from,
            to,
            arc,
            min: from.min(to),
            max: from.max(to),
        };
        if let Some(arc) = arc {
            for quarter in 0..4 {
                let point = arc.center + arc.radius * super::turn(quarter, 4);
                if (0.0..=1.0).contains(&side.share(point)) {
                    side.min = side.min.min(point);
                    side.max = side.max.max(point);
                }
            }
        }
        side
    }

    /// The greatest distance of one of its coordinates, or its circle's, from zero.
    fn reach(&self) -> f64 {
        let ends = self.min.abs().max(self.max.abs()).max_element();
        let center = |arc: &Arc| arc.center.abs().max_element() + arc.radius;
        self.arc.as_ref().map_or(ends, center).max(ends)
    }

    pub(super) fn at(&self, share: f64) -> DVec2 {
        match &self.arc {
            None => self.from.lerp(self.to, share),
            Some(arc) => arc.at(share),
        }
    }

    /// After which share of the side a point is that lies on it or its circle; of points before
    /// its start less than 0, down to where those are as near that are beyond its end.
    pub(super) fn share(&self, point: DVec2) -> f64 {
        match &self.arc {
            None => {
                let along = self.to - self.from;
                (point - self.from).dot(along) / along.length_squared()
            }
            Some(arc) => {
                let [from, to] = [self.from, point].map(|p| p - arc.center);
                let angle = elementary::atan2(from.perp_dot(to), from.dot(to)) * arc.sweep.signum();
                let sweep = arc.sweep.abs();
                // Half of what is not on the arc is before it.
                let angle = if angle < 0.5 * (sweep - TAU) {
                    angle + TAU
                } else {
                    angle
                };
                angle / sweep
            }
        }
    }

    /// Which way the side goes after a share of it.
    pub(super) fn course(&self, share: f64) -> Course {
        match &self.arc {
            None => Course {
                direction: (self.to - self.from).normalize_or_zero(),
                bend: 0.0,
            },
            Some(arc) => Course {
                direction: arc.tangent(share),
                bend: arc.sweep.signum() / arc.radius,
            },
        }
    }

    /// Where an arc turns back in x, as shares.
    pub(super) fn turns(&self) -> SmallVec<[f64; 2]> {
        let Some(arc) = &self.arc else {
            return SmallVec::new();
        };
        let points = [-1.0, 1.0].map(|across| arc.center + across * arc.radius * DVec2::X);
        let shares = points.map(|point| self.share(point)).into_iter();
        shares
            .filter(|share| *share > 0.0 && *share < 1.0)
            .collect()
    }

    fn length(&self) -> f64 {
        match &self.arc {
            None => self.from.distance(self.to),
            Some(arc) => arc.radius * arc.sweep.abs(),
        }
    }

    /// How far a point is from the line or circle.
    fn distance(&self, point: DVec2) -> f64 {
        match &self.arc {
            None => {
                let along = (self.to - self.from).normalize_or_zero();
                along.perp_dot(point - self.from).abs()
            }
            Some(arc) => (point.distance(arc.center) - arc.radius).abs(),
        }
    }

    /// Whether a point lies on the side.
    pub(super) fn holds(&self, point: DVec2, slack: f64) -> bool {
        self.distance(point) <= slack && self.reaches(point, slack)
    }

    /// Whether a point of the line or circle is on the side.
    fn reaches(&self, point: DVec2, slack: f64) -> bool {
        let beyond = slack / self.length();
        (-beyond..=1.0 + beyond).contains(&self.share(point))
    }

    /// Where two sides meet: their ends if these lie on the other one, and where else they cross
    /// or touch. What is nearer than `slack` touches; sides on one line or circle meet in ends
    /// alone.
    pub(super) fn meet(&self, other: &Self, slack: f64) -> Meetings {
        let mut points = Meetings::new();
        for (one, other) in [(self, other), (other, self)] {
            for end in [one.from, one.to] {
                if other.holds(end, slack) && !points.iter().any(|p| p.distance(end) <= slack) {
                    points.push(end);
                }
            }
        }
        let (crossings, near) = match (&self.arc, &other.arc) {
            (None, None) => self.lines_cross(other, slack),
            (None, Some(arc)) => self.line_meets(arc, slack),
            (Some(arc), None) => other.line_meets(arc, slack),
            (Some(one), Some(other)) => circles_meet(one, other, slack),
        };
        for point in crossings {
            let is_new = points.iter().all(|p| p.distance(point) > near);
            if is_new && self.reaches(point, slack) && other.reaches(point, slack) {
                points.push(point);
            }
        }
        points
    }

    /// Where lines cross, and how near to that their distance is within slack.
    fn lines_cross(&self, other: &Self, slack: f64) -> (Meetings, f64) {
        let (u, v) = (self.to - self.from, other.to - other.from);
        let across = u.perp_dot(v);
        let sine = (across / (u.length() * v.length())).abs();
        // Both are within slack of each other on all of the shorter one.
        if sine * self.length().min(other.length()) <= slack {
            return (Meetings::new(), slack);
        }
        let share = (other.from - self.from).perp_dot(v) / across;
        let point = self.from + share * u;
        (SmallVec::from_slice(&[point]), 2.0 * slack / sine)
    }

    fn line_meets(&self, arc: &Arc, slack: f64) -> (Meetings, f64) {
        let along = (self.to - self.from).normalize_or_zero();
        let foot = self.from + along * along.dot(arc.center - self.from);
        let off = arc.center.distance(foot);
        meet_across(
            foot,
            along,
            arc.radius - off,
            arc.radius + off,
            arc.radius,
            slack,
        )
    }
}

/// Where circles meet, and how near to that their distance is within slack.
fn circles_meet(one: &Arc, other: &Arc, slack: f64) -> (Meetings, f64) {
    let apart = other.center - one.center;
    let distance = apart.length();
    let (r, s) = (one.radius, other.radius);
    if distance <= slack && (r - s).abs() <= slack || distance == 0.0 {
        return (Meetings::new(), slack);
    }
    let axis = apart / distance;
    // By Heron: the half chord in factors, each of which is right next to 0.
    let outer = [r + s - distance, r + s + distance];
    let inner = [distance - (r - s), distance + (r - s)];
    let foot = one.center + axis * (0.5 * (distance + (r - s) * (r + s) / distance));
    let scale = 2.0 * distance;
    // The nearest to touching of both kinds.
    let (gap, rest) = if outer[0].abs() < inner[0].abs().min(inner[1].abs()) {
        (outer[0], inner[0] * inner[1] * outer[1])
    } else {
        let least = usize::from(inner[1].abs() < inner[0].abs());
        (inner[least], inner[1 - least] * outer[0] * outer[1])
    };
    let factor = rest / (scale * scale);
    // Half the chord squared is gap * factor.
    meet_across(foot, axis.perp(), gap, factor, r * s / distance, slack)
}

/// The ends of a chord around `foot`, whose half squared is `gap` times `factor`; the sine of
/// the angle at which curves cross there is that half by `radius`.
fn meet_across(
    foot: DVec2,
    along: DVec2,
    gap: f64,
    factor: f64,
    radius: f64,
    slack: f64,
) -> (Meetings, f64) {
    let zone = (2.0 * slack * factor.abs()).sqrt();
    if gap.abs() <= slack {
        return (SmallVec::from_slice(&[foot]), zone);
    }
    let square = gap * factor;
    if square <= 0.0 {
        return (Meetings::new(), zone);
    }
    let half = square.sqrt();
    let points = [foot - half * along, foot + half * along];
    (SmallVec::from_slice(&points), 2.0 * slack * radius / half)
}
