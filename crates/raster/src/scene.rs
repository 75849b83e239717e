//! A mesh made ready for drawing: single precision around its centre, cut
//! into clusters.

use std::sync::OnceLock;

use csg::{Color, Mesh};
use glam::{DVec3, Vec3};

use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::section::Section;

/// Most triangles in a cluster.
const CLUSTER_TRIANGLES: usize = 128;
/// Most vertices in a cluster.
pub(crate) const CLUSTER_VERTICES: usize = 128;

/// A few neighbouring triangles that are culled, transformed and set up
/// together, with vertices of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    /// First triangle in drawing order; a cluster's triangles are consecutive.
    pub first_triangle: u32,
    pub triangles: u32,
    /// First vertex in [`Scene::cluster_vertices`], a multiple of 16.
    pub first_vertex: u32,
    pub vertices: u32,
    /// Bounding sphere.
    pub centre: Vec3,
    pub radius: f32,
    /// Normals are within the cone about `axis` of half-angle asin(`sine`);
    /// sine is above 1 where there is no such cone.
    pub axis: Vec3,
    pub sine: f32,
    /// Whether the corners at each vertex share their normal.
    pub smooth: bool,
}

/// A mesh made ready for drawing, any number of times. Building one costs
/// O(vertices + triangles); it does not refer to the mesh.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All coordinates are relative to this point.
    pub(crate) centre: DVec3,
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) normals: Vec<[Vec3; 3]>,
    /// Index into `colors` for each triangle, or empty: all 0.
    pub(crate) triangle_surfaces: Vec<u32>,
    /// The colour of each surface; the last one is for triangles without.
    pub(crate) colors: Vec<Option<Color>>,
    pub(crate) clusters: Vec<Cluster>,
    pub(crate) cluster_vertices: [Vec<f32>; 3],
    /// Their normals, where the cluster is smooth.
    pub(crate) cluster_normals: [Vec<f32>; 3],
    /// The cluster of every so manieth triangle (see `cluster_of`).
    pub(crate) cluster_starts: Vec<u32>,
    /// For each triangle the numbers of its vertices within the cluster.
    pub(crate) local: Vec<[u8; 4]>,
    /// Planes that cut the mesh before it was made ready.
    pub(crate) sections: Vec<Section>,
    /// The mesh's feature edges, or those found when first asked for.
    feature_edges: OnceLock<Vec<Vec<u32>>>,
}

impl Scene {
    /// Makes a mesh ready. Triangles that name a vertex out of range, or one
    /// that is not finite, keep their number but are never drawn. Missing
    /// corner normals are computed (see [`corner_normals`]).
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let finite = || mesh.positions.iter().copied().filter(|p| p.is_finite());
        let first = finite().next().unwrap_or_default();
        let (low, high) = finite().fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        let centre = low / 2.0 + high / 2.0;
        let positions: Vec<Vec3> = mesh
            .positions
            .iter()
            .map(|&p| (p - centre).as_vec3())
            .collect();
        let surfaces = if mesh.triangle_surfaces.len() == mesh.triangles.len() {
            let none = mesh.surfaces.len() as u32;
            mesh.triangle_surfaces
                .iter()
                .map(|&surface| surface.min(none))
                .collect()
        } else {
            Vec::new()
        };
        let mut colors: Vec<_> = if surfaces.is_empty() {
            Vec::new()
        } else {
            mesh.surfaces.iter().map(|surface| surface.color).collect()
        };
        colors.push(None);
        let mut scene = Self {
            centre,
            low,
            high,
            positions,
            triangles: mesh.triangles.clone(),
            normals: corner_normals(mesh, CREASE_ANGLE),
            triangle_surfaces: surfaces,
            colors,
            ..Self::default()
        };
        if !mesh.feature_edges.is_empty() {
            let _ = scene.feature_edges.set(mesh.feature_edges.clone());
        }
        scene.build_clusters();
        scene.gather_normals();
        scene
    }

    /// The smallest box around all finite vertices.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// The corners of a triangle relative to the centre, unless it names a
    /// vertex that is not there.
    pub(crate) fn corners(&self, triangle: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = *self.triangles.get(triangle)?;
        let at = |v: u32| self.positions.get(v as usize).copied();
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// Feature edges as polylines of vertex indices: the mesh's own, or those
    /// found where it brings none.
    #[must_use]
    pub fn feature_edges(&self) -> &[Vec<u32>] {
        self.feature_edges
            .get_or_init(|| crate::edges::find_feature_edges(self))
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Cuts the triangles, in drawing order, into clusters.
    fn build_clusters(&mut self) {
        // The cluster a vertex was last seen in, and its number there.
        let mut seen = vec![(u32::MAX, 0u8); self.positions.len()];
        let mut members: Vec<u32> = Vec::with_capacity(CLUSTER_VERTICES);
        let mut first = 0usize;
        self.local.reserve(self.triangles.len());
        for index in 0..self.triangles.len() {
            let mut triangle = self.triangles[index];
            let usable = triangle.iter().all(|&v| {
                self.positions
                    .get(v as usize)
                    .is_some_and(|p| p.is_finite())
            });
            if !usable {
                // Three times one vertex has no area, and is never drawn.
                triangle = [members.first().copied().unwrap_or(u32::MAX); 3];
            }
            let number = self.clusters.len() as u32;
            let fresh = |v: &&u32| seen.get(**v as usize).is_some_and(|s| s.0 != number);
            let added = triangle.iter().filter(fresh).count();
            if index - first >= CLUSTER_TRIANGLES || members.len() + added > CLUSTER_VERTICES {
                self.finish_cluster(first, index, &members);
                members.clear();
                first = index;
            }
            let number = self.clusters.len() as u32;
            let mut local = [0u8; 4];
            for (slot, v) in local.iter_mut().zip(triangle) {
                let Some(entry) = seen.get_mut(v as usize) else {
                    continue;
                };
                if entry.0 != number {
                    *entry = (number, members.len() as u8);
                    members.push(v);
                }
                *slot = entry.1;
            }
            self.local.push(local);
        }
        if first < self.triangles.len() {
            self.finish_cluster(first, self.triangles.len(), &members);
        }
    }

    fn finish_cluster(&mut self, first: usize, end: usize, members: &[u32]) {
        let first_vertex = self.cluster_vertices[0].len();
        let points = || members.iter().map(|&v| self.positions[v as usize]);
        let start = points().next().unwrap_or_default();
        let (low, high) = points().fold((start, start), |(low, high), p| (low.min(p), high.max(p)));
        let centre = low / 2.0 + high / 2.0;
        let radius = points()
            .map(|p| p.distance_squared(centre))
            .fold(0.0, f32::max)
            .sqrt();
        let normals = || {
            (first..end).filter_map(|index| {
                let [a, b, c] = self.triangles[index];
                let at = |v: u32| self.positions.get(v as usize).copied();
                let (a, b, c) = (at(a)?, at(b)?, at(c)?);
                (b - a).cross(c - a).try_normalize()
            })
        };
        let axis = normals().sum::<Vec3>().normalize_or_zero();
        let cosine = normals().map(|n| n.dot(axis)).fold(1.0, f32::min);
        let sine = if cosine > 0.1 {
            // A little wider: rounding, and triangles that snapping tilts.
            (1.0 - cosine * cosine).max(0.0).sqrt() + 0.02
        } else {
            2.0
        };
        for axis in 0..3 {
            let coordinates = members.iter().map(|&v| self.positions[v as usize][axis]);
            self.cluster_vertices[axis].extend(coordinates);
            let padded = self.cluster_vertices[axis].len().next_multiple_of(16);
            self.cluster_vertices[axis].resize(padded, 0.0);
        }
        self.clusters.push(Cluster {
            first_triangle: first as u32,
            triangles: (end - first) as u32,
            first_vertex: first_vertex as u32,
            vertices: members.len() as u32,
            // A cluster's own rounding, and that of its culling.
            radius: radius * 1.0001 + f32::MIN_POSITIVE,
            centre,
            axis,
            sine,
            smooth: false,
        });
    }
}
