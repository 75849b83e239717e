//! A mesh made ready for drawing: single precision around its centre, cut
//! into clusters.

use std::sync::OnceLock;

use csg::Mesh;
use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;

use crate::camera::View;
use crate::cluster::{Cluster, Clusters};
use crate::cull::{Visibility, cluster_visibility};
use crate::error::MAX_SIZE;
use crate::frame::FrameMatrix;
use crate::geometry::Facing;
use crate::ground::Shadow;
use crate::look::SurfaceLook;
use crate::normals::{CREASE_ANGLE, CornerNormals, corner_normals};
use crate::options::RenderOptions;
use crate::section::Section;
use crate::shade::Finish;
use crate::silhouette::{SharedEdge, find_shared_edges};
use crate::texture::Texture;

/// A mesh made ready for drawing, any number of times. Building one costs
/// O(vertices + triangles); it does not refer to the mesh.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// All coordinates are relative to this point.
    pub(crate) centre: DVec3,
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    /// The height of the lowest point, be it cut away or not.
    pub(crate) lowest: f64,
    pub(crate) positions: Vec<Vec3>,
    /// What single precision leaves of each position, where the scene is so
    /// much larger than its parts that this may be seen; else empty.
    pub(crate) remainders: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Of the corners of each triangle, but see [`Prepared::corner_normals`].
    pub(crate) normals: Vec<[Vec3; 3]>,
    /// Index into `looks` for each triangle, or empty: all 0.
    pub(crate) triangle_surfaces: Vec<u32>,
    /// The body that each surface is part of ([`csg::MeshSurface::body`]).
    pub(crate) bodies: Vec<u32>,
    /// What each surface looks like; the last one is for triangles without.
    pub(crate) looks: Vec<SurfaceLook>,
    /// One more than the last triangle of each part, where there are several.
    part_ends: Vec<u32>,
    pub(crate) clusters: Vec<Cluster>,
    /// x, y, z and 0 of each.
    pub(crate) cluster_vertices: Vec<[f32; 4]>,
    /// The remainders of each, or empty.
    pub(crate) cluster_remainders: Vec<[f32; 4]>,
    /// Their normals, where the cluster is smooth.
    pub(crate) cluster_normals: Vec<[f32; 4]>,
    /// The cluster of every so manieth triangle (see `cluster_view`).
    pub(crate) cluster_starts: Vec<u32>,
    /// For each triangle the numbers of its vertices within the cluster.
    pub(crate) local: Vec<[u8; 4]>,
    /// Planes that cut the mesh before it was made ready.
    pub(crate) sections: Vec<Section>,
    /// How many vertices and triangles they leave; those cut away, as far as
    /// they matter for caps, come after them.
    pub(crate) kept_vertices: usize,
    pub(crate) kept_triangles: usize,
    /// The mesh's feature edges, or those found when first asked for.
    feature_edges: OnceLock<Vec<Vec<u32>>>,
    /// Those found when first asked for.
    shared_edges: OnceLock<Vec<SharedEdge>>,
    shadow: OnceLock<Option<Shadow>>,
}

impl Prepared {
    /// Makes a mesh ready. Triangles that name a vertex out of range, or one
    /// that is not finite, keep their number but are never drawn. Missing
    /// corner normals are computed (see [`corner_normals`]).
    ///
    /// Copies triangles and normals: where the mesh is not needed any more,
    /// `Prepared::from(mesh)` takes them over.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let scene = Self::ungrouped(mesh, mesh.triangles.clone());
        scene.with_normals(corner_normals(mesh, CREASE_ANGLE))
    }

    /// A scene to be drawn with this view, at this size and with these options
    /// only: corner normals are computed, or gathered, only where they may be
    /// seen, which is about half of them. The picture is
    /// that of [`Prepared::new`].
    #[must_use]
    pub fn for_view(
        mut mesh: Mesh,
        view: &View,
        width: u32,
        height: u32,
        options: &RenderOptions,
    ) -> Self {
        // Silhouettes are looked for in faces that turn away, too.
        let whole = options.edges.is_some();
        let [width, height] =
            [width, height].map(|side| side.saturating_mul(options.anti_aliasing.scale()));
        if whole || width.max(height) > MAX_SIZE {
            return Self::from(mesh);
        }
        let triangles = std::mem::take(&mut mesh.triangles);
        let mut scene = Self::ungrouped(&mesh, triangles);
        // The very test that the renderer makes.
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        let facing = Facing::of(&scene, options);
        let seen = |cluster: &Cluster| {
            let visibility = cluster_visibility(cluster, &matrix, facing);
            matches!(visibility, Visibility::Possible(_))
        };
        if mesh.corner_normals.len() == scene.triangles.len() {
            scene.normals = std::mem::take(&mut mesh.corner_normals);
            scene.gather_normals(seen, None);
            return scene;
        }
        mesh.triangles = std::mem::take(&mut scene.triangles);
        let clusters = scene.clusters.iter().filter(|cluster| seen(cluster));
        let ranges: Vec<_> = clusters.map(Cluster::range).collect();
        let missing = CornerNormals::new(&mesh, CREASE_ANGLE, &ranges);
        // (Zeros from the system; most are never touched.)
        scene.normals = bytemuck::zeroed_vec(mesh.triangles.len());
        scene.gather_normals(seen, Some(&missing));
        scene.triangles = std::mem::take(&mut mesh.triangles);
        scene
    }

    /// Makes a mesh ready, but for its normals.
    fn ungrouped(mesh: &Mesh, triangles: Vec<[u32; 3]>) -> Self {
        let all = triangles.len();
        Self::without_normals(mesh, triangles, &[all])
    }

    /// The same with triangles in groups, of so many each, that share no
    /// cluster.
    pub(crate) fn without_normals(mesh: &Mesh, triangles: Vec<[u32; 3]>, groups: &[usize]) -> Self {
        let (low, high) = finite_bounds(&mesh.positions).unwrap_or_default();
        let centre = low / 2.0 + high / 2.0;
        let positions: Vec<Vec3> = mesh
            .positions
            .par_iter()
            .map(|&p| (p - centre).as_vec3())
            .collect();
        let surfaces = if mesh.triangle_surfaces.len() == triangles.len() {
            let none = mesh.surfaces.len() as u32;
            mesh.triangle_surfaces
                .iter()
                .map(|&surface| surface.min(none))
                .collect()
        } else {
            Vec::new()
        };
        let mut looks = Vec::new();
        if !surfaces.is_empty() {
            let colors = mesh.surfaces.iter().map(|surface| surface.color);
            looks.extend(colors.map(SurfaceLook::of_color));
        }
        looks.push(SurfaceLook::default());
        let mut remainders = Vec::new();
        let mut found = Clusters::new(&positions, &remainders, &triangles, groups);
        if found.are_tiny(low, high) {
            let exact = mesh.positions.par_iter().zip(&positions);
            remainders = exact
                .map(|(&p, near)| (p - centre - near.as_dvec3()).as_vec3())
                .collect();
            found = Clusters::new(&positions, &remainders, &triangles, groups);
        }
        let Clusters {
            clusters,
            vertices,
            remainders: cluster_remainders,
            local,
        } = found;
        let scene = Self {
            centre,
            low,
            high,
            lowest: low.z,
            kept_vertices: positions.len(),
            kept_triangles: triangles.len(),
            positions,
            remainders,
            triangles,
            triangle_surfaces: surfaces,
            bodies: mesh.surfaces.iter().map(|surface| surface.body).collect(),
            looks,
            clusters,
            cluster_vertices: vertices,
            cluster_remainders,
            local,
            ..Self::default()
        };
        if !mesh.feature_edges.is_empty() {
            let _ = scene.feature_edges.set(mesh.feature_edges.clone());
        }
        scene
    }

    /// Says what surfaces look like, and where parts end.
    pub(crate) fn with_looks(mut self, mut looks: Vec<SurfaceLook>, ends: Vec<u32>) -> Self {
        looks.push(SurfaceLook::default());
        if looks.len() == self.looks.len() {
            self.looks = looks;
        }
        self.part_ends = ends;
        self
    }

    /// Dyes all surfaces in a pattern, in world coordinates.
    #[must_use]
    pub fn textured(mut self, texture: Texture) -> Self {
        for look in &mut self.looks {
            look.texture = Some((texture, DMat4::IDENTITY, Finish::default()));
        }
        self
    }

    /// The number of the part, counted place by place, that a triangle belongs
    /// to.
    #[must_use]
    pub fn part_of(&self, triangle: u32) -> usize {
        self.part_ends.partition_point(|&end| end <= triangle)
    }

    /// Whether anything is seen through.
    pub(crate) fn is_transparent(&self, options: &RenderOptions) -> bool {
        self.looks.iter().any(|look| look.is_transparent(options))
    }

    /// Adds the normals of all triangles' corners.
    pub(crate) fn with_normals(mut self, normals: Vec<[Vec3; 3]>) -> Self {
        self.normals = normals;
        self.gather_normals(|_| true, None);
        self
    }

    /// The smallest box around all finite vertices, but for those cut away.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// The corners of a triangle relative to the centre, unless it names a
    /// vertex that is not there.
    pub(crate) fn corners(&self, triangle: usize) -> Option<[DVec3; 3]> {
        let [a, b, c] = *self.triangles.get(triangle)?;
        Some([self.position(a)?, self.position(b)?, self.position(c)?])
    }

    /// A vertex relative to the centre.
    pub(crate) fn position(&self, vertex: u32) -> Option<DVec3> {
        let near = self.positions.get(vertex as usize)?.as_dvec3();
        let rest = self.remainders.get(vertex as usize);
        Some(rest.map_or(near, |rest| near + rest.as_dvec3()))
    }

    /// Feature edges as polylines of vertex indices: the mesh's own, or those
    /// found where it brings none.
    #[must_use]
    pub fn feature_edges(&self) -> &[Vec<u32>] {
        self.feature_edges
            .get_or_init(|| crate::edges::find_feature_edges(self))
    }

    /// The edges that two triangles share.
    pub(crate) fn shared_edges(&self) -> &[SharedEdge] {
        self.shared_edges.get_or_init(|| find_shared_edges(self))
    }

    /// The shadow that it casts on the ground.
    pub(crate) fn shadow(&self) -> Option<&Shadow> {
        self.shadow.get_or_init(|| Shadow::of(self)).as_ref()
    }

    /// Number of triangles, with those cut away that matter for caps.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }
}

impl From<Mesh> for Prepared {
    /// [`Prepared::new`], faster by the copies it need not make.
    fn from(mut mesh: Mesh) -> Self {
        let normals = if mesh.corner_normals.len() == mesh.triangles.len() {
            std::mem::take(&mut mesh.corner_normals)
        } else {
            corner_normals(&mesh, CREASE_ANGLE)
        };
        let triangles = std::mem::take(&mut mesh.triangles);
        Self::ungrouped(&mesh, triangles).with_normals(normals)
    }
}

/// The smallest box around those points that are finite, if there is any.
pub(crate) fn finite_bounds(points: &[DVec3]) -> Option<(DVec3, DVec3)> {
    combine_finite(points, |p| (p, p), |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// What is found for each finite point, combined: by an operation that gives
/// the same in any order, such as a maximum.
pub(crate) fn combine_finite<T: Send>(
    points: &[DVec3],
    of_point: impl Fn(DVec3) -> T + Sync,
    combine: impl Fn(T, T) -> T + Send + Sync,
) -> Option<T> {
    /// Points per parallel task.
    const CHUNK: usize = 1 << 14;
    points
        .par_chunks(CHUNK)
        .filter_map(|chunk| {
            let finite = chunk.iter().filter(|p| p.is_finite());
            finite.map(|&p| of_point(p)).reduce(&combine)
        })
        .reduce_with(&combine)
}
