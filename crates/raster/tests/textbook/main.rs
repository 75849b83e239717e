//! The formulas of textbooks with the numbers that they print: the table of
//! the crate's page names the test of each row.

mod hidden_surfaces;
mod polygons;
mod projections;
mod shading;
mod solids;
mod transforms;
mod viewing;

use crate::common;
use glam::DMat4;

/// A matrix as it is printed, row by row.
fn rows(rows: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&rows).transpose()
}

fn close(a: DMat4, b: DMat4) -> bool {
    a.abs_diff_eq(b, 1e-12)
}
