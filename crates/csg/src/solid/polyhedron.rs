//! Closed polyhedra from vertices and faces.
//!
//! Faces are checked and put on planes. Of few faces these are combined: a convex
//! polyhedron is the intersection of its half-spaces; any other is cut by the
//! planes of its own faces until nothing is left on either side (W. C. Thibault,
//! B. F. Naylor, "Set operations on polyhedra using binary space partitioning
//! trees", 1987), and that tree read as a formula. Of many faces the polyhedron is
//! a primitive, so that lowering can do the same in small boxes.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use smallvec::{SmallVec, smallvec};

use super::partition::{Facet, Tree};
use super::primitive::{Plane, Polyhedron, Primitive};
use super::profile::Profile;
use super::tree::Solid;
use crate::error::{NodeFault, PolyhedronFault};
use crate::mesh::Mesh;
use crate::numeric::tolerance::{NO_AREA, NO_VOLUME, ON_FACE, SAME_FACE};

/// The most faces: what is held of them while a boundary is evaluated takes some kilobytes
/// each.
const MOST_FACES: usize = 4_000_000;

/// The most faces of which a formula of half-spaces is made, and of which convex parts are:
/// time grows with the square of their number, or faster.
pub(crate) const FEW_FACES: usize = 48;
const MOST_FACES_IN_PARTS: usize = 20_000;

impl Solid {
    /// The solid that faces bound: closed, each listing the indices of its
    /// corners counter-clockwise seen from outside. A face whose corners do not
    /// lie in a plane is cut into triangles; faces without area are passed
    /// over. Vertices at the same place are one.
    ///
    /// Lowering reports faces that are open, inside out or run through each
    /// other, with their numbers and places. Takes n log n steps for n faces, and
    /// so does what is made of it; refused beyond 4,000,000.
    #[must_use]
    pub fn polyhedron<P: Into<DVec3>, F: AsRef<[u32]>>(
        vertices: impl IntoIterator<Item = P>,
        faces: impl IntoIterator<Item = F>,
    ) -> Self {
        let vertices: Vec<DVec3> = vertices.into_iter().map(Into::into).collect();
        let made = Faces::new(vertices, faces).and_then(|faces| {
            faces.check()?;
            Ok(faces.solid())
        });
        Self::made_of_points("polyhedron", made.map_err(NodeFault::from))
    }

    /// The same of a mesh that is known to be closed, to enclose a volume and not to run
    /// through itself.
    pub(super) fn of_checked(mesh: &Mesh, volume: f64) -> Self {
        let made = Faces::new(mesh.positions.clone(), &mesh.triangles).and_then(|faces| {
            faces.enclose(volume)?;
            Ok(faces.solid())
        });
        Self::made_of_points("polyhedron", made.map_err(NodeFault::from))
    }

    /// The same, the first faces on planes that are known better than by their corners; none if
    /// the faces bound no solid.
    pub(super) fn of_faces(
        vertices: Vec<DVec3>,
        faces: &[Vec<u32>],
        planes: &[Option<Plane>],
    ) -> Option<Self> {
        let mut faces = Faces::new(vertices, faces).ok()?;
        faces.check().ok()?;
        faces.planes = planes.to_vec();
        Some(faces.solid().0)
    }

    /// Convex polyhedra that do not overlap and make up the solid that a mesh
    /// bounds, each as its planes.
    ///
    /// # Errors
    /// As with [`Solid::polyhedron`].
    pub fn convex_parts(mesh: &Mesh) -> Result<Vec<Vec<Plane>>, NodeFault> {
        most(mesh.triangles.len(), MOST_FACES_IN_PARTS)?;
        let faces = Faces::new(mesh.positions.clone(), &mesh.triangles)?;
        Ok(match faces.convex() {
            Some(planes) => vec![planes],
            None => faces.tree().cells(),
        })
    }
}

impl Mesh {
    /// The triangles that make up polygons, each given by the indices of its
    /// corners, seen along its normal: ears cut off, so that a polygon need not
    /// be convex. `None` if a polygon names a vertex that does not exist.
    #[must_use]
    pub fn from_polygons<F: AsRef<[u32]>>(
        positions: Vec<DVec3>,
        polygons: impl IntoIterator<Item = F>,
    ) -> Option<Self> {
        let mut triangles = Vec::new();
        for polygon in polygons {
            let corners = polygon.as_ref();
            let place = |&corner: &u32| positions.get(corner as usize).copied();
            let points: Option<Vec<DVec3>> = corners.iter().map(place).collect();
            let cut = triangles_of(&points?).into_iter();
            triangles.extend(cut.map(|triangle| triangle.map(|k| corners[k])));
        }
        Some(Self::new(positions, triangles))
    }
}

/// Faces on planes.
struct Faces {
    vertices: Vec<DVec3>,
    /// Triangles or flat polygons, each with the number of the face given.
    faces: Vec<(Corners, u32)>,
    /// Of the first faces given, as far as they are known better than by their corners.
    planes: Vec<Option<Plane>>,
    size: f64,
}

/// The corners of a face: most have three.
type Corners = SmallVec<[u32; 4]>;
type Points = SmallVec<[DVec3; 4]>;

impl Faces {
    fn new<F: AsRef<[u32]>>(
        vertices: Vec<DVec3>,
        faces: impl IntoIterator<Item = F>,
    ) -> Result<Self, PolyhedronFault> {
        let far = |v: &DVec3| v.is_nan() || v.abs().max_element() >= 1e100;
        if let Some(vertex) = vertices.iter().position(far) {
            return Err(PolyhedronFault::NotFinite { vertex });
        }
        let same = same_places(&vertices);
        let size = vertices
            .iter()
            .map(|v| v.abs().max_element())
            .fold(0.0, f64::max);
        let faces = faces.into_iter();
        let mut result = Self {
            vertices,
            faces: Vec::with_capacity(faces.size_hint().0.min(MOST_FACES)),
            planes: Vec::new(),
            size,
        };
        let mut given = 0;
        for (face, corners) in faces.enumerate() {
            given = face + 1;
            if given > MOST_FACES {
                continue;
            }
            let mut named = Corners::new();
            for &corner in corners.as_ref() {
                let Some(&vertex) = same.get(corner as usize) else {
                    return Err(PolyhedronFault::NoSuchVertex {
                        face,
                        vertex: corner,
                        vertices: same.len(),
                    });
                };
                named.push(vertex);
            }
            named.dedup();
            while named.len() > 1 && named.first() == named.last() {
                named.pop();
            }
            if named.len() >= 3 {
                result.add(named, face as u32);
            }
        }
        most(given, MOST_FACES)?;
        Ok(result)
    }

    fn add(&mut self, corners: Corners, face: u32) {
        if corners.len() == 3 {
            self.faces.push((corners, face));
            return;
        }
        let points = self.points(&corners);
        let is_flat = plane_of(&points).is_none_or(|plane| {
            let off = |p: &DVec3| (plane.normal.dot(*p) - plane.offset).abs();
            points.iter().all(|p| off(p) <= ON_FACE * self.size)
        });
        if is_flat {
            self.faces.push((corners, face));
            return;
        }
        for triangle in triangles_of(&points) {
            self.faces
                .push((triangle.map(|k| corners[k]).into_iter().collect(), face));
        }
    }

    fn points(&self, corners: &[u32]) -> Points {
        corners.iter().map(|&i| self.vertices[i as usize]).collect()
    }

    fn check(&self) -> Result<(), PolyhedronFault> {
        let mut balance: FxHashMap<(u32, u32), (i32, u32)> = FxHashMap::default();
        for (corners, face) in &self.faces {
            let next = corners.iter().cycle().skip(1);
            for (&a, &b) in corners.iter().zip(next) {
                let (key, sign) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                balance.entry(key).or_insert((0, *face)).0 += sign;
            }
        }
        let open = balance.iter().filter(|(_, (sum, _))| *sum != 0);
        if let Some((&(a, b), &(_, face))) = open.min_by_key(|(edge, (_, face))| (*face, **edge)) {
            let edge = [a, b].map(|i| self.vertices[i as usize]);
            let face = face as usize;
            return Err(PolyhedronFault::Open { face, edge });
        }
        let (mesh, owners) = self.mesh();
        self.enclose(mesh.volume())?;
        let crossings = mesh.self_intersections();
        let real = |pair: &&[u32; 2]| owners[pair[0] as usize] != owners[pair[1] as usize];
        if let Some(pair) = crossings.iter().find(real) {
            return Err(PolyhedronFault::Crossing {
                faces: pair.map(|t| owners[t as usize] as usize),
                place: mesh.corners(pair[0] as usize)[0],
            });
        }
        if let Some(triangle) = mesh.misplaced() {
            return Err(PolyhedronFault::Misplaced {
                face: owners[triangle as usize] as usize,
                place: mesh.corners(triangle as usize)[0],
            });
        }
        Ok(())
    }

    /// That faces enclose so much makes them the boundary of a solid.
    fn enclose(&self, volume: f64) -> Result<(), PolyhedronFault> {
        if volume < 0.0 {
            return Err(PolyhedronFault::InsideOut);
        }
        if volume <= NO_VOLUME * self.size.powi(3) {
            return Err(PolyhedronFault::Degenerate);
        }
        Ok(())
    }

    /// All faces as triangles, and whose they are.
    fn mesh(&self) -> (Mesh, Vec<u32>) {
        let mut triangles = Vec::new();
        let mut owners = Vec::new();
        for (corners, face) in &self.faces {
            for triangle in triangles_of(&self.points(corners)) {
                triangles.push(triangle.map(|k| corners[k]));
                owners.push(*face);
            }
        }
        (Mesh::new(self.vertices.clone(), triangles), owners)
    }

    fn solid(&self) -> (Solid, Vec<DVec3>) {
        let mut is_used = vec![false; self.vertices.len()];
        for &corner in self.faces.iter().flat_map(|(corners, _)| corners) {
            is_used[corner as usize] = true;
        }
        let used = self.vertices.iter().zip(is_used);
        let used = used.filter_map(|(&vertex, is_used)| is_used.then_some(vertex));
        let solid = if self.faces.len() > FEW_FACES {
            Solid::primitive(Primitive::Polyhedron(Arc::new(self.polyhedron())))
        } else if let Some(planes) = self.convex() {
            Solid::convex_polyhedron(planes)
        } else {
            self.tree().solid()
        };
        (solid, used.collect())
    }

    /// All faces with planes of their own.
    fn polyhedron(&self) -> Polyhedron {
        let count = self.faces.len();
        let mut triangles = Vec::with_capacity(count);
        let mut faces = Vec::with_capacity(count);
        let mut planes = Vec::with_capacity(count);
        for (corners, given) in &self.faces {
            let points = self.points(corners);
            let known = self.planes.get(*given as usize).copied().flatten();
            let face = plane_of(&points).map_or(NO_FACE, |plane| {
                let plane = known.unwrap_or(plane);
                planes.push(plane);
                planes.len() as u32 - 1
            });
            if let &[a, b, c] = &corners[..] {
                triangles.push([a, b, c]);
                faces.push(face);
                continue;
            }
            for triangle in triangles_of(&points) {
                let flat = plane_of(&triangle.map(|k| points[k])).is_none();
                triangles.push(triangle.map(|k| corners[k]));
                faces.push(if flat { NO_FACE } else { face });
            }
        }
        flip_flat(&self.vertices, &mut triangles, &mut faces);
        Polyhedron {
            vertices: self.vertices.clone(),
            triangles,
            faces,
            planes,
        }
    }

    /// The planes, if all vertices are behind or on each.
    fn convex(&self) -> Option<Vec<Plane>> {
        let mut planes: Vec<Plane> = Vec::new();
        let slack = ON_FACE * self.size;
        for (corners, _) in &self.faces {
            let Some(plane) = plane_of(&self.points(corners)) else {
                continue;
            };
            for (corners, _) in &self.faces {
                for &i in corners {
                    if plane.normal.dot(self.vertices[i as usize]) - plane.offset > slack {
                        return None;
                    }
                }
            }
            planes.push(plane);
        }
        Some(planes)
    }

    fn tree(&self) -> Tree {
        let facets = (0..).zip(&self.faces).filter_map(|(face, (corners, _))| {
            let points = self.points(corners);
            let plane = plane_of(&points)?;
            Some(Facet {
                face,
                plane,
                corners: points.into_iter().collect(),
            })
        });
        let facets: Vec<Facet> = facets.collect();
        Tree::of(&facets, SAME_FACE * self.size)
    }
}

/// Of each vertex the first one at the same place.
pub(super) fn same_places(vertices: &[DVec3]) -> Vec<u32> {
    let mut places: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    places.reserve(vertices.len());
    (0..)
        .zip(vertices)
        .map(|(index, vertex)| {
            // Adding zero makes -0 and 0 the same.
            let key = vertex.to_array().map(|c| (c + 0.0).to_bits());
            *places.entry(key).or_insert(index)
        })
        .collect()
}

impl From<PolyhedronFault> for NodeFault {
    fn from(fault: PolyhedronFault) -> Self {
        Self::Polyhedron(Box::new(fault))
    }
}

fn most(faces: usize, limit: usize) -> Result<(), PolyhedronFault> {
    if faces > limit {
        return Err(PolyhedronFault::TooManyFaces { faces, limit });
    }
    Ok(())
}

/// The face of triangles without area.
const NO_FACE: u32 = u32::MAX;

/// Takes triangles without area away: their longest edge is flipped, so that they and the
/// neighbour there become two parts of the neighbour.
fn flip_flat(vertices: &[DVec3], triangles: &mut Vec<[u32; 3]>, faces: &mut Vec<u32>) {
    let mut pending: Vec<u32> = (0..triangles.len() as u32)
        .filter(|&t| faces[t as usize] == NO_FACE)
        .collect();
    if pending.is_empty() {
        return;
    }
    let mut beside: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    for (index, &triangle) in (0u32..).zip(&*triangles) {
        beside.extend(sides(triangle).map(|side| (side, index)));
    }
    // Chains of them are passed on; more steps than that would go round in circles.
    let mut left = 16 * pending.len();
    while let Some(flat) = pending.pop() {
        if left == 0 {
            break;
        }
        left -= 1;
        let at = |v: u32| vertices[v as usize];
        let length = |[a, b]: &[u32; 2]| at(*a).distance_squared(at(*b));
        let corners = triangles[flat as usize];
        let longest = sides(corners)
            .into_iter()
            .max_by(|s, t| length(s).total_cmp(&length(t)));
        let Some([a, c]) = longest else { continue };
        let Some(&b) = corners.iter().find(|&&v| v != a && v != c) else {
            continue;
        };
        let Some(&other) = beside.get(&[c, a]) else {
            continue;
        };
        let Some(&d) = triangles[other as usize]
            .iter()
            .find(|&&v| v != a && v != c)
        else {
            continue;
        };
        if d == b || other == flat {
            // Two of them back to back.
            continue;
        }
        let face = faces[other as usize];
        for (index, triangle) in [(flat, [b, a, d]), (other, [c, b, d])] {
            triangles[index as usize] = triangle;
            let points = triangle.map(at);
            faces[index as usize] = if plane_of(&points).is_none() {
                pending.push(index);
                NO_FACE
            } else {
                face
            };
            beside.extend(sides(triangle).map(|side| (side, index)));
        }
    }
    let mut is_kept = faces.iter().map(|&face| face != NO_FACE);
    triangles.retain(|_| is_kept.next().unwrap_or(false));
    faces.retain(|&face| face != NO_FACE);
}

/// The plane of a polygon (M. E. Newell's method, about its middle), with a
/// unit normal; none if it has no area to speak of.
pub(super) fn plane_of(points: &[DVec3]) -> Option<Plane> {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut normal = DVec3::ZERO;
    let mut longest: f64 = 0.0;
    let mut a = points.last().copied()?;
    for &b in points {
        normal += (a - middle).cross(b - middle);
        longest = longest.max(a.distance_squared(b));
        a = b;
    }
    if normal.length() <= NO_AREA * longest {
        return None;
    }
    let normal = normal.normalize();
    Some(Plane::through(middle, normal))
}

/// Triangles that make up a polygon, seen along its normal: ears cut off.
pub(super) fn triangles_of(points: &[DVec3]) -> SmallVec<[[usize; 3]; 2]> {
    if points.len() == 3 {
        return smallvec![[0, 1, 2]];
    }
    let Some(plane) = plane_of(points) else {
        return (2..points.len()).map(|k| [0, k - 1, k]).collect();
    };
    let (x, y) = plane.normal.any_orthonormal_pair();
    let (x, y) = if x.cross(y).dot(plane.normal) > 0.0 {
        (x, y)
    } else {
        (y, x)
    };
    let flat: Vec<DVec2> = points
        .iter()
        .map(|p| DVec2::new(p.dot(x), p.dot(y)))
        .collect();
    Profile::ears(&flat).into()
}
