//! What a mesh file says: its mesh, unit and objects, and the solid that these are.

use std::f64::consts::TAU;
use std::ops::Range;

use csg::{LengthUnit, Mesh, MeshFaults, Repairs, Solid, elementary};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::assemble::Assembled;
use crate::units;

/// How many pairs of objects, one in the box around the other, are looked at.
const MOST_NESTED: usize = 256;

/// What a mesh file says ([`read_mesh_file`](crate::read_mesh_file)).
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeshFile {
    /// All triangles.
    pub mesh: Mesh,
    /// The triangles of each object, one after the other: a mesh in one of its places (3MF,
    /// glTF), or what follows a line `o` (OBJ). Of other formats there is one.
    pub objects: Vec<Range<usize>>,
    /// Whether the file says its unit. Where it does not, the mesh's is the millimetre, and the
    /// numbers may be of any other.
    pub has_unit: bool,
    /// What was left out that somebody might miss: materials of an OBJ file in another folder.
    pub warnings: Vec<String>,
}

impl MeshFile {
    pub(crate) fn new(read: Assembled, has_unit: bool, warnings: Vec<String>) -> Self {
        let Assembled { mesh, objects } = read;
        let count = mesh.triangles.len();
        let firsts = objects.iter().copied();
        let ends = objects.iter().skip(1).copied().chain([count]);
        let objects = match objects.len() {
            0 => vec![0..count; 1],
            _ => firsts.zip(ends).map(|(first, end)| first..end).collect(),
        };
        Self {
            mesh,
            objects,
            has_unit,
            warnings,
        }
    }

    /// The same with lengths in `unit`: converted from the file's, or as they are where it has
    /// none.
    #[must_use]
    pub fn in_unit(mut self, unit: LengthUnit) -> Self {
        if self.has_unit {
            units::convert(&mut self.mesh, unit);
        } else {
            self.mesh.unit = unit;
        }
        self
    }

    /// The same with lengths in `unit` where the file has none.
    #[must_use]
    pub fn or_in(self, unit: LengthUnit) -> Self {
        let unit = if self.has_unit { self.mesh.unit } else { unit };
        self.in_unit(unit)
    }

    /// The same with all triangles turned round.
    #[must_use]
    pub fn turned(mut self) -> Self {
        for triangle in &mut self.mesh.triangles {
            triangle.reverse();
        }
        for normals in &mut self.mesh.corner_normals {
            normals.reverse();
            *normals = normals.map(|normal| -normal);
        }
        self
    }

    /// The solid that the mesh bounds ([`Solid::from_mesh`]), in [`Mesh::unit`]. Objects that
    /// bound solids and touch, overlap or lie in each other are united.
    ///
    /// # Errors
    /// All that is wrong with the mesh as a whole, if it bounds no solid and its objects do not,
    /// either.
    pub fn solid(&self) -> Result<Solid, Box<MeshFaults>> {
        let whole = Solid::from_mesh(&self.mesh);
        let pairs = self.box_pairs();
        let is_whole = match whole {
            Ok(_) => self.nested(&pairs).is_none(),
            Err(_) => pairs.is_empty(),
        };
        if is_whole {
            return whole;
        }
        let solids = self.objects.iter().map(|object| {
            let solid = Solid::from_mesh(&self.part([object]));
            solid.ok()
        });
        match solids.collect::<Option<Vec<_>>>() {
            Some(solids) => Ok(Solid::union(solids)),
            None => whole,
        }
    }

    /// The solid that the mesh bounds once it is mended ([`Solid::repaired`]), and what was
    /// changed; nothing where [`MeshFile::solid`] gives one.
    ///
    /// # Errors
    /// As [`Solid::repaired`].
    pub fn repaired(&self) -> Result<(Solid, Repairs), Box<MeshFaults>> {
        match self.solid() {
            Ok(solid) => Ok((solid, Repairs::default())),
            Err(_) => Solid::repaired(&self.mesh),
        }
    }

    /// Two objects, by their numbers from 0, that touch along faces, overlap or lie in each
    /// other: volumes and areas of the mesh count twice what both have.
    #[must_use]
    pub fn meeting_objects(&self) -> Option<[usize; 2]> {
        let pairs = self.box_pairs();
        let mut of: Vec<usize> = pairs.iter().flatten().copied().collect();
        of.sort_unstable();
        of.dedup();
        let objects: Vec<&Range<usize>> = of.iter().map(|&object| &self.objects[object]).collect();
        // The number of the object that each triangle of the part is of.
        let owners: Vec<usize> = of
            .iter()
            .zip(&objects)
            .flat_map(|(&object, range)| std::iter::repeat_n(object, range.len()))
            .collect();
        let crossings = self.part(objects).self_intersections();
        let owners = crossings
            .into_iter()
            .map(|pair| pair.map(|triangle| owners[triangle as usize]));
        let crossing = owners.into_iter().find(|[one, other]| one != other);
        crossing.or_else(|| self.nested(&pairs))
    }

    /// Two objects, one in the other, both facing outwards.
    fn nested(&self, pairs: &[[usize; 2]]) -> Option<[usize; 2]> {
        let boxes: Vec<_> = self
            .objects
            .iter()
            .map(|object| self.bounds(object))
            .collect();
        let nested = pairs.iter().filter_map(|&[one, other]| {
            let holds = |outer: usize, inner: usize| {
                let ((low, high), (from, to)) = (boxes[outer]?, boxes[inner]?);
                (low.cmple(from).all() && high.cmpge(to).all()).then_some([outer, inner])
            };
            holds(one, other).or_else(|| holds(other, one))
        });
        nested.take(MOST_NESTED).find(|&[outer, inner]| {
            let [outer, inner] = [outer, inner].map(|object| &self.objects[object]);
            let point = self.mesh.corners(inner.start)[0];
            let six_volumes: f64 = inner
                .clone()
                .map(|triangle| {
                    let [a, b, c] = self.mesh.corners(triangle).map(|corner| corner - point);
                    a.dot(b.cross(c))
                })
                .sum();
            six_volumes > 0.0 && windings(&self.mesh, outer, point) > 0.5
        })
    }

    /// Pairs of objects with boxes that have points in common.
    fn box_pairs(&self) -> Vec<[usize; 2]> {
        if self.objects.len() < 2 {
            return Vec::new();
        }
        let bounds = |object: usize| Some((object, self.bounds(&self.objects[object])?));
        let mut boxes: Vec<_> = (0..self.objects.len()).filter_map(bounds).collect();
        boxes.sort_by(|(_, (a, _)), (_, (b, _))| a.x.total_cmp(&b.x));
        let mut pairs = Vec::new();
        for (number, &(one, (low, high))) in boxes.iter().enumerate() {
            let later = boxes[number + 1..].iter();
            let near = later.take_while(|(_, (from, _))| from.x <= high.x);
            let meeting =
                near.filter(|(_, (from, to))| low.cmple(*to).all() && from.cmple(high).all());
            pairs.extend(meeting.map(|&(other, _)| [one.min(other), one.max(other)]));
        }
        pairs.sort_unstable();
        pairs
    }

    /// The box around some triangles.
    fn bounds(&self, object: &Range<usize>) -> Option<(DVec3, DVec3)> {
        let corners = object
            .clone()
            .flat_map(|triangle| self.mesh.corners(triangle));
        corners.fold(None, |bounds, corner| {
            let (low, high) = bounds.unwrap_or((corner, corner));
            Some((low.min(corner), high.max(corner)))
        })
    }

    /// Some of the objects, without anything that says how they look.
    fn part<'a>(&self, objects: impl IntoIterator<Item = &'a Range<usize>>) -> Mesh {
        let mut numbers = FxHashMap::default();
        let mut part = Mesh {
            unit: self.mesh.unit,
            ..Mesh::default()
        };
        for object in objects {
            // (Objects may share vertices.)
            numbers.clear();
            for &triangle in &self.mesh.triangles[object.clone()] {
                let corners = triangle.map(|corner| {
                    *numbers.entry(corner).or_insert_with(|| {
                        part.positions.push(self.mesh.positions[corner as usize]);
                        part.positions.len() as u32 - 1
                    })
                });
                part.triangles.push(corners);
            }
        }
        part
    }
}

/// How often closed triangles wind around a point that is not on them (A. van Oosterom,
/// J. Strackee, "The Solid Angle of a Plane Triangle", 1983).
fn windings(mesh: &Mesh, triangles: &Range<usize>, point: DVec3) -> f64 {
    let angles = triangles.clone().into_par_iter().map(|triangle| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - point);
        let lengths = [a.length(), b.length(), c.length()];
        let over = lengths[0] * lengths[1] * lengths[2]
            + a.dot(b) * lengths[2]
            + b.dot(c) * lengths[0]
            + c.dot(a) * lengths[1];
        elementary::atan2(a.dot(b.cross(c)), over)
    });
    angles.sum::<f64>() / TAU
}
