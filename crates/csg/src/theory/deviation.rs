//! How far a mesh strays from the boundary: the proof behind
//! [`Report::deviation`](crate::Report::deviation).
//!
//! The bound is of both directions: no point of the mesh is farther from the boundary, and no point
//! of the boundary from the mesh. Nothing is sampled.
//!
//! # The way along the gradient
//! From a point x where f(x) > 0 go down against the gradient, at speed 1. Then f falls at the rate
//! |∇f|, and with e = ∇f / |∇f|
//!
//! ```text
//! d|∇f| / ds = -eᵀ H e >= -λ,    λ the greatest eigenvalue of H, or 0:
//! ```
//!
//! on a way of length s the gradient's length shrinks by at most L s, L = λ. On the way up from f <
//! 0 it is L = -(the least eigenvalue), or 0 ([`Shrinkage`][tessellate/deviation.rs]). If D is any
//! bound of the length of the way, it ends at f = 0 within
//!
//! ```text
//! T(D) = |f(x)| / (|∇f(x)| - L D).
//! ```
//!
//! If T(D) <= D the way cannot be longer than D, as up to there the gradient was long enough, and
//! so T(D) itself is a bound ([`shrunk`][tessellate/deviation.rs] tries D = 1.25 T(0), then twice
//! what came of it, and says infinite if neither will do). The distance is at most the length of
//! the way.
//!
//! Of spheres, ellipsoids, cylinders and elliptic paraboloids f or -f is convex. Triangles with
//! corners on such a surface are within, and from there the gradient only grows: L = 0.
//!
//! # Over a triangle
//! At p = Σ λᵢ pᵢ, λᵢ >= 0, Σ λᵢ = 1, f is a quadratic polynomial and a component of ∇f a linear
//! one:
//!
//! ```text
//! f(p) = Σ λᵢ f(pᵢ) + Σ_{i<j} 2 bᵢⱼ λᵢ λⱼ,   2 bᵢⱼ = -(pᵢ - pⱼ)ᵀ Q (pᵢ - pⱼ),
//! |∇f(p)| >= ∇f(p)·u = Σ sᵢ λᵢ,              u a unit vector, sᵢ = ∇f(pᵢ)·u - L D.
//! ```
//!
//! u is about the gradient where the triangle is farthest off; any would be right. With sᵢ > 0, by
//! Cauchy and Schwarz Σ sᵢ λᵢ = (Σ sᵢ λᵢ)(Σ λᵢ) >= (Σ √sᵢ λᵢ)², so that in μᵢ = √sᵢ λᵢ
//!
//! ```text
//! |Σ 2 bᵢⱼ λᵢ λⱼ| / Σ sᵢ λᵢ <= |Σ 2 b'ᵢⱼ μᵢ μⱼ| / (Σ μᵢ)²,   b'ᵢⱼ = bᵢⱼ / √(sᵢ sⱼ):
//! ```
//!
//! a quadratic form on a triangle again, whose extremes are at the middles of sides or where its
//! derivatives are 0 ([`largest_on_triangle`][tessellate/deviation.rs]). Corners are on the surface
//! but for the precision of the mesh; what f is there is added. Of indefinite forms the part where
//! f < 0 and the part where f > 0 have L of their own ([`Ratio`][tessellate/deviation.rs]). Of fine
//! triangles all that was given away is of second order beside the bound: it is tight, and tests
//! next to it hold it against dense samples, within 5 % for spheres and cylinders.
//!
//! ```
//! # fn main() -> Result<(), csg::Error> {
//! use csg::{Mesher, Program, Solid};
//!
//! // A chord of an arc of angle a is r (1 - cos(a / 2)) off: the bound is no larger than asked
//! // for, and not much smaller, as triangles are as large as it permits.
//! let ball = Program::lower(&Solid::sphere(2.0))?;
//! let meshed = Mesher::new().tolerance(0.01).mesh(&ball)?;
//! let proven = meshed.report.deviation.expect("a tolerance was asked for");
//! assert!(proven <= 0.01 && proven > 0.008);
//! # Ok(())
//! # }
//! ```
//!
//! # Where gradients turn too fast
//! - *The apex of a cone.* There ∇f = 0. A triangle with a corner at the apex is bounded on the
//!   opposite side alone, as f and the distance are homogeneous about it. One that goes by the apex
//!   closely is compared with one whose nearest corner, or nearest two, are moved there: no point
//!   is moved farther than these ([`of_triangle`][tessellate/deviation.rs]).
//! - *Elongated ellipsoids, cylinders and cones.* An affine map makes them round
//!   ([`Round`][surface/round.rs]). Ways from the ball's centre, or at right angles from the axis,
//!   map a triangle that faces outward there onto the surface, and what they are long in space is a
//!   bound.
//!
//! # Along a chord
//! Edges between faces are chords of the curve of two surfaces
//! ([`of_chord`][tessellate/deviation/chord.rs]). If one surface is a plane, all of the above is
//! done within it: f = 4 m λ μ, m its value in the middle, over a slope that is at least 4 √(s t) λ
//! μ gives m / √(s t). Else with F = (f, f') scaled to unit gradients, J its Jacobian and J⁺ the
//! pseudoinverse, the way is
//!
//! ```text
//! x' = -J(x)⁺ F,     length <= |J⁺ F| / (1 - |J⁺| E),     |J⁺| = 1 / √(1 - |cos(∇f, ∇f')|),
//! ```
//!
//! E being by how much J changes: from the middle of the chord on at a constant rate, and by the
//! Hessians' norm for each length of the way. Next to a place where the surfaces touch |J⁺| proves
//! nothing; there a part of the chord is no farther from the curve than from the chord's end, and
//! parts are halved towards it. If they touch at both ends they do so all along the curve, one
//! surface goes on where the other ends, and the distance to both is bounded.
//!
//! # The other direction
//! Where the gradient is nowhere at a right angle to a triangle's normal the ways along it map the
//! triangle one to one onto a patch of the surface. Patches of neighbours meet along the images of
//! their common side; at an edge of the solid they meet within the sliver between the curve and its
//! chord, all of which is as near to the chord as `of_chord` says. As the mesh is closed and each
//! face is covered up to its edges, every point of the boundary is the image of a point of the mesh
//! that is as near as was bounded, or in such a sliver.
//!
//! # What else is counted
//! If surfaces were [settled](super::relations) the bound of how far they were moved is added, and
//! of how far edges and corners were moved with them, to first order: the sharper, the farther
//! ([`farthest`][settling/spread.rs]). Walls and gaps that are no more than so thin may be lost or
//! new, however long they are: the bound is then of the solid whose surfaces are moved so. Of
//! planes alone nothing is refined: the bound is the largest distance of a vertex from the planes
//! of its triangles.
//!
//! # What holds
//! *Proven*, where the report has no fallback ([`Report::is_proven`](crate::Report::is_proven)):
//! both bounds. What is not proven for a triangle or chord is no failure of a guess but a place in
//! [`Report::fallbacks`](crate::Report::fallbacks): the surface is refined with a smaller
//! tolerance, and if that does not help either, it is said. *Rests on*: that the mesh has the
//! boundary's topology, which it has from the contours; and on double arithmetic, in which bounds
//! are right to some ε of themselves and are not rounded outward.
//! *Checked only*: that triangles face outward, which is asked where they are cut up
//! ([`faces_out_everywhere`][tessellate/shape.rs]) and looked at once more in the end
//! ([`faces_in`][tessellate/shape.rs]); that none [run through each other](super::crossing).
//!
//! [settling/spread.rs]: ../../../src/csg/settling/spread.rs.html
//! [surface/round.rs]: ../../../src/csg/surface/round.rs.html
//! [tessellate/deviation.rs]: ../../../src/csg/tessellate/deviation.rs.html
//! [tessellate/deviation/chord.rs]: ../../../src/csg/tessellate/deviation/chord.rs.html
//! [tessellate/shape.rs]: ../../../src/csg/tessellate/shape.rs.html
