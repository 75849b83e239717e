//! The curves of two quadrics, in closed form.
//!
//! # The pencil
//! Points common to Xᵀ A X = 0 and Xᵀ B X = 0 are on every quadric of the pencil
//!
//! ```text
//! M(φ) = cos φ A + sin φ B,
//! ```
//!
//! and any two of these have the same curve in common. So one takes the one on which the curve is
//! known best. J. Levin (*A Parametric Algorithm for Drawing Pictures of Solid Objects Composed of
//! Quadric Surfaces*, Communications of the ACM 19, 1976) showed that there always is one with
//! straight lines on it, and that the other quadric meets each line at most twice: a square root in
//! one parameter. L. Dupont, D. Lazard, S. Lazard and S. Petitjean (*Near-Optimal Parameterization
//! of the Intersection of Quadrics* I-III, Journal of Symbolic Computation 43, 2008) classify all
//! pencils and work in projective space, where cylinders are cones with a vertex at infinity and
//! nothing is special there. This code takes its parametrisations from there, in doubles, and falls
//! back on other members of the pencil where theirs choose numbers to be exact.
//!
//! # Before there is a pencil
//! [`curves`][arrangement/pairs.rs] takes out what is simpler:
//!
//! - Two planes meet in a line ([`line`][arrangement/intersection.rs]).
//! - A plane and a quadric meet in a conic ([`conic`][arrangement/conic.rs]): f on the plane, as a
//!   form about its principal axes, is an ellipse, one or two branches of a hyperbola, a parabola
//!   or lines. If the centre is so far away that digits would be lost the same conic is given from
//!   a vertex or a point of it, as (t a + t² b) / (1 + l t + k t²).
//! - Quadrics of the same quadratic part but for a factor, as all spheres are, meet in the radical
//!   plane f - λ f' = 0, which is linear, and so in a conic.
//! - Quadrics of revolution about one axis, as those of turned parts are, meet in circles
//!   ([`circles`][arrangement/coaxial.rs]): each is α ρ² + β t² + γ t + δ = 0 at the distance ρ from the
//!   axis, and α' f - α f' = 0 is an equation of degree two in t, about the middle between its roots,
//!   however flat or steep the two are. Where they nearly touch there, or in the axis, the pencil tells.
//! - Cylinders along one direction meet in lines ([`lines`][arrangement/parallel.rs]): through the
//!   points where the conic of one, across that direction, meets the other. Pieces of letters are
//!   nearly straight, with vertices hundreds of sizes away: the pencil's coordinates are of that size.
//!
//! # Members with lines
//! det M(φ) is of degree four in cos φ and sin φ, and the same at φ + π: in 2 φ it is a
//! trigonometric polynomial of degree two, told by five values
//! ([`Trig::through`][arrangement/trig.rs]). Its roots are the singular members. With the
//! eigenvectors of a member, each divided by √|value| ([`carrier`][arrangement/pencil.rs]):
//!
//! | signs | what it is | its lines |
//! | --- | --- | --- |
//! | +, +, -, 0 | cone or cylinder | through the vertex q, the null vector, and p(θ) = z + cos θ x + sin θ y |
//! | +, +, -, - | one-sheet hyperboloid or hyperbolic paraboloid | through p(θ) = z + cos θ x + sin θ y and q(θ) = w + cos θ y - sin θ x |
//! | four alike | no points: the two have nothing in common | |
//! | +, +, +, - | ellipsoid, hyperboloid of two sheets, elliptic paraboloid | none |
//! | others | a point, a line, planes, or nothing is sure | not used so |
//!
//! That p and q are on the second one, and all between them, is (cos² + sin²) - 1 = 0 for each and
//! -cos sin + sin cos = 0 for both. A point α p + β q of a line is on another member N where
//!
//! ```text
//! a α² + 2 b α β + c β² = 0,   a = pᵀ N p,  b = pᵀ N q,  c = qᵀ N q,
//! α : β = -b ± √(b² - a c) : a   =   c : -b ∓ √(b² - a c),
//! ```
//!
//! of which the ratio that is farther from 0 : 0 is taken ([`Rulings`][arrangement/rulings.rs]). a,
//! b and c are trigonometric polynomials of degree two, Δ = b² - a c is one of degree four. Its
//! roots cut the lines into [`Part`][arrangement/rulings.rs]s:
//!
//! - Δ > 0 all around: two closed curves, one for each sign.
//! - Δ > 0 between two roots m ± h: one closed curve, there with one sign and back with the other.
//!   With θ = m - h cos t and Δ = (cos(θ - m) - cos h) r(θ) its root is smooth in t, as
//!   cos φ - cos h = 2 sin((h + φ) / 2) sin((h - φ) / 2) is a square times what is not 0.
//! - Δ = 0 everywhere: a curve that the lines touch.
//! - c = 0 everywhere, the vertex is on the other quadric: each line has one point besides,
//!   α : β = -2 b : a.
//!
//! Where a curve goes to infinity is the root of a last coordinate, and cuts it into pieces.
//!
//! # In which order members are tried
//! [`by_members`][arrangement/pencil.rs]: pairs of planes first, as conics are the simplest curves;
//! the two surfaces themselves, whose coefficients are known best; the singular members; those next
//! to a multiple root; one between each two roots; hyperboloids last. A multiple root of the
//! determinant is parted by rounding, but not a simple one of its derivative, so multiple roots are
//! looked for there, and a member is refined by Rayleigh's quotient (B. N. Parlett, *The Symmetric
//! Eigenvalue Problem*, 1980).
//!
//! # Special positions
//! R. T. Farouki, C. A. Neff and M. A. O'Connor (*Automatic Parsing of Degenerate Quadric-Surface
//! Intersections*, ACM Transactions on Graphics 8, 1989) list them. What of them is known here:
//!
//! | position | how it is told | curves |
//! | --- | --- | --- |
//! | cones of one apex | apexes agree by [`NEAR`][numeric/tolerance.rs] | up to four lines ([`common_vertex`][arrangement/pencil.rs]) |
//! | cones or cylinders that touch along a line | the planes polar to both vertices are one | that line, and a conic in another plane ([`along_ruling`][arrangement/pencil.rs]) |
//! | they have conics in common | a member of rank two or one | conics in one or two planes, crossing in nodes ([`on_planes`][arrangement/pencil/planes.rs]) |
//! | apex on the other surface | its value, by what is near | one point besides on each line; nodes where it passes the apex ([`on_cone`][arrangement/pencil.rs]) |
//! | they touch in a point and cross around it | Δ touches 0; Q - λ Q' is indefinite there | planes, or the cone with its apex there ([`through_contact`][arrangement/pencil/contact.rs]) |
//! | they touch in a point alone | Q - λ Q' is definite, its value nothing | none, the contact is told ([`Unknown::Touch`][arrangement/intersection.rs]) |
//! | they nearly touch | the same, its value not nothing | none or a loop around it, in a pencil of the loop's own unit ([`beside_contact`][arrangement/pencil/contact.rs]) |
//! | a line in common | a line of the cone is on the other | the line, and a twisted cubic ([`beside_line`][arrangement/pencil/cubic.rs]) |
//!
//! A twisted cubic has one point besides on each line of the family that meets the common line, q
//! being on that and p on the quadric in the plane through it.
//!
//! # Digits
//! Coordinates are about the middle between the anchors and in a unit in which all coefficients are
//! of like size. Three positions lose digits all the same, and are told in other bases of the same
//! pencil or by other angles of the same lines, which changes digits only:
//!
//! - Surfaces of one shape but for little: their difference, scaled up, stands for the second one
//!   ([`what_differs`][arrangement/pencil.rs]), and what it is off goes into what is nothing.
//! - A member that is two planes but for little has its lines next to one line but for few of them:
//!   by tan(φ / 2) = tan(h / 2) tan(φ' / 2) these few become half of all
//!   ([`Lines::spread`][arrangement/rulings.rs]).
//! - A curve on few lines: the same, around these.
//!
//! # What holds
//! *Checked only*, by tests beside [`arrangement/pairs.rs`][arrangement/pairs.rs]: that points of
//! the curves are on both surfaces, and that random points common to both are on the curves, for
//! random quadrics of all kinds and in the positions above. Classes are *decided* by tolerances,
//! not proven as in exact arithmetic. Where no member gives a curve, as where several degeneracies
//! meet, the answer is [`Unknown::NoForm`][arrangement/intersection.rs]: then surfaces are
//! [settled](super::relations) or cells do.
//!
//! [arrangement/coaxial.rs]: ../../../src/csg/arrangement/coaxial.rs.html
//! [arrangement/conic.rs]: ../../../src/csg/arrangement/conic.rs.html
//! [arrangement/intersection.rs]: ../../../src/csg/arrangement/intersection.rs.html
//! [arrangement/pairs.rs]: ../../../src/csg/arrangement/pairs.rs.html
//! [arrangement/parallel.rs]: ../../../src/csg/arrangement/parallel.rs.html
//! [arrangement/pencil.rs]: ../../../src/csg/arrangement/pencil.rs.html
//! [arrangement/pencil/contact.rs]: ../../../src/csg/arrangement/pencil/contact.rs.html
//! [arrangement/pencil/cubic.rs]: ../../../src/csg/arrangement/pencil/cubic.rs.html
//! [arrangement/pencil/planes.rs]: ../../../src/csg/arrangement/pencil/planes.rs.html
//! [arrangement/rulings.rs]: ../../../src/csg/arrangement/rulings.rs.html
//! [arrangement/trig.rs]: ../../../src/csg/arrangement/trig.rs.html
//! [numeric/tolerance.rs]: ../../../src/csg/numeric/tolerance.rs.html
