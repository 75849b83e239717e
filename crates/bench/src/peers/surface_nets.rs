//! fast-surface-nets on a dense grid of single-precision samples.

use csg::Mesh;
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::DVec3;

use crate::field::Field;

/// Samples the field on a grid of `cells` a side over the cube from -half to
/// half, with a margin of one cell, and meshes it; on one thread.
pub fn mesh(field: &Field, cells: u32, half: f64) -> Raw {
    let side = cells + 3;
    let cell = 2.0 * half / f64::from(cells);
    let at = |i: u32| ((f64::from(i) - 1.0) * cell - half) as f32;
    let xs: Vec<f32> = (0..side).map(at).collect();
    let shape = RuntimeShape::<u32, 3>::new([side; 3]);
    let mut samples = vec![0.0_f32; shape.size() as usize];
    for (index, row) in samples.chunks_exact_mut(side as usize).enumerate() {
        let (y, z) = (index as u32 % side, index as u32 / side);
        sample_row(field, &xs, at(y), at(z), row);
    }
    let mut buffer = SurfaceNetsBuffer::default();
    surface_nets(&samples, &shape, [0; 3], [side - 1; 3], &mut buffer);
    Raw { buffer, cell, half }
}

/// A mesh in the coordinates of the grid.
pub struct Raw {
    buffer: SurfaceNetsBuffer,
    cell: f64,
    half: f64,
}

impl Raw {
    /// In the coordinates of the scene.
    pub fn into_mesh(self) -> Mesh {
        let place = |p: &[f32; 3]| {
            let p = DVec3::from_array(p.map(f64::from));
            (p - 1.0) * self.cell - self.half
        };
        let positions = self.buffer.positions.iter().map(place).collect();
        let triangles = self.buffer.indices.chunks_exact(3);
        let triangles = triangles.map(|t| [t[0], t[1], t[2]]).collect();
        Mesh::new(positions, triangles)
    }
}

/// The field along a row of given y and z.
pub fn sample_row(field: &Field, xs: &[f32], y: f32, z: f32, out: &mut [f32]) {
    let join = |of: &[Field], least: bool, out: &mut [f32]| {
        let mut other = vec![0.0; out.len()];
        out.fill(if least { f32::INFINITY } else { -f32::INFINITY });
        for operand in of {
            sample_row(operand, xs, y, z, &mut other);
            for (value, &other) in out.iter_mut().zip(&other) {
                *value = if least {
                    value.min(other)
                } else {
                    value.max(other)
                };
            }
        }
    };
    match field {
        Field::Ball { center, radius } => {
            let [cx, cy, cz] = center.map(|c| c as f32);
            let across = (y - cy) * (y - cy) + (z - cz) * (z - cz);
            let radius = *radius as f32;
            for (value, x) in out.iter_mut().zip(xs) {
                *value = ((x - cx) * (x - cx) + across).sqrt() - radius;
            }
        }
        Field::Rod {
            axis,
            center,
            radius,
        } => {
            let [cx, cy, cz] = center.map(|c| c as f32);
            let (wx, wy, wz) = (
                f32::from(u8::from(*axis != 0)),
                f32::from(u8::from(*axis != 1)),
                f32::from(u8::from(*axis != 2)),
            );
            let across = wy * (y - cy) * (y - cy) + wz * (z - cz) * (z - cz);
            let radius = *radius as f32;
            for (value, x) in out.iter_mut().zip(xs) {
                *value = (wx * (x - cx) * (x - cx) + across).sqrt() - radius;
            }
        }
        Field::Block { low, high } => {
            let [lx, ly, lz] = low.map(|c| c as f32);
            let [hx, hy, hz] = high.map(|c| c as f32);
            let across = (ly - y).max(y - hy).max(lz - z).max(z - hz);
            for (value, x) in out.iter_mut().zip(xs) {
                *value = (lx - x).max(x - hx).max(across);
            }
        }
        Field::HalfSpace { normal, offset } => {
            let [nx, ny, nz] = normal.map(|c| c as f32);
            let across = ny * y + nz * z - *offset as f32;
            for (value, x) in out.iter_mut().zip(xs) {
                *value = nx * x + across;
            }
        }
        Field::Union(of) => join(of, true, out),
        Field::Intersection(of) => join(of, false, out),
        Field::Difference(from, taken) => {
            let mut other = vec![0.0; out.len()];
            sample_row(taken, xs, y, z, &mut other);
            sample_row(from, xs, y, z, out);
            for (value, other) in out.iter_mut().zip(&other) {
                *value = value.max(-other);
            }
        }
    }
}
