//! The pipeline from a scene and a view to a picture.
//!
//! Clusters are culled and taken front to back in a few batches. Each batch
//! is set up in parallel by cluster, then filled in parallel by tile, and
//! what it draws culls clusters of the next one. When visibility is settled,
//! each tile is shaded. Equal depths go to the triangle drawn first whatever
//! order the filler meets them in, so pictures depend neither on the number
//! of threads nor on the batches.

use csg::{Color, Mesh};
use rayon::prelude::*;

use crate::camera::View;
use crate::cull::{Visibility, cluster_visibility};
use crate::deferred::ShadeContext;
use crate::edges::draw_edges;
use crate::error::{MAX_SIZE, RasterError};
use crate::fill::{FillCounts, fill};
use crate::frame::FrameMatrix;
use crate::geometry::{Bins, Facing, GeometryContext, SetUpClusters};
use crate::ground::draw_ground_shadow;
use crate::image::Image;
use crate::occlusion::darken;
use crate::options::{AntiAliasing, RenderOptions};
use crate::resolve::{ResolveTile, Scratch, tile_rows};
use crate::scene::Scene;
use crate::section::{Caps, cap_tile};
use crate::shade::Material;
use crate::simd::{Kernel, Lanes, Level};
use crate::stats::Stats;
use crate::tile::{TILE, Tile};
use crate::triad::draw_triad;

/// Draws frames; keeps its working memory from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Renderer {
    level: Level,
    /// Size of the last frame.
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Samples drawn along a pixel's side.
    pub(crate) scale: u32,
    pub(crate) tiles: Vec<Tile>,
    bins: Vec<Bins>,
    order: Vec<(f32, u32)>,
}

/// Draws a mesh as seen by `view` into a picture of `width` x `height`
/// pixels. To draw a mesh more than once, keep a [`Scene`] and a
/// [`Renderer`].
///
/// # Errors
/// [`RasterError::SizeTooLarge`] above [`MAX_SIZE`] pixels a side.
pub fn render(
    mesh: &Mesh,
    view: &View,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Result<Image, RasterError> {
    let mut image = Image::default();
    Renderer::default().draw(&Scene::new(mesh), view, width, height, options, &mut image)?;
    Ok(image)
}

impl Renderer {
    /// A renderer that runs at a given level of instruction set; the picture
    /// is the same at every level.
    #[must_use]
    pub fn with_level(level: Level) -> Self {
        Self {
            level,
            ..Self::default()
        }
    }

    /// Draws one frame into `image`, which gets the given size, and returns
    /// what was done and left out.
    ///
    /// # Errors
    /// [`RasterError::SizeTooLarge`] above [`MAX_SIZE`] pixels a side (of the
    /// enlarged picture, for supersampling).
    pub fn draw(
        &mut self,
        scene: &Scene,
        view: &View,
        width: u32,
        height: u32,
        options: &RenderOptions,
        image: &mut Image,
    ) -> Result<Stats, RasterError> {
        let scale = options.anti_aliasing.scale();
        let stats = if scale == 1 {
            self.draw_plain(scene, view, width, height, options, image)?
        } else {
            let mut large = Image::default();
            let (w, h) = (width.saturating_mul(scale), height.saturating_mul(scale));
            let stats = self.draw_plain(scene, view, w, h, options, &mut large)?;
            *image = large.shrink(scale);
            stats
        };
        (self.width, self.height, self.scale) = (width, height, scale);
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        if options.ambient_occlusion {
            darken(image, &self.ambient_occlusion(scene, view));
        }
        if options.ground_shadow {
            draw_ground_shadow(scene, view, image)?;
        }
        if let Some(edges) = &options.edges {
            draw_edges(self, scene, &matrix, edges, image);
        }
        if options.triad {
            draw_triad(view, image);
        }
        Ok(stats)
    }

    fn draw_plain(
        &mut self,
        scene: &Scene,
        view: &View,
        width: u32,
        height: u32,
        options: &RenderOptions,
        image: &mut Image,
    ) -> Result<Stats, RasterError> {
        if width.max(height) > MAX_SIZE {
            return Err(RasterError::SizeTooLarge { width, height });
        }
        image.width = width;
        image.height = height;
        image
            .pixels
            .resize(width as usize * height as usize, [0; 4]);
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        let mut stats = self.settle_visibility(scene, &matrix, options);
        let materials = scene
            .colors
            .iter()
            .map(|color| Material::of_color(color.unwrap_or(options.default_color)))
            .collect();
        let context = ShadeContext::new(
            scene,
            view,
            &matrix,
            &options.lights,
            materials,
            options.interpolation,
            options.two_sided,
        );
        stats.pixels_shaded = self.resolve(&context, options.background, image);
        Ok(stats)
    }

    /// Fills the visibility buffer.
    fn settle_visibility(
        &mut self,
        scene: &Scene,
        matrix: &FrameMatrix,
        options: &RenderOptions,
    ) -> Stats {
        let columns = (matrix.width as usize).div_ceil(TILE);
        let rows = (matrix.height as usize).div_ceil(TILE);
        self.tiles.resize_with(columns * rows, Tile::default);
        self.tiles.iter_mut().for_each(|tile| tile.drawn = false);
        let facing = Facing {
            front: true,
            back: !options.cull_back_faces || !scene.sections.is_empty(),
        };
        let mut stats = Stats {
            clusters: scene.clusters.len() as u64,
            triangles: scene.triangles.len() as u64,
            tiles: self.tiles.len() as u64,
            ..Stats::default()
        };
        self.order_clusters(scene, matrix, facing, &mut stats);
        let samples = options.anti_aliasing.samples();
        let sample_range = match options.anti_aliasing {
            AntiAliasing::Msaa4 | AntiAliasing::Msaa8 => [0, 255],
            _ => [128, 128],
        };
        let tasks = rayon::current_num_threads() * 4;
        self.bins.resize_with(tasks, Bins::default);
        let order = std::mem::take(&mut self.order);
        let mut rest = &order[..];
        for share in batches(order.len()) {
            let (batch, later) = rest.split_at(share);
            rest = later;
            let context = GeometryContext {
                scene,
                matrix,
                facing,
                tiles: &self.tiles,
                columns,
                sample_range,
            };
            let level = self.level;
            let part = batch.len().div_ceil(tasks).max(1);
            self.bins.par_iter_mut().enumerate().for_each(|(k, bins)| {
                bins.clear(columns * rows);
                let first = (k * part).min(batch.len());
                let end = (first + part).min(batch.len());
                level.run(SetUpClusters {
                    context,
                    clusters: &batch[first..end],
                    bins,
                });
            });
            let bins = &self.bins;
            let size = [matrix.width, matrix.height].map(u32::cast_signed);
            let counts = self
                .tiles
                .par_iter_mut()
                .enumerate()
                .map(|(index, tile)| {
                    let origin = [index % columns, index / columns].map(|t| (t * TILE) as i32);
                    level.run(FillTile {
                        tile,
                        index,
                        bins,
                        origin,
                        size,
                        samples,
                    })
                })
                .reduce(FillCounts::default, |a, b| FillCounts {
                    hidden: a.hidden + b.hidden,
                    blocks: a.blocks + b.blocks,
                });
            stats.bin_entries_hidden += counts.hidden;
            stats.blocks += counts.blocks;
            for bins in &mut self.bins {
                stats.triangles_set_up += bins.records.len() as u64;
                stats.bin_entries += bins.tiles.iter().map(|t| t.len() as u64).sum::<u64>();
            }
        }
        self.order = order;
        if !scene.sections.is_empty() {
            let caps = Caps::new(&scene.sections, matrix);
            self.tiles.par_iter_mut().enumerate().for_each(|(k, tile)| {
                let origin = [k % columns, k / columns].map(|t| (t * TILE) as i32);
                cap_tile(tile, origin, samples, scene, matrix, &caps);
            });
        }
        for bins in &mut self.bins {
            let counts = std::mem::take(&mut bins.counts);
            stats.clusters_hidden += counts.clusters_hidden;
            stats.vertices_transformed += counts.vertices;
            stats.triangles_looked_at += counts.triangles;
            stats.triangles_facing_away += counts.facing_away;
            stats.triangles_without_sample += counts.no_sample;
            stats.triangles_clipped += counts.clipped;
        }
        stats.tiles_empty = self.tiles.iter().filter(|tile| !tile.drawn).count() as u64;
        stats
    }

    /// Leaves in `self.order` the clusters that may be seen, with their
    /// nearest depths, front to back.
    fn order_clusters(
        &mut self,
        scene: &Scene,
        matrix: &FrameMatrix,
        facing: Facing,
        stats: &mut Stats,
    ) {
        self.order.clear();
        for (index, cluster) in scene.clusters.iter().enumerate() {
            match cluster_visibility(cluster, matrix, facing) {
                Visibility::Outside => stats.clusters_outside += 1,
                Visibility::FacingAway => stats.clusters_facing_away += 1,
                Visibility::Possible(depth) => self.order.push((depth, index as u32)),
            }
        }
        self.order
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    }

    /// Shades every tile.
    fn resolve(&self, context: &ShadeContext, background: Color, image: &mut Image) -> u64 {
        let width = image.width as usize;
        if image.pixels.is_empty() {
            return 0;
        }
        let columns = width.div_ceil(TILE);
        let mut pieces = tile_rows(&mut image.pixels, width);
        pieces
            .par_iter_mut()
            .zip(&self.tiles)
            .enumerate()
            .map_init(Scratch::default, |scratch, (index, (rows, tile))| {
                self.level.run(ResolveTile {
                    context,
                    tile,
                    origin: [index % columns * TILE, index / columns * TILE],
                    rows,
                    background,
                    scratch,
                })
            })
            .sum()
    }
}

/// Sizes of the batches that so many clusters are taken in: few enough that
/// waiting for each other costs nothing, the first ones small so that what
/// they draw hides much of the rest.
fn batches(clusters: usize) -> Vec<usize> {
    if clusters < 512 {
        return vec![clusters];
    }
    let mut sizes: Vec<usize> = [8, 8, 8, 8, 4].iter().map(|part| clusters / part).collect();
    sizes.push(clusters - sizes.iter().sum::<usize>());
    sizes
}

/// Fills the triangles of one batch into one tile.
struct FillTile<'a> {
    tile: &'a mut Tile,
    index: usize,
    bins: &'a [Bins],
    origin: [i32; 2],
    size: [i32; 2],
    samples: &'static [[i32; 2]],
}

impl Kernel for FillTile<'_> {
    type Output = FillCounts;
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) -> FillCounts {
        let mut counts = FillCounts::default();
        let mut any = false;
        for bins in self.bins {
            for &entry in &bins.tiles[self.index] {
                if !self.tile.drawn {
                    self.tile.begin(self.samples.len());
                }
                any = true;
                let record = &bins.records[entry as usize];
                fill(
                    s,
                    self.tile,
                    self.origin,
                    self.size,
                    record,
                    self.samples,
                    &mut counts,
                );
            }
        }
        if any {
            self.tile.update_farthest();
        }
        counts
    }
}
