//! All points in which a surface meets a curve: roots that are not missed.
//!
//! Between two vertices of a curve nothing changes around it, so that the formula is evaluated once
//! for each stretch. A root that is missed would make a stretch of two, and a boundary that is
//! open. So roots are not looked for from guesses but by exclusion: an interval is done when it is
//! shown to have none or one.
//!
//! # Along a curve a surface is a polynomial
//! [`Curve::meet`][arrangement/curve.rs] puts the curve into f:
//!
//! | curve | f along it | most roots |
//! | --- | --- | --- |
//! | line | quadratic in t, solved about where the line runs along the surface | 2 |
//! | ellipse | of degree 2 in cos t and sin t | 4 |
//! | branch of a hyperbola | of degree 2 in cosh t and sinh t | 4 |
//! | parabola, conics by their vertex | of degree 4 in t, times a square that is about 1 | 4 |
//! | on lines of a quadric, and a plane | a q² - 2 b p q + c p², of degree 4 in cos θ and sin θ | 4 in space, on both branches |
//! | the same, and a quadric | (a c')² - 4 (a b') (b c'), of degree 8 | 8, as Bézout says |
//!
//! Of the last two p and q are the plane's values at the ends of a line, (a c') = a c' - c a' and
//! so on are minors of the two quadratic forms: it is their resultant, which is 0 on lines on which
//! both have a common root α : β. Roots of a resultant are *candidates*: each is on one of two
//! branches, or on neither next to where these end. [`Rulings::candidates`][arrangement/rulings/candidates.rs]
//! says where on the curve they would be, and [`find_at`][arrangement/roots.rs] tells by the sign
//! of f itself between candidates at which of them the curve crosses. Where the resultant vanishes
//! identically the curve, or the other branch, lies in the surface
//! ([`beside_branch`][arrangement/rulings/candidates.rs]).
//!
//! A sum Σ cₖ cos kt + sₖ sin kt ([`Trig`][arrangement/trig.rs]) is evaluated by Horner's rule on
//! the unit circle. Its amplitudes Aₖ = √(cₖ² + sₖ²) bound all it can be, |f| <= Σ Aₖ, and its
//! derivatives,
//! |f⁽ⁿ⁾| <= Σ kⁿ Aₖ. If |A₀| is more than all others together there is no root at all.
//!
//! # The test of an interval
//! Let |f''| <= B on [a, b] of width w ([`Roots::find_in_part`][arrangement/roots.rs]).
//!
//! *None.* f differs from the chord through its ends by at most B w² / 8. So if both ends have one
//! sign and
//!
//! ```text
//! min(|f(a)|, |f(b)|) > B w² / 8 + δ,
//! ```
//!
//! f is nowhere within δ of 0. (Where δ differs from place to place it is that of the ends.)
//!
//! *One.* f' is somewhere (f(b) - f(a)) / w and changes by at most B w. So if
//!
//! ```text
//! |f(b) - f(a)| > B w²,
//! ```
//!
//! f' has no root: f rises or falls, and has one root if the signs of the ends differ, which
//! Ridders' method finds between them (C. Ridders, *A New Algorithm for Computing a Single Root of
//! a Real Continuous Function*, IEEE Transactions on Circuits and Systems 26, 1979,
//! [`bracketed`][arrangement/roots.rs]), else none.
//!
//! *Neither.* The interval is halved. Around a simple root the second test holds once B w < |f'| /
//! 2 or so, away from roots the first: only next to multiple roots halving goes on. This is the
//! exclusion test of interval analysis (R. E. Moore, *Interval Analysis*, 1966) with a bound of
//! second order.
//!
//! B is the smaller of what f'' can be anywhere and |f''(middle)| + w / 2 max|f'''|
//! ([`bend_within`][arrangement/roots.rs]): next to a contact of higher order f'' itself is next to
//! 0, and the first alone would halve to the end.
//!
//! # Multiple roots, and rounding
//! Values below δ are as good as 0. For lines and conics that is a distance, TOUCH of the scene
//! times the slope there, and what rounding does to the terms. An interval over which f cannot
//! leave δ by more than a tenth, or that is one place after 40 halvings, is *next to 0*. Intervals
//! next to 0 that follow each other are one place, which is refined to where f is nearest to 0, by
//! f' = 0 or golden sections. A change of sign within it is a root as well as a contact. What
//! contacts of three surfaces are, in the end, is [decided for all three curves](super::relations).
//!
//! If a place next to 0 is longer than a sixteenth of the range, or there are more than 16,384
//! intervals, the roots are *lost*: the function is next to 0 for long, as if the curve lay in the
//! surface but for digits. Then nothing is told of it, and the stage above says
//! [`Undecided`](crate::Undecided).
//!
//! # What holds
//! *Proven* for the polynomial as it was computed: no root is missed outside of places within δ of
//! 0, and between two such places f has the sign that it is taken to have. *Decided*: what is
//! within δ. Coefficients are rounded and not enclosed by intervals: δ holds what that does to
//! values ([`POLYNOMIAL`][numeric/tolerance.rs] and [`CANCELLED`][numeric/tolerance.rs] of the
//! magnitudes, [`VALUE`][numeric/tolerance.rs] of the terms). *Checked only*, beside
//! [`arrangement/roots.rs`][arrangement/roots.rs] and [`arrangement/trig.rs`][arrangement/trig.rs]:
//! products of known factors give back their roots.
//!
//! Closed curves begin at an odd angle (`BEGIN`) and are searched from a place where f is clearly
//! not 0, so that no root of a symmetric model is at the seam of the parameter, to be found twice
//! or never.
//!
//! [arrangement/curve.rs]: ../../../src/csg/arrangement/curve.rs.html
//! [arrangement/roots.rs]: ../../../src/csg/arrangement/roots.rs.html
//! [arrangement/rulings/candidates.rs]: ../../../src/csg/arrangement/rulings/candidates.rs.html
//! [arrangement/trig.rs]: ../../../src/csg/arrangement/trig.rs.html
//! [numeric/tolerance.rs]: ../../../src/csg/numeric/tolerance.rs.html
