//! Extrusion: a profile moved along z, straight or to a scale.
//!
//! Sides become planes, discs cylinders or cones and parabolas parabolic
//! cylinders or cones, one surface each, in the profile's own formula: at every height the cross-section is the profile.

use std::ops::Range;

use glam::{DAffine2, DAffine3, DMat2, DMat3, DVec2, DVec3};

use super::polyhedron::FEW_FACES;
use super::profile::{Formula, Leaf, Profile, Sagitta, Segmented, formula, segmented};
use super::tree::{Made, Node, Solid};
use super::twist::{even_twist, extent, prism};
use crate::error::{NodeFault, ProfileFault};
use crate::numeric::tolerance::{IN_PROFILE, PROFILE_CHORD};
use crate::surface::is_far;

/// Solids from profiles, in the xy plane.
impl Solid {
    /// What a function made, and the corners of a box around it.
    pub(super) fn made(
        function: &'static str,
        made: Result<(Self, [DVec3; 2]), NodeFault>,
    ) -> Self {
        let (solid, within) = match made {
            Ok((solid, within)) => (Ok(solid), Some(within)),
            Err(fault) => (Err(fault), None),
        };
        Self::from_node(Node::Made(Made {
            function,
            solid,
            within,
            spanning: Vec::new(),
            strays: None,
            with_chords: None,
        }))
    }

    /// What a function made of points, and points whose convex hull is that of it.
    pub(super) fn made_of_points(
        function: &'static str,
        made: Result<(Self, Vec<DVec3>), NodeFault>,
    ) -> Self {
        let (solid, spanning) = match made {
            Ok((solid, points)) => (Ok(solid), points),
            Err(fault) => (Err(fault), Vec::new()),
        };
        let least = spanning.iter().copied().reduce(DVec3::min);
        let greatest = spanning.iter().copied().reduce(DVec3::max);
        Self::from_node(Node::Made(Made {
            function,
            solid,
            within: least.zip(greatest).map(<[DVec3; 2]>::from),
            spanning,
            strays: None,
            with_chords: None,
        }))
    }

    /// The profile moved along z, from `z.start` to `z.end`. Lines become
    /// planes, circles and arcs cylinders, parabolas parabolic cylinders (where contours with
    /// parabolas cross, these are chords within 1e-4 of the profile's size: see
    /// [`Solid::strays`]). Of more than 48 lines and nothing else it is a
    /// polyhedron ([`Solid::polyhedron`]), whose cost is that of the faces near a cut.
    #[must_use]
    pub fn extrude(profile: &Profile, z: Range<f64>) -> Self {
        made_of("extrude", extruded(profile, &z, DVec2::ONE))
    }

    /// The profile moved along z and scaled about the z axis on the way, by 1
    /// at `z.start` to `scale` along x and y at `z.end`; a scale of 0 along both
    /// ends in a point.
    ///
    /// Lines become planes, circles, arcs and parabolas cones. Where the scales differ, a
    /// line becomes a hyperbolic paraboloid (a plane if it is along x or y); of a profile with
    /// circles, arcs or parabolas all is in flat faces, as [`Solid::extrude_twisted`] has them.
    #[must_use]
    pub fn extrude_scaled(profile: &Profile, z: Range<f64>, scale: impl Into<DVec2>) -> Self {
        let scale = scale.into();
        if scale.x != scale.y && !profile.is_straight() {
            return even_twist("extrude_scaled", profile, &z, (0.0, scale), None);
        }
        made_of("extrude_scaled", extruded(profile, &z, scale))
    }

    /// The profile at `z.start`, drawn together to the point above `apex` at
    /// `z.end`: a pyramid or a cone over it.
    #[must_use]
    pub fn extrude_to_point(profile: &Profile, z: Range<f64>, apex: impl Into<DVec2>) -> Self {
        let apex = apex.into();
        let centred = profile.translate(-apex);
        let solid = extruded(&centred, &z, DVec2::ZERO).map(|made| {
            let apex = apex.extend(0.0);
            Extruded {
                solid: made.solid.translate(apex),
                with_chords: made.with_chords.map(|solid| solid.translate(apex)),
                within: made.within.map(|corner| corner + apex),
                ..made
            }
        });
        made_of("extrude_to_point", solid)
    }
}

struct Extruded {
    solid: Solid,
    /// Corners of a box around it.
    within: [DVec3; 2],
    /// How far chords that stand for something stray from that.
    strays: Option<f64>,
    /// The same with chords for parabolas.
    with_chords: Option<Solid>,
}

fn made_of(function: &'static str, extruded: Result<Extruded, NodeFault>) -> Solid {
    let made = match extruded {
        Ok(Extruded {
            solid,
            within,
            strays,
            with_chords,
        }) => Made {
            function,
            solid: Ok(solid),
            within: Some(within),
            spanning: Vec::new(),
            strays,
            with_chords,
        },
        Err(fault) => return Solid::made(function, Err(fault)),
    };
    Solid::from_node(Node::Made(made))
}

fn extruded(profile: &Profile, z: &Range<f64>, scale: DVec2) -> Result<Extruded, NodeFault> {
    extent(z)?;
    for scale in scale.to_array() {
        if !(scale >= 0.0 && scale.is_finite()) {
            return Err(NodeFault::NotPositive {
                what: "the scale",
                value: scale,
            });
        }
    }
    let tolerance = profile.tolerance_of(PROFILE_CHORD)?;
    let Some((min, max)) = profile.reach()? else {
        return Ok(Extruded {
            solid: Solid::empty(),
            within: [DVec3::ZERO; 2],
            strays: None,
            with_chords: None,
        });
    };
    let within = [
        (min.min(scale * min) - tolerance).extend(z.start),
        (max.max(scale * max) + tolerance).extend(z.end),
    ];
    let mut column = Column {
        z,
        scale,
        tolerance,
        has_chords: false,
    };
    let crosses =
        |known: &Result<Solid, ProfileFault>| matches!(known, Err(ProfileFault::Crossing { .. }));
    let mut solid = column.whole(profile);
    if crosses(&solid)
        && let Some(strokes) = profile.strokes()
    {
        solid = column.whole(&strokes);
    }
    let chords = profile.without_parabolas(tolerance);
    let with_chords = chords.and_then(|chords| column.whole(&chords).ok());
    Ok(match (solid, with_chords) {
        (Err(ProfileFault::Crossing { .. }), Some(solid)) => Extruded {
            solid,
            within,
            strays: Some(tolerance),
            with_chords: None,
        },
        (solid, with_chords) => Extruded {
            solid: solid?,
            within,
            strays: column.has_chords.then_some(tolerance),
            with_chords,
        },
    })
}

/// What profiles become that are moved along z and scaled on the way, also beyond both ends.
struct Column<'a> {
    z: &'a Range<f64>,
    scale: DVec2,
    /// For chords, a length.
    tolerance: f64,
    /// Whether there are such, in place of what is bent.
    has_chords: bool,
}

impl Column<'_> {
    fn whole(&mut self, profile: &Profile) -> Result<Solid, ProfileFault> {
        Ok(match self.prism(profile)? {
            Some(prism) => prism,
            None => between(self.z, self.of(profile)?),
        })
    }

    /// A polyhedron between both ends, if the profile is of many lines and nothing else.
    fn prism(&self, profile: &Profile) -> Result<Option<Solid>, ProfileFault> {
        if !(self.is_even() && profile.is_straight()) {
            return Ok(None);
        }
        let contours = profile.contours(self.tolerance)?;
        let is_fine = contours.iter().map(Vec::len).sum::<usize>() > FEW_FACES;
        Ok(is_fine
            .then(|| prism(&contours, &profile.lines(&contours), self.z, self.scale))
            .flatten())
    }

    fn is_even(&self) -> bool {
        self.scale.x == self.scale.y
    }

    /// Shapes of many lines as prisms, if there are such and they are not scaled, and else one
    /// formula of half-spaces: cones and planes that are scaled have one apex in common, and corners
    /// tell planes to rounding only.
    fn of(&mut self, profile: &Profile) -> Result<Solid, ProfileFault> {
        if self.scale != DVec2::ONE {
            return self.of_half_spaces(profile);
        }
        let mut has_prisms = false;
        let by_shapes = profile.by_shapes(|shape| {
            let known = match self.prism(shape)? {
                Some(prism) => Some(prism),
                None => self.segmented(shape)?,
            };
            has_prisms |= known.is_some();
            match known {
                Some(known) => Ok(known),
                None => self.of_half_spaces(shape),
            }
        })?;
        if has_prisms {
            Ok(by_shapes)
        } else {
            self.of_half_spaces(profile)
        }
    }

    /// A polyhedron with segments of curves added and taken away, of shapes of many sides.
    fn segmented(&self, shape: &Profile) -> Result<Option<Solid>, ProfileFault> {
        let Some(Segmented { polygons, steps }) = segmented(shape)? else {
            return Ok(None);
        };
        if polygons.iter().map(Vec::len).sum::<usize>() <= FEW_FACES {
            return Ok(None);
        }
        let lines = shape.lines(&polygons);
        let prism = prism(&polygons, &lines, self.z, self.scale);
        Ok(prism.map(|prism| {
            steps.iter().fold(prism, |solid, (is_added, set)| {
                let segments = set.solid(|leaf| self.of_leaf(leaf));
                if *is_added {
                    solid | segments
                } else {
                    solid - segments
                }
            })
        }))
    }

    fn of_half_spaces(&mut self, profile: &Profile) -> Result<Solid, ProfileFault> {
        let is_even = self.is_even();
        let sagitta = Sagitta::of_length(self.tolerance);
        let Formula { set, has_chords } = formula(profile, sagitta, &|_| is_even)?;
        self.has_chords |= has_chords;
        Ok(set.solid(|leaf| self.of_leaf(leaf)))
    }

    /// At which height an image of the unit disc, or of a parabola from 0 to 1, is drawn in to a point, if
    /// that is near enough to keep its digits.
    fn tip(&self, map: DAffine2) -> Option<f64> {
        let Self { z, scale, .. } = *self;
        if scale.x == 0.0 {
            return Some(z.end);
        }
        let DMat2 { x_axis, y_axis } = map.matrix2;
        let reach = x_axis.length() + y_axis.length() + map.translation.length();
        let height = z.end - z.start;
        let beyond = height / (1.0 - scale.x);
        let is_near = scale.x != 1.0 && !is_far(beyond, height.max(reach));
        is_near.then_some(z.start + beyond)
    }

    fn of_leaf(&self, leaf: &Leaf) -> Solid {
        let Self { z, scale, .. } = *self;
        let height = z.end - z.start;
        let growth = (scale.x - 1.0) / height;
        match *leaf {
            Leaf::HalfPlane { from, to } => side(from, to, z.start, height, scale),
            Leaf::Disc(map) if self.is_even() && scale.x != 1.0 => {
                let DMat2 { x_axis, y_axis } = map.matrix2;
                match self.tip(map) {
                    None => far_cone(map, z.start, growth),
                    Some(tip) => cone(x_axis, y_axis, map.translation, z.start, tip),
                }
            }
            Leaf::Disc(map) => {
                let map = DAffine3 {
                    matrix3: DMat3::from_cols(
                        map.matrix2.x_axis.extend(0.0),
                        map.matrix2.y_axis.extend(0.0),
                        DVec3::Z,
                    ),
                    translation: map.translation.extend(0.0),
                };
                Solid::infinite_cylinder(1.0).affine(map)
            }
            Leaf::Parabola(map) => parabolic(map, z.start, growth, self.tip(map)),
        }
    }
}

/// What is of a solid between two heights.
fn between(z: &Range<f64>, solid: Solid) -> Solid {
    Solid::intersection([
        solid,
        Solid::half_space_through(z.start * DVec3::Z, -DVec3::Z),
        Solid::half_space_through(z.end * DVec3::Z, DVec3::Z),
    ])
}

/// What is to the left of a line from one point to another, which is scaled on
/// the way up.
fn side(from: DVec2, to: DVec2, bottom: f64, height: f64, scale: DVec2) -> Solid {
    let outward = -(to - from).normalize_or_zero().perp();
    let offset = outward.dot(from.midpoint(to));
    let (n, slope) = (outward, (scale - 1.0) / height);
    let flat = |slope: f64| {
        let normal = n.extend(-offset * slope);
        Solid::half_space_through(from.extend(bottom), normal)
    };
    // (As good as along an axis is along it: else it would be a pair of planes.)
    if slope.x == slope.y || n.y.abs() <= IN_PROFILE {
        flat(slope.x)
    } else if n.x.abs() <= IN_PROFILE {
        flat(slope.y)
    } else {
        // n.x x / (1 + sx z) + n.y y / (1 + sy z) <= offset, times both.
        let DVec2 { x: sx, y: sy } = slope;
        let coefficients = [
            0.0,
            0.0,
            -offset * sx * sy,
            0.0,
            n.y * sx,
            n.x * sy,
            n.x,
            n.y,
            -offset * (sx + sy),
            -offset,
        ];
        Solid::quadric(coefficients).translate(bottom * DVec3::Z)
    }
}

/// The double cone over an ellipse at height `base` with its tip on the z axis.
fn cone(x: DVec2, y: DVec2, center: DVec2, base: f64, apex: f64) -> Solid {
    let map = DAffine3 {
        matrix3: DMat3::from_cols(x.extend(0.0), y.extend(0.0), center.extend(base - apex)),
        translation: apex * DVec3::Z,
    };
    double_cone().affine(map)
}

/// The same by its coefficients at the height of the ellipse, as its tip is so far away that about
/// that digits would be lost: of a disc that grows by that share along a unit of length.
fn far_cone(disc: DAffine2, base: f64, growth: f64) -> Solid {
    // |q| <= k, for q = a p - k c where a maps the disc to one of radius 1 and c is its centre there.
    let a = disc.matrix2.inverse();
    let c = a * disc.translation;
    let form = a.transpose() * a;
    let linear = -2.0 * (a.transpose() * c);
    let rest = c.length_squared() - 1.0;
    let coefficients = [
        form.x_axis.x,
        form.y_axis.y,
        growth * growth * rest,
        2.0 * form.x_axis.y,
        growth * linear.y,
        growth * linear.x,
        linear.x,
        linear.y,
        2.0 * growth * rest,
        rest,
    ];
    Solid::quadric(coefficients).translate(base * DVec3::Z)
}

/// The inner side of the parabola that is the image of y = x² at height `base`, which grows by a share
/// along a unit of length: a parabolic cylinder, or a cone, about its tip if that is given.
fn parabolic(map: DAffine2, base: f64, growth: f64, tip: Option<f64>) -> Solid {
    // v k >= u² for (u, v) = a (p - k c) where a maps to y = x², and c to its origin.
    let a = map.matrix2.inverse();
    let [u, v] = [a.row(0), a.row(1)];
    let c = map.translation;
    // About c at that height: k = 1 + growth z, p - k c = (x, y) - growth z c. About the tip,
    // which is above the origin: k = growth z, and the same.
    let across = u.extend(-growth * u.dot(c));
    let along = v.extend(-growth * v.dot(c));
    let linear = if tip.is_some() { DVec3::ZERO } else { -along };
    let coefficients = [
        across.x * across.x,
        across.y * across.y,
        across.z * across.z - growth * along.z,
        2.0 * across.x * across.y,
        2.0 * across.y * across.z - growth * along.y,
        2.0 * across.z * across.x - growth * along.x,
        linear.x,
        linear.y,
        linear.z,
        0.0,
    ];
    let anchor = tip.map_or(c.extend(base), |tip| tip * DVec3::Z);
    Solid::quadric(coefficients).translate(anchor)
}

/// x² + y² <= z².
pub(super) fn double_cone() -> Solid {
    Solid::quadric([1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
}
