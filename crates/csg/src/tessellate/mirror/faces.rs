//! Walls that are cut open: a face is the image of the one next to it.
//!
//! What two faces have in common is told by names: a corner or a chain of chords of the one
//! has its counterpart on the other, and so do, from there on, the faces beyond a chain that
//! is no rim of the wall. The triangles of one side are mapped to the other vertex by
//! vertex, and the rims between the two are strips of as many chords on both sides.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::triangulate::{Named, Scratch, triangulate};
use crate::program::{Surface, SurfaceId};
use crate::surface::solve;
use crate::tessellate::fine::Fine;
use crate::tessellate::goal::Goal;
use crate::tessellate::grow::Grower;
use crate::tessellate::half_edges::{HalfEdges, Kind, NONE, halves_of, next, triangle_of};
use crate::tessellate::hand_back::hand_back;
use crate::tessellate::outcome::Unkept;
use crate::tessellate::parts::Refined;
use crate::tessellate::region::Bend;
use crate::tessellate::surfaced::Surfaced;

/// A mesh in which of each two faces whose triangles run through each other the one is the
/// image of the other, as far as their borders correspond; none if there are none such. Pairs
/// of triangles are given.
pub(crate) fn mirrored(
    refined: &Refined,
    surfaces: &[Surface],
    goal: &Goal,
    wrong: &[[u32; 2]],
) -> Option<Refined> {
    let surfaced = &refined.surfaced;
    let mut mesh = HalfEdges::new(surfaced, surfaces)?;
    mesh.fix_contacts();
    let regions = |pair: &[u32; 2]| pair.map(|triangle| mesh.region_index(triangle));
    let pairs = wrong.iter().map(regions);
    let mut pairs: Vec<[u32; 2]> = pairs
        .filter(|[one, other]| one != other)
        .map(|[one, other]| [one.min(other), one.max(other)])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    // Farther apart than both sides stray no wall runs through itself.
    let mut mirror = Mirror::new(&mesh, 2.0 * goal.tolerance);
    for pair in pairs {
        mirror.match_from(pair);
    }
    if mirror.pairs.is_empty() {
        return None;
    }
    mirror.add_images()?;
    let made = mirror.put_together(surfaced)?;
    let mut closed = HalfEdges::new(&made, surfaces)?;
    let mut grower = Grower::new(&mut closed, goal, surfaced.precision);
    grower.measure_everything();
    let mut outcome = grower.outcome;
    // An image is as fine as what it is of.
    let surface = |region: u32| mirror.mesh.regions[region as usize].surface;
    let pairs = mirror.pairs.iter().map(|pair| pair.regions.map(surface));
    let finer = pairs.filter(|[_, image]| outcome.tighter.contains(image));
    let finer: Vec<SurfaceId> = finer.map(|[original, _]| original).collect();
    outcome.tighter.extend(finer);
    let is_left =
        |(reason, _): &&(Unkept, DVec3)| matches!(reason, Unkept::Lost | Unkept::NotManifold);
    let left = refined.outcome.unkept.iter().filter(is_left);
    outcome.unkept.extend(left);
    let mut surfaced = surfaced.empty();
    hand_back(&closed, &Fine::default(), &mut surfaced);
    Some(Refined { surfaced, outcome })
}

/// A part of a face's border, of half-edges one after another with the face on the left,
/// along which there is one other face.
struct Chain {
    /// The face beyond.
    other: u32,
    halves: Vec<u32>,
    is_closed: bool,
}

/// Faces, each with what of it corresponds to what of its image.
struct Mirror<'m, 's> {
    mesh: &'m HalfEdges<'s>,
    /// How thick walls are at most.
    reach: f64,
    chains: Vec<Chain>,
    /// For each half-edge its chain, or [`NONE`].
    chain_of: Vec<u32>,
    /// For each vertex the first one in the same place.
    places: Vec<u32>,
    /// For each region its chains, and its corners: the places of those on the border, and those
    /// within.
    borders: Vec<Vec<u32>>,
    corners: Vec<[Vec<u32>; 2]>,
    triangles: Vec<Vec<u32>>,
    /// For each region the other one of its pair, or [`NONE`].
    partner: Vec<u32>,
    /// Faces and their images, with the chains that correspond.
    pairs: Vec<Pair>,
    /// For each vertex its image, or [`NONE`].
    image: Vec<u32>,
    /// All vertices, the new ones last.
    positions: Vec<DVec3>,
}

/// A face and its image.
struct Pair {
    regions: [u32; 2],
    /// Within.
    corners: Vec<[u32; 2]>,
    chains: Vec<[u32; 2]>,
}

impl<'m, 's> Mirror<'m, 's> {
    fn new(mesh: &'m HalfEdges<'s>, reach: f64) -> Self {
        let count = mesh.regions.len();
        let mut mirror = Self {
            mesh,
            reach,
            chains: Vec::new(),
            chain_of: vec![NONE; mesh.end_of_halves() as usize],
            places: mesh.places(),
            borders: vec![Vec::new(); count],
            corners: vec![[Vec::new(), Vec::new()]; count],
            triangles: vec![Vec::new(); count],
            partner: vec![NONE; count],
            pairs: Vec::new(),
            image: vec![NONE; mesh.positions.len()],
            positions: mesh.positions.clone(),
        };
        for triangle in (0..mesh.triangle_count()).filter(|&t| !mesh.is_gone(t)) {
            mirror.triangles[mesh.region_index(triangle) as usize].push(triangle);
        }
        mirror.find_chains();
        mirror.find_corners();
        mirror
    }

    /// The half-edge of a face's border after another one.
    fn next_on_border(&self, half: u32) -> u32 {
        let mut half = next(half);
        while !self.mesh.is_feature(half) {
            half = next(self.mesh.twin(half));
        }
        half
    }

    fn beyond(&self, half: u32) -> u32 {
        self.mesh.region_index(triangle_of(self.mesh.twin(half)))
    }

    fn find_chains(&mut self) {
        let mesh = self.mesh;
        let starts_chain = |all: &Self, before: u32, half: u32| {
            mesh.kinds[mesh.origin(half) as usize] == Kind::Corner
                || all.beyond(before) != all.beyond(half)
        };
        let borders: Vec<u32> = mesh
            .halves()
            .filter(|&half| mesh.is_feature(half))
            .collect();
        let after: FxHashMap<u32, u32> = borders
            .iter()
            .map(|&half| (half, self.next_on_border(half)))
            .collect();
        let starts = after
            .iter()
            .filter(|&(&before, &half)| starts_chain(self, before, half));
        let mut starts: Vec<u32> = starts.map(|(_, &half)| half).collect();
        starts.sort_unstable();
        // What is left afterwards is closed.
        for half in starts.iter().copied().chain(borders) {
            if self.chain_of[half as usize] != NONE {
                continue;
            }
            let number = self.chains.len() as u32;
            let mut halves = Vec::new();
            let mut here = half;
            while self.chain_of[here as usize] == NONE
                && (here == half || starts.binary_search(&here).is_err())
            {
                self.chain_of[here as usize] = number;
                halves.push(here);
                here = after[&here];
            }
            let is_closed = here == half && starts.binary_search(&half).is_err();
            self.borders[mesh.region_index(triangle_of(half)) as usize].push(number);
            self.chains.push(Chain {
                other: self.beyond(half),
                halves,
                is_closed,
            });
        }
    }

    fn find_corners(&mut self) {
        let mesh = self.mesh;
        for (triangles, corners) in self.triangles.iter().zip(&mut self.corners) {
            let halves = triangles.iter().flat_map(|&triangle| halves_of(triangle));
            let halves = halves.map(|half| (mesh.origin(half), mesh.is_feature(half)));
            let is_corner = |&(v, _): &(u32, bool)| mesh.kinds[v as usize] == Kind::Corner;
            let halves: Vec<(u32, bool)> = halves.filter(is_corner).collect();
            let borders = halves.iter().filter(|(_, is_border)| *is_border);
            let border: FxHashSet<u32> = borders.map(|&(vertex, _)| vertex).collect();
            let within = halves.iter().filter(|(vertex, _)| !border.contains(vertex));
            let within = within.map(|&(vertex, _)| vertex).collect();
            let places = border.iter().map(|&vertex| self.places[vertex as usize]);
            *corners = [places.collect(), within];
            for corners in corners {
                corners.sort_unstable();
                corners.dedup();
            }
        }
    }

    /// Matches two faces, and from there on others beyond their borders that are no rims; or
    /// none of them if not all correspond.
    fn match_from(&mut self, seed: [u32; 2]) {
        let partner = |all: &Self, regions: [u32; 2]| regions.map(|r| all.partner[r as usize]);
        if partner(self, seed) != [NONE; 2] {
            return;
        }
        let known = self.pairs.len();
        let mut pending = vec![seed];
        while let Some(regions) = pending.pop() {
            if self.pairs[known..]
                .iter()
                .any(|pair| pair.regions == regions)
            {
                continue;
            }
            let is_new = partner(self, regions) == [NONE; 2];
            let Some(pair) = is_new.then(|| self.pair(regions)).flatten() else {
                for pair in self.pairs.drain(known..) {
                    for region in pair.regions {
                        self.partner[region as usize] = NONE;
                    }
                }
                return;
            };
            for chains in &pair.chains {
                let beyond = chains.map(|chain| self.chains[chain as usize].other);
                let is_between = beyond == [regions[1], regions[0]];
                if !self.is_rim(beyond) && !is_between {
                    pending.push(beyond);
                }
            }
            self.partner[regions[0] as usize] = regions[1];
            self.partner[regions[1] as usize] = regions[0];
            self.pairs.push(pair);
        }
    }

    /// Whether faces beyond both sides of a wall are of one surface.
    fn is_rim(&self, [one, other]: [u32; 2]) -> bool {
        let surface = |region: u32| self.mesh.regions[region as usize].surface;
        one == other || surface(one) == surface(other)
    }

    /// What of two faces corresponds; none if their borders do not.
    fn pair(&self, regions: [u32; 2]) -> Option<Pair> {
        let [one, other] = regions.map(|region| &self.mesh.regions[region as usize]);
        if one.surface == other.surface {
            return None;
        }
        let [border, within] = [0, 1].map(|k| {
            let [of_one, of_other] = regions.map(|region| &self.corners[region as usize][k]);
            self.nearest(of_one, of_other)
        });
        let [all_one, all_other] = regions.map(|region| &self.corners[region as usize]);
        let are_all = border.len() == all_one[0].len()
            && border.len() == all_other[0].len()
            && within.len() == all_other[1].len();
        if !are_all {
            return None;
        }
        let image: FxHashMap<u32, u32> = border.into_iter().map(|[a, b]| (a, b)).collect();
        let [of_one, of_other] = regions.map(|region| &self.borders[region as usize]);
        if of_one.len() != of_other.len() {
            return None;
        }
        let mut left: Vec<u32> = of_other.clone();
        let mut chains = Vec::new();
        for &chain in of_one {
            let matches = |&other: &u32| self.corresponds(chain, other, &image);
            let fits = left.iter().copied().filter(matches);
            let best = fits.min_by(|&a, &b| {
                let [a, b] = [a, b].map(|other| self.distance(chain, other));
                a.total_cmp(&b)
            })?;
            left.retain(|&other| other != best);
            chains.push([chain, best]);
        }
        Some(Pair {
            regions,
            corners: within,
            chains,
        })
    }

    /// Each place of one list with the nearest of the other, if that is so for both.
    fn nearest(&self, some: &[u32], others: &[u32]) -> Vec<[u32; 2]> {
        let nearest = |vertex: u32, of: &[u32]| {
            let at = self.mesh.at(vertex);
            let distance = |&v: &u32| self.mesh.at(v).distance_squared(at);
            of.iter()
                .copied()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let both = some.iter().filter_map(|&vertex| {
            let other = nearest(vertex, others)?;
            (nearest(other, some)? == vertex).then_some([vertex, other])
        });
        both.collect()
    }

    /// Whether chains run beside each other between the same corners, against each other.
    fn corresponds(&self, chain: u32, other: u32, image: &FxHashMap<u32, u32>) -> bool {
        let [chain, other] = [chain, other].map(|chain| &self.chains[chain as usize]);
        if !self.is_beside(chain, other) || !self.is_beside(other, chain) {
            return false;
        }
        if chain.is_closed || other.is_closed {
            return chain.is_closed == other.is_closed;
        }
        let places = |chain: &Chain| self.ends(chain).map(|end| self.places[end as usize]);
        let [ends, others] = [places(chain), places(other)];
        let images = ends.map(|end| image.get(&end).copied());
        images == [Some(others[1]), Some(others[0])]
    }

    /// The same edges, of the face beyond.
    fn twin(&self, chain: u32) -> u32 {
        let half = self.chains[chain as usize].halves[0];
        self.chain_of[self.mesh.twin(half) as usize]
    }

    fn ends(&self, chain: &Chain) -> [u32; 2] {
        let last = chain.halves[chain.halves.len() - 1];
        [self.mesh.origin(chain.halves[0]), self.mesh.target(last)]
    }

    /// How far the middle of a chain is from another one, less where both are along one
    /// surface; nothing if it is the same between the two faces.
    fn distance(&self, chain: u32, other: u32) -> f64 {
        if self.twin(chain) == other {
            return 0.0;
        }
        let [chain, other] = [chain, other].map(|chain| &self.chains[chain as usize]);
        let middle = chain.halves[chain.halves.len() / 2];
        let far = self.off(self.mesh.at(self.mesh.origin(middle)), other);
        if self.is_rim([chain.other, other.other]) {
            far
        } else {
            2.0 * far
        }
    }

    /// How far a place is from a chain.
    fn off(&self, at: DVec3, chain: &Chain) -> f64 {
        let far = chain.halves.iter().map(|&half| {
            let ends = [self.mesh.origin(half), self.mesh.target(half)];
            let [p, q] = ends.map(|v| self.mesh.at(v));
            let along = ((at - p).dot(q - p) / p.distance_squared(q)).clamp(0.0, 1.0);
            p.lerp(q, along).distance(at)
        });
        far.fold(f64::INFINITY, f64::min)
    }

    /// Whether the whole of a chain is no farther from another one than a wall is thick.
    fn is_beside(&self, chain: &Chain, other: &Chain) -> bool {
        let starts = chain.halves.iter().map(|&half| self.mesh.origin(half));
        starts
            .chain(self.ends(chain))
            .all(|vertex| self.off(self.mesh.at(vertex), other) <= self.reach)
    }

    /// Finds the images of all vertices.
    fn add_images(&mut self) -> Option<()> {
        let pairs = std::mem::take(&mut self.pairs);
        for pair in &pairs {
            for &[vertex, image] in &pair.corners {
                self.set_image(vertex, image)?;
            }
        }
        for pair in &pairs {
            for &chains in &pair.chains {
                self.add_images_of_chain(pair.regions, chains)?;
            }
        }
        for pair in &pairs {
            self.add_images_within(pair.regions)?;
        }
        self.pairs = pairs;
        Some(())
    }

    fn set_image(&mut self, vertex: u32, image: u32) -> Option<()> {
        let known = &mut self.image[vertex as usize];
        if *known == NONE {
            *known = image;
        }
        (*known == image).then_some(())
    }

    fn add_images_of_chain(&mut self, regions: [u32; 2], [chain, other]: [u32; 2]) -> Option<()> {
        let mesh = self.mesh;
        let [one, across] = [chain, other].map(|chain| &self.chains[chain as usize]);
        let vertices = one.halves.iter().map(|&half| mesh.origin(half));
        let vertices: Vec<u32> = vertices.skip(usize::from(!one.is_closed)).collect();
        if !one.is_closed {
            let [[from, to], [image_to, image_from]] = [one, across].map(|chain| self.ends(chain));
            self.set_image(from, image_from)?;
            self.set_image(to, image_to)?;
        }
        if self.twin(chain) == other {
            for vertex in vertices {
                self.set_image(vertex, vertex)?;
            }
            return Some(());
        }
        let across = self.chains[other as usize].other;
        let pair = [regions[1], across].map(|region| mesh.regions[region as usize].surface);
        if pair[0] == pair[1] {
            return None;
        }
        let pair = pair.map(|id| &mesh.surfaces[id]);
        for vertex in vertices {
            if self.image[vertex as usize] != NONE {
                continue;
            }
            let start = mesh.at(vertex);
            let reach = self.reach(start, regions[1]);
            let found = solve::sharp_common_point(&pair, start, reach, mesh.precision);
            if found.residual > mesh.precision {
                return None;
            }
            self.image[vertex as usize] = self.positions.len() as u32;
            self.positions.push(found.point);
        }
        Some(())
    }

    /// How far an image may be.
    fn reach(&self, at: DVec3, region: u32) -> f64 {
        let surface = &self.mesh.surfaces[self.mesh.regions[region as usize].surface];
        let off = surface.value(at).abs() / surface.gradient(at).length();
        4.0 * off + self.mesh.precision
    }

    fn add_images_within(&mut self, [one, other]: [u32; 2]) -> Option<()> {
        let mesh = self.mesh;
        let region = &mesh.regions[other as usize];
        let surface = &mesh.surfaces[region.surface];
        for &triangle in &self.triangles[one as usize] {
            for vertex in mesh.triangle(triangle) {
                if self.image[vertex as usize] == NONE {
                    let at = region.project(surface, mesh.at(vertex))?;
                    self.image[vertex as usize] = self.positions.len() as u32;
                    self.positions.push(at);
                }
            }
        }
        Some(())
    }

    /// The mesh with images in place of faces, and with rims that lead to these.
    fn put_together(&self, surfaced: &Surfaced) -> Option<Surfaced> {
        let mesh = self.mesh;
        let mut is_image = vec![false; mesh.regions.len()];
        // The chains of rims along images, with those that they are images of.
        let mut counterpart: FxHashMap<u32, u32> = FxHashMap::default();
        let mut rims: Vec<u32> = Vec::new();
        for pair in &self.pairs {
            is_image[pair.regions[1] as usize] = true;
        }
        for pair in &self.pairs {
            for &[chain, other] in &pair.chains {
                let beyond = self.chains[other as usize].other;
                let is_between = beyond == pair.regions[0];
                if !is_image[beyond as usize] && !is_between {
                    counterpart.insert(self.twin(other), chain);
                    rims.push(beyond);
                }
            }
        }
        rims.sort_unstable();
        rims.dedup();
        let mut made = Surfaced {
            positions: self.positions.clone(),
            borders: mesh.borders.clone(),
            ..surfaced.empty()
        };
        let add = |made: &mut Surfaced, corners: [u32; 3], region: usize| {
            made.triangles.push(corners);
            made.groups.push(mesh.regions[region].group);
        };
        for (region, triangles) in self.triangles.iter().enumerate() {
            let is_kept = !is_image[region] && rims.binary_search(&(region as u32)).is_err();
            for &triangle in triangles.iter().filter(|_| is_kept) {
                add(&mut made, mesh.triangle(triangle), region);
            }
        }
        for pair in &self.pairs {
            let [one, other] = pair.regions.map(|region| region as usize);
            for &triangle in &self.triangles[one] {
                let [a, b, c] = mesh.triangle(triangle).map(|v| self.image[v as usize]);
                add(&mut made, [a, c, b], other);
            }
        }
        for rim in rims {
            let triangles = self
                .strip(rim, &counterpart)
                .or_else(|| self.flat(rim, &counterpart))?;
            for corners in triangles {
                add(&mut made, corners, rim as usize);
            }
        }
        Some(made)
    }

    /// The triangles of a rim between chains that correspond.
    fn strip(&self, rim: u32, counterpart: &FxHashMap<u32, u32>) -> Option<Vec<[u32; 3]>> {
        let mesh = self.mesh;
        let chains = &self.borders[rim as usize];
        let originals = chains.iter().filter_map(|chain| counterpart.get(chain));
        let originals: Vec<u32> = originals.copied().collect();
        let is_end = |&&chain: &&u32| {
            let along = mesh.twin(self.chains[chain as usize].halves[0]);
            let is_original = originals.contains(&self.chain_of[along as usize]);
            !counterpart.contains_key(&chain) && !is_original
        };
        let mut ends = chains.iter().filter(is_end);
        let are_short = ends.all(|&end| self.chains[end as usize].halves.len() == 1);
        let originals = originals.iter().map(|&chain| &self.chains[chain as usize]);
        if !are_short || originals.clone().any(|original| original.other != rim) {
            return None;
        }
        let halves = originals.flat_map(|original| &original.halves);
        let mut triangles = Vec::new();
        for &half in halves {
            let [from, to] = [mesh.origin(half), mesh.target(half)];
            let [image_from, image_to] = [from, to].map(|v| self.image[v as usize]);
            if from != image_from {
                triangles.push([to, from, image_from]);
            }
            if to != image_to {
                triangles.push([to, image_from, image_to]);
            }
        }
        Some(triangles)
    }

    /// The triangles of a rim in a plane.
    fn flat(&self, rim: u32, counterpart: &FxHashMap<u32, u32>) -> Option<Vec<[u32; 3]>> {
        let mesh = self.mesh;
        let region = &mesh.regions[rim as usize];
        let surface = &mesh.surfaces[region.surface];
        let has_more = || !self.corners[rim as usize][1].is_empty();
        if region.bend != Bend::Flat || has_more() {
            return None;
        }
        let normal = region.outward * surface.linear;
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let named = |vertex: u32| -> Named {
            let at = self.positions[vertex as usize];
            (glam::DVec2::new(at.dot(x), at.dot(y)), vertex)
        };
        // The vertices of a chain without its end.
        let vertices = |chain: u32| -> Vec<u32> {
            match counterpart.get(&chain) {
                Some(&original) => {
                    let halves = self.chains[original as usize].halves.iter();
                    halves
                        .map(|&half| self.image[mesh.origin(half) as usize])
                        .collect()
                }
                None => {
                    let halves = self.chains[chain as usize].halves.iter();
                    halves.map(|&half| mesh.origin(half)).collect()
                }
            }
        };
        let mut done: FxHashSet<u32> = FxHashSet::default();
        let mut contours: Vec<Vec<Named>> = Vec::new();
        for &first in &self.borders[rim as usize] {
            let mut contour = Vec::new();
            let mut chain = first;
            while done.insert(chain) {
                contour.extend(vertices(chain).into_iter().map(named));
                let halves = &self.chains[chain as usize].halves;
                let after = self.next_on_border(halves[halves.len() - 1]);
                chain = self.chain_of[after as usize];
            }
            if !contour.is_empty() {
                contours.push(contour);
            }
        }
        triangulate(&contours, mesh.precision, &|| true, &mut Scratch::default())
    }
}
