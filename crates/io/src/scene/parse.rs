//! The grammar: from tokens to a flat list of nodes.
//!
//! Nodes stand in the order of the text, each with the end of its subtree, so
//! that neither reading nor dropping a tree of any depth recurses.

use std::ops::Range;

use super::error::{Place, SceneError};
use super::lex::{Lexer, Token, unescaped};
use super::placing::{self, is_placing};

/// The kinds of node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Group,
    Union,
    Difference,
    Intersection,
    Multmatrix,
    Color,
    Render,
    Cube,
    Sphere,
    Cylinder,
    Polyhedron,
    Circle,
    Square,
    Polygon,
    Text,
    Import,
    Surface,
    LinearExtrude,
    RotateExtrude,
    Offset,
    Projection,
    Hull,
    Minkowski,
    Resize,
    /// A node that cannot be read, in a subtree that `%` leaves out.
    Other,
}

/// The nodes that can be read, as messages list them.
pub(super) const NODES: [&str; 28] = [
    "group",
    "union",
    "difference",
    "intersection",
    "hull",
    "minkowski",
    "multmatrix",
    "translate",
    "rotate",
    "scale",
    "mirror",
    "resize",
    "color",
    "render",
    "cube",
    "sphere",
    "cylinder",
    "polyhedron",
    "circle",
    "square",
    "polygon",
    "text",
    "import",
    "surface",
    "offset",
    "projection",
    "linear_extrude",
    "rotate_extrude",
];

impl Kind {
    fn of(name: &str) -> Self {
        match name {
            "group" => Self::Group,
            "union" => Self::Union,
            "difference" => Self::Difference,
            "intersection" => Self::Intersection,
            "multmatrix" => Self::Multmatrix,
            // (Their arguments become a matrix.)
            _ if is_placing(name) => Self::Multmatrix,
            "color" => Self::Color,
            "render" => Self::Render,
            "cube" => Self::Cube,
            "sphere" => Self::Sphere,
            "cylinder" => Self::Cylinder,
            "polyhedron" => Self::Polyhedron,
            "circle" => Self::Circle,
            "square" => Self::Square,
            "polygon" => Self::Polygon,
            "text" => Self::Text,
            "import" => Self::Import,
            "surface" => Self::Surface,
            "linear_extrude" => Self::LinearExtrude,
            "rotate_extrude" => Self::RotateExtrude,
            "offset" => Self::Offset,
            "projection" => Self::Projection,
            "hull" => Self::Hull,
            "minkowski" => Self::Minkowski,
            "resize" => Self::Resize,
            _ => Self::Other,
        }
    }

    pub(super) fn is_leaf(self) -> bool {
        matches!(
            self,
            Self::Cube
                | Self::Sphere
                | Self::Cylinder
                | Self::Polyhedron
                | Self::Circle
                | Self::Square
                | Self::Polygon
                | Self::Text
                | Self::Import
                | Self::Surface
        )
    }
}

/// One node of the text.
#[derive(Debug)]
pub(super) struct NodeText<'a> {
    pub kind: Kind,
    pub name: &'a str,
    /// Byte offset of the name.
    pub offset: usize,
    /// Which of [`Tree::arguments`] are this node's.
    pub arguments: Range<usize>,
    /// Index after the last node of the subtree.
    pub end: usize,
    /// Whether `%` leaves the subtree out.
    pub background: bool,
}

/// One argument of a node.
#[derive(Debug)]
pub(super) struct Argument<'a> {
    pub key: Option<&'a str>,
    pub value: Value,
}

/// The value of an argument.
#[derive(Debug)]
pub(super) enum Value {
    Number(f64),
    Bool(bool),
    List(Vec<Value>),
    Text(String),
    /// `undef`.
    Undefined,
}

/// A scene text taken apart.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    pub text: &'a str,
    pub nodes: Vec<NodeText<'a>>,
    pub arguments: Vec<Argument<'a>>,
}

/// Lists in lists: matrices need two levels, polygons with paths three.
const DEEPEST_LIST: usize = 8;

pub(super) fn parse(text: &str) -> Result<Tree<'_>, SceneError> {
    let mut lexer = Lexer::new(text)?;
    let mut tree = Tree {
        text,
        nodes: Vec::new(),
        arguments: Vec::new(),
    };
    // The nodes whose children are being read, and whether these stand in braces: a lone child need
    // not.
    let mut open: Vec<(usize, bool)> = Vec::new();
    // The outermost of them that `%` leaves out.
    let mut background: Option<usize> = None;
    loop {
        if lexer.peek() == Token::End {
            let Some(&(innermost, _)) = open.last() else {
                return Ok(tree);
            };
            let node = &tree.nodes[innermost];
            let problem = format!("the `{{` of `{}` is never closed", node.name);
            return Err(lexer.error(node.offset, problem));
        }
        if lexer.take_mark('}')? {
            let Some((closed, _)) = open.pop() else {
                let problem = "a `}` too many: no `{` is open here".into();
                return Err(lexer.error(lexer.offset().saturating_sub(1), problem));
            };
            close(&mut tree, closed, &mut background);
        } else {
            let index = tree.nodes.len();
            node(&mut lexer, &mut tree, background.is_some())?;
            let has_braces = lexer.take_mark('{')?;
            let has_lone_child =
                matches!(lexer.peek(), Token::Name(_) | Token::Mark('%' | '#')) && !has_braces;
            if has_braces || has_lone_child {
                open.push((index, has_braces));
                if background.is_none() && tree.nodes[index].background {
                    background = Some(index);
                }
                continue;
            }
            if !lexer.take_mark(';')? {
                let wanted = if tree.nodes[index].kind.is_leaf() {
                    "`;`"
                } else {
                    "`;`, `{` or a child"
                };
                return Err(lexer.unexpected(wanted));
            }
        }
        // What ends here is the lone child of those that wait for one.
        while let Some((closed, _)) = open.pop_if(|(_, has_braces)| !*has_braces) {
            close(&mut tree, closed, &mut background);
        }
    }
}

/// Ends the subtree of a node with the last one that was read.
fn close(tree: &mut Tree<'_>, node: usize, background: &mut Option<usize>) {
    tree.nodes[node].end = tree.nodes.len();
    if *background == Some(node) {
        *background = None;
    }
}

/// Reads modifiers, name and arguments of one node.
fn node<'a>(
    lexer: &mut Lexer<'a>,
    tree: &mut Tree<'a>,
    in_background: bool,
) -> Result<(), SceneError> {
    let mut background = in_background;
    loop {
        if lexer.take_mark('%')? {
            background = true;
        } else if !lexer.take_mark('#')? {
            break;
        }
    }
    let offset = lexer.offset();
    let Token::Name(name) = lexer.peek() else {
        return Err(lexer.unexpected("a node such as `cube(...)`"));
    };
    lexer.take()?;
    if lexer.peek() != Token::Mark('(') {
        return Err(lexer.unexpected(&format!("`(` after `{name}`")));
    }
    let kind = Kind::of(name);
    if kind == Kind::Other && !background {
        return Err(SceneError::Unsupported {
            place: Place::of(tree.text, offset),
            node: name.to_owned(),
        });
    }
    lexer.take()?;
    let first = tree.arguments.len();
    if !lexer.take_mark(')')? {
        loop {
            tree.arguments.push(argument(lexer)?);
            if lexer.take_mark(')')? {
                break;
            }
            if !lexer.take_mark(',')? {
                return Err(lexer.unexpected("`,` or `)`"));
            }
        }
    }
    let mut unnamed = placing::names(name).iter();
    for argument in &mut tree.arguments[first..] {
        if argument.key.is_none() {
            argument.key = unnamed.next().copied();
        }
    }
    if is_placing(name) && !background {
        let matrix = placing::matrix(name, &tree.arguments[first..]);
        let value = matrix.map_err(|problem| SceneError::Argument {
            place: Place::of(tree.text, offset),
            node: name.to_owned(),
            problem,
        })?;
        tree.arguments.truncate(first);
        tree.arguments.push(Argument { key: None, value });
    }
    tree.nodes.push(NodeText {
        kind,
        name,
        offset,
        arguments: first..tree.arguments.len(),
        end: tree.nodes.len() + 1,
        background,
    });
    Ok(())
}

fn argument<'a>(lexer: &mut Lexer<'a>) -> Result<Argument<'a>, SceneError> {
    let key = match lexer.peek() {
        Token::Name(key) if !matches!(key, "true" | "false" | "undef") => {
            lexer.take()?;
            lexer.expect_mark('=')?;
            Some(key)
        }
        _ => None,
    };
    let value = value(lexer, DEEPEST_LIST)?;
    Ok(Argument { key, value })
}

fn value(lexer: &mut Lexer<'_>, levels: usize) -> Result<Value, SceneError> {
    let value = match lexer.peek() {
        Token::Number(number) => Value::Number(number),
        Token::Name("true") => Value::Bool(true),
        Token::Name("false") => Value::Bool(false),
        Token::Name("undef") => Value::Undefined,
        Token::String(text) => Value::Text(unescaped(text)),
        Token::Mark('[') if levels > 0 => {
            lexer.take()?;
            return list(lexer, levels - 1).map(Value::List);
        }
        Token::Mark('[') => {
            let problem = format!("lists more than {DEEPEST_LIST} deep");
            return Err(lexer.error(lexer.offset(), problem));
        }
        _ => return Err(lexer.unexpected("a value")),
    };
    lexer.take()?;
    Ok(value)
}

/// The rest of a list after its `[`.
fn list(lexer: &mut Lexer<'_>, levels: usize) -> Result<Vec<Value>, SceneError> {
    let mut values = Vec::new();
    if lexer.take_mark(']')? {
        return Ok(values);
    }
    loop {
        values.push(value(lexer, levels)?);
        if lexer.take_mark(']')? {
            return Ok(values);
        }
        if !lexer.take_mark(',')? {
            return Err(lexer.unexpected("`,` or `]`"));
        }
    }
}
