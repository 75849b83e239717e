//! Caps: where section planes cut through solid matter.
//!
//! What all planes keep is convex: a ray enters it through planes that have
//! the viewer on the side cut away, the last of which is its *entry*, and
//! leaves it through others. What lies before the entry is cut off. If the
//! faces after it turn their backs more often than their fronts, the ray has
//! entered solid matter through the cut: the sample becomes part of the cap, at
//! the depth of the entry. The ray may meet faces where it has already left
//! what is kept through another plane, so faces beyond such planes are drawn
//! as well: they decide about caps, and are not shown themselves. This needs no
//! triangulation of the cut and is right for every closed mesh and every
//! sample, if the far plane is behind the whole mesh: which faces a sample
//! meets is found exactly, and a mesh whose corners are snapped is still
//! closed, so that their number does not depend on which of two faces that
//! meet at a silhouette is the nearer one.
//!
//! A cap of a solid that is seen through is as opaque as the face by which the
//! ray leaves that solid, and one more of the fragments that are blended by
//! depth.

use glam::{DMat4, DVec3, DVec4};

use crate::frame::FrameMatrix;
use crate::section::Section;
use crate::shading::ShadeContext;
use crate::tile::{BLOCK, BLOCK_PIXELS, BLOCKS, NO_TRIANGLE, TileBuffer, capped};
use crate::transparent::Fragment;

/// The section planes of one frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Caps {
    /// Those that have the viewer on the side cut away: rays enter through
    /// them, and leave through others.
    planes: Vec<Option<CapPlane>>,
    /// Bits of those.
    entries: u8,
}

/// A section plane as seen: at the sample (x, y), in sub-pixels from the
/// middle of the picture, it shows the homogeneous point x·x_step + y·y_step +
/// origin, scaled so that W is 1.
#[derive(Clone, Copy, Debug)]
struct CapPlane {
    x_step: DVec4,
    y_step: DVec4,
    origin: DVec4,
    /// The row of the matrix that gives depth.
    depth: DVec4,
}

impl CapPlane {
    fn at(&self, x: f64, y: f64) -> DVec4 {
        self.x_step * x + self.y_step * y + self.origin
    }
}

impl Caps {
    pub fn new(sections: &[Section], matrix: &FrameMatrix) -> Self {
        let [x, y, z, w] = matrix.rows;
        let viewer = matrix.viewer;
        let planes: Vec<_> = sections
            .iter()
            .map(|section| {
                // Only a cut that faces the viewer shows its cap.
                if section.normal.dot(viewer.truncate()) <= section.offset * viewer.w {
                    return None;
                }
                let plane = section.normal.extend(-section.offset);
                let to_window = DMat4::from_cols(x, y, w, plane).transpose();
                let inverse = to_window.inverse();
                inverse.is_finite().then_some(CapPlane {
                    x_step: inverse.x_axis,
                    y_step: inverse.y_axis,
                    origin: inverse.z_axis,
                    depth: z,
                })
            })
            .collect();
        let bits = planes.iter().enumerate();
        let entries = bits.fold(0, |bits, (k, plane)| bits | u8::from(plane.is_some()) << k);
        Self { planes, entries }
    }

    /// Whether triangles beyond these planes are drawn: if some ray may meet
    /// them after its entry.
    pub fn wants(&self, beyond: u8) -> bool {
        beyond == 0 || (self.entries != 0 && beyond & self.entries == 0)
    }

    /// The point of a cap at a sample, relative to the scene's centre.
    pub fn point(&self, plane: usize, x: f64, y: f64) -> DVec3 {
        self.planes
            .get(plane)
            .copied()
            .flatten()
            .map_or(DVec3::ZERO, |plane| {
                let p = plane.at(x, y);
                p.truncate() / p.w
            })
    }

    /// Where the ray of a sample enters what is kept, if it does so
    /// beyond the near plane.
    fn entry(&self, sections: &[Section], x: f64, y: f64) -> Option<Entry> {
        let mut last: Option<(f64, usize, DVec4)> = None;
        for (k, plane) in self.planes.iter().enumerate() {
            let Some(plane) = plane else { continue };
            let p = plane.at(x, y);
            let depth = plane.depth.dot(p);
            // Behind the viewer the ray has left for good.
            if p.w <= 0.0 {
                return None;
            }
            if last.is_none_or(|(before, ..)| depth < before) {
                last = Some((depth, k, p));
            }
        }
        let (depth, plane, p) = last.filter(|(depth, ..)| *depth <= 1.0)?;
        let behind = |s: &Section| s.normal.extend(-s.offset).dot(p) <= 0.0;
        let exits = sections.iter().zip(&self.planes);
        let kept = exits
            .filter(|(_, entry)| entry.is_none())
            .all(|(s, _)| behind(s));
        Some(Entry {
            plane,
            depth: depth as f32,
            kept,
        })
    }
}

/// Where a ray enters what section planes keep.
struct Entry {
    plane: usize,
    /// Reversed.
    depth: f32,
    /// Whether it does, or has left through another plane before.
    kept: bool,
}

/// Turns the samples of a tile whose rays enter through a cut into cap, and
/// clears those that show what is cut away.
pub(crate) fn cap_tile(
    buffer: &mut TileBuffer,
    origin: [i32; 2],
    samples: &[[i32; 2]],
    context: &ShadeContext,
) {
    let (scene, matrix, caps) = (context.scene, context.matrix, &context.caps);
    if !buffer.tile.drawn {
        return;
    }
    let kept = |number: i32| (number as usize) < scene.kept_triangles;
    let fragments = buffer.fragments.as_deref_mut();
    let mut fragments = fragments.map_or_else(Vec::new, std::mem::take);
    fragments.sort_unstable_by(Fragment::order);
    let mut seen_through = fragments
        .chunk_by(|a, b| a.place() == b.place())
        .map(|group| (group[0], SeenThrough::of(group, scene.kept_triangles)))
        .peekable();
    let mut caps_seen_through = Vec::new();
    for (k, (plane, sample)) in buffer.planes().zip(samples).enumerate() {
        let depths = plane.depth.as_flattened_mut();
        let numbers = plane.triangle.as_flattened_mut();
        let windings = plane.winding.as_flattened();
        let here = depths.iter_mut().zip(numbers).zip(windings);
        for (index, ((depth, number), &winding)) in here.enumerate() {
            let behind = seen_through.next_if(|(first, _)| first.place() == (k, index));
            if *number == NO_TRIANGLE && behind.is_none() {
                continue;
            }
            let in_matter = winding > 0;
            let cut_away = !kept(*number) && behind.is_none_or(|(_, faces)| !faces.kept);
            if !in_matter && kept(*number) {
                continue;
            }
            let (block, lane) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
            let column = block % BLOCKS * BLOCK + lane % BLOCK;
            let row = block / BLOCKS * BLOCK + lane / BLOCK;
            let at = |pixel: usize, axis: usize| {
                let sub = (pixel as i32 + origin[axis]) * 256 + sample[axis];
                f64::from(sub - matrix.middle[axis])
            };
            let entry = if in_matter {
                caps.entry(&scene.sections, at(column, 0), at(row, 1))
            } else {
                None
            };
            // A face that is kept proves that the matter before it is kept as
            // well, up to rounding.
            if let Some(entry) = entry.filter(|entry| entry.kept || !cut_away) {
                let exit = behind.and_then(|(first, faces)| Some((first, faces.exit(winding)?)));
                if let Some((first, exit)) = exit {
                    let cap = capped(exit, entry.plane);
                    caps_seen_through.push(first.cap(entry.depth, cap));
                } else {
                    let face = match behind {
                        Some((first, _)) if *number == NO_TRIANGLE => first.triangle,
                        _ => *number,
                    };
                    *depth = entry.depth;
                    *number = capped(face, entry.plane);
                    continue;
                }
            }
            if !kept(*number) {
                *depth = 0.0;
                *number = NO_TRIANGLE;
            }
        }
    }
    drop(seen_through);
    fragments.extend(caps_seen_through);
    if let Some(list) = &mut buffer.fragments {
        **list = fragments;
    }
}

/// The faces at a sample that are seen through.
#[derive(Clone, Copy)]
struct SeenThrough {
    /// How many more of them show their backs than their fronts.
    winding: i32,
    /// The first back without a front before it: there the ray leaves the solid
    /// in which it is at the entry.
    exit: Option<i32>,
    /// Whether any is of what section planes keep.
    kept: bool,
}

impl SeenThrough {
    /// From near to far.
    fn of(fragments: &[Fragment], kept_triangles: usize) -> Self {
        let (mut exit, mut open) = (None, 0);
        for fragment in fragments {
            if fragment.winding < 0 {
                open += 1;
            } else if open > 0 {
                open -= 1;
            } else {
                exit = exit.or(Some(fragment.triangle));
            }
        }
        let kept = |f: &Fragment| (f.triangle as usize) < kept_triangles;
        Self {
            winding: fragments.iter().map(|f| i32::from(f.winding)).sum(),
            exit,
            kept: fragments.iter().any(kept),
        }
    }

    /// The face by which a ray leaves the solid whose cap is seen through, if
    /// it is: nothing opaque is cut there. `winding` is that of all faces.
    fn exit(&self, winding: i32) -> Option<i32> {
        self.exit.filter(|_| winding <= self.winding)
    }
}
