//! The mathematics behind this crate, for who takes its code over: what is computed, by which
//! formula, why that is right, and what of it is proven, decided or only checked.
//!
//! `ARCHITECTURE.md` in the repository tells which way a solid goes through the files. These pages
//! follow it where there is something to prove:
//!
//! | page | question | answered in |
//! | --- | --- | --- |
//! | [`relations`] | What is the same, touches or nearly does? | `surface/kind.rs`, `program/unify.rs`, `program/settle`, `arrangement/triple.rs`, `numeric/tolerance.rs` |
//! | [`pencils`] | In which curves do two quadrics meet? | `arrangement/{pairs,conic,pencil,rulings}` |
//! | [`roots`] | Where does a third surface cross such a curve, and are these all? | `arrangement/{curve,roots,trig}.rs` |
//! | [`deviation`] | How far do triangles and chords stray? | `tessellate/deviation` |
//! | [`crossing`] | When can a mesh run through itself? | `tessellate/{alongside,mirror,beside,separate}` |
//!
//! Functions that are named here are mostly private: their names are links to the files that they
//! are in.
//!
//! # Notation
//! A surface is where a function f is 0, and its half-space where f ≤ 0. Of a plane f is the
//! distance, n·(x - a) with a unit normal n; of a quadric it is
//!
//! ```text
//! f(x) = (x - a)ᵀ Q (x - a) + g·(x - a) + c
//! ```
//!
//! about an anchor a, the largest of the six coefficients of Q being 1
//! ([`normalised`][program/unify.rs]). ∇f is its gradient and H = 2 Q its Hessian, so that |f| /
//! |∇f| is the distance to first order ([`first_order`][tessellate/deviation.rs]). In homogeneous
//! coordinates X = (x, 1) a quadric is Xᵀ M X with a symmetric 4 by 4 matrix M
//! ([`matrix`][arrangement/rulings.rs]). ε is the distance from 1 to the next double, 2.2e-16,
//! twice what one operation may be off.
//!
//! # Three kinds of statements
//! - *Proven*: it follows from what is computed, rounding bounded or its place in the proof said.
//! - *Decided*: rounding leaves it open, and one function gives the one answer, which all later
//!   stages take over. Which values are as good as 0 is said in
//!   [`numeric/tolerance.rs`][numeric/tolerance.rs], each with its reason.
//! - *Checked only*: nothing guarantees it beforehand; a finished mesh is looked at, and what is
//!   wrong is in the [`Report`](crate::Report).
//!
//! [arrangement/rulings.rs]: ../../src/csg/arrangement/rulings.rs.html
//! [numeric/tolerance.rs]: ../../src/csg/numeric/tolerance.rs.html
//! [program/unify.rs]: ../../src/csg/program/unify.rs.html
//! [tessellate/deviation.rs]: ../../src/csg/tessellate/deviation.rs.html

pub mod crossing;
pub mod deviation;
pub mod pencils;
pub mod relations;
pub mod roots;
