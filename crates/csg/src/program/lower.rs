//! Lowering: from a tree of transformed primitives to surfaces and a formula.
//!
//! One iterative walk carries the accumulated map, name, colour and polarity
//! downwards (negation is pushed to the literals, so a difference is an
//! intersection whose later operands are walked negated) and values upwards.
//! Nested operations of one kind are flattened on the way: their values are
//! left on the value stack for the operation above. Subtrees that occur more
//! than once are remembered per map, name, colour and polarity.

mod builder;
mod polyhedron;

pub(super) use self::builder::{avalanche, simplified};

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use self::builder::{Builder, compact, push_index};
use super::formula::{Formula, Literal, Operand, Operation};
use super::given::Gathered;
use super::local::{LocalShape, half_spaces};
use super::lowered::{Lowered, Origin};
use super::placed::{Convex, Polyhedra, Region};
use super::reach::reach;
use super::unify::WorldMap;
use super::{Bounds, Surface, SurfaceId};
use crate::color::Color;
use crate::error::{Error, NodeFault, NodePath, PathStep};
use crate::numeric::tolerance::MAPPED;
use crate::solid::{Made, Node, Primitive, Solid};

/// What lowering a solid for the first time comes to.
pub(super) enum First {
    /// It has no polyhedra of many faces.
    Lowered(Lowered),
    /// These, the other primitives, and the surfaces of all.
    Placed(Vec<Region>, Vec<Convex>, Vec<Surface>),
}

impl First {
    /// # Errors
    /// Those of [`super::Program::lower`].
    pub fn of(solid: &Solid) -> Result<Self, Error> {
        let mut lowering = Lowering::new(solid, Polyhedra::Met(Vec::new()));
        lowering.walk(solid)?;
        Ok(match &mut lowering.polyhedra {
            Polyhedra::Met(regions) if !regions.is_empty() => {
                let surfaces = lowering.builder.table.into_surfaces();
                Self::Placed(std::mem::take(regions), lowering.others, surfaces)
            }
            _ => Self::Lowered(lowering.finish().lowered),
        })
    }
}

/// What lowering comes to.
pub(super) struct Finished {
    pub lowered: Lowered,
    /// Where faces are left out, of each surface its number among all.
    pub ids: Vec<u32>,
}

impl Finished {
    pub const NOTHING: Self = Self {
        lowered: Lowered::NOTHING,
        ids: Vec::new(),
    };
}

/// A solid whose primitives are in place, with its polyhedra dealt with in one of the ways.
pub(super) fn lowered_with(solid: &Solid, polyhedra: Polyhedra<'_>) -> Result<Finished, Error> {
    let mut lowering = Lowering::new(solid, polyhedra);
    lowering.walk(solid)?;
    Ok(lowering.finish())
}

/// A name, and those around it.
#[derive(Clone, Default)]
struct Named {
    name: Option<Arc<str>>,
    parts: Arc<[Arc<str>]>,
}

/// A chain of a million names must not be kept whole for each of them.
const MOST_PARTS: usize = 15;

/// What a subtree inherits from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Context {
    /// Index of the accumulated map, name and colour.
    map: u32,
    name: u32,
    color: u32,
    negated: bool,
}

/// What a subtree comes to.
#[derive(Clone, Copy)]
struct Value {
    operand: Operand,
    /// A box around its points.
    bounds: Bounds,
}

impl Value {
    const NOTHING: Self = Self {
        operand: Operand::Constant(false),
        bounds: Bounds::NOTHING,
    };

    fn combined(
        builder: &mut Builder,
        operation: Operation,
        values: &[Self],
    ) -> Result<Self, Error> {
        let operands: Vec<Operand> = values.iter().map(|value| value.operand).collect();
        let bounds = values.iter().map(|value| value.bounds);
        Ok(Self {
            operand: builder.combine(operation, operands)?,
            bounds: match operation {
                Operation::And => bounds.fold(Bounds::EVERYTHING, Bounds::intersected),
                Operation::Or => bounds.fold(Bounds::NOTHING, Bounds::united),
            },
        })
    }
}

/// One node on the way from the root to the current one.
struct Frame<'a> {
    solid: &'a Solid,
    context: Context,
    /// Which operand to visit next.
    next: usize,
    /// Which operand of the frame below this one is.
    operand: usize,
    /// The operation that the values above `base` are to be combined by, and
    /// whether the frame below does that because it is the same one.
    operation: Option<Operation>,
    merged: bool,
    base: usize,
}

struct Lowering<'a> {
    frames: Vec<Frame<'a>>,
    values: Vec<Value>,
    maps: Vec<WorldMap>,
    map_index: FxHashMap<[u64; 12], u32>,
    /// Names and colours met so far; the first of each is "none".
    names: Vec<Named>,
    /// By the number of what is around it, and the name.
    name_index: FxHashMap<(u32, Arc<str>), u32>,
    colors: Vec<Option<Color>>,
    color_index: FxHashMap<[u32; 4], u32>,
    /// Where on the stack the outermost node is that a function made of primitives, and how many
    /// such there were.
    body: Option<usize>,
    bodies: u32,
    /// Nodes that occur more than once in the tree.
    repeated: FxHashSet<usize>,
    known: FxHashMap<(usize, Context), Value>,
    builder: Builder,
    polyhedra: Polyhedra<'a>,
    /// Of the polyhedra met so far, by their primitives and contexts, the numbers.
    region_index: FxHashMap<(usize, Context), u32>,
    /// The edges and vertices of polyhedra.
    gathered: Gathered,
    /// The other primitives, and how many were met.
    others: Vec<Convex>,
    others_met: usize,
}

impl<'a> Lowering<'a> {
    fn new(root: &'a Solid, polyhedra: Polyhedra<'a>) -> Self {
        let mut lowering = Self {
            frames: Vec::new(),
            values: Vec::new(),
            maps: Vec::new(),
            map_index: FxHashMap::default(),
            names: vec![Named::default()],
            name_index: FxHashMap::default(),
            colors: vec![None],
            color_index: FxHashMap::default(),
            body: None,
            bodies: 0,
            repeated: find_repeated(root),
            known: FxHashMap::default(),
            builder: Builder::default(),
            polyhedra,
            region_index: FxHashMap::default(),
            gathered: Gathered::default(),
            others: Vec::new(),
            others_met: 0,
        };
        lowering.intern_map(WorldMap::IDENTITY);
        lowering
    }

    fn intern_map(&mut self, map: WorldMap) -> u32 {
        let key = map.map.to_cols_array().map(f64::to_bits);
        *self.map_index.entry(key).or_insert_with(|| {
            self.maps.push(map);
            (self.maps.len() - 1) as u32
        })
    }

    /// A name within another one.
    fn intern_name(&mut self, outer: u32, name: &Arc<str>) -> u32 {
        let around = &self.names[outer as usize];
        if around.name.as_ref() == Some(name) {
            return outer;
        }
        let next = self.names.len() as u32;
        let key = (outer, name.clone());
        let index = *self.name_index.entry(key).or_insert(next);
        if index == next {
            let parts = if around.parts.len() < MOST_PARTS {
                around.parts.iter().chain(&around.name).cloned().collect()
            } else {
                around.parts.clone()
            };
            self.names.push(Named {
                name: Some(name.clone()),
                parts,
            });
        }
        index
    }

    fn walk(&mut self, root: &'a Solid) -> Result<(), Error> {
        let context = Context {
            map: 0,
            name: 0,
            color: 0,
            negated: false,
        };
        self.enter(root, context, 0, None)?;
        while let Some(frame) = self.frames.last_mut() {
            let node = frame.solid.node();
            let index = frame.next;
            let Some(operand) = node.operands().get(index) else {
                self.leave()?;
                continue;
            };
            frame.next += 1;
            let mut context = frame.context;
            let operation = frame.operation;
            match node {
                Node::Difference(_) if index > 0 => context.negated = !context.negated,
                Node::Transform(map, _) => {
                    let map = map.clone().map_err(|fault| self.error(fault))?;
                    context.map = self.accumulate(context.map, map)?;
                }
                Node::Named(name, _) => context.name = self.intern_name(context.name, name),
                Node::Colored(color, _) => {
                    let [r, g, b] = color.rgb;
                    let key = [r, g, b, color.alpha].map(f32::to_bits);
                    let next = self.colors.len() as u32;
                    context.color = *self.color_index.entry(key).or_insert(next);
                    if context.color == next {
                        self.colors.push(Some(*color));
                    }
                }
                _ => {}
            }
            self.enter(operand, context, index, operation)?;
        }
        Ok(())
    }

    /// The accumulated map followed by (further in) `inner`, checked.
    fn accumulate(&mut self, outer: u32, inner: glam::DAffine3) -> Result<u32, Error> {
        if !inner.is_finite() {
            return Err(self.error(NodeFault::NotFinite {
                what: "every entry of the map",
            }));
        }
        let alone = WorldMap::IDENTITY.then_inner(&inner);
        // Not so much as one correct digit is left below this.
        let conditioning = alone.relative_determinant().abs();
        if conditioning.is_nan() || conditioning <= MAPPED {
            return Err(self.error(NodeFault::SingularMap {
                determinant: inner.matrix3.determinant(),
            }));
        }
        let outer = self.maps[outer as usize];
        let map = if outer.is_identity() {
            alone
        } else {
            outer.then_inner(&inner)
        };
        if !map.map.is_finite() {
            return Err(self.error(NodeFault::OutOfRange {
                what: "the map together with those above it",
            }));
        }
        Ok(self.intern_map(map))
    }

    /// Starts on a node: finds its value at once (a leaf, a known subtree) or
    /// puts it on the stack. `above` is the operation its value feeds.
    fn enter(
        &mut self,
        solid: &'a Solid,
        context: Context,
        operand: usize,
        above: Option<Operation>,
    ) -> Result<(), Error> {
        let node = solid.node();
        let repeated = self.repeated.contains(&solid.id());
        if repeated && let Some(&value) = self.known.get(&(solid.id(), context)) {
            self.values.push(value);
            return Ok(());
        }
        let nary = match node {
            Node::Union(_) => Some(("union", Operation::Or)),
            Node::Intersection(_) => Some(("intersection", Operation::And)),
            Node::Difference(_) => Some(("difference", Operation::And)),
            _ => None,
        };
        let own = nary.map(|(_, operation)| {
            if context.negated {
                operation.dual()
            } else {
                operation
            }
        });
        if self.body.is_none() && matches!(node, Node::Made(_)) {
            self.body = Some(self.frames.len());
            self.bodies += 1;
        }
        self.frames.push(Frame {
            solid,
            context,
            next: 0,
            operand,
            // A repeated node must come to one value that can be remembered.
            operation: own.or(if repeated { None } else { above }),
            merged: own.is_some() && own == above && !repeated,
            base: self.values.len(),
        });
        match node {
            Node::Primitive(primitive) => self.lower_primitive(primitive, context),
            Node::Made(Made {
                solid: Err(fault), ..
            }) => Err(self.error(fault.clone())),
            _ if nary.is_some() && node.operands().is_empty() => {
                let operation = nary.map_or("", |(name, _)| name);
                Err(self.error(NodeFault::NoOperands { operation }))
            }
            _ => Ok(()),
        }
    }

    /// Finishes the node on top of the stack: its value replaces those of its
    /// operands, unless the operation below takes them all.
    fn leave(&mut self) -> Result<(), Error> {
        let Some(frame) = self.frames.pop() else {
            return Ok(());
        };
        if self.body == Some(self.frames.len()) {
            self.body = None;
        }
        let combines = matches!(
            frame.solid.node(),
            Node::Union(_) | Node::Intersection(_) | Node::Difference(_)
        );
        if combines
            && !frame.merged
            && let Some(operation) = frame.operation
        {
            let values = &self.values[frame.base..];
            let value = Value::combined(&mut self.builder, operation, values)?;
            self.values.truncate(frame.base);
            self.values.push(value);
        }
        if let Node::Made(Made {
            within: Some(corners),
            ..
        }) = frame.solid.node()
            && !frame.context.negated
        {
            // As with a primitive's half-spaces: together they are within.
            let map = self.maps[frame.context.map as usize].map;
            let bounds = Bounds::of_box(&map, *corners);
            for value in &mut self.values[frame.base..] {
                value.bounds = value.bounds.intersected(bounds);
            }
        }
        if self.repeated.contains(&frame.solid.id())
            && let [value] = self.values[frame.base..]
        {
            self.known.insert((frame.solid.id(), frame.context), value);
        }
        Ok(())
    }

    fn lower_primitive(&mut self, primitive: &Primitive, context: Context) -> Result<(), Error> {
        let surfaces = match half_spaces(primitive).map_err(|fault| self.error(fault))? {
            LocalShape::Constant(value) => {
                let value = value != context.negated;
                self.values.push(Value {
                    operand: Operand::Constant(value),
                    bounds: if value {
                        Bounds::EVERYTHING
                    } else {
                        Bounds::NOTHING
                    },
                });
                return Ok(());
            }
            LocalShape::HalfSpaces(surfaces) => surfaces,
            LocalShape::Polyhedron(polyhedron) => {
                return self.lower_polyhedron(primitive, &polyhedron, context);
            }
        };
        let origin = self.add_origin(primitive, context);
        let base = self.values.len();
        let map = self.maps[context.map as usize];
        let own = reach(primitive, &map.map);
        // Together with the primitive's other half-spaces, each is within its box.
        let bounds = if context.negated {
            Bounds::EVERYTHING
        } else {
            own
        };
        let placed = self.polyhedra.placed();
        let known = placed.and_then(|placed| placed.others.get(self.others_met));
        self.others_met += 1;
        let mut half_spaces = SmallVec::new();
        for (index, surface) in surfaces.into_iter().enumerate() {
            let known = known.and_then(|known| known.half_spaces.get(index));
            let (surface, flipped) = match known {
                Some(known) => *known,
                None => {
                    let placed = map.apply(&surface).ok_or_else(|| {
                        self.error(NodeFault::OutOfRange {
                            what: "the primitive under the maps above it",
                        })
                    })?;
                    self.builder.table.insert(placed)
                }
            };
            half_spaces.push((surface, flipped));
            let operand = self.builder.literal(Literal {
                surface,
                origin,
                outside: flipped != context.negated,
            })?;
            self.values.push(Value { operand, bounds });
        }
        self.others.push(Convex {
            half_spaces,
            bounds: own,
        });
        let operation = if context.negated {
            Operation::Or
        } else {
            Operation::And
        };
        let flattens = self
            .frames
            .last()
            .is_some_and(|frame| frame.operation == Some(operation));
        if !flattens {
            let value = Value::combined(&mut self.builder, operation, &self.values[base..])?;
            self.values.truncate(base);
            self.values.push(value);
        }
        Ok(())
    }

    fn finish(mut self) -> Finished {
        let root = self.values.pop().unwrap_or(Value::NOTHING);
        let Builder {
            mut formula,
            origins,
            table,
            ..
        } = self.builder;
        formula.root = root.operand;
        let mut formula = compact(&formula);
        let known = self
            .polyhedra
            .placed()
            .map_or(&[][..], |placed| placed.surfaces);
        let own = table.into_surfaces();
        let count = known.len() + own.len();
        let others = self.others.iter().flat_map(|other| &other.half_spaces);
        let mut others: Vec<u32> = others.map(|&(surface, _)| surface).collect();
        let (surfaces, ids) = match &self.polyhedra {
            Polyhedra::Met(_) => (own, Vec::new()),
            // Those that are known will do.
            Polyhedra::Outlined(_) => (Vec::new(), Vec::new()),
            Polyhedra::Written(_, None) => ([known, &own].concat(), Vec::new()),
            Polyhedra::Written(_, Some(_)) => {
                let in_use = Renumbered::of(&mut formula, count);
                self.gathered
                    .renumber(|id| in_use.number(id.0).map(SurfaceId));
                others.retain_mut(|surface| in_use.renumber(surface));
                let surface = |&id: &u32| match known.get(id as usize) {
                    Some(surface) => *surface,
                    None => own[id as usize - known.len()],
                };
                (in_use.ids.iter().map(surface).collect(), in_use.ids)
            }
        };
        let others = others.into_iter().map(SurfaceId);
        let given = self.gathered.finish(surfaces.len(), others);
        let lowered = Lowered {
            surfaces,
            formula,
            origins,
            reach: root.bounds,
            given: given.map(Arc::new),
        };
        Finished { lowered, ids }
    }

    fn add_origin(&mut self, primitive: &Primitive, context: Context) -> u32 {
        let origin = Origin {
            kind: primitive.kind(),
            body: self.body.map_or(0, |_| self.bodies),
            name: self.names[context.name as usize].name.clone(),
            parts: self.names[context.name as usize].parts.clone(),
            color: self.colors[context.color as usize],
        };
        push_index(&mut self.builder.origins, origin)
    }

    /// The fault as an error at the node on top of the stack.
    fn error(&self, fault: NodeFault) -> Error {
        let steps = self
            .frames
            .iter()
            .map(|frame| PathStep {
                operand: frame.operand,
                kind: frame.solid.node().kind(),
                name: match frame.solid.node() {
                    Node::Named(name, _) => Some(name.clone()),
                    _ => None,
                },
            })
            .collect();
        Error::InvalidNode {
            path: NodePath { steps },
            fault,
        }
    }
}

/// The surfaces that a formula names, numbered anew.
pub(super) struct Renumbered {
    /// Ascending.
    pub ids: Vec<u32>,
    /// Of each surface; none of those that are not named.
    numbers: Vec<Option<u32>>,
}

impl Renumbered {
    /// Renumbers the surfaces of a formula.
    pub fn of(formula: &mut Formula, surfaces: usize) -> Self {
        let mut is_named = vec![false; surfaces];
        for literal in &formula.literals {
            is_named[literal.surface as usize] = true;
        }
        let mut ids = Vec::new();
        let number =
            |(surface, &is_named): (u32, &bool)| is_named.then(|| push_index(&mut ids, surface));
        let numbers: Vec<Option<u32>> = (0..).zip(&is_named).map(number).collect();
        for literal in &mut formula.literals {
            literal.surface = numbers[literal.surface as usize].unwrap_or_default();
        }
        Self { ids, numbers }
    }

    fn number(&self, surface: u32) -> Option<u32> {
        self.numbers[surface as usize]
    }

    /// Renumbers a surface; false if it is not named.
    fn renumber(&self, surface: &mut u32) -> bool {
        let number = self.number(*surface);
        *surface = number.unwrap_or_default();
        number.is_some()
    }
}

/// The nodes that more than one operand list of the tree below `root` names
/// (or one list several times).
fn find_repeated(root: &Solid) -> FxHashSet<usize> {
    let mut seen = FxHashSet::default();
    let mut repeated = FxHashSet::default();
    let mut pending = vec![root];
    while let Some(solid) = pending.pop() {
        if !solid.is_shared() || seen.insert(solid.id()) {
            pending.extend(solid.node().operands());
        } else {
            repeated.insert(solid.id());
        }
    }
    repeated
}
