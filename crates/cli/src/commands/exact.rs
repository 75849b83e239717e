//! What `measure` says of a solid's exact boundary, as JSON and for people.

use std::fmt;
use std::time::Instant;

use csg::{BoundaryOptions, Brep, Program, Solid};
use serde::Serialize;

use super::account::{Bounds, MovedAccount, told};
use super::figure::Figure;
use crate::mesher::Unit;

/// Measures of a solid from its exact boundary. In the model's unit and its powers.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct ExactAccount {
    volume: Figure,
    area: Figure,
    centroid: Option<[Figure; 3]>,
    /// About the centroid, at density 1: the rows of a symmetric matrix.
    inertia: [[f64; 3]; 3],
    /// Bound on the error of each of its entries.
    inertia_error: f64,
    bounds: Option<Bounds>,
    /// Connected parts of the boundary.
    components: usize,
    /// Summed over the components.
    genus: usize,
    faces: usize,
    edges: usize,
    vertices: usize,
    /// Null unless surfaces that nearly coincide or touch were moved.
    moved: Option<MovedAccount>,
    /// How far parts of the solid stray at most from what they stand for: chords and flat faces, from
    /// what there are no surfaces for. Measures are of the solid as it is. Null if all is what was
    /// asked for.
    strays: Option<f64>,
    unit: &'static str,
    seconds: f64,
}

impl ExactAccount {
    /// Evaluates and measures the boundary.
    pub(crate) fn of(
        (solid, program): (&Solid, &Program),
        options: &BoundaryOptions,
        unit: Unit,
    ) -> Result<(Self, Brep), csg::Error> {
        let start = Instant::now();
        let brep = program.boundary(options)?;
        let measure = brep.measure();
        let account = Self {
            volume: measure.volume.into(),
            area: measure.area.into(),
            centroid: measure.centroid.map(|centroid| centroid.map(Figure::from)),
            inertia: measure.inertia().to_cols_array_2d(),
            inertia_error: 2.0 * measure.second_moments_error,
            bounds: brep
                .bounds()
                .map(|bounds| Bounds::new(bounds.min, bounds.max)),
            components: brep.shells().len(),
            genus: brep.shells().map(|shell| shell.genus()).sum(),
            faces: brep.faces().len(),
            edges: brep.edges().len(),
            vertices: brep.vertices().len(),
            moved: brep.moved().map(MovedAccount::from),
            strays: solid.strays(),
            unit: unit.symbol(),
            seconds: start.elapsed().as_secs_f64(),
        };
        Ok((account, brep))
    }
}

impl ExactAccount {
    /// Whether nothing is left of the solid.
    pub(crate) fn is_empty(&self) -> bool {
        self.faces == 0
    }
}

impl fmt::Display for ExactAccount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.unit;
        writeln!(f, "volume      {} {unit}³", self.volume)?;
        writeln!(f, "area        {} {unit}²", self.area)?;
        if let Some(centroid) = &self.centroid {
            for (axis, figure) in ["x", "y", "z"].into_iter().zip(centroid) {
                writeln!(f, "centroid {axis}  {figure} {unit}")?;
            }
        }
        if let Some(bounds) = &self.bounds {
            writeln!(f, "{bounds}")?;
        }
        writeln!(f, "components  {}", self.components)?;
        writeln!(f, "genus       {}", self.genus)?;
        writeln!(f, "faces       {}", self.faces)?;
        writeln!(f, "edges       {}", self.edges)?;
        writeln!(f, "vertices    {}", self.vertices)?;
        if let Some(moved) = &self.moved {
            writeln!(f, "{moved}")?;
        }
        if let Some(strays) = self.strays {
            writeln!(f, "{}", told(strays, unit))?;
        }
        writeln!(f, "state       exact boundary")?;
        writeln!(f, "seconds     {:.3}", self.seconds)
    }
}
