//! Culling of whole clusters: by the view volume, by the cone of their
//! normals, and by hierarchical depth.

use glam::{DVec3, DVec4};

use crate::cluster::Cluster;
use crate::fixed::SUBPIXEL_BITS;
use crate::frame::FrameMatrix;
use crate::geometry::{Facing, GeometryContext};
use crate::tile::Tile;

/// Why a cluster is left out, or how near it comes.
pub(crate) enum Visibility {
    Outside,
    FacingAway,
    /// May be seen; greatest reversed depth of its bounding sphere.
    Possible(f32),
}

/// A plane's distance from the centre of a sphere, and its greatest change
/// within it.
fn reach(row: DVec4, centre: DVec3, radius: f64) -> (f64, f64) {
    let normal = row.truncate();
    (normal.dot(centre) + row.w, normal.length() * radius)
}

/// Culls a cluster by the view volume and by its normal cone.
pub(crate) fn cluster_visibility(
    cluster: &Cluster,
    matrix: &FrameMatrix,
    facing: Facing,
) -> Visibility {
    let [x, y, z, w] = matrix.rows;
    let [half_x, half_y] = matrix.middle.map(f64::from);
    let planes = [
        w * half_x + x,
        w * half_x - x,
        w * half_y + y,
        w * half_y - y,
        w - z,
        z,
    ];
    for plane in planes {
        let (distance, change) = reach(plane, cluster.centre, cluster.radius);
        if distance < -(change * 1.0001) {
            return Visibility::Outside;
        }
    }
    if !(facing.front && facing.back) {
        let away = matrix.viewer.truncate() - cluster.centre * matrix.viewer.w;
        let slack = cluster.sine * away.length() + cluster.radius * matrix.viewer.w;
        let towards = cluster.axis.dot(away);
        if (facing.front && towards < -slack) || (facing.back && towards > slack) {
            return Visibility::FacingAway;
        }
    }
    // Depth is b + (a + r·p) / w, where b is the part of the z row along the
    // w row: exact for a perspective, whose depth depends on w alone.
    let w_normal = w.truncate();
    let length = w_normal.length_squared();
    let b = if length > 0.0 {
        z.truncate().dot(w_normal) / length
    } else {
        0.0
    };
    let (w_centre, w_change) = reach(w, cluster.centre, cluster.radius);
    let nearest_w = w_centre - w_change;
    if nearest_w <= 0.0 {
        return Visibility::Possible(1.0);
    }
    let (rest, rest_change) = reach(z - w * b, cluster.centre, cluster.radius);
    let most = rest + rest_change;
    let nearest = b + most
        / if most > 0.0 {
            nearest_w
        } else {
            w_centre + w_change
        };
    Visibility::Possible((nearest * 1.00001 + 1e-6).min(1.0) as f32)
}

/// Whether hierarchical depth hides a cluster whose nearest depth is `depth`.
pub(crate) fn hidden(cluster: &Cluster, depth: f32, context: &GeometryContext) -> bool {
    let matrix = context.matrix;
    let [x, y, _, w] = matrix.rows;
    let (w_centre, w_change) = reach(w, cluster.centre, cluster.radius);
    let nearest_w = w_centre - w_change;
    if nearest_w <= 0.0 || depth >= 1.0 {
        return false;
    }
    let range = |row: DVec4, axis: usize| {
        let at = (row.truncate().dot(cluster.centre) + row.w) / w_centre;
        let (_, change) = reach(row - w * at, cluster.centre, cluster.radius);
        let spread = change / nearest_w + 2.0 * 256.0;
        let tile = |v: f64| (v as i32).saturating_add(matrix.middle[axis]) >> (SUBPIXEL_BITS + 3);
        (tile(at - spread), tile(at + spread))
    };
    let (x0, x1) = range(x, 0);
    let (y0, y1) = range(y, 1);
    let last = [matrix.width, matrix.height].map(|side| (side.cast_signed() - 1) >> 3);
    let (x0, x1) = (x0.max(0), x1.min(last[0]));
    let (y0, y1) = (y0.max(0), y1.min(last[1]));
    let whole = |tile: &Tile| tile.drawn && depth < tile.farthest_of_all;
    for tile_y in y0 >> 3..=y1 >> 3 {
        for tile_x in x0 >> 3..=x1 >> 3 {
            let Some(tile) = context
                .tiles
                .get(tile_y as usize * context.columns + tile_x as usize)
            else {
                return false;
            };
            if !tile.drawn {
                return false;
            }
            if whole(tile) {
                continue;
            }
            for sy in (y0 - tile_y * 8).max(0)..=(y1 - tile_y * 8).min(7) {
                for sx in (x0 - tile_x * 8).max(0)..=(x1 - tile_x * 8).min(7) {
                    if depth >= tile.farthest[(sy * 8 + sx) as usize] {
                        return false;
                    }
                }
            }
        }
    }
    true
}
