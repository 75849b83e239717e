//! What is the same, what is nothing, what is on what: every question of geometry that
//! rounding makes one of degree, each once, with its one answer.
//!
//! Shares are of the scene's longest side where nothing else is said. *Derived* answers
//! follow from the unit of rounding ε or from other answers here. *Above rounding* are those
//! of which rounding tells how small they may be, and a margin that is named was chosen.
//! *Decrees* could be others, within what is said of them. What tunes speed or the number of
//! triangles alone is beside the code that it tunes.

// Rounding itself.

/// How far may a coordinate be off after a sum or two, of the coordinates summed?
///
/// Derived: corners of boxes are `middle ± half` of `(low + high) / 2` and `(high - low) / 2`,
/// four roundings of at most ε / 2 of |low| + |high|; twice that, and twice again for what
/// the other side of a comparison is off.
pub(crate) const COORDINATE: f64 = 8.0 * f64::EPSILON;

/// How far may the value of a surface's function be off, of the sum of its terms' magnitudes,
/// and how far points of the boundary, of their distances from the origin?
///
/// Derived: fewer than 16 roundings, each of at most ε / 2, lie on the way from any coefficient
/// to the value or to the interval around it.
pub(crate) const VALUE: f64 = 16.0 * f64::EPSILON;

/// How far is the value of a surface's function off, of its terms' magnitudes in vectors?
///
/// Derived: the same as [`VALUE`] without the margin that makes it a bound: roundings are of
/// either sign.
pub(crate) const USUAL_VALUE: f64 = 4.0 * f64::EPSILON;

/// How far are points off that went through maps or solvers, of the largest coordinate; and of
/// which map is nothing left, by its determinant over the product of its columns' lengths?
///
/// Derived: a product of matrices adds at most 6 ε, a chain of ten is still below. A determinant
/// that small has not one correct digit. A tolerance below cannot be kept.
pub(crate) const MAPPED: f64 = 64.0 * f64::EPSILON;

// Points on surfaces.

/// Is a point on a surface that a solver put there?
///
/// Above rounding: values are right to [`VALUE`], of terms that sum up to some ten sizes of the
/// scene times the slope: 4e-14; five times that, as slopes may be less than the steepest one.
pub(crate) const ON_SURFACE: f64 = 2e-13;

/// Is a point of a mesh that is refined on its surface, of the farthest coordinate?
///
/// Decree: five times [`ON_SURFACE`], as vertices come from any of the ways of meshing, and
/// from the longest chains of solvers. The precision of all refinement depends on it.
pub(crate) const ON_REFINED: f64 = 5.0 * ON_SURFACE;

/// Is a line in a plane?
///
/// Decree: a tenth of [`WELD`], so that vertices on it are one still where a third plane meets it
/// at a sine of a tenth.
pub(crate) const ON_PLANE: f64 = 0.1 * WELD;

/// Are two points one vertex?
///
/// Decree: above what three planes that meet at sines of a thousandth make of [`VALUE`], and a
/// thirtieth of [`NEAR`]. What is nearer in the model is settled before.
pub(crate) const WELD: f64 = 3e-11;

/// Does a curve touch a surface that it does not cross, and do two surfaces?
///
/// Above rounding: values along curves are right to [`VALUE`], and to some more where curves are
/// computed from several factors; 28 times that. Its square root, 3e-7, is how far from a contact
/// surfaces are told apart: what is farther from touching has two roots along all three curves
/// of three surfaces.
pub(crate) const TOUCH: f64 = 1e-13;

/// Is a point of a curve where another point is, is an ellipse a circle, is a length nothing
/// beside another one?
///
/// Decree: far above [`VALUE`], and no tolerance asked for is below. Surfaces that are nearer to
/// each other all over are made one before.
pub(crate) const NEAR: f64 = 1e-9;

/// The same of a mesh that is refined, in its own precision.
///
/// Derived: [`NEAR`] over the precision of a mesh around the origin, whose farthest coordinate is
/// half of its side, but for the factor of two.
pub(crate) const NEAR_OF_REFINED: f64 = NEAR / ON_REFINED;

/// Is a vertex on a conic of two surfaces, in precisions of a mesh that is refined?
///
/// Derived: where surfaces cross at a sine of [`CROSSING`], points within the precision of both are
/// as many precisions from their curve.
pub(crate) const ON_CONIC: f64 = 1.0 / CROSSING;

/// Do curves have the same curvature: over the length of the scene they part by no more than
/// what is near.
///
/// Derived from [`NEAR`].
pub(crate) const SAME_BEND: f64 = NEAR;

/// Are two points one next to where surfaces touch, in distances below which others are?
///
/// Derived: where a curve touches a surface to the fourth order, a place is known to a quarter
/// of the digits: ε^(1/4) is 1e-4, and this much of [`WELD`] is 3e-5.
pub(crate) const TOUCHING_REACH: f64 = 1e6;

/// May contacts of three surfaces, each told along another of their curves, be one, in distances
/// below which other points are, if all between the two is common to the three?
///
/// Derived: a curve may cross a surface to the fifth order where the other two surfaces of its
/// three meet the third in a contact of the fourth, and is within rounding of it as far as a fifth
/// of the digits tells: ε^(1/5) is 7e-4, and this much of [`WELD`] is 1e-3.
pub(crate) const BLURRED_REACH: f64 = 3e7;

/// May rounding alone have made two roots along a curve, in roundings that the surface stays
/// within between them, if another curve of the same three surfaces tells so?
///
/// Decree: as many as where two of the three meet at a sine of a thousandth, which makes so much
/// of one rounding. What is between this and one rounding is a contact only if it is one on
/// another curve.
pub(crate) const DOUBTFUL: f64 = 1e3;

// Directions.

/// Are two planes parallel, by the sine of their angle?
///
/// Derived from [`WELD`]: over the scene's diagonal, of at most √3 sides, they part by less than
/// one vertex from another, so that no vertex tells which way their line runs.
pub(crate) const PARALLEL_PLANES: f64 = WELD / 3.0;

/// Do surfaces touch at a point common to both, by the sine of the angle between gradients; and
/// which values of a form taken at a contact are nothing?
///
/// Derived: points within a share s of both surfaces are up to √(2 s) radii of curvature from
/// where these touch, and the sine there is as much; with [`ON_REFINED`] it is 1.4e-6.
pub(crate) const TOUCHING: f64 = 1e-6;

/// The same of surfaces that are said to touch at both ends of an edge.
///
/// Derived: ends may be contacts of the fourth order, known to a quarter of the digits, ε^(1/4).
pub(crate) const TOUCHING_AT_ENDS: f64 = 1e-4;

/// Do surfaces cross at an angle at which a point of their curve is found by Newton's plain steps,
/// and bends of the curve by the quotients that they are?
///
/// Decree: two digits of sixteen are lost by it. Elsewhere slower ways are taken.
pub(crate) const CROSSING: f64 = 1e-2;

/// Is there no step across two gradients, by the sine of their angle?
///
/// Decree: beyond a hundredth of [`TOUCHING`] a step is a hundred million times as long as the
/// surfaces are far, and would leave the neighbourhood.
pub(crate) const DEPENDENT_IN_STEP: f64 = 1e-8;

/// Are directions around a point or a curve the same, in radians?
///
/// Derived: next to where surfaces touch, points are known to half of the digits, and directions
/// turn by as much: √[`VALUE`] is 6e-8.
pub(crate) const SAME_DIRECTION: f64 = 1e-7;

/// Do lines and curves leave a point in the same direction, or are lines around a point the
/// same, in radians, where the point is known to all digits?
///
/// Derived from [`NEAR`]: over the length of the scene they part by no more than what is near.
pub(crate) const SAME_ANGLE: f64 = NEAR;

/// Are unit normals dependent but for rounding, by their cross or triple product, over a cell of
/// which it is bounded by intervals?
///
/// Decree: above the rounding of such products, some ε, so that surfaces that touch are not said
/// to cross; cells in which it is less are split.
pub(crate) const DEPENDENT_IN_CELL: f64 = 1e-9;

// Coefficients.

/// Is a value of a quadratic form nothing, of the largest?
///
/// Above rounding: Jacobi's method leaves some ten ε, 2e-15, and coefficients that an author
/// wrote in decimals and turned a few more; five hundred times that. The kind of a quadric given
/// by ten coefficients depends on it.
pub(crate) const NO_VALUE: f64 = 1e-12;

/// Is a quadric's centre, vertex or apex so far away, by squares of distances in sizes of the part that
/// is there, that it is kept about that part?
///
/// Decree: f about a point so far away loses two digits that the coefficients have.
pub(crate) const FAR_CENTRE: f64 = 100.0;

/// Are two values of a quadric's form one, of the larger: is it round, and no ellipse?
///
/// Above rounding: the same as [`NO_VALUE`], as values come from the same coefficients. What is
/// taken to be round is by half as much of its radius off.
pub(crate) const ROUND: f64 = NO_VALUE;

/// Is a sum of terms nothing, of their sizes: a coefficient of a combination of surfaces, or of
/// a polynomial along a curve?
///
/// Above rounding: products of up to four factors whose coefficients are known to 1e-13 or so, of
/// up to nine terms, are right to 4e-12; over twice that.
pub(crate) const CANCELLED: f64 = 1e-11;

/// Is the discriminant of a quadratic equation along a curve 0, or a point of it at infinity?
///
/// Above rounding: products of two factors, not of four, a tenth of [`CANCELLED`].
pub(crate) const NO_DISCRIMINANT: f64 = 0.1 * CANCELLED;

/// Are values of a computed form the same, or nothing, of the largest?
///
/// Decree: they are right to about 1e-14, at a contact that was looked for by steps to 1e-11. On it
/// depend bounds between surfaces of one kind, how cells tell a contact from a crossing, and in
/// which directions a step of least squares goes.
pub(crate) const SAME_VALUE: f64 = 1e-10;

/// Is a polynomial in sine and cosine 0, of its magnitude?
///
/// Above rounding: its terms, of degree eight at most, are right to some ε each; forty-five ε.
pub(crate) const POLYNOMIAL: f64 = 1e-14;

/// Is a root of such a polynomial a multiple one?
///
/// Decree: at a root of a derivative known to all digits, the value is right to [`POLYNOMIAL`]; a
/// hundred thousand times that, as nearly multiple roots are tried as such and refined.
pub(crate) const MULTIPLE_ROOT: f64 = 1e-9;

/// Are two roots one, of the range in which they were looked for?
///
/// Decree: above some ε to which bisection ends, far below what [`WELD`] makes one.
pub(crate) const SAME_ROOT: f64 = 1e-13;

/// Is a point or a plane of projective coordinates at infinity, in units of the two surfaces?
///
/// Decree: what is farther than a thousand million sizes away has no place in a scene.
pub(crate) const AT_INFINITY: f64 = 1e-9;

// Polygons and polyhedra that are given.

/// Is a given corner on the plane of a face, of the polyhedron's size?
///
/// Above rounding: of a face as high as it is long, Newell's normal and an offset are right to
/// thirty ε; fifteen times that, for those that are less high.
pub(crate) const ON_FACE: f64 = 1e-13;

/// Are planes of faces the same within the size of the polyhedron?
///
/// Decree: ten times [`ON_FACE`], which holds of faces a tenth as large as the polyhedron. Points
/// that cuts made are taken to be on a plane by it, too.
pub(crate) const SAME_FACE: f64 = 10.0 * ON_FACE;

/// Are given points off the planes of their hull, so that it is none; are they corners of its
/// face?
///
/// Decree: a hundred times [`SAME_FACE`] is no longer what rounding did to a solid.
pub(crate) const OFF_HULL: f64 = 100.0 * SAME_FACE;

/// Has a polygon no area, of the square of its longest side?
///
/// Above rounding: a cross product of two differences is right to 6 ε of it; seven times that.
pub(crate) const NO_AREA: f64 = 1e-14;

/// Has a polyhedron no volume, of its size's cube?
///
/// Above rounding: it is a sum of triple products, each right to about 6 ε of it, and most of what
/// they are off by cancels.
pub(crate) const NO_VOLUME: f64 = 1e-15;

/// Is a triangle so narrow, or an angle between edges and triangles so small, that it is not told
/// what of two polyhedra crosses? By heights of what they are of, and by sines.
///
/// Derived: distances right to [`VALUE`] of the size are right to 4e-10 when divided by it, less
/// than [`NEAR`], by which they are held apart.
pub(crate) const SLANT: f64 = 1e-5;

/// Are vertices at the gaps of a mesh that is repaired one, of its longest side?
///
/// Decree: seventeen roundings of the coordinates of a file in single precision.
pub(crate) const SEWN: f64 = 1e-6;

/// Is a triangle of a mesh that is refined flat, by its height, of its longest side?
///
/// Derived: corners are within [`ON_REFINED`] of their places, so that the normal of a triangle as
/// long as the mesh is right to a hundredth; shorter ones are not told from flat ones so well.
pub(crate) const FLAT: f64 = 100.0 * ON_REFINED;

/// Do facets on one plane that look opposite ways cover each other, by what their areas differ of
/// all?
///
/// Decree: a facet that is seen is more of them in a cell that is cut by all others' planes; what is
/// told then is told of a point in the largest.
pub(crate) const COVERED: f64 = 1e-6;

/// Are edges between two planes on one line, in distances at which points are on these?
///
/// Derived: so far apart are lines that are off planes which meet at a sine of a tenth. Along lines
/// of planes that meet at lesser ones it is not told.
pub(crate) const ON_LINE: f64 = 10.0;

/// Is a length in a profile nothing, of its size, or a turn, in radians?
///
/// Above rounding: arcs are told by bulges, whose centre, angles and ends lie some hundred
/// roundings from what was given, 2e-14 of the size; fifty times that. Whether paths are closed,
/// and whether circles stay circles under a map, depends on it.
pub(crate) const IN_PROFILE: f64 = 1e-12;

/// Is a side of a profile that is turned level, by its rise?
///
/// Decree: of a cone a millionth as high as wide, whose coefficients differ by its square, six digits
/// tell where it meets others. By how much that moves it is told.
pub(crate) const LEVEL: f64 = 1e-6;

/// Is the sum of a polygon's turns a single whole one, in radians?
///
/// Decree: it is a whole number of turns but for rounding, so anything between would do.
pub(crate) const WHOLE_TURN: f64 = 1e-6;

/// How far may chords stray from a profile's arcs, of its size, where they cannot be kept and
/// nothing else is asked?
///
/// Decree: nothing to be seen. Extrusions, revolutions, offsets and hulls of circles that become
/// polygons depend on it.
pub(crate) const PROFILE_CHORD: f64 = 1e-4;

/// Is a mesh where its program is, at least, if no tolerance was asked for?
///
/// Decree: a thousandth of what a picture shows of the solid. What is less than this is not
/// reported as wrong.
pub(crate) const HELD: f64 = 1e-6;

// Of moves of surfaces.

/// How far may surfaces be moved, of the tolerance?
///
/// Decree: so little that what is left of the tolerance takes half a percent more triangles.
pub(crate) const UNSEEN: f64 = 0.01;

/// So many times as far, where there is no other way?
///
/// Decree: a tenth of the tolerance then, for which what is left of it takes five percent more
/// triangles.
pub(crate) const SEEN: f64 = 10.0;

/// Are two lengths the same that maps made, of these?
///
/// Above rounding: some thousand times that of one, as long chains of maps make.
pub(crate) const SAME_LENGTH: f64 = 1e-12;

/// Do columns of a matrix that was written in six digits make a turn, of their lengths?
///
/// Derived: entries are off by up to 5e-7, and so lengths of columns by √3 times that. Two of these
/// differ, and two columns are off the right angle, by no more than twice as much, 1.8e-6.
pub(crate) const SIX_DIGITS: f64 = 3e-6;

/// Was something meant that is missed by less, of the scene?
///
/// Above rounding: numbers of six digits are off by up to five millionths of themselves.
pub(crate) const MISSED: f64 = 5e-6;

/// By how much may something be missed, of what surfaces may move?
///
/// Decree: by half of it, as some are moved for several reasons.
pub(crate) const SHARE_MISSED: f64 = 0.5;

/// How far may edges and corners be moved with surfaces, of the tolerance?
///
/// Decree: the rest is enough for chords and triangles; what is sharper is reported.
pub(crate) const MOVED_AT_EDGES: f64 = 0.5;

/// On which side of a triangle is its surface's outside, by the cosine between their normals?
///
/// Decree: one that is turned farther from its surface does not tell; others of the face do.
pub(crate) const TELLS_SIDE: f64 = 0.5;

// Of boundaries.

/// Does a curve pass through one point in one go, by its parameter where two pieces of it meet
/// there, in radians?
///
/// Above rounding: where a curve passes through itself its parameters differ by an angle between
/// two surfaces, and parameters of one place agree to the square root of [`WELD`] at worst, 5e-6,
/// where it touches what cuts it; two hundred times that.
pub(crate) const SAME_PLACE: f64 = 1e-3;

/// Is a point of a surface on the sheet of it that a chart shows, of the scene?
///
/// Above rounding: a graph is computed by a square root, of whose argument 1e-14 may be lost where
/// it turns away from the eye, and so 1e-7 of the height; ten times that. Two sheets that are
/// nearer meet there, and a point between them is taken to be on both.
pub(crate) const OTHER_SHEET: f64 = 1e-6;

/// How much may rounding change an integral, of the sum of its terms' magnitudes?
///
/// Derived: each term is a weight times the product of five sums of some coordinates at most, ten
/// roundings each of ε / 2, and the point itself is right to [`VALUE`].
pub(crate) const INTEGRAL: f64 = 64.0 * f64::EPSILON;

/// Does an integral change no more, of the whole size's power?
///
/// Above rounding: a sum of terms of that size is right to ε / 2 of it, 1e-16; ten times that, so
/// that halving ends where rounding is all that changes.
pub(crate) const CONVERGED: f64 = 1e-15;

/// Is a corner of a profile that is turned on the axis, of the profile's size?
///
/// Far above rounding (of `5 cos(π/2)` 3e-16 are left), and below any bore: one as narrow could neither be
/// made nor seen.
pub(crate) const ON_AXIS: f64 = 1e-9;
