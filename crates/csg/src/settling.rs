//! The ways to move surfaces before a boundary is evaluated, so that it can be.

mod spread;

use glam::DVec3;

use crate::arrangement::{self, Chords};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::numeric::tolerance::{MISSED, ON_FACE, SEEN, SHARE_MISSED};
use crate::program::{Bounds, Program, Settled, Surface};
use crate::report::Moved;

/// What is done to surfaces, in the order in which it is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Settling {
    /// Those that cannot be told apart where boundaries are evaluated are made one.
    Merged,
    /// Those that miss touching, being round, flush or in line by little are moved until they
    /// are, by up to so many times what others are moved.
    Aligned { times: f64 },
    /// All are rounded to as many decimals as are a small share of the tolerance.
    Rounded,
    /// The same as first, and then each that passes a place that made trouble within such a
    /// share of the solid's size is moved on its own, by a small share of the tolerance.
    Perturbed { within: f64 },
}

impl Settling {
    pub const ALL: [Self; 5] = [
        Self::Merged,
        Self::Aligned { times: 1.0 },
        Self::Rounded,
        Self::Perturbed { within: 0.02 },
        Self::Perturbed {
            within: f64::INFINITY,
        },
    ];

    /// Those of meshes to a tolerance, each with the series of chords that curves are cut into
    /// at first. Where that is by shorter ones the boundary is the same as before. What an author
    /// rounded coarser than the tolerance allows for is moved by more of it then.
    pub fn with_chords() -> impl Iterator<Item = (Self, &'static Chords)> {
        let (nearest, farther) = Self::ALL.split_at(2);
        let long = |&way: &Self| -> (Self, &'static Chords) { (way, &Chords::LONG) };
        let shorter = [&Chords::SHORT, &Chords::SHORTEST];
        let again = nearest
            .iter()
            .flat_map(move |&way| shorter.map(|chords| (way, chords)));
        let seen = [Self::Aligned { times: SEEN }];
        let farther = seen.into_iter().chain(farther.iter().copied());
        let last = farther.clone().last();
        let last = last
            .into_iter()
            .flat_map(move |way| shorter.map(|chords| (way, chords)));
        let nearest = nearest.iter().map(long);
        nearest
            .chain(again)
            .chain(farther.map(move |way| long(&way)))
            .chain(last)
    }

    /// Whether nothing is left of the solid because surfaces were moved: walls thinner
    /// than that are better meshed in another way than lost.
    pub fn has_lost(self, is_empty: bool) -> bool {
        self != Self::Merged && is_empty
    }
}

/// A program to be evaluated.
pub(crate) struct Prepared(Option<Settled>);

impl Prepared {
    /// A program with its surfaces moved in one of the ways, by no more than `unseen` within
    /// its bounds; none if it was tried as it is. `places` are those that made trouble so far.
    pub fn new(
        program: &Program,
        bounds: &Bounds,
        settling: Settling,
        unseen: f64,
        places: &[DVec3],
    ) -> Result<Option<Self>, Error> {
        let size = bounds.size();
        let unresolved = arrangement::unresolved(program) * size.max_element();
        let ball = (bounds.center(), 0.5 * size.length());
        let merged = || program.merged(ball, unresolved.min(unseen), unseen);
        let settled = match settling {
            Settling::Merged => merged()?,
            Settling::Aligned { times } => {
                let most = times * unseen;
                let within = (MISSED * size.max_element()).min(SHARE_MISSED * most);
                let same = unresolved.min(most);
                match program.aligned(ball, (within, same), most)? {
                    None => return Ok(None),
                    aligned => aligned,
                }
            }
            Settling::Rounded => match program.rounded(ball, unseen)? {
                None => return Ok(None),
                rounded => rounded,
            },
            Settling::Perturbed { within } => {
                let within = within * size.max_element();
                let is_meant = |surface: &Surface| {
                    let passes = |&place: &DVec3| {
                        let slope = surface.gradient(place).length();
                        surface.value(place).abs() <= within * (slope + within)
                    };
                    within.is_infinite() || places.iter().any(passes)
                };
                let merged = merged()?;
                let program = merged.as_ref().map_or(program, |m| &m.program);
                let Some(perturbed) = program.perturbed(ball, unseen, is_meant)? else {
                    return Ok(None);
                };
                Some(match merged {
                    Some(merged) => Settled {
                        merged: merged.merged,
                        moved: merged.moved + perturbed.moved,
                        moves: sums(&merged.moves, &perturbed.moves),
                        between: merged.between + perturbed.between,
                        ..perturbed
                    },
                    None => perturbed,
                })
            }
        };
        Ok(Some(Self(settled)))
    }

    /// What is told of the moves: what was moved by less than rounding moves it, or the plane of a
    /// face through given points, is where it was.
    pub fn told(&self, bounds: &Bounds) -> Option<Moved> {
        let longest = bounds.size().max_element();
        let rounding = arrangement::rounding(bounds.center(), longest) + ON_FACE * longest;
        let moved = self.0.as_ref().filter(|settled| settled.moved > rounding);
        moved.map(|settled| Moved {
            merged: settled.merged,
            distance: settled.moved,
            place: settled.place,
        })
    }

    /// What it was made, if that is another one.
    pub fn moved(&self) -> Option<&Settled> {
        self.0.as_ref()
    }

    pub fn program<'a>(&'a self, original: &'a Program) -> &'a Program {
        self.moved().map_or(original, |settled| &settled.program)
    }

    /// Bound on how far any surface was moved.
    pub fn distance(&self) -> f64 {
        self.moved().map_or(0.0, |settled| settled.moved)
    }

    /// Bound on the volume between surfaces that were made one, within bounds.
    pub fn volume_between(&self, bounds: &Bounds) -> f64 {
        let DVec3 { x, y, z } = bounds.size();
        // No convex surface has more area in a box than that itself, and a surface has two sheets.
        let area = 4.0 * (x * y + y * z + z * x);
        area * self.moved().map_or(0.0, |settled| settled.between)
    }

    /// How far the boundary was moved of which this is a mesh, to first order, and where most:
    /// its edges and corners by more than its surfaces, of which `surfaces` are those in the
    /// mesh's frame. Of moves that are not [`told`](Self::told) only these count.
    pub fn moved_boundary(
        &self,
        mesh: &Mesh,
        surfaces: &[Surface],
        told: Option<Moved>,
    ) -> (f64, DVec3) {
        let moved = self.distance();
        match self.moved().filter(|_| told.is_some()) {
            Some(settled) => {
                let (distance, place) = spread::farthest(mesh, surfaces, &settled.moves);
                (distance.max(moved), place)
            }
            None => (moved, DVec3::ZERO),
        }
    }
}

fn sums(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}
