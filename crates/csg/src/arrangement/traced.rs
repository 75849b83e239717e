//! What is found in blocks.

use super::contacts::Contact;
use super::piece::Piece;

/// What is found in blocks.
#[derive(Default)]
pub(super) struct Traced {
    /// Of edges.
    pub pieces: Vec<Piece>,
    pub contacts: Vec<Contact>,
}
