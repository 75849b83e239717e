//! Is a mesh right? Held against the tree it was made from, by code that shares
//! nothing with the mesher: rays through both, and the boundary beside the mesh's
//! points. Whether the mesh is closed, manifold and free of self-intersections is the
//! mesh's own exact check.

mod mesh_spans;
mod spans;

use std::f64::consts::PI;

use csg::{Mesh, Solid};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use stereotomy::csg;

use self::mesh_spans::{bundle, crossings, winding};
pub use self::spans::{Line, Spans, Tree};

// (Not all who judge need all of it.)
#[allow(dead_code)]
#[path = "../../crates/csg/src/random.rs"]
mod split_mix;
pub(crate) use self::split_mix::Random;

/// A mesh to be judged.
pub struct Case<'a> {
    pub tree: &'a Tree,
    pub mesh: &'a Mesh,
    /// How far the mesh may be from the solid's boundary, rounding aside.
    pub tolerance: f64,
    /// Walls and gaps thinner than this may be lost or new.
    pub unseen: f64,
    /// Of the rays.
    pub seed: u64,
}

/// What a mesh is.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// What is wrong, in words, with a place; nothing of a mesh that is right.
    pub faults: Vec<String>,
    /// Volume of the tree along the rays, and of the mesh along the same ones.
    pub volumes: [f64; 2],
    /// The largest distance of a vertex or a triangle's middle from the boundary, as far
    /// as some were tried.
    pub deviation: f64,
}

/// Rays along a side of each bundle.
const SIDE: usize = 20;
/// Rays through places about each leaf.
const PER_LEAF: usize = 16;
/// Vertices and triangles whose distance is measured.
const SAMPLES: usize = 1500;
/// Directions in which something is looked for about a point.
const DIRECTIONS: usize = 48;
/// The same where nothing may be there.
const THOROUGH: usize = 4000;
/// Directions in the plane of a layer.
const ALONG_LAYER: u32 = 64;
/// Proofs that a mesh is wrong.
const ENOUGH: usize = 40;

/// Whether anything of a solid is seen along rays.
pub fn is_seen(solid: &Solid, seed: u64) -> bool {
    let tree = Tree::new(solid);
    let case = Case {
        tree: &tree,
        mesh: &Mesh::default(),
        tolerance: 0.0,
        unseen: 0.0,
        seed,
    };
    let judge = Judge::new(&case);
    let mut random = Random(seed);
    let mut lines = judge.targeted(&mut random);
    lines.extend(judge.grid(random_turn(&mut random)).0);
    let rounding = judge.rounding;
    let is_long = |[low, high]: &[f64; 2]| high - low > rounding;
    lines
        .iter()
        .any(|line| tree.spans(line).iter().any(is_long))
}

/// Judges a mesh.
pub fn judge(case: &Case<'_>) -> Verdict {
    let mut verdict = Verdict::default();
    let check = case.mesh.check();
    if !check.is_manifold() {
        verdict.faults.push(check.to_string());
    }
    let crossings = case.mesh.self_intersections();
    if let Some(first) = crossings.first() {
        let place = case.mesh.corners(first[0] as usize)[0];
        let words = format!("{} crossings (first near {place})", crossings.len());
        verdict.faults.push(words);
    }
    let judge = Judge::new(case);
    judge.hold_rays(&mut verdict);
    judge.hold_points(&mut verdict);
    verdict
}

struct Judge<'a> {
    case: &'a Case<'a>,
    bounds: [DVec3; 2],
    /// Lengths and distances that mean nothing.
    rounding: f64,
}

impl<'a> Judge<'a> {
    fn new(case: &'a Case<'a>) -> Self {
        let [mut low, mut high] = case.tree.bounds();
        if let Some((least, greatest)) = case.mesh.bounds() {
            let is_open = !(low.is_finite() && high.is_finite() && low.cmple(high).all());
            if is_open {
                (low, high) = (least, greatest);
            }
            (low, high) = (low.min(least), high.max(greatest));
        }
        let far = low.abs().max(high.abs()).max_element();
        Self {
            case,
            bounds: [low, high],
            rounding: 1e-9 * low.distance(high) + 32.0 * f64::EPSILON * far,
        }
    }

    /// A grid of parallel rays, one somewhere in each square, and the area of a square.
    fn grid(&self, turn: DMat3) -> (Vec<Line>, f64) {
        let middle = self.bounds[0].midpoint(self.bounds[1]);
        let half = 0.5 * (self.bounds[1] - self.bounds[0]);
        let reach = |axis: DVec3| axis.abs().dot(half);
        let [u, v, w] = [turn.x_axis, turn.y_axis, turn.z_axis];
        let mut random = Random(self.case.seed ^ w.x.to_bits());
        let mut lines = Vec::with_capacity(SIDE * SIDE);
        for i in 0..SIDE {
            for k in 0..SIDE {
                let [x, y] = [i, k].map(|n| {
                    let share = (n as f64 + random.unit()) / SIDE as f64;
                    2.0 * share - 1.0
                });
                lines.push(Line {
                    origin: middle + u * (x * reach(u)) + v * (y * reach(v)),
                    direction: w,
                });
            }
        }
        (lines, 4.0 * reach(u) * reach(v) / (SIDE * SIDE) as f64)
    }

    /// Rays through places about every leaf, however small or thin.
    fn targeted(&self, random: &mut Random) -> Vec<Line> {
        let mut leaves: Vec<(DAffine3, [DVec3; 2])> = Vec::new();
        self.case.tree.leaves(&mut leaves);
        let mut lines = Vec::new();
        for (map, [low, high]) in leaves {
            for _ in 0..PER_LEAF {
                let share = DVec3::from_array([(); 3].map(|()| random.unit()));
                lines.push(Line {
                    origin: map.transform_point3(low + share * (high - low)),
                    direction: direction(random),
                });
            }
        }
        lines
    }

    fn hold_rays(&self, verdict: &mut Verdict) {
        let Case { tree, mesh, .. } = self.case;
        let mut random = Random(self.case.seed);
        let mut proven = 0;
        let (mut first, mut longest) = (DVec3::ZERO, 0.0);
        let mut hold = |line: &Line, crossings: Vec<(f64, i32)>| -> Option<[f64; 2]> {
            let of_tree = tree.spans(line);
            let of_mesh = winding(crossings)?;
            for [low, high] in differences(&of_tree, &of_mesh) {
                let is_enough = proven == ENOUGH;
                if !is_enough && high - low > self.rounding && self.is_proof(line, low, high) {
                    proven += 1;
                    if high - low > longest {
                        longest = high - low;
                        first = line.at(low.midpoint(high));
                    }
                }
            }
            let length = |spans: &[[f64; 2]]| spans.iter().map(|s| s[1] - s[0]).sum::<f64>();
            let inside = of_mesh.iter().filter(|s| s.1 == 1).map(|s| s.0);
            Some([length(&of_tree), length(&inside.collect::<Vec<_>>())])
        };
        let turn = random_turn(&mut random);
        let (mut sums, mut squares, mut count) = ([0.0; 2], 0.0, 0.0);
        for axis in 0..3 {
            let at = |k: usize| turn.col((axis + k) % 3);
            let (lines, area) = self.grid(DMat3::from_cols(at(1), at(2), at(0)));
            let cells = bundle(mesh, &lines);
            for (line, crossings) in lines.iter().zip(cells) {
                if let Some([of_tree, of_mesh]) = hold(line, crossings) {
                    let whole = area * (SIDE * SIDE) as f64;
                    sums[0] += whole * of_tree;
                    sums[1] += whole * of_mesh;
                    squares += (whole * (of_tree - of_mesh)).powi(2);
                    count += 1.0;
                }
            }
        }
        for line in self.targeted(&mut random) {
            hold(&line, crossings(mesh, &line));
        }
        verdict.volumes = sums.map(|sum| sum / count);
        let off = verdict.volumes[0] - verdict.volumes[1];
        let error = ((squares / count - off * off).max(0.0) / count).sqrt();
        let size = (self.bounds[1] - self.bounds[0]).max(DVec3::ZERO);
        let skin = 2.0 * size.dot(DVec3::new(size.y, size.z, size.x));
        let allowed = mesh.area() * self.case.tolerance
            + skin * (self.case.unseen + self.rounding)
            + 5.0 * error;
        if proven > 0 {
            let words =
                format!("differs from the solid along {proven} rays, by {longest:.3e} at {first}");
            verdict.faults.push(words);
        } else if off.abs() > allowed {
            verdict.faults.push(format!("volume off by {off:.3e}"));
        }
    }

    /// Whether the piece of a line that is in the solid or in the mesh, not in both,
    /// cannot be because one is within the tolerance of the other.
    fn is_proof(&self, line: &Line, low: f64, high: f64) -> bool {
        let place = line.at(low.midpoint(high));
        if !place.is_finite() {
            return true;
        }
        let allowed = self.case.tolerance + self.rounding;
        let beside = |reach| {
            let mut random = Random(self.case.seed);
            let mut directions = (0..THOROUGH).map(|_| direction(&mut random));
            directions.any(|d| self.along(place, d, reach).is_some())
        };
        let (from_mesh, normal) = mesh_spans::nearest(self.case.mesh, place);
        // The rim of a layer, which is seen from within it alone.
        let is_near_rim = || {
            let x = normal.any_orthonormal_vector();
            let y = normal.cross(x);
            let mut angles = (0..ALONG_LAYER).map(|k| PI * f64::from(k) / f64::from(ALONG_LAYER));
            angles.any(|a| {
                let along = a.cos() * x + a.sin() * y;
                self.along(place, along, allowed).is_some()
            })
        };
        // A wall or gap of the mesh, or one of the solid.
        let unseen = self.case.unseen.max(self.rounding);
        let is_thin = || from_mesh <= unseen || beside(unseen);
        let is_near =
            || self.along(place, normal, allowed).is_some() || is_near_rim() || beside(allowed);
        (from_mesh > allowed || !is_near()) && !is_thin()
    }

    /// How far the boundary is from a place, seen in some directions; none if it is
    /// beyond the reach.
    fn distance(&self, place: DVec3, reach: f64, random: &mut Random) -> Option<f64> {
        let found = (0..DIRECTIONS).filter_map(|_| self.along(place, direction(random), reach));
        found.reduce(f64::min)
    }

    /// The same by lines through places all around, too: a slit is missed by most lines
    /// through its own end.
    fn about(&self, place: DVec3, reach: f64, random: &mut Random) -> Option<f64> {
        let through = self.distance(place, reach, random);
        through.or_else(|| {
            (0..64 * THOROUGH).find_map(|_| {
                // Near by or far: where surfaces meet at a small angle, or part soon.
                let aside = 0.99 * reach * (1e-6f64).powf(random.unit());
                let near = place + aside * direction(random);
                let found = self.along(near, direction(random), reach - aside)?;
                Some(found + aside)
            })
        })
    }

    /// The nearest place, up to a distance, where a line through a point enters or leaves
    /// the solid.
    fn along(&self, place: DVec3, direction: DVec3, reach: f64) -> Option<f64> {
        let line = Line {
            origin: place,
            direction,
        };
        let ends = self.case.tree.spans(&line).into_iter().flatten();
        let nearest = ends.map(f64::abs).reduce(f64::min)?;
        (nearest <= reach).then_some(nearest)
    }

    /// Whether a place of a triangle is at a wall or gap of the mesh so thin that it may be
    /// new.
    fn is_at_thin(&self, place: DVec3, middle: DVec3, normal: DVec3) -> bool {
        let unseen = self.case.unseen;
        if unseen == 0.0 {
            return false;
        }
        let mut random = Random(self.case.seed);
        let near = place.move_towards(middle, 0.3 * self.case.tolerance);
        let sides = [1e-3, -1e-3].map(|share| near + share * unseen * normal);
        let mut tried = sides.into_iter().flat_map(|origin| {
            let lines = (0..DIRECTIONS).map(move |_| origin);
            lines.collect::<Vec<_>>()
        });
        tried.any(|origin| {
            let direction = direction(&mut random);
            let found = crossings(self.case.mesh, &Line { origin, direction });
            let nearest = |sign: f64| {
                let beyond = found.iter().map(|(t, _)| sign * t).filter(|&t| t > 0.0);
                beyond.fold(f64::INFINITY, f64::min)
            };
            nearest(1.0) + nearest(-1.0) <= unseen
        })
    }

    /// Whether vertices and the middles of triangles are near the boundary.
    fn hold_points(&self, verdict: &mut Verdict) {
        let mesh = self.case.mesh;
        let reach = self.case.tolerance + self.rounding;
        let mut random = Random(!self.case.seed);
        let mut off = 0;
        let mut first = DVec3::ZERO;
        let step = mesh.triangles.len().div_ceil(SAMPLES).max(1);
        for index in (0..mesh.triangles.len()).step_by(step) {
            let corners = mesh.corners(index);
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let normal = normal.normalize_or_zero();
            for place in [middle].into_iter().chain(corners) {
                // Across the triangle, here or beside, or all around.
                let towards = corners.into_iter().chain([middle]);
                let beside = towards.flat_map(|to| {
                    [0.05, 0.3, 0.7].map(|share| place.move_towards(to, share * reach))
                });
                let mut across = [place].into_iter().chain(beside).filter_map(|near| {
                    let found = self.along(near, normal, reach)?;
                    Some(found.hypot(near.distance(place))).filter(|&d| d <= reach)
                });
                let found = across
                    .next()
                    .or_else(|| self.about(place, reach, &mut random));
                match found {
                    Some(distance) => verdict.deviation = verdict.deviation.max(distance),
                    None if self.is_at_thin(place, middle, normal) => {}
                    None => {
                        off += 1;
                        first = place;
                    }
                }
            }
        }
        if off > 0 {
            let words = format!("{off} points farther than the tolerance (one is {first})");
            verdict.faults.push(words);
        }
    }
}

/// Where a line is in a solid and not in a mesh, in the mesh alone, or in a mesh
/// otherwise than once.
fn differences(of_tree: &[[f64; 2]], of_mesh: &[([f64; 2], i32)]) -> Spans {
    let mut ends: Vec<f64> = of_tree.iter().flatten().copied().collect();
    ends.extend(of_mesh.iter().flat_map(|(span, _)| *span));
    ends.sort_by(f64::total_cmp);
    let mut found = Spans::new();
    for pair in ends.windows(2) {
        let [low, high] = [pair[0], pair[1]];
        if low >= high {
            continue;
        }
        let holds = |span: &[f64; 2]| span[0] <= low && high <= span[1];
        let inside = i32::from(of_tree.iter().any(holds));
        let times = of_mesh.iter().find(|(span, _)| holds(span));
        if inside == times.map_or(0, |(_, times)| *times) {
            continue;
        }
        match found.last_mut() {
            Some(last) if last[1] == low => last[1] = high,
            _ => found.push([low, high]),
        }
    }
    found
}

/// A direction, each as likely as the others.
fn direction(random: &mut Random) -> DVec3 {
    let z = 2.0 * random.unit() - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * random.unit()).sin_cos();
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * cos, across * sin, z)
}

fn random_turn(random: &mut Random) -> DMat3 {
    let turn = DQuat::from_axis_angle(direction(random), 0.1 + random.unit());
    DMat3::from_quat(turn)
}
