//! Corner normals for meshes that bring none.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use csg::Mesh;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Two faces whose normals differ by less than this angle (in radians, 30
/// degrees) are taken for one smooth surface, unless they are known to lie on
/// different ones.
pub const CREASE_ANGLE: f64 = std::f64::consts::FRAC_PI_6;

/// Triangles per parallel task.
const CHUNK: usize = 1 << 13;

/// Unit normals at the corners of each triangle: the mesh's own if it has
/// them, otherwise the mean of the normals, weighted by the angle at the
/// vertex, of those triangles around it that lie on the same surface (if the
/// mesh says so) and whose normals are within `crease_angle` of this one's.
/// Degenerate triangles get a zero normal. O(sum of squared valences), less
/// where surfaces are smooth.
#[must_use]
pub fn corner_normals(mesh: &Mesh, crease_angle: f64) -> Vec<[Vec3; 3]> {
    if mesh.corner_normals.len() == mesh.triangles.len() {
        return mesh.corner_normals.clone();
    }
    // (Zeros from the system, which the threads touch first; `vec!` would write
    // them here.)
    let mut normals: Vec<[Vec3; 3]> = bytemuck::zeroed_vec(mesh.triangles.len());
    let all = 0..mesh.triangles.len();
    let found = CornerNormals::new(mesh, crease_angle, &[all]);
    normals.par_chunks_mut(CHUNK).enumerate().for_each_init(
        Stars::default,
        |stars, (k, normals)| {
            found.fill(stars, k * CHUNK, normals);
        },
    );
    normals
}

/// What the corner normals of some triangles follow from.
pub(crate) struct CornerNormals<'a> {
    pub mesh: &'a Mesh,
    crease: Crease,
    smooth: Smooth,
    around: Around,
}

impl<'a> CornerNormals<'a> {
    /// Looks at what is around the vertices of some ranges of triangles.
    pub fn new(mesh: &'a Mesh, crease_angle: f64, ranges: &[Range<usize>]) -> Self {
        let wanted: Vec<AtomicBool> = (0..mesh.positions.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|_| AtomicBool::new(false))
            .collect();
        ranges.par_iter().for_each(|range| {
            for v in mesh.triangles[range.clone()].as_flattened() {
                if let Some(wanted) = wanted.get(*v as usize) {
                    wanted.store(true, Ordering::Relaxed);
                }
            }
        });
        let crease = Crease::new(crease_angle);
        let smooth = Smooth::new(mesh, &wanted, &crease);
        let around = Around::new(mesh, &smooth);
        Self {
            mesh,
            crease,
            smooth,
            around,
        }
    }

    /// The normal that all corners at a vertex share; `None` where they may
    /// differ.
    pub fn at_vertex(&self, vertex: u32) -> Option<Vec3> {
        let state = self.smooth.states.get(vertex as usize)?;
        (*state != ROUGH).then(|| self.smooth.normals[vertex as usize])
    }

    /// Those of consecutive triangles, given the number of the first.
    pub fn fill(&self, stars: &mut Stars, first: usize, normals: &mut [[Vec3; 3]]) {
        let Self { mesh, crease, .. } = self;
        for (normals, index) in normals.iter_mut().zip(first..) {
            for (k, normal) in normals.iter_mut().enumerate() {
                let vertex = mesh.triangles[index][k];
                if let Some(common) = self.at_vertex(vertex) {
                    *normal = common;
                } else if (vertex as usize) < mesh.positions.len() {
                    let star = &mut stars.0[vertex as usize % STARS];
                    if star.vertex != Some(vertex) {
                        star.fill(mesh, &self.around, vertex, crease);
                    }
                    *normal = star.normal(mesh, index, crease);
                }
            }
        }
    }
}

/// The normals at vertices whose faces all count as one surface.
struct Smooth {
    /// Of any use where the state is not [`ROUGH`].
    normals: Vec<Vec3>,
    /// For each vertex 0, or one more than the first triangle around it, or
    /// [`ROUGH`].
    states: Vec<u32>,
}

/// The state of a vertex whose faces do not, or may not, count as one surface.
const ROUGH: u32 = u32::MAX;

impl Smooth {
    /// Each thread adds up what is around a range of the vertices: all go
    /// over all triangles, but none waits, and the order is that of one. Only
    /// vertices that are wanted are looked at.
    fn new(mesh: &Mesh, wanted: &[AtomicBool], crease: &Crease) -> Self {
        let vertices = mesh.positions.len();
        let share = share(mesh);
        // (Zeros from the system, which the threads touch first.)
        let mut sums: Vec<DVec3> = bytemuck::zeroed_vec(vertices);
        let mut normals: Vec<Vec3> = bytemuck::zeroed_vec(vertices);
        let mut states: Vec<u32> = bytemuck::zeroed_vec(vertices);
        sums.par_chunks_mut(share)
            .zip(normals.par_chunks_mut(share))
            .zip(states.par_chunks_mut(share))
            .zip(wanted.par_chunks(share))
            .enumerate()
            .for_each(|(part, (((sums, normals), states), wanted))| {
                for (index, triangle) in mesh.triangles.iter().enumerate() {
                    let own = triangle.map(|v| (v as usize).wrapping_sub(part * share));
                    let is_wanted = |v: usize| wanted.get(v).is_some_and(is_set);
                    if own.iter().any(|&v| is_wanted(v))
                        && let Some(face) = Face::of(mesh, index)
                    {
                        for k in (0..3).filter(|&k| is_wanted(own[k])) {
                            let v = own[k];
                            sums[v] += face.unit * face.weight(k);
                            if states[v] == 0 {
                                states[v] = index as u32 + 1;
                                normals[v] = face.unit.as_vec3();
                            }
                            let first = states[v].wrapping_sub(1) as usize;
                            if !(crease.near(normals[v], face.unit.as_vec3())
                                && surface(mesh, first) == surface(mesh, index))
                            {
                                states[v] = ROUGH;
                            }
                        }
                    }
                }
                for (normal, sum) in normals.iter_mut().zip(sums) {
                    *normal = sum.normalize_or_zero().as_vec3();
                }
            });
        Self { normals, states }
    }
}

fn is_set(flag: &AtomicBool) -> bool {
    flag.load(Ordering::Relaxed)
}

/// The surface that a triangle is known to lie on.
fn surface(mesh: &Mesh, triangle: usize) -> Option<&u32> {
    mesh.triangle_surfaces.get(triangle)
}

/// Vertices for each thread.
fn share(mesh: &Mesh) -> usize {
    let vertices = mesh.positions.len();
    vertices.div_ceil(rayon::current_num_threads()).max(1)
}

/// A triangle as seen from its corners.
struct Face {
    corners: [DVec3; 3],
    unit: DVec3,
    /// Twice its area.
    area: f64,
}

impl Face {
    /// `None` if it names a vertex that is not there.
    fn of(mesh: &Mesh, triangle: usize) -> Option<Self> {
        let [a, b, c] = mesh.triangles[triangle];
        let at = |v: u32| mesh.positions.get(v as usize).copied();
        let corners = [at(a)?, at(b)?, at(c)?];
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        Some(Self {
            corners,
            unit: cross.normalize_or_zero(),
            area: cross.length(),
        })
    }

    /// The angle at a corner.
    fn weight(&self, k: usize) -> f64 {
        let here = self.corners[k];
        let (next, last) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
        angle(self.area, (next - here).dot(last - here))
    }
}

/// The triangles around each rough vertex, in one array.
struct Around {
    /// Where each vertex's triangles begin; one more than vertices, or none
    /// where no vertex is rough.
    starts: Vec<u32>,
    /// Indices of triangles, ascending around each vertex.
    triangles: Vec<u32>,
}

impl Around {
    /// Each thread gathers what is around a range of the vertices, as
    /// [`Smooth::new`] does.
    fn new(mesh: &Mesh, smooth: &Smooth) -> Self {
        let states = &smooth.states;
        if !states.par_iter().any(|&state| state == ROUGH) {
            return Self {
                starts: Vec::new(),
                triangles: Vec::new(),
            };
        }
        let vertices = mesh.positions.len();
        let share = share(mesh);
        let is_rough = |v: u32| states.get(v as usize) == Some(&ROUGH);
        let mut starts = vec![0u32; vertices + 1];
        starts[1..]
            .par_chunks_mut(share)
            .enumerate()
            .for_each(|(part, counts)| {
                let first = part * share;
                for &v in mesh.triangles.as_flattened() {
                    if let Some(count) = counts.get_mut((v as usize).wrapping_sub(first))
                        && is_rough(v)
                    {
                        *count += 1;
                    }
                }
            });
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut triangles = vec![0u32; starts[vertices] as usize];
        let mut parts = Vec::new();
        let mut rest = &mut triangles[..];
        for first in (0..vertices).step_by(share) {
            let end = vertices.min(first + share);
            let (part, later) = rest.split_at_mut((starts[end] - starts[first]) as usize);
            parts.push((first, end, part));
            rest = later;
        }
        parts.into_par_iter().for_each(|(first, end, part)| {
            let base = starts[first];
            let mut next: Vec<u32> = starts[first..end].iter().map(|s| s - base).collect();
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                for &v in triangle {
                    if let Some(next) = next.get_mut((v as usize).wrapping_sub(first))
                        && is_rough(v)
                    {
                        part[*next as usize] = index as u32;
                        *next += 1;
                    }
                }
            }
        });
        Self { starts, triangles }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        let range = [0, 1].map(|i| self.starts[vertex as usize + i] as usize);
        &self.triangles[range[0]..range[1]]
    }
}

/// Up to which angle faces count as one surface.
struct Crease {
    cosine: f64,
    /// Cosine of a little less than half the angle: faces within it of one
    /// direction are within the angle of each other, rounding included.
    half_cosine: f64,
}

impl Crease {
    fn new(angle: f64) -> Self {
        Self {
            cosine: angle.cos(),
            half_cosine: (angle.clamp(0.0, std::f64::consts::PI) / 2.0).cos() + 1e-9,
        }
    }

    /// Whether a face is so near to another that all that are, are of one
    /// surface. False for faces without a normal.
    fn near(&self, first: Vec3, face: Vec3) -> bool {
        f64::from(first.dot(face)) >= self.half_cosine + 1e-6
    }
}

/// Vertices met lately, by number: neighbouring triangles share them.
pub(crate) struct Stars(Vec<Star>);

const STARS: usize = 512;

impl Default for Stars {
    fn default() -> Self {
        Self(vec![Star::default(); STARS])
    }
}

/// What is around a vertex.
#[derive(Clone, Default)]
struct Star {
    vertex: Option<u32>,
    /// Each triangle with its unit normal and its weight.
    faces: Vec<(u32, DVec3, f64)>,
    /// The normal at all corners, if the surface is smooth here.
    common: Option<Vec3>,
}

impl Star {
    fn fill(&mut self, mesh: &Mesh, around: &Around, vertex: u32, crease: &Crease) {
        self.vertex = Some(vertex);
        self.faces.clear();
        let triangles = around.of(vertex);
        for &index in triangles {
            if let Some(face) = Face::of(mesh, index as usize) {
                let corners = mesh.triangles[index as usize];
                // (A triangle that names the vertex twice has no normal anyway.)
                let k = corners.iter().position(|&v| v == vertex).unwrap_or(0);
                self.faces.push((index, face.unit, face.weight(k)));
            }
        }
        let sum: DVec3 = self
            .faces
            .iter()
            .map(|&(_, face, weight)| face * weight)
            .sum();
        let axis = sum.normalize_or_zero();
        let surface = |index: u32| surface(mesh, index as usize);
        let smooth = self.faces.iter().all(|&(index, face, _)| {
            face.dot(axis) >= crease.half_cosine && surface(index) == surface(triangles[0])
        });
        self.common = smooth.then(|| axis.as_vec3());
    }

    /// The normal at the corner of one of the triangles.
    fn normal(&self, mesh: &Mesh, index: usize, crease: &Crease) -> Vec3 {
        if let Some(common) = self.common {
            return common;
        }
        let surface = |index: u32| surface(mesh, index as usize);
        let own = self.faces.iter().find(|face| face.0 == index as u32);
        let Some(&(_, face, _)) = own else {
            return Vec3::ZERO;
        };
        let sum: DVec3 = self
            .faces
            .iter()
            .filter(|other| {
                surface(other.0) == surface(index as u32) && other.1.dot(face) >= crease.cosine
            })
            .map(|&(_, face, weight)| face * weight)
            .sum();
        let normal = sum.normalize_or_zero();
        if normal == DVec3::ZERO { face } else { normal }.as_vec3()
    }
}

/// The angle, 0 to pi, whose sine and cosine are in proportion to `sine` (at
/// least 0) and `cosine`, within 4e-8: a weight needs no more, and this costs
/// a fraction of `atan2` (Abramowitz, Stegun, *Handbook of Mathematical
/// Functions*, 4.4.49).
fn angle(sine: f64, cosine: f64) -> f64 {
    let (large, small) = (sine.max(cosine.abs()), sine.min(cosine.abs()));
    if large == 0.0 {
        return 0.0;
    }
    let x = small / large;
    let s = x * x;
    let series = -0.016_165_736_7 + s * 0.002_866_225_7;
    let series = 0.042_909_613_8 + s * series;
    let series = -0.075_289_640_0 + s * series;
    let series = 0.106_562_639_3 + s * series;
    let series = -0.142_088_994_4 + s * series;
    let series = 0.199_935_508_5 + s * series;
    let series = -0.333_331_452_8 + s * series;
    let acute = x * (1.0 + s * series);
    let angle = if sine > cosine.abs() {
        std::f64::consts::FRAC_PI_2 - acute
    } else {
        acute
    };
    if cosine < 0.0 {
        std::f64::consts::PI - angle
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_close_to_the_true_ones() {
        for step in 0..=100_000 {
            let true_angle = f64::from(step) * (std::f64::consts::PI / 100_000.0);
            let scale = f64::from(step % 7 + 1) * 1e-3;
            let found = angle(true_angle.sin().max(0.0) * scale, true_angle.cos() * scale);
            assert!((found - true_angle).abs() < 4e-8, "{found} {true_angle}");
        }
        assert_eq!(angle(0.0, 0.0), 0.0);
    }
}
