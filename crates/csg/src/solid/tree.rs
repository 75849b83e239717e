//! The tree: sharing, Boolean operators, names, colours and a drop that no
//! depth can overflow.

use std::collections::HashMap;
use std::fmt;
use std::ops::{Add, BitAnd, BitOr, Not, Sub};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::primitive::Primitive;
use crate::color::Color;
use crate::error::NodeFault;
use crate::numeric::stretch;

/// A solid: an immutable tree whose subtrees are shared, not copied.
///
/// Cloning costs one reference count. `|` (and `+`) unite, `-` subtracts, `&`
/// intersects; each works on values and on references.
///
/// ```
/// use csg::Solid;
///
/// let blank = Solid::cube(1.5) & Solid::sphere(1.0);
/// let bore = Solid::infinite_cylinder(0.5);
/// let drilled = blank - &bore - bore.rotate_x(90f64.to_radians());
/// ```
#[derive(Clone)]
pub struct Solid(Arc<Node>);

/// One node of a [`Solid`]'s tree.
#[derive(Debug)]
#[non_exhaustive]
pub enum Node {
    /// A leaf.
    Primitive(Primitive),
    /// The points in any operand.
    Union(Vec<Solid>),
    /// The points in every operand.
    Intersection(Vec<Solid>),
    /// The points in the first operand and in none of the others.
    Difference(Vec<Solid>),
    /// The image of the operand under an affine map, or what is wrong with
    /// the arguments the map was to be made from.
    Transform(Result<DAffine3, NodeFault>, Solid),
    /// What an authoring function made of other nodes.
    Made(Made),
    /// The operand under a name.
    Named(Arc<str>, Solid),
    /// The operand in a colour.
    Colored(Color, Solid),
}

/// What an authoring function made of other nodes, as an extrusion is of
/// half-spaces.
#[derive(Debug)]
pub struct Made {
    /// The function's name.
    pub function: &'static str,
    /// What it made, or what is wrong with its arguments.
    pub solid: Result<Solid, NodeFault>,
    /// The least and greatest corner of a box around the solid, if it has an
    /// end: half-spaces alone may not tell.
    pub within: Option<[DVec3; 2]>,
    /// Points whose convex hull is that of the solid; empty where none were
    /// given.
    pub spanning: Vec<DVec3>,
    /// How far its boundary strays at most from that of what was asked for, if it stands for
    /// something curved that there are no surfaces for.
    pub strays: Option<f64>,
    /// The same with chords for parabolas, within 1e-4 of the profile's size, if it has such: for
    /// programs that do not know them.
    pub with_chords: Option<Solid>,
}

impl Node {
    /// The node's children, in order.
    #[must_use]
    pub fn operands(&self) -> &[Solid] {
        match self {
            Self::Primitive(_) => &[],
            Self::Made(made) => made.solid.as_ref().map_or(&[], std::slice::from_ref),
            Self::Union(operands) | Self::Intersection(operands) | Self::Difference(operands) => {
                operands
            }
            Self::Transform(_, operand) | Self::Named(_, operand) | Self::Colored(_, operand) => {
                std::slice::from_ref(operand)
            }
        }
    }

    /// The node's kind, in the words of the authoring functions.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Primitive(primitive) => primitive.kind(),
            Self::Union(_) => "union",
            Self::Intersection(_) => "intersection",
            Self::Difference(_) => "difference",
            Self::Transform(..) => "transform",
            Self::Made(made) => made.function,
            Self::Named(..) => "named",
            Self::Colored(..) => "colored",
        }
    }
}

/// Takes the tree apart with a work list instead of the call stack, so that a
/// chain of a million operations drops in constant stack space.
impl Drop for Node {
    fn drop(&mut self) {
        let mut pending = Vec::new();
        take_operands(self, &mut pending);
        while let Some(Solid(node)) = pending.pop() {
            if let Some(mut node) = Arc::into_inner(node) {
                take_operands(&mut node, &mut pending);
            }
        }
    }
}

/// Moves the operands of `node` to `pending`, leaving a leaf behind.
fn take_operands(node: &mut Node, pending: &mut Vec<Solid>) {
    match node {
        Node::Primitive(_) => {}
        Node::Made(made) => {
            if let Ok(operand) = &mut made.solid {
                pending.push(std::mem::replace(operand, Solid::empty()));
            }
        }
        Node::Union(operands) | Node::Intersection(operands) | Node::Difference(operands) => {
            pending.append(operands);
        }
        Node::Transform(_, operand) | Node::Named(_, operand) | Node::Colored(_, operand) => {
            pending.push(std::mem::replace(operand, Solid::empty()));
        }
    }
}

impl Solid {
    pub(super) fn from_node(node: Node) -> Self {
        Self(Arc::new(node))
    }

    /// What a function made of other solids, or what is wrong with its arguments.
    pub(crate) fn shaped(function: &'static str, solid: Result<Self, NodeFault>) -> Self {
        Self::from_node(Node::Made(Made {
            function,
            solid,
            within: None,
            spanning: Vec::new(),
            strays: None,
            with_chords: None,
        }))
    }

    /// The same solid, said to stand for another one, from whose boundary its own strays so far
    /// at most.
    #[must_use]
    pub fn standing_in(mut self, strays: f64) -> Self {
        if let Node::Made(Made { solid: Err(_), .. }) = self.node() {
            return self;
        }
        if let Some(Node::Made(made)) = Arc::get_mut(&mut self.0) {
            made.strays = Some(made.strays.map_or(strays, |before| before.max(strays)));
            return self;
        }
        Self::shaped("standing_in", Ok(self)).standing_in(strays)
    }

    /// How far a part of the solid strays at most from what was asked for, as far as it stands for
    /// something curved that there are no surfaces for: circles turned beside an axis are chords
    /// ([`Solid::revolve`]), twists flat faces. None if all is what was asked for. What is said
    /// of the solid, as its volume, is said of it as it is.
    #[must_use]
    pub fn strays(&self) -> Option<f64> {
        let mut known: HashMap<usize, Option<f64>> = HashMap::new();
        // Nodes on the way down, and again (true) after their operands.
        let mut pending = vec![(self, false)];
        while let Some((solid, is_after)) = pending.pop() {
            let operands = solid.node().operands();
            if !is_after {
                if !known.contains_key(&solid.id()) {
                    pending.push((solid, true));
                    pending.extend(operands.iter().map(|operand| (operand, false)));
                }
                continue;
            }
            let below = operands.iter().filter_map(|o| known[&o.id()]);
            let below = below.reduce(f64::max);
            let strays = match solid.node() {
                Node::Transform(Ok(map), _) => below.map(|below| below * stretch(map)),
                Node::Made(made) => below.into_iter().chain(made.strays).reduce(f64::max),
                _ => below,
            };
            known.insert(solid.id(), strays);
        }
        known[&self.id()]
    }

    /// The solid without any point.
    #[must_use]
    pub fn empty() -> Self {
        // One shared node: dropping a tree asks for it once per inner node.
        static EMPTY: std::sync::OnceLock<Solid> = std::sync::OnceLock::new();
        EMPTY
            .get_or_init(|| Self::from_node(Node::Primitive(Primitive::Empty)))
            .clone()
    }

    /// What a function made, for those who read trees that were stored.
    #[must_use]
    pub fn from_made(made: Made) -> Self {
        Self::from_node(Node::Made(made))
    }

    /// The root of the tree, for those who walk it (writers, translators).
    #[must_use]
    pub fn node(&self) -> &Node {
        &self.0
    }

    /// An identity of this very node: equal for clones, different for solids
    /// built separately, valid while the solid lives.
    #[must_use]
    pub fn id(&self) -> usize {
        Arc::as_ptr(&self.0) as usize
    }

    /// Whether another solid or tree may hold this node as well.
    pub(crate) fn is_shared(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }

    /// The union of all operands. Lowering rejects an empty list; where "none"
    /// is meant, [`Solid::empty`] says so.
    #[must_use]
    pub fn union(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::from_node(Node::Union(operands.into_iter().collect()))
    }

    /// The intersection of all operands. Lowering rejects an empty list; where
    /// all of space is meant, [`Solid::space`] says so.
    #[must_use]
    pub fn intersection(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::from_node(Node::Intersection(operands.into_iter().collect()))
    }

    /// The first operand without all the others. Lowering rejects an empty
    /// list.
    #[must_use]
    pub fn difference(operands: impl IntoIterator<Item = Self>) -> Self {
        Self::from_node(Node::Difference(operands.into_iter().collect()))
    }

    /// The same solid under a name, which the faces of every primitive below
    /// carry unless a name further in overrides it.
    #[must_use]
    pub fn named(&self, name: impl Into<Arc<str>>) -> Self {
        Self::from_node(Node::Named(name.into(), self.clone()))
    }

    /// The same solid in a colour, which the faces of every primitive below
    /// carry unless a colour further in overrides it.
    #[must_use]
    pub fn colored(&self, color: Color) -> Self {
        Self::from_node(Node::Colored(color, self.clone()))
    }
}

/// Prints the tree down to three levels; a million nodes would not help.
impl fmt::Debug for Solid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fn write(solid: &Solid, levels: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            let node = solid.node();
            match node {
                Node::Primitive(primitive) => return write!(f, "{primitive:?}"),
                Node::Named(name, _) => write!(f, "named {name:?}")?,
                _ => f.write_str(node.kind())?,
            }
            let operands = node.operands();
            if levels == 0 {
                return write!(f, "[{} more]", operands.len());
            }
            f.write_str("[")?;
            for (i, operand) in operands.iter().take(8).enumerate() {
                if i > 0 {
                    f.write_str(", ")?;
                }
                write(operand, levels - 1, f)?;
            }
            if operands.len() > 8 {
                write!(f, ", {} more", operands.len() - 8)?;
            }
            f.write_str("]")
        }
        write(self, 3, f)
    }
}

macro_rules! boolean_operator {
    ($trait:ident, $method:ident, $node:ident) => {
        impl $trait<&Solid> for &Solid {
            type Output = Solid;
            fn $method(self, other: &Solid) -> Solid {
                Solid::from_node(Node::$node(vec![self.clone(), other.clone()]))
            }
        }
        impl $trait<Solid> for Solid {
            type Output = Solid;
            fn $method(self, other: Solid) -> Solid {
                Solid::from_node(Node::$node(vec![self, other]))
            }
        }
        impl $trait<&Solid> for Solid {
            type Output = Solid;
            fn $method(self, other: &Solid) -> Solid {
                Solid::from_node(Node::$node(vec![self, other.clone()]))
            }
        }
        impl $trait<Solid> for &Solid {
            type Output = Solid;
            fn $method(self, other: Solid) -> Solid {
                Solid::from_node(Node::$node(vec![self.clone(), other]))
            }
        }
    };
}

boolean_operator!(BitOr, bitor, Union);
boolean_operator!(Add, add, Union);
boolean_operator!(BitAnd, bitand, Intersection);
boolean_operator!(Sub, sub, Difference);

/// The complement: all points outside.
impl Not for &Solid {
    type Output = Solid;
    fn not(self) -> Solid {
        Solid::space() - self
    }
}

/// The complement: all points outside.
impl Not for Solid {
    type Output = Solid;
    fn not(self) -> Solid {
        Solid::space() - self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_send_and_sync() {
        fn check<T: Send + Sync>() {}
        check::<Solid>();
    }

    #[test]
    fn a_million_deep_drops_without_recursion() {
        let ball = Solid::sphere(1.0);
        let mut chain = ball.clone();
        for i in 0..1_000_000 {
            chain = match i % 4 {
                0 => chain - &ball,
                1 => chain.translate([1.0, 0.0, 0.0]),
                2 => chain | &ball,
                _ => chain.named("link"),
            };
        }
        std::thread::Builder::new()
            .stack_size(64 * 1024)
            .spawn(move || drop(chain))
            .expect("a thread")
            .join()
            .expect("no overflow");
        assert_eq!(ball.node().operands().len(), 0);
    }

    #[test]
    fn debug_is_short() {
        let wide = Solid::union((0..1000).map(|_| Solid::sphere(1.0)));
        assert!(format!("{wide:?}").len() < 400);
    }
}
