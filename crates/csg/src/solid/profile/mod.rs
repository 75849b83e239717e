//! Profiles: what a user draws in a plane, to be extruded or revolved.
//!
//! A [`Profile`] is a Boolean combination of circles and contours of lines,
//! arcs and parabolas, held in postfix order under maps that are already applied to the
//! leaves: however many operations made it, nothing recurses. It is never
//! turned into polygons unless an operation needs corners (offset, hull,
//! twist); lowering makes a formula over half-planes, discs and what
//! parabolas enclose of it ([`formula`]), and extrusion or revolution makes surfaces of these.

mod arcs;
mod bent;
mod contour;
mod ears;
mod flatten;
mod hull;
mod lines;
mod monotone;
mod offset;
mod outline;
mod parabola;
mod path;
mod plane_set;
mod polygon;
mod segments;
mod shapes;
mod side;
mod stored;
mod turn;

#[cfg(test)]
mod tests;

use std::ops::{Add, BitAnd, BitOr, Sub};
use std::sync::Arc;

use crate::elementary;
use glam::{DAffine2, DMat2, DVec2};
use serde::{Deserialize, Serialize};

use super::tree::Solid;
use crate::error::ProfileFault;

pub use self::offset::Join;
pub use self::path::Path;
pub use self::turn::turn;

pub(crate) use self::arcs::Sagitta;
pub(crate) use self::contour::{Formula, Segmented, formula, segmented};
pub(crate) use self::lines::Lines;
pub(crate) use self::parabola::corner_on_parabola;
pub(crate) use self::plane_set::{Leaf, PlaneSet};
pub(crate) use self::polygon::doubled_area;
use crate::numeric::tolerance::MAPPED;

/// Which points closed contours enclose, by how often these wind around them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum FillRule {
    /// Those around which the contours wind an odd number of times: a contour
    /// within another is a hole, whichever way round it runs.
    #[default]
    EvenOdd,
    /// Those around which they wind at all, counter-clockwise turns counting
    /// +1 and clockwise ones -1: as outlines of glyphs are meant.
    NonZero,
}

impl FillRule {
    fn is_inside(self, winding: i64) -> bool {
        match self {
            Self::EvenOdd => winding % 2 != 0,
            Self::NonZero => winding != 0,
        }
    }
}

/// A corner of a contour, and how the side that starts there bends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Corner {
    pub point: DVec2,
    pub bend: Bend,
}

/// How a side goes from its corner to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Bend {
    Straight,
    /// By an arc: the tangent of a quarter of the angle that it turns through, counter-clockwise
    /// positive, and not 0.
    Arc(f64),
    /// By a parabola.
    Parabola {
        /// Where its tangents at both ends meet.
        control: DVec2,
        /// The control points of the curve that it is a piece of: however that is cut, its pieces
        /// are on one parabola to the last digit.
        of: [DVec2; 3],
    },
}

impl Bend {
    fn is_finite(self) -> bool {
        match self {
            Self::Straight => true,
            Self::Arc(bulge) => bulge.is_finite(),
            Self::Parabola { control, of } => {
                control.is_finite() && of.iter().all(|point| point.is_finite())
            }
        }
    }
}

impl Corner {
    pub(crate) const fn straight(point: DVec2) -> Self {
        let bend = Bend::Straight;
        Self { point, bend }
    }

    /// With an arc of a bulge to the next corner; 0 is a straight side.
    pub(crate) fn arc(point: DVec2, bulge: f64) -> Self {
        let bend = if bulge == 0.0 {
            Bend::Straight
        } else {
            Bend::Arc(bulge)
        };
        Self { point, bend }
    }

    fn is_straight(&self) -> bool {
        self.bend == Bend::Straight
    }

    fn is_parabola(&self) -> bool {
        matches!(self.bend, Bend::Parabola { .. })
    }

    /// Of what is no arc 0.
    fn bulge(&self) -> f64 {
        match self.bend {
            Bend::Arc(bulge) => bulge,
            Bend::Straight | Bend::Parabola { .. } => 0.0,
        }
    }
}

/// A closed contour of lines, arcs and parabolas.
pub(crate) type Contour = Vec<Corner>;

/// A set of points in the plane: a Boolean combination of circles and
/// contours of lines, arcs and parabolas.
///
/// `|` (and `+`) unite, `-` subtracts, `&` intersects. Building never fails:
/// what is wrong with an argument is found when the profile is made into a
/// solid, or asked for by [`Profile::contours`].
///
/// ```
/// use csg::{Profile, Program, Solid};
///
/// let plate = Profile::rounded_rectangle([60.0, 40.0], 5.0);
/// let holes = Profile::circle(3.0);
/// let drilled = [[-20.0, 0.0], [20.0, 0.0]]
///     .into_iter()
///     .fold(plate, |plate, at| plate - holes.translate(at));
/// let solid = Solid::extrude(&drilled, 0.0..4.0);
/// let program = Program::lower(&solid)?;
/// assert!(program.contains([0.0, 0.0, 2.0]) && !program.contains([20.0, 0.0, 2.0]));
/// # Ok::<(), csg::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Step>", into = "Vec<Step>")]
pub struct Profile {
    /// In postfix order; one value is left at the end.
    steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Step {
    Shape(Shape, DAffine2),
    /// Combines the last so many values.
    Combine(Combination, usize),
    /// Nobody stores what is wrong.
    #[serde(skip)]
    Fault(ProfileFault),
}

/// A leaf in its own coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Shape {
    /// The disc of radius 1 around the origin.
    Disc,
    Contours(Arc<[Contour]>, FillRule),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Combination {
    Union,
    Intersection,
    /// The first without all the others.
    Difference,
}

impl Profile {
    fn shape(shape: Shape, map: DAffine2) -> Self {
        Self {
            steps: vec![Step::Shape(shape, map)],
        }
    }

    pub(crate) fn faulty(fault: ProfileFault) -> Self {
        Self {
            steps: vec![Step::Fault(fault)],
        }
    }

    /// The first thing that is wrong with what the profile was made from, as far as
    /// that can be told without going through its contours.
    #[must_use]
    pub fn fault(&self) -> Option<&ProfileFault> {
        self.steps.iter().find_map(|step| match step {
            Step::Fault(fault) => Some(fault),
            _ => None,
        })
    }

    /// Whether it has neither circles nor arcs nor parabolas.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.steps.iter().all(|step| match step {
            Step::Shape(Shape::Disc, _) => false,
            Step::Shape(Shape::Contours(contours, _), _) => {
                contours.iter().flatten().all(Corner::is_straight)
            }
            Step::Combine(..) | Step::Fault(_) => true,
        })
    }

    fn of(result: Result<Self, ProfileFault>) -> Self {
        result.unwrap_or_else(Self::faulty)
    }

    /// The profile without any point.
    #[must_use]
    pub fn empty() -> Self {
        Self::combine(Combination::Union, std::iter::empty())
    }

    fn combine(combination: Combination, operands: impl IntoIterator<Item = Self>) -> Self {
        let mut steps = Vec::new();
        let mut count = 0;
        for mut operand in operands {
            // A chain of unions is one union.
            let first = count == 0 && combination != Combination::Intersection;
            match operand.steps.last() {
                Some(&Step::Combine(inner, n)) if first && inner == combination && n > 0 => {
                    operand.steps.pop();
                    count += n;
                }
                _ => count += 1,
            }
            if steps.is_empty() {
                steps = operand.steps;
            } else {
                steps.append(&mut operand.steps);
            }
        }
        steps.push(Step::Combine(combination, count));
        Self { steps }
    }

    /// The union of all operands; nothing if there are none.
    #[must_use]
    pub fn union(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::combine(Combination::Union, operands)
    }

    /// The intersection of all operands; nothing if there are none.
    #[must_use]
    pub fn intersection(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::combine(Combination::Intersection, operands)
    }

    /// The first operand without all the others; nothing if there are none.
    #[must_use]
    pub fn difference(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::combine(Combination::Difference, operands)
    }

    /// The image under an invertible affine map.
    #[must_use]
    pub fn affine(&self, map: DAffine2) -> Self {
        if !map.is_finite() {
            return Self::faulty(ProfileFault::NotFinite { what: "the map" });
        }
        let linear = map.matrix2;
        let lengths = linear.x_axis.length() * linear.y_axis.length();
        let conditioning = (linear.determinant() / lengths).abs();
        if conditioning.is_nan() || conditioning <= MAPPED {
            return Self::faulty(ProfileFault::SingularMap);
        }
        let mut mapped = self.clone();
        for step in &mut mapped.steps {
            if let Step::Shape(_, own) = step {
                *own = map * *own;
            }
        }
        mapped
    }

    /// Moves by `offset`.
    #[must_use]
    pub fn translate(&self, offset: impl Into<DVec2>) -> Self {
        self.affine(DAffine2::from_translation(offset.into()))
    }

    /// Turns about the origin, counter-clockwise, by an angle in radians.
    #[must_use]
    pub fn rotate(&self, radians: f64) -> Self {
        let direction = elementary::direction(radians);
        let turn = DMat2::from_cols(direction, direction.perp());
        self.affine(DAffine2::from_mat2(turn))
    }

    /// Scales about the origin; a negative factor turns by half a turn.
    #[must_use]
    pub fn scale(&self, factor: f64) -> Self {
        self.scale_xy([factor; 2])
    }

    /// Scales about the origin, along x and y; negative factors mirror.
    #[must_use]
    pub fn scale_xy(&self, factors: impl Into<DVec2>) -> Self {
        self.affine(DAffine2::from_scale(factors.into()))
    }

    /// Mirrors in the line through the origin across `normal`.
    #[must_use]
    pub fn mirror(&self, normal: impl Into<DVec2>) -> Self {
        let normal = normal.into();
        let Some(unit) = normal.try_normalize() else {
            return Self::faulty(ProfileFault::NotFinite {
                what: "the mirror's normal, or its direction,",
            });
        };
        let across = -2.0 * unit;
        let matrix = DMat2::IDENTITY + DMat2::from_cols(across * unit.x, across * unit.y);
        self.affine(DAffine2::from_mat2(matrix))
    }

    /// What solids that stand for its shapes, each a profile of its own, make together.
    pub(super) fn by_shapes(
        &self,
        mut solid_of: impl FnMut(&Self) -> Result<Solid, ProfileFault>,
    ) -> Result<Solid, ProfileFault> {
        let solid = self.fold(
            |shape, map| solid_of(&Self::shape(shape.clone(), *map)),
            |combination, solids| {
                Ok(match combination {
                    Combination::Union => Solid::union(solids),
                    Combination::Intersection => Solid::intersection(solids),
                    Combination::Difference => {
                        let mut solids = solids.into_iter();
                        let first = solids.next().unwrap_or_else(Solid::empty);
                        first - Solid::union(solids)
                    }
                })
            },
        )?;
        Ok(solid.unwrap_or_else(Solid::empty))
    }

    /// Goes through the steps: the value of each leaf, then what becomes of
    /// the values of operands.
    fn fold<T>(
        &self,
        mut leaf: impl FnMut(&Shape, &DAffine2) -> Result<T, ProfileFault>,
        mut combine: impl FnMut(Combination, Vec<T>) -> Result<T, ProfileFault>,
    ) -> Result<Option<T>, ProfileFault> {
        let mut values = Vec::new();
        for step in &self.steps {
            let value = match step {
                Step::Shape(shape, map) => leaf(shape, map)?,
                Step::Fault(fault) => return Err(fault.clone()),
                &Step::Combine(combination, count) => {
                    let operands = values.split_off(values.len() - count);
                    combine(combination, operands)?
                }
            };
            values.push(value);
        }
        Ok(values.pop())
    }
}

macro_rules! boolean_operator {
    ($trait:ident, $method:ident, $combination:ident) => {
        impl $trait<&Profile> for &Profile {
            type Output = Profile;
            fn $method(self, other: &Profile) -> Profile {
                self.clone().$method(other.clone())
            }
        }
        impl $trait<Profile> for Profile {
            type Output = Profile;
            fn $method(self, other: Profile) -> Profile {
                Profile::combine(Combination::$combination, [self, other])
            }
        }
        impl $trait<&Profile> for Profile {
            type Output = Profile;
            fn $method(self, other: &Profile) -> Profile {
                self.$method(other.clone())
            }
        }
        impl $trait<Profile> for &Profile {
            type Output = Profile;
            fn $method(self, other: Profile) -> Profile {
                self.clone().$method(other)
            }
        }
    };
}

boolean_operator!(BitOr, bitor, Union);
boolean_operator!(Add, add, Union);
boolean_operator!(BitAnd, bitand, Intersection);
boolean_operator!(Sub, sub, Difference);
