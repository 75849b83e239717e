//! What nodes come to: solids, profiles, or nothing.

use csg::{Made, Node, Primitive, Profile, Solid};

/// The value of a node.
#[derive(Clone, Debug)]
pub(super) enum Piece {
    /// No points, in the plane or in space.
    Nothing,
    Solid(Solid),
    Flat(Profile),
}

/// Why a piece that an operation cannot take was left out.
pub(super) const MIXED: &str =
    "profiles and solids do not mix: what is not like the first is left out";

/// Pieces of one kind: that of the first which has points.
pub(super) enum Pieces {
    Nothing,
    Solids(Vec<Solid>),
    Flats(Vec<Profile>),
}

impl Piece {
    pub(super) fn of(solid: Solid) -> Self {
        if is_empty(&solid) {
            Self::Nothing
        } else {
            Self::Solid(solid)
        }
    }

    fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }
}

fn is_empty(solid: &Solid) -> bool {
    match solid.node() {
        Node::Primitive(Primitive::Empty) => true,
        Node::Made(Made {
            solid: Ok(solid), ..
        }) => is_empty(solid),
        _ => false,
    }
}

/// The pieces that have points and are like the first of these; and whether
/// others were left out.
pub(super) fn alike(pieces: Vec<Piece>) -> (Pieces, bool) {
    let (mut solids, mut flats) = (Vec::new(), Vec::new());
    let mut first_is_solid = None;
    for piece in pieces {
        match piece {
            Piece::Nothing => continue,
            Piece::Solid(solid) => solids.push(solid),
            Piece::Flat(profile) => flats.push(profile),
        }
        first_is_solid.get_or_insert(flats.is_empty());
    }
    let mixed = !solids.is_empty() && !flats.is_empty();
    let pieces = match first_is_solid {
        None => Pieces::Nothing,
        Some(true) => Pieces::Solids(solids),
        Some(false) => Pieces::Flats(flats),
    };
    (pieces, mixed)
}

/// The Boolean operations, with what pieces are left out.
pub(super) fn union(pieces: Vec<Piece>) -> (Piece, bool) {
    let (pieces, mixed) = alike(pieces);
    let piece = match pieces {
        Pieces::Nothing => Piece::Nothing,
        Pieces::Solids(solids) => Piece::Solid(one_or(solids, Solid::union)),
        Pieces::Flats(flats) => Piece::Flat(one_or(flats, Profile::union)),
    };
    (piece, mixed)
}

pub(super) fn intersection(pieces: Vec<Piece>) -> (Piece, bool) {
    if pieces.is_empty() || pieces.iter().any(Piece::is_nothing) {
        return (Piece::Nothing, false);
    }
    let (pieces, mixed) = alike(pieces);
    if mixed {
        // What is left out is not met, either.
        return (Piece::Nothing, true);
    }
    let piece = match pieces {
        Pieces::Nothing => Piece::Nothing,
        Pieces::Solids(solids) => Piece::Solid(one_or(solids, Solid::intersection)),
        Pieces::Flats(flats) => Piece::Flat(one_or(flats, Profile::intersection)),
    };
    (piece, mixed)
}

pub(super) fn difference(pieces: Vec<Piece>) -> (Piece, bool) {
    if pieces.first().is_none_or(Piece::is_nothing) {
        return (Piece::Nothing, false);
    }
    let (pieces, mixed) = alike(pieces);
    let piece = match pieces {
        Pieces::Nothing => Piece::Nothing,
        Pieces::Solids(solids) => Piece::Solid(one_or(solids, Solid::difference)),
        Pieces::Flats(flats) => Piece::Flat(one_or(flats, Profile::difference)),
    };
    (piece, mixed)
}

/// The only operand, or the operation on several.
fn one_or<T>(mut operands: Vec<T>, operation: impl FnOnce(Vec<T>) -> T) -> T {
    match operands.pop() {
        Some(only) if operands.is_empty() => only,
        Some(last) => {
            operands.push(last);
            operation(operands)
        }
        None => operation(operands),
    }
}
