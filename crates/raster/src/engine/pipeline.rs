//! The pipeline from a scene and a view to a picture.
//!
//! Clusters are culled and taken front to back in a few batches. Each batch
//! is set up in parallel by cluster, then filled in parallel by tile, and
//! what it draws culls clusters of the next one. When visibility is settled,
//! each tile is shaded. Equal depths go to the triangle drawn first whatever
//! order the filler meets them in, so pictures depend neither on the number
//! of threads nor on the batches.

use csg::Mesh;
use rayon::prelude::*;

use crate::camera::View;
use crate::caps::cap_tile;
use crate::cull::{Visibility, cluster_visibility};
use crate::edges::draw_edges;
use crate::error::{MAX_SIZE, RasterError};
use crate::fill::FillCounts;
use crate::fill_tile::{FillTile, UpdateFarthest, any_in};
use crate::frame::FrameMatrix;
use crate::geometry::{Bins, Facing, GeometryContext, SetUpClusters};
use crate::ground::draw_ground_shadow;
use crate::image::Image;
use crate::options::RenderOptions;
use crate::prepared::Prepared;
use crate::resolve::{ResolveTile, Scratch, tile_rows};
use crate::shading::ShadeContext;
use crate::simd::Level;
use crate::stats::Stats;
use crate::tile::{Layout, PlanePool, TILE, TileBuffer, Tiles};
use crate::triad::draw_triad;

/// What is drawn, and how large.
#[derive(Clone, Copy)]
struct Shot<'a> {
    scene: &'a Prepared,
    view: &'a View,
    width: u32,
    height: u32,
    options: &'a RenderOptions,
}

/// Draws frames; keeps its working memory from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Renderer {
    pub(crate) level: Level,
    /// Size of the last frame.
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Samples drawn along a pixel's side.
    pub(crate) scale: u32,
    pub(crate) tiles: Tiles,
    /// Memory of the threads, where tiles are worked on one by one.
    planes: PlanePool,
    bins: Vec<Bins>,
    order: Vec<(f32, u32)>,
    /// Width, height and samples of the last frame, as they were drawn.
    shape: [u32; 3],
}

/// Draws a mesh as seen by `view` into a picture of `width` x `height`
/// pixels. To draw a mesh more than once, keep a [`Prepared`] and a
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
    Renderer::default().draw(
        &Prepared::new(mesh),
        view,
        width,
        height,
        options,
        &mut image,
    )?;
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
    /// enlarged picture, for supersampling); [`RasterError::OtherAspect`] for a
    /// camera's view of a picture of other proportions;
    /// [`RasterError::BadLineWidth`].
    pub fn draw(
        &mut self,
        scene: &Prepared,
        view: &View,
        width: u32,
        height: u32,
        options: &RenderOptions,
        image: &mut Image,
    ) -> Result<Stats, RasterError> {
        // A shadow lies between the model and what is behind.
        let backdrop = options.background;
        let cleared = RenderOptions {
            background: backdrop.with_alpha(0.0),
            ..options.clone()
        };
        let behind = options.ground_shadow && backdrop.alpha > 0.0;
        let options = if behind { &cleared } else { options };
        let mut shot = Shot {
            scene,
            view,
            width,
            height,
            options,
        };
        let scale = options.anti_aliasing.scale();
        if width.max(height).saturating_mul(scale) > MAX_SIZE {
            return Err(RasterError::SizeTooLarge { width, height });
        }
        view.check_size(width, height)?;
        options.check()?;
        let stats = if scale == 1 {
            self.draw_faces(shot, image)
        } else {
            let mut large = Image::default();
            (shot.width, shot.height) = (width * scale, height * scale);
            let stats = self.draw_faces(shot, &mut large);
            *image = large.shrink(scale);
            stats
        };
        (self.width, self.height, self.scale) = (width, height, scale);
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        if options.ambient_occlusion {
            self.darken(scene, view, options.ground_shadow, image);
        }
        if options.ground_shadow {
            draw_ground_shadow(self.level, scene, view, behind, image);
        }
        if let Some(edges) = &options.edges {
            draw_edges(self, scene, &matrix, edges, image);
        }
        if behind {
            image.put_behind(backdrop);
        }
        if options.triad {
            draw_triad(view, image);
        }
        Ok(stats)
    }

    /// Draws faces, a pixel for each of the shot's.
    fn draw_faces(&mut self, shot: Shot, image: &mut Image) -> Stats {
        let Shot {
            scene,
            view,
            width,
            height,
            options,
        } = shot;
        image.width = width;
        image.height = height;
        let pixels = width as usize * height as usize;
        if image.pixels.is_empty() {
            // Zeros from the system, which the threads that shade touch first.
            image.pixels = vec![[0; 4]; pixels];
        }
        image.pixels.resize(pixels, [0; 4]);
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        let context = ShadeContext::new(scene, view, &matrix, options);
        let columns = (width as usize).div_ceil(TILE);
        let rows = (height as usize).div_ceil(TILE);
        let samples = options.anti_aliasing.samples().len();
        let windings = !scene.sections.is_empty();
        let mut stats = Stats {
            clusters: scene.clusters.len() as u64,
            triangles: scene.triangles.len() as u64,
            tiles: (columns * rows) as u64,
            ..Stats::default()
        };
        let facing = Facing::of(scene, options);
        self.order_clusters(&context, facing, &mut stats);
        // Several samples a pixel, touched for the first time, take longer than to
        // fill a tile twice: they are kept only while a tile is worked on. Where
        // clusters hide each other, a renderer that draws more than one frame of a
        // size keeps them from the second one on, so that none is filled twice.
        let shape = [width, height, samples as u32];
        let again = std::mem::replace(&mut self.shape, shape) == shape;
        let is_dense = self.order.len() >= FEW_CLUSTERS && !windings;
        let tile_by_tile = samples > 1 && !(again && is_dense);
        let layout = Layout {
            samples: if tile_by_tile { 1 } else { samples },
            winding: windings && !tile_by_tile,
            transparent: context.transparent,
            // Many triangles are small ones; of few, taking these blocks apart
            // afterwards takes longer than is won.
            in_quads: is_dense && !context.transparent,
        };
        self.tiles.begin(columns * rows, layout);
        let tasks = rayon::current_num_threads() * 4;
        self.bins.resize_with(tasks, Bins::default);
        let order = std::mem::take(&mut self.order);
        let sizes = batches(order.len(), tile_by_tile, windings);
        let mut rest = &order[..];
        let mut pieces = tile_rows(&mut image.pixels, width as usize);
        for (number, &share) in sizes.iter().enumerate() {
            let (batch, later) = rest.split_at(share);
            rest = later;
            if number == 0 || !tile_by_tile {
                let tiles = columns * rows;
                self.bins.par_iter_mut().for_each(|bins| bins.clear(tiles));
            }
            self.set_up(&context, facing, options, batch, columns);
            let is_last = number + 1 == sizes.len();
            let counts = if is_last {
                self.finish_tiles(columns, options, &context, tile_by_tile, &mut pieces)
            } else {
                self.fill_tiles(columns, options, tile_by_tile)
            };
            stats.bin_entries_hidden += counts.hidden;
            stats.blocks += counts.blocks;
            stats.pixels_shaded += counts.shaded;
            if tile_by_tile && !is_last {
                continue;
            }
            for bins in &self.bins {
                stats.triangles_set_up += bins.records.len() as u64;
                stats.bin_entries += bins.tiles.iter().map(|t| t.len() as u64).sum::<u64>();
                stats.tiny_pixels += bins.pixels.iter().map(|t| t.len() as u64).sum::<u64>();
            }
        }
        self.order = order;
        for bins in &mut self.bins {
            let counts = std::mem::take(&mut bins.counts);
            stats.clusters_hidden += counts.clusters_hidden;
            stats.vertices_transformed += counts.vertices;
            stats.triangles_looked_at += counts.triangles;
            stats.triangles_facing_away += counts.facing_away;
            stats.triangles_without_sample += counts.no_sample;
            stats.triangles_clipped += counts.clipped;
            stats.triangles_tiny += counts.tiny;
        }
        let tiles = self.tiles.of_picture.iter();
        stats.tiles_empty = tiles.filter(|tile| !tile.drawn).count() as u64;
        stats
    }

    /// Sets up the triangles of a batch of clusters, sorted into bins.
    fn set_up(
        &mut self,
        shading: &ShadeContext,
        facing: Facing,
        options: &RenderOptions,
        batch: &[(f32, u32)],
        columns: usize,
    ) {
        let samples = options.anti_aliasing.samples();
        let sample_range = samples
            .as_flattened()
            .iter()
            .fold([255, 0], |[low, high], &v| [v.min(low), v.max(high)]);
        let context = GeometryContext {
            scene: shading.scene,
            matrix: shading.matrix,
            facing,
            tiles: &self.tiles.of_picture,
            columns,
            sample_range,
            transparent: shading.transparent.then_some((
                shading,
                options.cull_back_faces && shading.scene.sections.is_empty(),
            )),
        };
        let level = self.level;
        let part = batch.len().div_ceil(self.bins.len()).max(1);
        self.bins.par_iter_mut().enumerate().for_each(|(k, bins)| {
            let first = (k * part).min(batch.len());
            let end = (first + part).min(batch.len());
            level.run(SetUpClusters {
                context,
                clusters: &batch[first..end],
                bins,
            });
        });
    }

    /// Fills what is in the bins into the tiles.
    fn fill_tiles(
        &mut self,
        columns: usize,
        options: &RenderOptions,
        tile_by_tile: bool,
    ) -> FillCounts {
        let (level, bins, pool) = (self.level, &self.bins, &self.planes);
        let samples = options.anti_aliasing.samples();
        let tiles = self.tiles.buffers(|index| any_in(bins, index));
        tiles
            .into_par_iter()
            .enumerate()
            .map(|(index, mut tile)| {
                if tile_by_tile && tile.has_planes() {
                    return pool.with(samples.len(), false, |planes| {
                        let mut tile = tile.on(planes);
                        let counts = level.run(FillTile {
                            tile: &mut tile,
                            index,
                            bins,
                            origin: origin(index, columns),
                            samples,
                        });
                        level.run(UpdateFarthest { tile: &mut tile });
                        counts
                    });
                }
                let counts = level.run(FillTile {
                    tile: &mut tile,
                    index,
                    bins,
                    origin: origin(index, columns),
                    samples,
                });
                if counts.any {
                    level.run(UpdateFarthest { tile: &mut tile });
                }
                counts
            })
            .reduce(FillCounts::default, FillCounts::add)
    }

    /// Fills the last bins, caps sections and shades, one tile after the
    /// other, while it is at hand.
    fn finish_tiles(
        &mut self,
        columns: usize,
        options: &RenderOptions,
        context: &ShadeContext,
        tile_by_tile: bool,
        pieces: &mut [Vec<&mut [[u8; 4]]>],
    ) -> FillCounts {
        let (level, bins, pool) = (self.level, &self.bins, &self.planes);
        let samples = options.anti_aliasing.samples();
        let background = options.background;
        let tiles = self.tiles.buffers(|index| any_in(bins, index));
        tiles
            .into_par_iter()
            .zip(pieces)
            .enumerate()
            .map_init(Scratch::default, |scratch, (index, (mut tile, rows))| {
                let mut finish = |tile: &mut TileBuffer| {
                    let origin = origin(index, columns);
                    let mut counts = level.run(FillTile {
                        tile,
                        index,
                        bins,
                        origin,
                        samples,
                    });
                    if !context.scene.sections.is_empty() {
                        cap_tile(tile, origin, samples, context);
                    }
                    let resolve = ResolveTile {
                        context,
                        tile,
                        origin: origin.map(|v| v as usize),
                        rows,
                        background,
                        scratch,
                    };
                    counts.shaded = if resolve.tile.sees_through() {
                        resolve.run_transparent(level, samples)
                    } else {
                        resolve.run(level)
                    };
                    tile.part_first_samples();
                    counts
                };
                if !(tile_by_tile && tile.has_planes()) {
                    return finish(&mut tile);
                }
                let windings = !context.scene.sections.is_empty();
                pool.with(samples.len(), windings, |planes| {
                    let counts = finish(&mut tile.on(planes));
                    tile.keep_first(planes);
                    counts
                })
            })
            .reduce(FillCounts::default, FillCounts::add)
    }

    /// Leaves in `self.order` the clusters that may be seen, with their
    /// nearest depths, front to back.
    fn order_clusters(&mut self, context: &ShadeContext, facing: Facing, stats: &mut Stats) {
        self.order.clear();
        for (index, cluster) in context.scene.clusters.iter().enumerate() {
            if !context.caps.wants(cluster.beyond) {
                stats.clusters_outside += 1;
                continue;
            }
            match cluster_visibility(cluster, context.matrix, facing) {
                Visibility::Outside => stats.clusters_outside += 1,
                Visibility::FacingAway => stats.clusters_facing_away += 1,
                Visibility::Possible(depth) => self.order.push((depth, index as u32)),
            }
        }
        self.order
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    }
}

/// The first pixel of a tile.
fn origin(index: usize, columns: usize) -> [i32; 2] {
    [index % columns, index / columns].map(|t| (t * TILE) as i32)
}

/// So many clusters are taken in one batch (which tunes speed alone).
const FEW_CLUSTERS: usize = 512;

/// Sizes of the batches that so many clusters are taken in: few enough that
/// waiting for each other costs nothing, the first ones small so that what
/// they draw hides much of the rest.
fn batches(clusters: usize, tile_by_tile: bool, windings: bool) -> Vec<usize> {
    // (Windings count what is hidden: nothing is left out for that.)
    if clusters < FEW_CLUSTERS || (tile_by_tile && windings) {
        return vec![clusters];
    }
    if tile_by_tile {
        // Those before the last are filled once more.
        return vec![clusters / 4, clusters - clusters / 4];
    }
    let mut sizes: Vec<usize> = [8, 8, 8, 8, 4].iter().map(|part| clusters / part).collect();
    sizes.push(clusters - sizes.iter().sum::<usize>());
    sizes
}
