//! Scenes as users of implicit modellers write them: distance fields joined
//! by minimum and maximum.

/// A scalar field, negative inside.
#[derive(Clone, Debug)]
pub enum Field {
    /// Distance to a sphere.
    Ball { center: [f64; 3], radius: f64 },
    /// Distance to an infinite cylinder along an axis (0 for x, ...).
    Rod {
        axis: usize,
        center: [f64; 3],
        radius: f64,
    },
    /// The greatest distance to a face of a box; infinite sides are allowed.
    Block { low: [f64; 3], high: [f64; 3] },
    /// n·p - offset, n a unit vector.
    HalfSpace { normal: [f64; 3], offset: f64 },
    /// The least.
    Union(Vec<Field>),
    /// The greatest.
    Intersection(Vec<Field>),
    /// The first without the second.
    Difference(Box<Field>, Box<Field>),
}

impl Field {
    /// The first without the second.
    pub fn difference(from: Self, taken: Self) -> Self {
        Self::Difference(Box::new(from), Box::new(taken))
    }

    /// How many leaves there are.
    pub fn leaves(&self) -> usize {
        match self {
            Self::Union(of) | Self::Intersection(of) => of.iter().map(Self::leaves).sum(),
            Self::Difference(from, taken) => from.leaves() + taken.leaves(),
            _ => 1,
        }
    }
}
