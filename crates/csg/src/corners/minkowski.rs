//! Minkowski sums: all sums of a point of each.

use std::ops::Range;

use glam::{DAffine2, DAffine3, DMat2, DMat3, DVec2, DVec3};

use super::hull::{balls, primitives};
use super::{Faceting, parts};
use crate::error::Error;
use crate::numeric::tolerance::SAME_LENGTH;
use crate::solid::profile::{Join, Profile};
use crate::solid::{Primitive, Solid};

/// The most pairs of convex parts.
const MOST_PAIRS: usize = 1000;

impl Solid {
    /// The Minkowski sum: all sums of a point of each; nothing if one is empty or there are none. Parts
    /// that are not convex are cut into convex ones first. Exact of flat faces, of balls, of balls
    /// of one size and flat faces with at most 200 corners, and of cylinders with parallel axes and of
    /// prisms along these; else of meshes.
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
        let solids: Vec<Self> = solids.into_iter().collect();
        faceting.standing_in(|faceting| {
            if let Some(sum) = sum_of_columns(&solids, faceting)? {
                return Ok(sum);
            }
            // In another order it is the same.
            let is_round = |solid: &Self| balls(std::slice::from_ref(solid)).is_some();
            let (round, flat): (Vec<Self>, Vec<Self>) = solids.into_iter().partition(is_round);
            let kinds = [
                sum_in_order(flat, faceting)?,
                sum_in_order(round, faceting)?,
            ];
            let sum = sum_in_order(kinds.into_iter().flatten().collect(), faceting)?;
            Ok(sum.unwrap_or_else(Self::empty))
        })
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

/// The sum of solids that are each what a flat shape sweeps along one axis, cylinders among them: that
/// of the shapes, swept along all the ways together. None of others.
fn sum_of_columns(solids: &[Solid], faceting: &mut Faceting) -> Result<Option<Solid>, Error> {
    let all = solids
        .iter()
        .map(|solid| primitives(std::slice::from_ref(solid)))
        .collect::<Option<Vec<_>>>();
    let Some(all) = all else { return Ok(None) };
    let axis = all.iter().flatten().find_map(|(primitive, map)| {
        let is_cylinder = matches!(primitive, Primitive::Cylinder { z: Some(_), .. });
        is_cylinder.then(|| map.matrix3.z_axis.normalize_or_zero())
    });
    let Some(axis) = axis else { return Ok(None) };
    let (x, y) = axis.any_orthonormal_pair();
    let frame = DAffine3::from_mat3(DMat3::from_cols(x, y, axis));
    let mut shapes = Vec::with_capacity(all.len());
    let mut along = 0.0..0.0;
    for primitives in all {
        let column = |(primitive, map): (&Primitive, DAffine3)| {
            Column::of(
                primitive,
                DAffine3::from_mat3(frame.matrix3.transpose()) * map,
            )
        };
        let columns = primitives.into_iter().map(column);
        let Some(columns) = columns.collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let Some(first) = columns.first().map(|column| column.z.clone()) else {
            return Ok(None);
        };
        if columns.iter().any(|column| column.z != first) {
            return Ok(None);
        }
        along = along.start + first.start..along.end + first.end;
        shapes.push(Profile::union(
            columns.into_iter().map(|column| column.shape),
        ));
    }
    let sum = Profile::minkowski_sum(shapes, faceting).ok();
    Ok(sum.map(|shape| Solid::extrude(&shape, along).affine(frame)))
}

/// What a flat shape sweeps along z.
struct Column {
    shape: Profile,
    z: Range<f64>,
}

impl Column {
    /// The image of a primitive under a map, if it is one.
    fn of(primitive: &Primitive, map: DAffine3) -> Option<Self> {
        let sides = map.matrix3;
        let columns = [sides.x_axis, sides.y_axis, sides.z_axis];
        let is_along = |v: DVec3| v.truncate().length() <= SAME_LENGTH * v.length();
        let is_across = |v: DVec3| v.z.abs() <= SAME_LENGTH * v.length();
        let is_swept =
            |up: usize| is_along(columns[up]) && (0..3).all(|k| k == up || is_across(columns[k]));
        let flat = |up: usize| {
            let [x, y] = [columns[(up + 1) % 3], columns[(up + 2) % 3]];
            DAffine2 {
                matrix2: DMat2::from_cols(x.truncate(), y.truncate()),
                translation: map.translation.truncate(),
            }
        };
        let swept = |shape: Profile, up: usize, [from, to]: [f64; 2]| {
            let ends = [from, to].map(|z| map.translation.z + z * columns[up].z);
            Self {
                shape: shape.affine(flat(up)),
                z: ends[0].min(ends[1])..ends[0].max(ends[1]),
            }
        };
        match primitive {
            Primitive::Cuboid { min, max } => {
                let up = (0..3).find(|&up| is_swept(up))?;
                let corner = |at: &DVec3| DVec2::new(at[(up + 1) % 3], at[(up + 2) % 3]);
                let shape = Profile::rectangle_between(corner(min), corner(max));
                Some(swept(shape, up, [min[up], max[up]]))
            }
            Primitive::Cylinder { radii, z: Some(z) } if is_swept(2) => {
                let shape = Profile::circle(1.0).scale_xy(*radii);
                let column = swept(shape, 2, [z.start, z.end]);
                column.shape.as_circle().is_some().then_some(column)
            }
            Primitive::Prism { polygon, z } if is_swept(2) => {
                let shape = Profile::polygon(polygon.iter().copied());
                Some(swept(shape, 2, [z.start, z.end]))
            }
            _ => None,
        }
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
