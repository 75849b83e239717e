//! Polyhedra of many faces: their formula, and what is known of their edges.

use glam::DVec3;
use rayon::prelude::*;

use super::builder::Builder;
use super::{Context, Lowering, Value};
use crate::error::{Error, NodeFault, PolyhedronFault};
use crate::program::Bounds;
use crate::program::formula::{Literal, Operand, Operation};
use crate::program::halved::{Halved, Partition};
use crate::program::placed::{IsNeeded, Placed, Polyhedra, Region};
use crate::program::reach::reach;
use crate::program::unify::WorldMap;
use crate::solid::partition::{Child, Tree};
use crate::solid::{Plane, Polyhedron, Primitive};
use crate::surface::{Surface, SurfaceId};

/// Faces whose planes are put in place together. Tunes speed only.
const AT_ONCE: usize = 1 << 14;

impl Lowering<'_> {
    /// Leaves the value of a polyhedron on the stack.
    pub(super) fn lower_polyhedron(
        &mut self,
        primitive: &Primitive,
        polyhedron: &Polyhedron,
        context: Context,
    ) -> Result<(), Error> {
        let origin = self.add_origin(primitive, context);
        let map = self.maps[context.map as usize];
        let key = Context {
            negated: false,
            ..context
        };
        let key = (std::ptr::from_ref(primitive) as usize, key);
        let next = self.region_index.len() as u32;
        let region = *self.region_index.entry(key).or_insert(next);
        let operand = match &self.polyhedra {
            Polyhedra::Met(_) => {
                if region == next {
                    let met = self.place(polyhedron, &map, origin)?;
                    if let Polyhedra::Met(regions) = &mut self.polyhedra {
                        regions.push(met);
                    }
                }
                Operand::Constant(false)
            }
            Polyhedra::Outlined(placed) => {
                let literal = Literal {
                    surface: placed.surfaces.len() as u32 + region,
                    origin,
                    outside: context.negated,
                };
                self.builder.literal(literal)?
            }
            &Polyhedra::Written(placed, is_needed) => {
                self.write(placed, (region, is_needed), origin, context.negated)?
            }
        };
        let bounds = if context.negated {
            Bounds::EVERYTHING
        } else {
            reach(primitive, &map.map)
        };
        self.values.push(Value { operand, bounds });
        Ok(())
    }

    /// A polyhedron in place, its planes among the surfaces.
    fn place(
        &mut self,
        polyhedron: &Polyhedron,
        map: &WorldMap,
        origin: u32,
    ) -> Result<Region, Error> {
        let Polyhedron {
            vertices,
            triangles,
            faces,
            planes,
        } = polyhedron;
        // It may have been read from a file.
        let count = vertices.len();
        for (face, corners) in triangles.iter().enumerate() {
            let missing = corners.iter().find(|&&v| v as usize >= count);
            let missing = missing.copied().or(match faces.get(face) {
                Some(&face) if (face as usize) < planes.len() => None,
                _ => Some(u32::MAX),
            });
            if let Some(vertex) = missing {
                let fault = PolyhedronFault::NoSuchVertex {
                    face,
                    vertex,
                    vertices: count,
                };
                return Err(self.error(fault.into()));
            }
        }
        let out_of_range = NodeFault::OutOfRange {
            what: "the polyhedron under the maps above it",
        };
        let mut is_met = vec![false; planes.len()];
        let is_first = |&&face: &&u32| !std::mem::replace(&mut is_met[face as usize], true);
        let met: Vec<u32> = faces.iter().filter(is_first).copied().collect();
        // Of each face the surface, and whether that looks the other way.
        let mut placed = vec![(0, false); planes.len()];
        let placing = map.placing();
        let place = |&face: &u32| {
            let Plane { normal, offset } = planes[face as usize];
            let surface = placing(&Surface::plane(offset * normal, normal))?;
            Some((surface, surface.key()))
        };
        let mut surfaces = Vec::new();
        self.builder.table.reserve(planes.len());
        for some in met.chunks(AT_ONCE) {
            let all = some.par_iter().with_min_len(AT_ONCE / 16).map(place);
            all.collect_into_vec(&mut surfaces);
            for (&face, surface) in some.iter().zip(&surfaces) {
                let Some((surface, key)) = *surface else {
                    return Err(self.error(out_of_range));
                };
                placed[face as usize] = self.builder.table.insert_with_key(surface, key);
            }
        }
        let in_place: Vec<DVec3> = vertices
            .iter()
            .map(|&v| map.map.transform_point3(v))
            .collect();
        if !in_place.iter().all(|v| v.is_finite()) {
            return Err(self.error(out_of_range));
        }
        // A mirror turns triangles round, not planes.
        let is_mirrored = map.map.matrix3.determinant() < 0.0;
        let outward = |&[a, b, c]: &[u32; 3]| if is_mirrored { [c, b, a] } else { [a, b, c] };
        Ok(Region {
            vertices: in_place,
            triangles: triangles.iter().map(outward).collect(),
            surfaces: faces.iter().map(|&face| placed[face as usize]).collect(),
            origin,
        })
    }

    /// The formula of a polyhedron, or of what is outside of it.
    fn write(
        &mut self,
        placed: Placed<'_>,
        (number, is_needed): (u32, Option<IsNeeded<'_>>),
        origin: u32,
        negated: bool,
    ) -> Result<Operand, Error> {
        let region = &placed.regions[number as usize];
        let facets = region.facets(placed.surfaces);
        let partition = match is_needed {
            None => Partition::new(facets, &|_, _| true),
            Some(is_needed) => {
                Partition::new(facets, &|parts, ends| is_needed(number, parts, ends))
            }
        };
        self.gathered.slack = self.gathered.slack.max(partition.slack);
        let mut writer = Writer {
            builder: &mut self.builder,
            origin,
            negated,
            first_cut: placed.surfaces.len() as u32,
            literals: Vec::new(),
            cuts: &mut self.gathered.cuts,
        };
        let operand = writer.partition(&partition)?;
        let literals = writer.literals;
        self.gathered.are_walls = is_needed.is_some();
        let is_written = |surface: SurfaceId| {
            let written = literals.get(surface.index());
            written.is_some_and(|written| written.iter().any(Option::is_some))
        };
        let faces = region.triangles.iter().zip(&region.surfaces);
        let faces = faces.map(|(&corners, &(surface, _))| (corners, SurfaceId(surface)));
        let faces = faces.filter(|&(_, surface)| is_needed.is_none() || is_written(surface));
        self.gathered.add(region.vertices.iter().copied(), faces);
        Ok(operand)
    }
}

/// Writes a polyhedron, or what is outside of it, as a formula.
struct Writer<'a> {
    builder: &'a mut Builder,
    origin: u32,
    negated: bool,
    /// How many surfaces there are without cuts, which are those of the builder.
    first_cut: u32,
    /// Of each surface that for its inside, and that for its outside.
    literals: Vec<[Option<Operand>; 2]>,
    cuts: &'a mut Vec<SurfaceId>,
}

impl Writer<'_> {
    fn partition(&mut self, partition: &Partition) -> Result<Operand, Error> {
        let mut operands = Vec::with_capacity(7);
        for axis in 0..3 {
            let above = self.cut(axis, partition.low[axis], true)?;
            let below = self.cut(axis, partition.high[axis], false)?;
            operands.extend([above, below]);
        }
        let inner = self.halved(&partition.root)?;
        if inner == self.constant(false) {
            return Ok(inner);
        }
        if inner != self.constant(true) {
            operands.push(inner);
        }
        self.builder.gate(self.operation(Operation::And), &operands)
    }

    fn constant(&self, value: bool) -> Operand {
        Operand::Constant(value != self.negated)
    }

    fn operation(&self, operation: Operation) -> Operation {
        if self.negated {
            operation.dual()
        } else {
            operation
        }
    }

    fn literal(&mut self, surface: u32, outside: bool) -> Result<Operand, Error> {
        let outside = outside != self.negated;
        let index = surface as usize;
        if index >= self.literals.len() {
            let most = (self.first_cut as usize + self.builder.table.len()).max(index + 1);
            self.literals.resize(most, [None; 2]);
        }
        if let Some(known) = self.literals[index][usize::from(outside)] {
            return Ok(known);
        }
        let literal = self.builder.literal(Literal {
            surface,
            origin: self.origin,
            outside,
        })?;
        self.literals[index][usize::from(outside)] = Some(literal);
        Ok(literal)
    }

    /// The half-space below a coordinate along an axis, or above it.
    fn cut(&mut self, axis: usize, at: f64, above: bool) -> Result<Operand, Error> {
        let normal = DVec3::AXES[axis];
        let plane = Surface::plane(at * normal, normal);
        let Some(placed) = WorldMap::IDENTITY.apply(&plane) else {
            return Ok(self.constant(true));
        };
        let (cut, flipped) = self.builder.table.insert(placed);
        let surface = self.first_cut + cut;
        self.cuts.push(SurfaceId(surface));
        self.literal(surface, flipped != above)
    }

    fn pair(&mut self, operation: Operation, pair: [Operand; 2]) -> Result<Operand, Error> {
        let absorbing = self.constant(operation.absorbing());
        let neutral = self.constant(!operation.absorbing());
        match pair {
            [one, other] if one == absorbing || other == absorbing => Ok(absorbing),
            [rest, known] | [known, rest] if known == neutral => Ok(rest),
            pair => self.builder.gate(self.operation(operation), &pair),
        }
    }

    /// `inner` where a half-space holds, and `outer` where its complement does.
    fn choice(
        &mut self,
        [holds, fails]: [Operand; 2],
        [inner, outer]: [Operand; 2],
    ) -> Result<Operand, Error> {
        let [all, none] = [true, false].map(|value| self.constant(value));
        match [inner, outer] {
            [one, other] if one == other => Ok(one),
            [one, other] if other == none => self.pair(Operation::And, [holds, one]),
            [one, other] if one == none => self.pair(Operation::And, [fails, other]),
            [one, other] if one == all => self.pair(Operation::Or, [holds, other]),
            [one, other] if other == all => self.pair(Operation::Or, [fails, one]),
            [one, other] => {
                let one = self.pair(Operation::And, [holds, one])?;
                let other = self.pair(Operation::And, [fails, other])?;
                self.pair(Operation::Or, [one, other])
            }
        }
    }

    /// Recursion is as deep as boxes are halved.
    fn halved(&mut self, halved: &Halved) -> Result<Operand, Error> {
        match halved {
            Halved::Constant(value) => Ok(self.constant(*value)),
            Halved::Faces(tree) => self.tree(tree),
            Halved::Cut(axis, at, halves) => {
                let below = self.halved(&halves[0])?;
                let above = self.halved(&halves[1])?;
                if below == above {
                    return Ok(below);
                }
                let cuts = [self.cut(*axis, *at, false)?, self.cut(*axis, *at, true)?];
                self.choice(cuts, [below, above])
            }
        }
    }

    fn tree(&mut self, tree: &Tree) -> Result<Operand, Error> {
        let mut values: Vec<Operand> = vec![self.constant(false); tree.nodes.len()];
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let (surface, flipped) = (node.face / 2, node.face % 2 == 1);
            let value = |child: Child| match child {
                Child::Node(index) => values[index],
                Child::Inside => self.constant(true),
                Child::Outside => self.constant(false),
            };
            let children = [value(node.back), value(node.front)];
            let sides = [
                self.literal(surface, flipped)?,
                self.literal(surface, !flipped)?,
            ];
            values[index] = self.choice(sides, children)?;
        }
        Ok(values.first().copied().unwrap_or(self.constant(false)))
    }
}
