//! Sets of points of the plane as formulas over half-planes, discs and what parabolas enclose.

use glam::{DAffine2, DVec2};

use crate::solid::Solid;

/// One side of a line, an ellipse, or the inner side of a parabola.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leaf {
    /// What lies to the left of the line, seen along it.
    HalfPlane { from: DVec2, to: DVec2 },
    /// The image of the disc of radius 1 around the origin.
    Disc(DAffine2),
    /// The image of y >= x².
    Parabola(DAffine2),
}

impl Leaf {
    pub(super) fn mapped(self, map: &DAffine2) -> Self {
        match self {
            Self::HalfPlane { from, to } => {
                let [from, to] = [from, to].map(|point| map.transform_point2(point));
                if map.matrix2.determinant() < 0.0 {
                    Self::HalfPlane { from: to, to: from }
                } else {
                    Self::HalfPlane { from, to }
                }
            }
            Self::Disc(own) => Self::Disc(*map * own),
            Self::Parabola(own) => Self::Parabola(*map * own),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Leaf(Leaf),
    /// The intersection of the last so many values.
    All(usize),
    /// Their union.
    Any(usize),
    Not,
}

/// A formula over leaves in postfix order, so that no depth recurses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneSet {
    steps: Vec<Step>,
}

impl PlaneSet {
    pub(crate) const EMPTY: Self = Self { steps: Vec::new() };

    pub(crate) fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    pub(crate) fn leaf(leaf: Leaf) -> Self {
        Self {
            steps: vec![Step::Leaf(leaf)],
        }
    }

    /// The intersection; empty if one of them is, or there are none.
    pub(crate) fn all(sets: Vec<Self>) -> Self {
        if sets.iter().any(Self::is_empty) {
            return Self::EMPTY;
        }
        Self::combined(sets, Step::All)
    }

    pub(crate) fn any(mut sets: Vec<Self>) -> Self {
        sets.retain(|set| !set.is_empty());
        Self::combined(sets, Step::Any)
    }

    /// The set without all the others.
    pub(crate) fn without(self, others: Vec<Self>) -> Self {
        let mut others = Self::any(others);
        if self.is_empty() || others.is_empty() {
            return self;
        }
        others.steps.push(Step::Not);
        Self::all(vec![self, others])
    }

    fn combined(sets: Vec<Self>, step: impl Fn(usize) -> Step) -> Self {
        let count = sets.len();
        let mut steps = Vec::new();
        for mut set in sets {
            steps.append(&mut set.steps);
        }
        if count > 1 {
            steps.push(step(count));
        }
        Self { steps }
    }

    /// Adds a leaf to a formula under construction in postfix order.
    pub(super) fn push(&mut self, leaf: Leaf) {
        self.steps.push(Step::Leaf(leaf));
    }

    /// Combines the last two values of a formula under construction.
    pub(super) fn push_pair(&mut self, both: bool) {
        self.steps
            .push(if both { Step::All(2) } else { Step::Any(2) });
    }

    pub(super) fn mapped(mut self, map: &DAffine2) -> Self {
        for step in &mut self.steps {
            if let Step::Leaf(leaf) = step {
                *leaf = leaf.mapped(map);
            }
        }
        self
    }

    /// The same with the lines of half-planes given by other points on them.
    pub(super) fn along(mut self, line: impl Fn(DVec2, DVec2) -> [DVec2; 2]) -> Self {
        for step in &mut self.steps {
            if let Step::Leaf(Leaf::HalfPlane { from, to }) = step {
                [*from, *to] = line(*from, *to);
            }
        }
        self
    }

    /// The leaves, in any order.
    #[cfg(test)]
    pub(crate) fn leaves(&self) -> impl Iterator<Item = &Leaf> {
        self.steps.iter().filter_map(|step| match step {
            Step::Leaf(leaf) => Some(leaf),
            _ => None,
        })
    }

    /// The same formula over solids.
    pub(crate) fn solid(&self, mut solid_of: impl FnMut(&Leaf) -> Solid) -> Solid {
        let mut values: Vec<Solid> = Vec::new();
        for step in &self.steps {
            let value = match step {
                Step::Leaf(leaf) => solid_of(leaf),
                &Step::All(count) => Solid::intersection(values.split_off(values.len() - count)),
                &Step::Any(count) => Solid::union(values.split_off(values.len() - count)),
                Step::Not => !values.pop().unwrap_or_else(Solid::empty),
            };
            values.push(value);
        }
        values.pop().unwrap_or_else(Solid::empty)
    }

    /// Whether a point that is on no boundary lies in the set.
    #[cfg(test)]
    pub(super) fn contains(&self, point: DVec2) -> bool {
        let mut values: Vec<bool> = Vec::new();
        for step in &self.steps {
            let value = match step {
                Step::Leaf(Leaf::HalfPlane { from, to }) => {
                    (*to - *from).perp_dot(point - *from) > 0.0
                }
                Step::Leaf(Leaf::Disc(map)) => map.inverse().transform_point2(point).length() < 1.0,
                Step::Leaf(Leaf::Parabola(map)) => {
                    let own = map.inverse().transform_point2(point);
                    own.y > own.x * own.x
                }
                &Step::All(count) => values.split_off(values.len() - count).iter().all(|&v| v),
                &Step::Any(count) => values.split_off(values.len() - count).iter().any(|&v| v),
                Step::Not => !values.pop().expect("a value"),
            };
            values.push(value);
        }
        values.pop().unwrap_or(false)
    }
}
