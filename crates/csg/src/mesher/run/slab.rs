//! Meshing a slab of a lattice.

use super::Run;
use crate::error::Error;
use crate::limits::Demand;
use crate::mesher::options::Method;
use crate::surface_nets::slab::{self, Slab};
use crate::task::Task;

impl Run<'_> {
    /// A slab of the mesh by cells.
    pub fn slab(&self, part: u32, of: u32) -> Result<Slab, Error> {
        self.check_slab(part, of)?;
        let mesher = self.mesher;
        self.control.check()?;
        let bounds = match mesher.bounds {
            Some(bounds) => Some(bounds),
            None => self.program.bounds()?,
        };
        // A box without extent holds no solid: at most a point was left of it.
        let Some(bounds) = bounds.filter(|bounds| bounds.size().max_element() > 0.0) else {
            return Ok(slab::empty(self.program, mesher.unit, (part, of)));
        };
        let longest = bounds.size().max_element();
        let cell = self.cell_size(&bounds)?.min(longest);
        let control = self.control.again(Demand::Cells(cell));
        let task = Task::new(self.program, bounds, cell, &control);
        let slab = slab::cut(&task, mesher.unit, (part, of))?;
        control.check_triangles(slab.triangles.len())?;
        self.control.tell(1.0);
        Ok(slab)
    }

    fn check_slab(&self, part: u32, of: u32) -> Result<(), Error> {
        let mesher = self.mesher;
        let problem = if part >= of {
            format!("slab {part} of {of}: they are counted from 0")
        } else if matches!(mesher.method, Method::Draft) {
            "a slab of a draft: slabs are exact, leave one of the two out".into()
        } else if self.goal.is_some() {
            "a slab to a tolerance: slabs are by cells alone, leave one of the two out".into()
        } else if self.smallest.is_some() || !mesher.is_by_cells() {
            "a slab without cells: give their number or size".into()
        } else if mesher.feature_angle.is_some() {
            "feature edges of a slab: they are known of whole meshes alone".into()
        } else if mesher.limits.partial {
            "a partial result of a slab: the others would not fit it, raise the limits".into()
        } else {
            return Ok(());
        };
        Err(Error::InvalidOption(problem))
    }
}
