//! What is the same, what touches, what nearly does: relations of surfaces, each decided once.
//!
//! Numbers that an author writes are rounded, and products of matrices round them again. So a
//! cylinder that is meant to touch a plane touches it by 1e-17 too little or too much, and no exact
//! arithmetic on the numbers as they are tells which was meant. Relations are therefore not found
//! again by each stage that needs them but decided by one function and looked up from then on.
//!
//! # One surface: its kind
//! By Sylvester's law of inertia an affine map keeps how many values of Q are positive, negative
//! and 0, whether a slope is left that no centre takes away, and of which sign f is at the centre.
//! These three are the affine type of a quadric ([`Kind::of_signature`][surface/kind.rs]). Whether
//! one of them is 0 is what rounding hides: a primitive knows it and says so when it is made. It is
//! asked of coefficients only where an author gave ten of them, by
//! [`NO_VALUE`][numeric/tolerance.rs] of the largest value, and never again: maps change the
//! coefficients and leave the kind.
//!
//! # Two surfaces: are they one?
//! *When lowering.* A surface in the tree goes through a chain of maps, f'(x) = f(M⁻¹ x). With the
//! map goes a bound of what rounding did to it ([`WorldMap`][program/unify.rs]): of a product A B,
//! where A and B are off by at most α and β in a matrix norm that bounds the stretch,
//!
//! ```text
//! |A B - (A B)'| <= α |B| + 6 ε |A| |B|       (a caller's own B is taken to be right to 2 ε)
//! ```
//!
//! and alike for the translation. Two placed surfaces may be one if their coefficients, both about
//! one anchor, differ by no more than both bounds together; then the first of them stands for both,
//! perhaps the other way round ([`SurfaceTable::insert`][program/unify.rs]). Candidates are found
//! by a weighted sum of coefficients that is the same for all descriptions of one surface up to its
//! sign: it is hashed by nearness, so that n surfaces take about n steps.
//!
//! *When settling.* What differs by more than arithmetic explains but by less than a boundary can
//! be evaluated with, a radius of 0.3333333333 beside one of a third, is moved before that
//! ([`program/settle.rs`][program/settle.rs], [`Settling::ALL`][settling.rs] has the order). How
//! far apart two quadrics are within a ball is bounded by their functions
//! ([`distance_bound`][program/settle/distance.rs]): with D = f - λ f', λ chosen such that the
//! quadratic parts agree best, points of the other surface are off this one by
//!
//! ```text
//! |f| / |∇f| = |D| / |∇f|,    |∇f|² = 4 Σ vₖ² xₖ² >= 4 min|vₖ| |c|    on  Σ vₖ xₖ² = c,
//! ```
//!
//! to first order. Surfaces each of which is near the next are a chain
//! ([`Chains`][program/settle/chains.rs]), and one of them stands for all unless the chain is too
//! long.
//!
//! | way | what is moved | by |
//! | --- | --- | --- |
//! | merged | what cannot be told apart is made one | at most what is [`unresolved`][arrangement/mod.rs] |
//! | aligned | what nearly touches, is nearly flush, in line, of one size or round, is made so | least moves that satisfy all relations at once |
//! | rounded | all numbers, to decimals | a share of what may be moved |
//! | perturbed | what passes the place that made trouble, then all | deterministic moves of a fifth of what is allowed, or more |
//!
//! Aligning solves the relations as equations F(u) = 0 in the moves u of places, sizes and, if that
//! is not enough, directions. Each step of Newton's method is the shortest solution of the
//! linearised system J u = -F, which may be under- and overdetermined at once: conjugate gradients
//! on JᵀJ u = -Jᵀ F from u = 0 stay in the row space of J and so end there (M. R. Hestenes and E.
//! Stiefel, *Methods of Conjugate Gradients for Solving Linear Systems*, Journal of Research of the
//! National Bureau of Standards 49, 1952). A result is used if all moves are within what is
//! allowed. By how much surfaces were moved is told in [`Report::moved`](crate::Report::moved).
//!
//! # Two surfaces: do they touch?
//! Where two surfaces have one tangent plane without crossing all around, they touch. Newton's
//! method on f = 0 and ∇f = λ ∇f', which has its root there even if both values differ by rounding,
//! finds the place ([`contact`][arrangement/pencil/contact.rs]). Let d = f - λ f'. They do touch if
//! d is below [`TOUCH`][numeric/tolerance.rs] of the scene there, times the slope. Its quadratic
//! form tells how: if it is definite, in one point; if its values are of the signs +, 0 and -, in
//! two curves that cross there ([pencils](super::pencils)).
//!
//! # Three surfaces: one point, two, or none?
//! A vertex is where the curve of two surfaces meets a third one. Along a curve that meets a
//! surface in a contact of order k the surface's value goes like s (t - t₀)ᵏ, and a rounding of ρ
//! in it moves or makes roots within
//!
//! ```text
//! |t - t₀| <= (ρ / s)^(1/k):      half of the digits at k = 2, a quarter at k = 4.
//! ```
//!
//! Three surfaces have three curves, and on each of them rounding makes another number of roots at
//! other places. Their order along the curves, from which contours are linked, would contradict
//! itself. So ([`arrangement/triple.rs`][arrangement/triple.rs]):
//!
//! 1. On each curve roots between which the third surface stays within
//!    [`DOUBTFUL`][numeric/tolerance.rs] = 1000 roundings are one
//!    [`Cluster`][arrangement/triple.rs]. It is a contact by what this curve tells if the surface
//!    stays within *one* rounding, at 0.2, 0.5 and 0.8 of the way.
//! 2. [`contacts`][arrangement/triple.rs] gathers the doubtful clusters of all three curves, the
//!    sharpest first: how far along its curve each may as well be is its blur. If one of the three
//!    tells that it is a contact, those that cannot be told from it are the same contact: balls
//!    around them overlap, or all between them is common to the three surfaces
//!    ([`Ball::is_same`][arrangement/triple.rs]).
//! 3. Its one point is an apex or a node of a pair if there is one, else where the curve on which
//!    it is sharpest runs along the third surface: the root of the *derivative* of the distance
//!    ([`Triple::nearest`][arrangement/triple.rs]), which has all digits where the distance itself
//!    has half.
//!
//! Whoever asks, in whatever block and with the surfaces in whatever order, is told the same:
//! [`Relations`][arrangement/relations.rs] keeps each answer, by surfaces in ascending order. Two
//! threads may decide at once; they decide alike.
//!
//! # Which number is nothing?
//! All of these are rows of [`numeric/tolerance.rs`][numeric/tolerance.rs]: with ε, a share of the
//! scene, and one of three reasons, *derived* from rounding, *above rounding* by a margin that is
//! named, or a *decree*. What one row decides bounds the next ones: vertices are welded within
//! [`WELD`][numeric/tolerance.rs], so planes whose lines are told apart by less are parallel
//! ([`PARALLEL_PLANES`][numeric/tolerance.rs]), and lines nearer to a plane than a tenth of it are
//! in that ([`ON_PLANE`][numeric/tolerance.rs]).
//!
//! # What is not decided
//! Where contours stay open although all of this was decided, the evaluation says so and where
//! ([`Undecided`](crate::Undecided)), and surfaces are settled in the next way. No relation is
//! guessed twice within one evaluation.
//!
//! [arrangement/mod.rs]: ../../../src/csg/arrangement/mod.rs.html
//! [arrangement/pencil/contact.rs]: ../../../src/csg/arrangement/pencil/contact.rs.html
//! [arrangement/relations.rs]: ../../../src/csg/arrangement/relations.rs.html
//! [arrangement/triple.rs]: ../../../src/csg/arrangement/triple.rs.html
//! [numeric/tolerance.rs]: ../../../src/csg/numeric/tolerance.rs.html
//! [program/settle.rs]: ../../../src/csg/program/settle.rs.html
//! [program/settle/chains.rs]: ../../../src/csg/program/settle/chains.rs.html
//! [program/settle/distance.rs]: ../../../src/csg/program/settle/distance.rs.html
//! [program/unify.rs]: ../../../src/csg/program/unify.rs.html
//! [settling.rs]: ../../../src/csg/settling.rs.html
//! [surface/kind.rs]: ../../../src/csg/surface/kind.rs.html
