//! When a mesh can run through itself, and what is done about it.
//!
//! The exact boundary does not run through itself, and vertices are on it. But chords and triangles
//! stray, and what strays may come out on the far side of what is beside it. No tolerance prevents
//! that: a wall may be thinner than any.
//!
//! # The first rule: gap against stray
//! If two sheets of the boundary are a gap apart and their triangles stray from them by at most s
//! and t ([deviation](super::deviation)), then
//!
//! ```text
//! gap > s + t:    they do not meet.
//! ```
//!
//! A common point would be within s of a point of the one sheet and within t of one of the other.
//!
//! So it is only walls, gaps, and places where faces come together that need care: edges and
//! corners, and contacts. s and t fall with the square of the size of triangles. Where the gap does
//! not, as in a wall of constant thickness or between faces that meet at an angle, fine enough
//! triangles end it. Where it falls as the square, too, as next to a contact, they never do if they
//! are as large as they are far from it.
//!
//! # The second rule: vertices side by side
//! Let vertices p₀, p₁ on one sheet have feet q₀, q₁ on the other. At the same share u of both
//! chords the gap is
//!
//! ```text
//! ((1 - u) p₀ + u p₁) - ((1 - u) q₀ + u q₁) = (1 - u) (p₀ - q₀) + u (p₁ - q₁),
//! ```
//!
//! the mean of those at the ends, and over two triangles whose corners are side by side it is the
//! mean of three. If the gaps are about in one direction, the normal's, and none is negative, then
//! no mean is: the two do not cross, *however far they stray*. All of the following puts vertices
//! side by side.
//!
//! # Edges beside each other
//! Two curves that bound one face and are nearer than their chords stray leave no room between
//! their chords ([`align`][tessellate/alongside.rs]). Pairs are chains of chords that bound a face
//! of the coarse mesh with one triangle across, where *different* surfaces meet that face: curves
//! of one pair of surfaces part where these do. Near is the distance of points of the one to the
//! surface that makes the other, to first order, against the sum of what both stray; where surfaces
//! meet at a small angle a chord strays farther along the face than from the surfaces, so it is
//! also asked how far points in a row are from straight (`sag`).
//!
//! Of those that are connected so the one with the most points leads. The others get a foot next to
//! each of its points in place of their own, as theirs would be as many, and lead on from there.
//! Vertices stay. In up to four more rounds what one has besides, also points that the tolerance
//! asks for, gets feet on the others. A foot is left out next to a vertex that is there already,
//! unless a chord from there would come nearer to the point that the foot is next to than half the
//! gap: near its ends a parabola that strays by s amid them strays by about 4 s u at the share u,
//! so it is kept if 4 s u > gap / 2.
//!
//! # Walls
//! Two whole ellipsoids whose bounds agree within the tolerance are made as one and its image
//! ([`originals`][tessellate/mirror.rs], [`image`][tessellate/mirror.rs]): the one is refined, each
//! vertex is brought to the other surface, and triangles are turned over if one of them is a void.
//! Every triangle of the image is bounded and must face outward; else the part is refined by
//! itself.
//!
//! Faces of a wall that is cut open are looked for after refining, where triangles are found to run
//! through each other ([`mirrored`][tessellate/mirror/faces.rs]). Two faces correspond if their
//! corners do, each the nearest to the other, and their chains of edges, end to end and no farther
//! apart than twice the tolerance. From there matching goes on over each pair of chains to the
//! faces beyond, unless these are of one surface: that is the wall's rim. All must correspond, or
//! none does. Then the one side is the image of the other, vertex by vertex, rims are strips of as
//! many chords on both sides or planes triangulated anew, and the whole is measured again. It is
//! kept if fewer triangles run through each other than before.
//!
//! # Faces that meet at an edge
//! The two triangles at an edge have its chord in common, and nothing else unless they are in one
//! plane. But if they tilt from their faces by more than the angle α between these they change
//! sides, and what adjoins them must cross. A triangle of height h on a surface of curvature κ
//! tilts by about κ h / 2, so
//!
//! ```text
//! h < 2 α / (κ₁ + κ₂)
//! ```
//!
//! is about enough. There is *no rule* in the code that asks for it beforehand. Triangles must face
//! as their surface does, in the middle within a cosine of 0.2 and elsewhere at all
//! ([`faces_out`][tessellate/shape.rs]); sharp edges at which this is not enough are found by the
//! check and cut until it is, which ends as α does not depend on h. Where α falls to 0 along an
//! edge, at a contact, only the second rule helps.
//!
//! # The check, and what follows it
//! [`Mesh::self_intersections`](crate::Mesh::self_intersections) finds all pairs of triangles that
//! run through each other, exactly for the coordinates as they are: by boxes, then by signs of
//! determinants (J. R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates*, Discrete & Computational Geometry 18, 1997; P. Guigue and O. Devillers,
//! *Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates*, Journal of
//! Graphics Tools 8, 2003). Sharing a vertex, or lying edge on edge, is contact and no crossing.
//! Triangles that face into the solid count as well. What is found is treated in this order
//! ([`refine_wrong`][mesher/run/tolerance.rs]):
//!
//! 1. The mesh as it came from the contours hardly ever runs through itself, be its faces as near
//!    to each other as they may: it is refined once more with every vertex where it is there, so
//!    that nothing is made coarser ([`Goal`][tessellate/goal.rs]).
//! 2. Faces become images of each other, as above.
//! 3. [`Parting::Farthest`][tessellate/separate.rs]: sides of the two triangles that stray farthest
//!    are cut at points of their surfaces, up to 14 rounds. By the first rule that ends it where
//!    surfaces do not touch.
//! 4. [`Parting::Beside`][tessellate/separate.rs]: where they do, triangles are cut beside corners
//!    of the other one that are between a triangle and its surface, and else beside the points
//!    where sides run through triangles ([`sides_beside`][tessellate/beside.rs]): that is the
//!    second rule.
//! 5. If the mesh still runs through itself, 2 to 4 are done to the mesh that was refined freely.
//! 6. What is left makes the mesher [settle](super::relations) surfaces and evaluate with shorter
//!    chords, and at last is told.
//!
//! # What holds
//! *Checked only*: that a mesh of curved faces does not run through itself. No rule above is a
//! guarantee: feet are along gradients, not along one normal; gaps at corners of three curves may
//! point in different directions; lists of pairs come from the coarse mesh. The check is *exact*,
//! so that a mesh that runs through itself is never handed over without a word: each place is in
//! [`Report::fallbacks`](crate::Report::fallbacks) (unless checks were switched off). Meshes of
//! planes alone are exact, and their faces do not stray.
//!
//! [mesher/run/tolerance.rs]: ../../../src/csg/mesher/run/tolerance.rs.html
//! [tessellate/alongside.rs]: ../../../src/csg/tessellate/alongside.rs.html
//! [tessellate/beside.rs]: ../../../src/csg/tessellate/beside.rs.html
//! [tessellate/goal.rs]: ../../../src/csg/tessellate/goal.rs.html
//! [tessellate/mirror.rs]: ../../../src/csg/tessellate/mirror.rs.html
//! [tessellate/mirror/faces.rs]: ../../../src/csg/tessellate/mirror/faces.rs.html
//! [tessellate/separate.rs]: ../../../src/csg/tessellate/separate.rs.html
//! [tessellate/shape.rs]: ../../../src/csg/tessellate/shape.rs.html
