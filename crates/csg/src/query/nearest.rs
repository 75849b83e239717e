//! How far points are from a solid's boundary.

use glam::DVec3;

use crate::error::Error;
use crate::mesh::MeshSurface;
use crate::mesher::Mesher;
use crate::program::Program;

/// What of a solid's boundary is nearest to a point ([`Program::nearest`]).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Nearest {
    /// How far the point is from the boundary, in model units, negative within the solid.
    pub distance: f64,
    /// How far that may be off; none if it was not proven how far the mesh is off the boundary.
    pub error: Option<f64>,
    /// The nearest point, which is no farther than that off the boundary.
    pub point: DVec3,
    /// The face it is on: its surface, and the primitive's number, name and colour.
    pub face: MeshSurface,
}

impl Program {
    /// How far points are from the solid's boundary, with the nearest point and face of each:
    /// those of a mesh, so that a distance is off by no more than that is from the boundary, which
    /// [`Nearest::error`] tells. The sign is that of [`Self::contains`]. `None` of an empty solid.
    ///
    /// A mesh, and about log n steps a point for n triangles, in parallel.
    ///
    /// ```
    /// use csg::{Mesher, Program, Solid};
    ///
    /// let part = Solid::cube(4.0).named("block") - Solid::sphere(1.0).named("hollow");
    /// let points = [[0.0, 0.0, 0.25].into(), [0.0, 3.0, 0.0].into(), [1.5, 0.0, 0.0].into()];
    /// let mesher = Mesher::new().tolerance(1e-3);
    /// let nearest = Program::lower(&part)?.nearest(&points, &mesher)?.expect("no empty solid");
    /// for (found, (distance, face)) in
    ///     nearest.iter().zip([(0.75, "hollow"), (1.0, "block"), (-0.5, "block")])
    /// {
    ///     assert!((found.distance - distance).abs() <= found.error.expect("proven"));
    ///     assert!(distance == -0.5 || found.face.name.as_deref() == Some(face));
    /// }
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a point that is not finite; as [`Mesher::mesh`].
    pub fn nearest(
        &self,
        points: &[DVec3],
        mesher: &Mesher,
    ) -> Result<Option<Vec<Nearest>>, Error> {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::InvalidOption(format!(
                "point {index} is {}: give finite numbers",
                points[index]
            )));
        }
        let meshed = mesher.mesh(self)?;
        let Some(nearest) = meshed.mesh.nearest(points) else {
            return Ok(None);
        };
        let signed = points.iter().zip(nearest).map(|(&point, near)| Nearest {
            distance: if self.contains(point) {
                -near.distance
            } else {
                near.distance
            },
            error: meshed.report.deviation,
            point: near.point,
            face: meshed
                .mesh
                .surface_of(near.triangle as usize)
                .cloned()
                .unwrap_or_default(),
        });
        Ok(Some(signed.collect()))
    }
}
