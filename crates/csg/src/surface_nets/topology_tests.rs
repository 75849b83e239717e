//! Stitching on random signs and random decisions of ambiguous faces: whatever
//! they are, the mesh is manifold. No solid and no geometry is behind them.

use glam::{DVec3, UVec3};

use super::assembly::Assembly;
use super::lattice::{CELLS, SAMPLES};
use super::loops::{self, PATTERNS};
use super::part::{ComplexCell, FaceArcs, Part, PolygonCode, PolygonGroup};
use super::stitch::{Directory, Scratch, Stitcher};
use crate::mesh::Mesh;
use crate::program::{Program, Surface};
use crate::random::Random;
use crate::solid::Solid;
use crate::sweeps::one_in;

/// Bricks along each side of the test's lattice.
const BRICKS: usize = 2;
/// Samples along each side of it.
const WIDE: usize = BRICKS * CELLS + 1;

/// Where vertices are put.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Placement {
    /// In the middle of their cell or face: the polygons are then the faces
    /// of unit cubes about the inside samples.
    Middle,
    /// Anywhere within a cell of their cell: every diagonal gets its turn.
    Anywhere,
    /// On a corner of their cell or face: neighbours often coincide.
    Corner,
}

/// Signs and face decisions, nothing else.
struct Signs {
    inside: Vec<bool>,
    /// Per normal axis and lowest sample.
    joined: Vec<[bool; 3]>,
    /// The samples beyond which nothing is inside.
    from: [usize; 3],
    to: [usize; 3],
}

fn at([x, y, z]: [usize; 3]) -> usize {
    x + WIDE * (y + WIDE * z)
}

impl Signs {
    /// A box of samples from `from`, `sides` long, inside with the given
    /// probability each, or a checkerboard with faults.
    fn random(random: &mut Random, from: [usize; 3], sides: [usize; 3]) -> Self {
        let mut signs = Self::outside(from, sides);
        let checkerboard = random.below(4) == 0;
        // From sparse to dense; of a checkerboard, the share of faults.
        let density = random.unit().powi(random.below(3) as i32);
        signs.fill(|[x, y, z]| {
            let hit = random.unit() < density;
            hit != (checkerboard && (x + y + z) % 2 == 0)
        });
        let bias = random.unit();
        for faces in &mut signs.joined {
            *faces = [(); 3].map(|()| random.unit() < bias);
        }
        signs
    }

    fn outside(from: [usize; 3], sides: [usize; 3]) -> Self {
        Self {
            inside: vec![false; WIDE.pow(3)],
            joined: vec![[false; 3]; WIDE.pow(3)],
            from,
            to: [0, 1, 2].map(|a| from[a] + sides[a]),
        }
    }

    fn fill(&mut self, mut inside: impl FnMut([usize; 3]) -> bool) {
        for z in self.from[2]..self.to[2] {
            for y in self.from[1]..self.to[1] {
                for x in self.from[0]..self.to[0] {
                    self.inside[at([x, y, z])] = inside([x, y, z]);
                }
            }
        }
    }

    fn corners(&self, cell: [usize; 3]) -> u8 {
        (0..8).fold(0, |corners, i| {
            let corner = [0, 1, 2].map(|a| cell[a] + (i >> a & 1));
            corners | u8::from(self.inside[at(corner)]) << i
        })
    }

    fn joined(&self, cell: [usize; 3], corners: u8) -> u8 {
        (0..6).fold(0, |joined, face| {
            let mut lowest = cell;
            lowest[face / 2] += face & 1;
            let is_joined = loops::is_ambiguous(corners, face) && self.joined[at(lowest)][face / 2];
            joined | u8::from(is_joined) << face
        })
    }

    /// Where a brick's own cells, faces and edges may change sign, along one
    /// axis and in the brick's own count.
    fn range(&self, brick: [usize; 3], axis: usize) -> std::ops::Range<usize> {
        let first = brick[axis] * CELLS;
        let from = (self.from[axis] - 1).saturating_sub(first);
        from..self.to[axis].saturating_sub(first).min(CELLS)
    }

    /// What placing would leave behind for stitching.
    fn parts(&self, random: &mut Random, placement: Placement) -> Vec<Part> {
        let mut parts: Vec<Part> = (0..=random.below(4)).map(|_| Part::default()).collect();
        for index in 0..BRICKS.pow(3) {
            let brick = [
                index % BRICKS,
                index / BRICKS % BRICKS,
                index / BRICKS / BRICKS,
            ];
            let count = parts.len();
            let part = &mut parts[random.below(count)];
            self.add_brick(random, placement, brick, part);
        }
        parts
    }

    fn add_brick(
        &self,
        random: &mut Random,
        placement: Placement,
        brick: [usize; 3],
        part: &mut Part,
    ) {
        let record = part.open_brick(UVec3::from_array(brick.map(|b| b as u32)));
        let samples: Vec<[usize; 3]> = self
            .range(brick, 2)
            .flat_map(|z| self.range(brick, 1).map(move |y| [y, z]))
            .flat_map(|[y, z]| self.range(brick, 0).map(move |x| [x, y, z]))
            .collect();
        let packed = |[x, y, z]: [usize; 3]| x + SAMPLES * (y + SAMPLES * z);
        let global = |local: [usize; 3]| [0, 1, 2].map(|a| brick[a] * CELLS + local[a]);
        let mut complex = Vec::new();
        for &local in &samples {
            let cell = global(local);
            let corners = self.corners(cell);
            if PATTERNS[usize::from(corners)].simple {
                part.cells.push(packed(local) as u16);
                let vertex = place(random, placement, cell, DVec3::ONE);
                part.vertices.push(vertex);
            } else if corners != 0 && corners != 255 {
                complex.push((local, corners));
            }
        }
        for (local, corners) in complex {
            let cell = global(local);
            let joined = self.joined(cell, corners);
            let loops = loops::trace(corners, joined);
            part.complex.push(ComplexCell {
                sample: packed(local) as u16,
                loops,
                vertex: part.vertices.len() as u32 - record.vertices.start,
            });
            for _ in 0..loops.count {
                let vertex = place(random, placement, cell, DVec3::ONE);
                part.vertices.push(vertex);
            }
        }
        let mut groups = [const { Vec::new() }; 2];
        for &local in &samples {
            let sample = global(local);
            let corners = self.corners(sample);
            for axis in 0..3 {
                // Lower faces and edges of the cell, which the brick owns.
                if loops::is_ambiguous(corners, 2 * axis) {
                    part.arcs.push(FaceArcs {
                        face: (axis << 12 | packed(local)) as u16,
                        vertex: part.vertices.len() as u32 - record.vertices.start,
                        joined: self.joined[at(sample)][axis],
                    });
                    let mut extent = DVec3::ONE;
                    extent[axis] = 0.0;
                    for _ in 0..2 {
                        let vertex = place(random, placement, sample, extent);
                        part.vertices.push(vertex);
                    }
                }
                let starts_inside = corners & 1 == 1;
                let ends_inside = corners >> (1 << axis) & 1 == 1;
                if starts_inside != ends_inside {
                    let code = PolygonCode::new(
                        axis,
                        starts_inside,
                        random.below(2) == 0,
                        packed(local) as u16,
                    );
                    groups[random.below(2)].push(code);
                }
            }
        }
        for (surface, group) in groups.into_iter().enumerate() {
            part.polygons.extend_from_slice(&group);
            part.groups.push(PolygonGroup {
                surface: surface as u32,
                origin: 0,
                reversed: false,
                count: group.len() as u32,
                entry: 0,
            });
        }
        part.close_brick(record);
    }

    fn mesh(&self, random: &mut Random, placement: Placement, surfaces: &[Surface]) -> Mesh {
        let parts = self.parts(random, placement);
        let mut directory = Directory::default();
        directory.extend(&parts);
        let stitcher = Stitcher {
            parts: &parts,
            directory: &directory,
            surfaces,
            least_area: 0.0,
        };
        let mut assembly = Assembly::default();
        assembly.add(&parts, 0, 1.0, |part, out| {
            stitcher.part(pulp::Scalar, part, &mut Scratch::default(), out)
        });
        let assembled = assembly.finish();
        Mesh::new(assembled.positions, assembled.triangles)
    }

    fn inside_samples(&self) -> usize {
        self.inside.iter().filter(|&&inside| inside).count()
    }
}

/// A vertex of the cell or face at `lowest` with the given extent.
fn place(random: &mut Random, placement: Placement, lowest: [usize; 3], extent: DVec3) -> DVec3 {
    let lowest = DVec3::from_array(lowest.map(|l| l as f64));
    let within = DVec3::from_array([(); 3].map(|()| match placement {
        Placement::Middle => 0.5,
        Placement::Anywhere => 3.0 * random.unit() - 1.0,
        Placement::Corner => random.below(2) as f64,
    }));
    lowest + within * extent
}

/// A plane and a sphere.
fn surfaces() -> Vec<Surface> {
    let solid = Solid::half_space([0.0, 0.0, 1.0], 8.0) & Solid::sphere(9.0);
    let program = Program::lower(&solid).expect("a valid solid");
    program.surfaces().to_vec()
}

fn assert_manifold(signs: &Signs, random: &mut Random, surfaces: &[Surface], which: &str) {
    for placement in [Placement::Middle, Placement::Anywhere, Placement::Corner] {
        let mesh = signs.mesh(random, placement, surfaces);
        let check = mesh.check();
        assert!(check.is_manifold(), "{which} {placement:?}: {check}");
        if placement == Placement::Middle {
            assert_eq!(check.unreferenced_vertices, 0, "{which}");
            // Everywhere, and the right way out.
            assert_eq!(mesh.volume(), signs.inside_samples() as f64, "{which}");
        }
    }
}

#[test]
fn every_cell_with_every_decision_in_every_place_is_manifold() {
    let surfaces = surfaces();
    let mut random = Random(1);
    for mask in 0..=255u8 {
        let faces = PATTERNS[usize::from(mask)].ambiguous;
        for joined in (0..64u8).filter(|joined| joined & !faces == 0) {
            // In the middle of a brick, and across eight.
            for from in [[5; 3], [CELLS; 3]] {
                let cell = from.map(|f| f - usize::from(f == CELLS));
                let mut signs = Signs::outside(cell, [2; 3]);
                signs.fill(|sample| {
                    let corner = (0..3).fold(0, |c, a| c | (sample[a] - cell[a]) << a);
                    mask >> corner & 1 == 1
                });
                for face in 0..6 {
                    let mut lowest = cell;
                    lowest[face / 2] += face & 1;
                    signs.joined[at(lowest)][face / 2] = joined >> face & 1 == 1;
                }
                let which = format!("{mask:08b} {joined:06b} at {cell:?}");
                assert_manifold(&signs, &mut random, &surfaces, &which);
            }
        }
    }
}

#[test]
fn random_signs_with_random_decisions_are_manifold() {
    let surfaces = surfaces();
    for seed in (0..3000).step_by(one_in(5)) {
        let mut random = Random(seed);
        let sides = [(); 3].map(|()| 2 + random.below(6));
        let from = [0, 1, 2].map(|a| 1 + random.below(WIDE - 1 - sides[a]));
        let signs = Signs::random(&mut random, from, sides);
        assert_manifold(&signs, &mut random, &surfaces, &format!("seed {seed}"));
    }
}
