//! The bounding box of a solid, from its program alone.
//!
//! 1. Boxes of literals (axis-aligned planes, ellipsoids, cylinders along an
//!    axis) combine through the formula: a finite result encloses the solid.
//! 2. Otherwise infinity is searched: a point far away is s (±1, u, v) (or with
//!    another axis first) with |u|, |v| <= 1, and f / s² of a quadric, f / s of
//!    a plane, is a polynomial of second degree in u, v and w = 1/s. Those are
//!    quadrics again, on a finite box: the same pruning proves the solid empty
//!    there, or finds a direction in which it goes on.
//!    Flat or long surfaces tell too little there by their coefficients: then the boxes
//!    of primitives must do ([`mod@super::reach`]), or those of the corners of a few planes
//!    that bound something together ([`mod@planes`]).
//! 3. From the finite box that is left, slabs are shaved off every side as long
//!    as they are proven empty.

mod planes;

use glam::DVec3;

use self::planes::Wedge;
use super::cell::{Cell, Pruner};
use super::formula::{Formula, Operand, Operation};
use super::narrow::Narrower;
use super::{Apart, Program};
use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::surface::{Bounds, Side, Surface, half_space_bounds};

/// A side is shaved until not even a slab of this share of the box is proven
/// empty.
const FINEST_SLAB: f64 = 1.0 / 512.0;
/// The same for programs so large that every proof costs noticeable time.
const COARSEST_SLAB: f64 = 1.0 / 4.0;
/// How many surfaces all attempts at shaving together may look at before the
/// coarser limit is approached.
const SHAVING_BUDGET: usize = 4_000_000;
/// Of so many gates a box of a deep formula is looked at before it is halved.
const MOST_GATES: usize = 1000;
/// How often a slab is halved before it counts as not empty.
const SLAB_LEVELS: usize = 16;
/// How often the neighbourhood of infinity is halved before a solid that is
/// still there counts as unbounded.
const INFINITY_LEVELS: usize = 12;

impl Program {
    /// A box that encloses the solid, on each side at most about 1/256 of its
    /// size too large (up to a quarter for programs of some 100,000 surfaces,
    /// where more would cost time); `None` if the solid is proven empty. Of a polyhedron of
    /// many faces that is subtracted only what is near other faces is seen to be gone.
    ///
    /// # Errors
    /// [`Error::Unbounded`] if the solid reaches infinitely far.
    pub fn bounds(&self) -> Result<Option<Bounds>, Error> {
        if let Some(Apart { uncut, rest }) = self.apart() {
            let own = Some(uncut.bounds()).filter(|own| own.is_finite());
            let rest = rest.bounds()?;
            return Ok(match (own, rest) {
                (Some(own), Some(rest)) => Some(own.united(rest)),
                (own, rest) => own.or(rest),
            });
        }
        let is_deep = self.given().is_some();
        self.find_bounds(|surfaces, root, loose| Shaver::new(surfaces, root, is_deep).shave(loose))
    }

    /// A box that encloses the solid, however much too large: a fraction of the
    /// time that [`Self::bounds`] takes.
    pub(crate) fn loose_bounds(&self) -> Result<Option<Bounds>, Error> {
        if let Some(outline) = self.outline()
            && outline.reach().is_finite()
            && outline.cell().constant().is_none()
        {
            return Ok(Some(outline.reach()));
        }
        self.find_bounds(|_, _, loose| Some(loose))
    }

    fn find_bounds(
        &self,
        tighten: impl Fn(&[Surface], &Cell, Bounds) -> Option<Bounds>,
    ) -> Result<Option<Bounds>, Error> {
        let root = self.root_cell();
        match root.constant() {
            Some(false) => return Ok(None),
            Some(true) => return Err(unbounded(DVec3::X)),
            None => {}
        }
        // The middle of the anchors: near the solid, wherever that is.
        let first = self.surfaces()[0].anchor();
        let (low, high) = self
            .surfaces()
            .iter()
            .fold((first, first), |(low, high), s| {
                (low.min(s.anchor()), high.max(s.anchor()))
            });
        let origin = 0.5 * low + 0.5 * high;
        let surfaces = self.surfaces_about(origin);
        let reach = Bounds {
            min: self.reach().min - origin,
            max: self.reach().max - origin,
        };
        // Polyhedra bound themselves, and their formulas are long.
        let is_known = self.given().is_some() && reach.is_finite();
        let mut current = if is_known {
            reach
        } else {
            literal_bounds(&surfaces, self.formula(), |_| Bounds::EVERYTHING)
        };
        if !current.is_finite() {
            let extent = |s: &Surface| {
                s.anchor.abs().max_element() + s.constant.abs().sqrt() + s.extent_of_slope()
            };
            let guess = surfaces.iter().map(extent).fold(0.0, f64::max);
            let guess = if guess > 0.0 { 2.0 * guess } else { 1.0 };
            let finite = match finite_radius(&surfaces, &root, guess) {
                Ok(radius) => Bounds::around(DVec3::ZERO, DVec3::splat(radius)),
                Err(_) if reach.is_finite() => reach,
                Err(error) => {
                    let by_corners = literal_bounds(&surfaces, self.formula(), Wedge::bounds);
                    if !by_corners.is_finite() {
                        return Err(error);
                    }
                    by_corners
                }
            };
            current = current.intersected(finite);
        }
        if current.min.cmpgt(current.max).any() {
            return Ok(None);
        }
        let mut tight = tighten(&surfaces, &root, current);
        let clearly = 2.0 * reach.size().max_element();
        if let Some(found) = tight
            && reach.is_finite()
            && found.size().max_element() > clearly
        {
            tight = tighten(&surfaces, &root, found.intersected(reach));
        }
        Ok(tight.map(|bounds| Bounds {
            min: bounds.min + origin,
            max: bounds.max + origin,
        }))
    }
}

fn unbounded(direction: DVec3) -> Error {
    Error::Unbounded {
        direction: direction.normalize_or(DVec3::X).to_array(),
    }
}

impl Surface {
    /// How far a quadric's linear part moves its extrema.
    fn extent_of_slope(&self) -> f64 {
        if self.is_plane() {
            0.0
        } else {
            self.linear.abs().max_element()
        }
    }

    /// A box around the surface itself, as far as it is easily told: infinite where it
    /// is not.
    pub(crate) fn own_bounds(&self) -> Bounds {
        let bounds = half_space_bounds(self);
        if !self.is_plane() {
            return bounds;
        }
        // Its half-space ends on one side, at the plane.
        let [low, high] = [bounds.min, bounds.max].map(DVec3::is_finite_mask);
        let slack = COORDINATE * self.anchor.abs();
        Bounds {
            min: DVec3::select(high, self.anchor - slack, bounds.min),
            max: DVec3::select(low, self.anchor + slack, bounds.max),
        }
    }
}

/// A surface near infinity, on one face of the cube of directions: f / s² (or
/// f / s for planes) in the coordinates (u, v, w = 1/s).
struct AtInfinity {
    surface: Surface,
    /// For quadrics whose quadratic form has no negative (positive) values:
    /// where (f - form) / s is positive (negative), so is f, although f / s²
    /// comes to zero at infinity.
    definite: Option<(Side, Surface)>,
}

impl AtInfinity {
    /// `axis` is the coordinate that is ±s; the other two follow cyclically.
    fn new(surface: &Surface, axis: usize, sign: f64) -> Self {
        let (i, j, k) = (axis, (axis + 1) % 3, (axis + 2) % 3);
        let squares = [0, 1, 2].map(|n| surface.quadratic[n]);
        // The coefficient of the product of coordinates a and b.
        let cross = |a: usize, b: usize| match (a.min(b), a.max(b)) {
            (0, 1) => surface.quadratic[3],
            (1, 2) => surface.quadratic[4],
            _ => surface.quadratic[5],
        };
        let (linear, constant) = surface.expanded_about(DVec3::ZERO);
        let rest = Surface {
            constant: sign * linear[i],
            ..Surface::plane(DVec3::ZERO, DVec3::new(linear[j], linear[k], constant))
        };
        if surface.is_plane() {
            return Self {
                surface: rest,
                definite: None,
            };
        }
        Self {
            surface: Surface {
                anchor: DVec3::ZERO,
                quadratic: [
                    squares[j],
                    squares[k],
                    constant,
                    cross(j, k),
                    linear[k],
                    linear[j],
                ],
                linear: DVec3::new(sign * cross(i, j), sign * cross(i, k), sign * linear[i]),
                constant: squares[i],
                // Not its own, for which nobody asks here.
                kind: surface.kind,
            },
            definite: surface.definiteness().map(|side| (side, rest)),
        }
    }

    fn side(&self, center: DVec3, half: DVec3) -> Side {
        let side = self.surface.side_of_box(center, half);
        match &self.definite {
            Some((definite, rest)) if side == Side::Crossing => {
                if rest.side_of_box(center, half) == *definite {
                    *definite
                } else {
                    side
                }
            }
            _ => side,
        }
    }
}

/// A radius around the origin beyond which the solid is empty, at least
/// `guess`.
fn finite_radius(surfaces: &[Surface], root: &Cell, guess: f64) -> Result<f64, Error> {
    let mut radius = guess;
    let mut pruner = Pruner::default();
    let mut sides = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let face: Vec<AtInfinity> = surfaces
                .iter()
                .map(|surface| AtInfinity::new(surface, axis, sign))
                .collect();
            let half_w = 0.5 / guess;
            let center = DVec3::new(0.0, 0.0, half_w);
            let mut pending = vec![(center, DVec3::new(1.0, 1.0, half_w), 0, root.clone())];
            while let Some((center, half, level, parent)) = pending.pop() {
                sides.clear();
                let ids = parent.surfaces.iter();
                sides.extend(ids.map(|&id| face[id as usize].side(center, half)));
                let mut cell = Cell::default();
                parent.restrict_into(&sides, &mut pruner, &mut cell);
                if cell.constant() == Some(false) {
                    continue;
                }
                let nearest_w = center.z - half.z;
                if nearest_w > 0.0 {
                    radius = radius.max(1.0 / nearest_w);
                } else if cell.constant() == Some(true) || level == INFINITY_LEVELS {
                    let mut direction = DVec3::ZERO;
                    direction[axis] = sign;
                    direction[(axis + 1) % 3] = center.x;
                    direction[(axis + 2) % 3] = center.y;
                    return Err(unbounded(direction));
                } else {
                    let half = half * 0.5;
                    for octant in 0..8 {
                        let center = center + octant_offset(octant) * half;
                        pending.push((center, half, level + 1, cell.clone()));
                    }
                }
            }
        }
    }
    Ok(radius)
}

/// The box of a formula, from boxes of its literals, and of the planes that are all to hold;
/// infinite where they are.
fn literal_bounds(
    surfaces: &[Surface],
    formula: &Formula,
    of_planes: impl Fn(&Wedge) -> Bounds,
) -> Bounds {
    let mut gates: Vec<Bounds> = Vec::with_capacity(formula.gates().len());
    let half_space = |literal: u32| {
        let literal = formula.literals()[literal as usize];
        let surface = surfaces[literal.surface as usize];
        if literal.outside {
            surface.negated()
        } else {
            surface
        }
    };
    let operand_bounds = |operand: Operand, gates: &[Bounds]| match operand {
        Operand::Constant(true) => Bounds::EVERYTHING,
        Operand::Constant(false) => Bounds::NOTHING,
        Operand::Literal(i) => half_space_bounds(&half_space(i)),
        Operand::Gate(i) => gates[i as usize],
    };
    let together = |operands: &[Operand]| {
        let mut wedge = Wedge::default();
        for &operand in operands {
            if let Operand::Literal(i) = operand
                && let plane = half_space(i)
                && plane.is_plane()
            {
                wedge.add(plane);
            }
        }
        of_planes(&wedge)
    };
    for gate in formula.gates() {
        let operands = formula.operands_of(gate);
        let boxes = operands.iter();
        let boxes = boxes.map(|&operand| operand_bounds(operand, &gates));
        gates.push(match gate.operation {
            Operation::And => {
                let all = boxes.fold(Bounds::EVERYTHING, Bounds::intersected);
                if all.is_finite() {
                    all
                } else {
                    all.intersected(together(operands))
                }
            }
            // Nothing is the inverted box, which unites as it should.
            Operation::Or => boxes.fold(Bounds::NOTHING, |all, b| {
                if b.min.cmpgt(b.max).any() {
                    all
                } else {
                    all.united(b)
                }
            }),
        });
    }
    operand_bounds(formula.root(), &gates)
}

/// Which sides of a box (lower x, upper x, lower y, ...) the solid comes so
/// near to that not even the thinnest slab there is empty; as far as a few
/// points near each side tell.
fn sides_reached(surfaces: &[Surface], root: &Cell, bounds: Bounds) -> [bool; 6] {
    const POINTS: usize = 10;
    const LANES: usize = 6 * POINTS;
    /// So many of them are where a curved surface comes to the side, if one does.
    const ON_SURFACE: usize = 5;
    let depth = 0.5 * FINEST_SLAB * bounds.size();
    let touching = surfaces_touching(surfaces, bounds, depth);
    let mut points = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let (side, index) = (lane / POINTS, lane % POINTS);
        let axis = side / 2;
        let (index, surface) = match touching[side] {
            Some(own) if index < ON_SURFACE => (index, Some(own)),
            Some(_) => (index - ON_SURFACE, None),
            None => (index, None),
        };
        // The middle of the side, then the R2 sequence (Roberts 2018).
        let along = |step: f64| (0.5 + index as f64 * step).fract();
        let mut share = [0.0; 3];
        share[(axis + 1) % 3] = along(0.754_877_666_246_693);
        share[(axis + 2) % 3] = along(0.569_840_290_998_053);
        let mut point = bounds.min + DVec3::from_array(share) * bounds.size();
        if let Some(own) = surface {
            let middle = own.center();
            point = DVec3::select(middle.is_finite_mask(), middle, point);
        }
        point[axis] = if side % 2 == 1 {
            bounds.max[axis] - depth[axis]
        } else {
            bounds.min[axis] + depth[axis]
        };
        for (coordinates, value) in points.iter_mut().zip(point.to_array()) {
            coordinates[lane] = value;
        }
    }
    let signs: Vec<u64> = surfaces
        .iter()
        .map(|surface| {
            let mut inside = [0u64; LANES];
            for (lane, inside) in inside.iter_mut().enumerate() {
                let point = DVec3::from_array([0, 1, 2].map(|a| points[a][lane]));
                *inside = u64::from(surface.value(point) <= 0.0) << lane;
            }
            inside.into_iter().fold(0, |all, bit| all | bit)
        })
        .collect();
    let inside = root
        .formula
        .evaluate_words(&mut Vec::new(), |_, surface| signs[surface as usize]);
    [0, 1, 2, 3, 4, 5].map(|side| inside >> (side * POINTS) & ((1 << POINTS) - 1) != 0)
}

/// For each side of a box a curved surface whose own box ends nearer to it than
/// `depth`, by that box: it is infinite along rulings.
fn surfaces_touching(surfaces: &[Surface], bounds: Bounds, depth: DVec3) -> [Option<Bounds>; 6] {
    let mut touching = [None; 6];
    for surface in surfaces.iter().filter(|surface| !surface.is_plane()) {
        let own = half_space_bounds(surface);
        let low = (own.min - bounds.min).abs().cmplt(depth);
        let high = (own.max - bounds.max).abs().cmplt(depth);
        for axis in 0..3 {
            for (side, touches) in [low, high].into_iter().enumerate() {
                if touches.test(axis) {
                    touching[2 * axis + side] = Some(own);
                }
            }
        }
    }
    touching
}

/// Takes slabs off a box as long as they are proven empty.
struct Shaver<'a> {
    surfaces: &'a [Surface],
    root: &'a Cell,
    /// Whether little of the formula matters in a box, and is found from its root.
    is_deep: bool,
    levels: Vec<Cell>,
    pruner: Pruner,
    narrower: Narrower,
    /// Surfaces, or gates, looked at so far.
    spent: usize,
}

impl<'a> Shaver<'a> {
    fn new(surfaces: &'a [Surface], root: &'a Cell, is_deep: bool) -> Self {
        Self {
            surfaces,
            root,
            is_deep,
            levels: Vec::new(),
            pruner: Pruner::default(),
            narrower: Narrower::default(),
            spent: 0,
        }
    }

    fn shave(&mut self, mut bounds: Bounds) -> Option<Bounds> {
        let mut reached = sides_reached(self.surfaces, self.root, bounds);
        if !reached.contains(&true) && self.is_empty(bounds, SLAB_LEVELS / 2) {
            return None;
        }
        loop {
            // Mostly the box is as small as it can be, which a point near a side
            // tells, or else its thinnest slab.
            let is_open = [0, 1, 2, 3, 4, 5].map(|side| {
                let slab = slab(bounds, side, FINEST_SLAB).filter(|_| !reached[side]);
                slab.is_some_and(|(slab, _)| self.is_empty(slab, SLAB_LEVELS))
            });
            if !self.shave_sides(&mut bounds, is_open) || self.spent >= SHAVING_BUDGET {
                return Some(bounds);
            }
            reached = sides_reached(self.surfaces, self.root, bounds);
        }
    }

    /// Takes slabs off some sides; returns whether there were any.
    fn shave_sides(&mut self, bounds: &mut Bounds, is_open: [bool; 6]) -> bool {
        // Shares of the box, from coarse to fine: all sides at each before the
        // next, so that a budget that runs out has brought all sides equally
        // far. A box that shrinks is gone over again.
        let mut any = false;
        let mut share = 0.5;
        while share >= FINEST_SLAB && (share >= COARSEST_SLAB || self.spent < SHAVING_BUDGET) {
            let mut shaved = false;
            for side in (0..6).filter(|&side| is_open[side]) {
                if let Some((slab, rest)) = slab(*bounds, side, share)
                    && self.is_empty(slab, SLAB_LEVELS)
                {
                    *bounds = rest;
                    shaved = true;
                }
            }
            any |= shaved;
            if !shaved {
                share *= 0.5;
            } else if share < 0.5 {
                share *= 2.0;
            }
        }
        any
    }

    /// Whether the box is proven empty: by pruning it, or its halves, to the
    /// given depth. A box that is not empty soon shows a piece that is not.
    fn is_empty(&mut self, bounds: Bounds, levels: usize) -> bool {
        let mut pending = vec![(bounds, 0)];
        while let Some((bounds, level)) = pending.pop() {
            match self.constant(bounds, level) {
                Some(false) => {}
                None if level < levels => {
                    let axis = bounds.size().max_position();
                    let middle = bounds.center()[axis];
                    let (mut low, mut high) = (bounds, bounds);
                    low.max[axis] = middle;
                    high.min[axis] = middle;
                    pending.push((low, level + 1));
                    pending.push((high, level + 1));
                }
                _ => return false,
            }
        }
        true
    }

    /// What the program comes to in a box, one of the last looked at halved so often.
    fn constant(&mut self, bounds: Bounds, level: usize) -> Option<bool> {
        // The box of rounded corners, enlarged by what rounding took.
        // (There is no other side of a comparison.)
        let slack = 0.5 * COORDINATE * (bounds.min.abs() + bounds.max.abs());
        let (center, half) = (bounds.center(), 0.5 * bounds.size() + slack);
        if self.is_deep {
            let side = |id: u32| self.surfaces[id as usize].side_of_box(center, half);
            self.spent += MOST_GATES;
            return self.narrower.constant(&self.root.formula, side, MOST_GATES);
        }
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, Cell::default);
        }
        let (above, below) = self.levels.split_at_mut(level);
        let parent = above.last().unwrap_or(self.root);
        self.spent += parent.surfaces.len();
        let cell = &mut below[0];
        parent.prune_into(self.surfaces, center, half, &mut self.pruner, cell);
        cell.constant()
    }
}

/// A slab of a share of a box along one side (lower x, upper x, lower y, ...),
/// and the rest; none where the box is flat as far as doubles can tell.
fn slab(bounds: Bounds, side: usize, share: f64) -> Option<(Bounds, Bounds)> {
    let axis = side / 2;
    let (least, most) = (bounds.min[axis], bounds.max[axis]);
    let width = share * (most - least);
    let (mut slab, mut rest) = (bounds, bounds);
    let inner = if side % 2 == 1 {
        let inner = most - width;
        (slab.min[axis], rest.max[axis]) = (inner, inner);
        inner
    } else {
        let inner = least + width;
        (slab.max[axis], rest.min[axis]) = (inner, inner);
        inner
    };
    (inner > least && inner < most).then_some((slab, rest))
}

/// The corner of the cube ±1 that octant `octant` (bit 0 for x) lies towards.
fn octant_offset(octant: u8) -> DVec3 {
    let side = |bit: u8| if octant >> bit & 1 == 0 { -1.0 } else { 1.0 };
    DVec3::new(side(0), side(1), side(2))
}
