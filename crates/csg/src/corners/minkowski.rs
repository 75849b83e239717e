//! Minkowski sums: all sums of a point of each.

use glam::{DVec2, DVec3};

use super::hull::balls;
use super::{Faceting, parts};
use crate::error::Error;
use crate::solid::Solid;
use crate::solid::profile::{Join, Profile};

/// The most pairs of convex parts.
const MOST_PAIRS: usize = 1000;

impl Solid {
    /// The Minkowski sum: all sums of a point of each; nothing if one is empty or there are none. Parts
    /// that are not convex are cut into convex ones first. Exact of flat faces, of balls, and of balls
    /// of one size and flat faces with at most 200 corners; else of meshes.
    ///
    /// Of m and n convex parts it is the union of m n hulls: at most 1000.
    ///
    /// # Errors
    /// What is wrong with a solid, one without end, [`Error::InvalidOption`] for more parts, or
    /// more work than `faceting` has left.
    pub fn minkowski_sum(
        solids: impl IntoIterator<Item = Self>,
        faceting: &mut Faceting,
    ) -> Result<Self, Error> {
        // In another order it is the same.
        let is_round = |solid: &Self| balls(std::slice::from_ref(solid)).is_some();
        let (round, flat): (Vec<Self>, Vec<Self>) = solids.into_iter().partition(is_round);
        let kinds = [
            sum_in_order(flat, faceting)?,
            sum_in_order(round, faceting)?,
        ];
        let sum = sum_in_order(kinds.into_iter().flatten().collect(), faceting)?;
        Ok(sum.unwrap_or_else(Self::empty))
    }
}

impl Profile {
    /// The Minkowski sum of flat shapes. That of one with circles is what its outline moved outwards
    /// encloses; others are summed as prisms ([`Solid::minkowski_sum`]).
    ///
    /// # Errors
    /// As for solids; [`Error::InvalidOption`] where rounding leaves open how an outline is moved.
    pub fn minkowski_sum(
        profiles: impl IntoIterator<Item = Self>,
        faceting: &mut Faceting,
    ) -> Result<Self, Error> {
        let mut others = Vec::new();
        let (mut radius, mut place) = (0.0, DVec2::ZERO);
        for profile in profiles {
            match profile.as_circle() {
                Some((center, of)) => {
                    radius += of;
                    place += center;
                }
                None => others.push(profile),
            }
        }
        let Some(first) = others.pop() else {
            return Ok(Self::circle(radius).translate(place));
        };
        let sum = if others.is_empty() {
            first
        } else {
            let prism = |profile| Solid::extrude(profile, -0.5..0.5);
            let prisms: Vec<Solid> = others.iter().chain([&first]).map(prism).collect();
            Solid::minkowski_sum(prisms, faceting)?.faceted_section(faceting)?
        };
        if radius == 0.0 {
            return Ok(sum);
        }
        let moved = sum.exact_offset(radius, Join::Round).ok_or_else(|| {
            let problem = "rounding leaves open how its outline is moved by the circles";
            Error::InvalidOption(problem.to_owned())
        })?;
        Ok(moved.translate(place))
    }
}

/// None of no solids.
fn sum_in_order(solids: Vec<Solid>, faceting: &mut Faceting) -> Result<Option<Solid>, Error> {
    let mut solids = solids.into_iter();
    let Some(mut sum) = solids.next() else {
        return Ok(None);
    };
    for solid in solids {
        sum = match rounded(&sum, &solid, faceting)? {
            Some(rounded) => rounded,
            None => sum_of_parts(&sum, &solid, faceting)?,
        };
    }
    Ok(Some(sum))
}

/// The hulls of all sums of corners.
fn sum_of_parts(one: &Solid, other: &Solid, faceting: &mut Faceting) -> Result<Solid, Error> {
    let (first, second) = (parts(one, faceting)?, parts(other, faceting)?);
    let pairs = first.len() * second.len();
    if pairs > MOST_PAIRS {
        return Err(Error::InvalidOption(format!(
            "{} by {} convex parts are more than {MOST_PAIRS} pairs: give simpler operands",
            first.len(),
            second.len()
        )));
    }
    if pairs == 0 {
        return Ok(Solid::empty());
    }
    let mut hulls = Vec::with_capacity(pairs);
    for a in &first {
        for b in &second {
            let [left, most] = faceting.sums;
            let rest = left.checked_sub(a.len() * b.len());
            faceting.sums[0] = rest.ok_or_else(|| {
                Error::InvalidOption(format!(
                    "its operands have too many corners (more than {most} pairs in all): give simpler ones"
                ))
            })?;
            let sums = a.iter().flat_map(|&p| b.iter().map(move |&q| p + q));
            hulls.push(Solid::hull(sums));
        }
    }
    Ok(Solid::union(hulls))
}

/// The sum of two solids if one of them is made of balls, and the other one too, or of few flat
/// faces.
fn rounded(one: &Solid, other: &Solid, faceting: &mut Faceting) -> Result<Option<Solid>, Error> {
    /// Of all parts; with more, chords of the balls are cheaper.
    const MOST_CORNERS: usize = 200;
    let of = |solid: &Solid| balls(std::slice::from_ref(solid));
    let (parts, (centers, radius)) = match (of(one), of(other)) {
        (None, None) => return Ok(None),
        (Some((ones, radius)), Some((others, other))) => {
            let parts = ones.into_iter().map(|center| vec![center]).collect();
            (parts, (others, radius + other))
        }
        (Some(balls), None) => (parts(other, faceting)?, balls),
        (None, Some(balls)) => (parts(one, faceting)?, balls),
    };
    let corners: usize = parts.iter().map(Vec::len).sum();
    if corners * centers.len() > MOST_CORNERS {
        return Ok(None);
    }
    if parts.is_empty() {
        return Ok(Some(Solid::empty()));
    }
    let pairs = parts
        .iter()
        .flat_map(|part| centers.iter().map(move |&center| (part, center)));
    let hulls = pairs.map(|(part, center)| {
        let moved: Vec<DVec3> = part.iter().map(|&corner| corner + center).collect();
        Solid::hull_of_balls(&moved, radius)
    });
    Ok(hulls.collect::<Option<Vec<Solid>>>().map(Solid::union))
}
