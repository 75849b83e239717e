//! Solids and profiles of a new size.

use glam::{BVec2, BVec3, DAffine2, DAffine3, DVec2, DVec3};

use super::Faceting;
use crate::BoundaryOptions;
use crate::error::Error;
use crate::limits::Limits;
use crate::program::Program;
use crate::solid::Solid;
use crate::solid::profile::Profile;

impl Solid {
    /// The least and greatest coordinates, to rounding ([`crate::Brep::bounds`]; those of a mesh
    /// where the exact boundary could not be told); `None` of an empty solid.
    ///
    /// # Errors
    /// What is wrong with the solid, one without end, [`Error::InvalidOption`] for more work than
    /// `faceting` has left.
    pub fn corner_bounds(&self, faceting: &mut Faceting) -> Result<Option<(DVec3, DVec3)>, Error> {
        let program = Program::lower(self)?;
        if !program.is_polyhedral() {
            let limits = Limits::new().cells(faceting.cells[0]);
            match program.boundary(&BoundaryOptions::new().limits(limits)) {
                Ok(brep) => return Ok(brep.bounds().map(|bounds| (bounds.min, bounds.max))),
                Err(Error::Undecided(_) | Error::LimitReached(_)) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(faceting.mesh(self)?.bounds())
    }

    /// The solid scaled about the origin to a size along each axis, in model units: 0 leaves an axis
    /// alone, or, where `auto` is true, scales it as the axis of the largest new size. Empty solids
    /// stay empty. The size it has is that of [`Self::corner_bounds`].
    ///
    /// ```
    /// use csg::glam::BVec3;
    /// use csg::{Program, Solid, corners::Faceting};
    ///
    /// let bar = Solid::cuboid([1.0, 2.0, 3.0]);
    /// let resized = bar.resized([2.0, 0.0, 0.0], BVec3::new(false, true, false), &mut Faceting::new())?;
    /// let volume = Program::lower(&resized)?.boundary(&Default::default())?.measure().volume;
    /// assert!((volume.value - 2.0 * 4.0 * 3.0).abs() <= volume.error);
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::corner_bounds`]; [`Error::InvalidOption`] for a size that is not finite.
    pub fn resized(
        &self,
        size: impl Into<DVec3>,
        auto: BVec3,
        faceting: &mut Faceting,
    ) -> Result<Self, Error> {
        faceting.standing_in(|faceting| {
            let Some((min, max)) = self.corner_bounds(faceting)? else {
                return Ok(Self::empty());
            };
            let scale = factors(max - min, size.into(), auto)?;
            Ok(self.affine(DAffine3::from_scale(scale)))
        })
    }
}

impl Profile {
    /// The same of a flat shape, whose size is exact but for rounding.
    ///
    /// # Errors
    /// What is wrong with the profile; [`Error::InvalidOption`] for a size that is not finite.
    pub fn resized(&self, size: impl Into<DVec2>, auto: BVec2) -> Result<Self, Error> {
        let bounds = self
            .tight_bounds()
            .map_err(|fault| Error::InvalidOption(fault.to_string()))?;
        let Some((min, max)) = bounds else {
            return Ok(self.clone());
        };
        let own = (max - min).extend(1.0);
        let auto = BVec3::new(auto.x, auto.y, false);
        let scale = factors(own, size.into().extend(0.0), auto)?.truncate();
        Ok(self.affine(DAffine2::from_scale(scale)))
    }
}

/// What a size is to be scaled by.
fn factors(own: DVec3, size: DVec3, auto: BVec3) -> Result<DVec3, Error> {
    let mut scale = DVec3::ONE;
    let mut largest = 0;
    for axis in 0..3 {
        if size[axis] != 0.0 {
            scale[axis] = size[axis] / own[axis];
            if size[axis] > size[largest] {
                largest = axis;
            }
        }
    }
    if size[largest] != 0.0 {
        let same = size[largest] / own[largest];
        for axis in 0..3 {
            if auto.test(axis) && size[axis] == 0.0 {
                scale[axis] = same;
            }
        }
    }
    if scale.is_finite() && scale.cmpne(DVec3::ZERO).all() {
        Ok(scale)
    } else {
        Err(Error::InvalidOption(format!(
            "the new size {size} is not finite"
        )))
    }
}
