//! STEP files of cut ellipsoids, spheroids and spheres turned in six digits: what is written is
//! evaluated here, by the standard's equations, and held against those of the solids it was made from.

use std::collections::HashMap;
use std::f64::consts::TAU;

use csg::{BoundaryOptions, Program, Solid};
use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4, dvec3};
use io::step::{StepOptions, write_step};

/// The entities of a file: what is between an entity's number and the semicolon.
struct File<'a>(HashMap<&'a str, &'a str>);

/// What stands between the brackets after a name: lists within it, numbers and references.
#[derive(Clone, Debug)]
enum Item<'a> {
    Atom(&'a str),
    List(Vec<Item<'a>>),
}

type Curve = Box<dyn Fn(f64) -> DVec3>;
type Surface = Box<dyn Fn(DVec2) -> DVec3>;

impl<'a> Item<'a> {
    fn list(&self) -> &[Item<'a>] {
        match self {
            Item::List(items) => items,
            Item::Atom(atom) => panic!("{atom} is no list"),
        }
    }

    fn atom(&self) -> &'a str {
        match self {
            Item::Atom(atom) => atom,
            Item::List(items) => panic!("{items:?} is a list"),
        }
    }

    fn number(&self) -> f64 {
        self.atom().parse().expect("a number")
    }

    fn numbers(&self) -> Vec<f64> {
        self.list().iter().map(Item::number).collect()
    }
}

/// The items of a list that begins after a bracket, and what follows it.
fn items(mut text: &str) -> (Vec<Item<'_>>, &str) {
    let mut all = Vec::new();
    loop {
        if let Some(rest) = text.strip_prefix('(') {
            let (inner, rest) = items(rest);
            all.push(Item::List(inner));
            text = rest;
        } else if let Some(rest) = text.strip_prefix(')') {
            return (all, rest);
        } else if let Some(rest) = text.strip_prefix(',') {
            text = rest;
        } else {
            let end = text.find([',', ')']).expect("a list ends");
            all.push(Item::Atom(&text[..end]));
            text = &text[end..];
        }
    }
}

impl<'a> File<'a> {
    fn of(text: &'a str) -> Self {
        let entities = text.lines().filter_map(|line| {
            let (id, entity) = line.split_once('=')?;
            Some((id, entity.strip_suffix(';')?))
        });
        Self(entities.collect())
    }

    /// The items after a name in an entity.
    fn part(&self, id: &str, name: &str) -> Option<Vec<Item<'a>>> {
        let entity = self.0[id];
        let begin = format!("{name}(");
        let at = if entity.starts_with(&begin) {
            0
        } else {
            // One of several names.
            let after = |c: char| entity.find(&format!("{c}{begin}")).map(|at| at + 1);
            after('(').or_else(|| after(')'))?
        };
        Some(items(&entity[at + begin.len()..]).0)
    }

    /// The same where it must be there.
    fn known(&self, id: &str, name: &str) -> Vec<Item<'a>> {
        let found = self.part(id, name);
        found.unwrap_or_else(|| panic!("no {name}: {}", self.0[id]))
    }

    fn all(&self, name: &str) -> Vec<Vec<Item<'a>>> {
        let begin = format!("{name}(");
        let ids = self.0.iter();
        ids.filter(|(_, entity)| entity.starts_with(&begin))
            .map(|(id, _)| self.known(id, name))
            .collect()
    }

    fn numbers(&self, id: &str, name: &str) -> Vec<f64> {
        self.known(id, name)[1].numbers()
    }

    fn point(&self, id: &str) -> DVec3 {
        DVec3::from_slice(&self.numbers(id, "CARTESIAN_POINT"))
    }

    fn direction(&self, id: &str) -> DVec3 {
        DVec3::from_slice(&self.numbers(id, "DIRECTION")).normalize()
    }

    /// A direction times a length.
    fn vector(&self, id: &str) -> DVec3 {
        let vector = self.known(id, "VECTOR");
        vector[2].number() * self.direction(vector[1].atom())
    }

    /// An origin, and the directions of x, y and z.
    fn placement(&self, id: &str) -> (DVec3, DMat3) {
        let items = self.known(id, "AXIS2_PLACEMENT_3D");
        let [z, x] = [2, 3].map(|k: usize| self.direction(items[k].atom()));
        let x = x.reject_from(z).normalize();
        let axes = DMat3::from_cols(x, z.cross(x), z);
        (self.point(items[1].atom()), axes)
    }

    /// A curve in space.
    fn curve(&self, id: &str) -> Curve {
        let about = |items: &[Item<'_>], radii: [f64; 2]| -> Curve {
            let (origin, axes) = self.placement(items[1].atom());
            Box::new(move |t| origin + axes * dvec3(radii[0] * t.cos(), radii[1] * t.sin(), 0.0))
        };
        if let Some(items) = self.part(id, "LINE") {
            let (point, along) = (self.point(items[1].atom()), self.vector(items[2].atom()));
            Box::new(move |t| point + t * along)
        } else if let Some(items) = self.part(id, "CIRCLE") {
            about(&items, [items[2].number(); 2])
        } else if let Some(items) = self.part(id, "ELLIPSE") {
            about(&items, [items[2].number(), items[3].number()])
        } else {
            self.spline(id).1
        }
    }

    /// A B-spline, of the plane with z = 0, and from where to where its parameter goes.
    fn spline(&self, id: &str) -> ([f64; 2], Curve) {
        let items = self.known(id, "B_SPLINE_CURVE_WITH_KNOTS");
        let point = |id: &Item<'_>| match self.numbers(id.atom(), "CARTESIAN_POINT")[..] {
            [x, y] => DVec4::new(x, y, 0.0, 1.0),
            [x, y, z] => DVec4::new(x, y, z, 1.0),
            _ => panic!("no point"),
        };
        let points: Vec<DVec4> = items[2].list().iter().map(point).collect();
        let degree = items[1].number() as usize;
        let knots = knots(&items[6], &items[7]);
        let ends = [knots[0], knots[knots.len() - 1]];
        let curve = move |t| de_boor(degree, &points, &knots, t).truncate();
        (ends, Box::new(curve))
    }

    fn surface(&self, id: &str) -> Surface {
        let named = |name: &str| {
            let items = self.part(id, name)?;
            let numbers: Vec<f64> = items[2..].iter().map(Item::number).collect();
            let (origin, axes) = self.placement(items[1].atom());
            Some((origin, axes, numbers))
        };
        if let Some((origin, axes, radius)) = named("SPHERICAL_SURFACE") {
            Box::new(move |at| {
                let ((sin, cos), (up, across)) = (at.x.sin_cos(), at.y.sin_cos());
                origin + radius[0] * (axes * dvec3(across * cos, across * sin, up))
            })
        } else if let Some((origin, axes, radius)) = named("CYLINDRICAL_SURFACE") {
            Box::new(move |at| {
                let (sin, cos) = at.x.sin_cos();
                origin + axes * dvec3(radius[0] * cos, radius[0] * sin, at.y)
            })
        } else if let Some((origin, axes, _)) = named("PLANE") {
            Box::new(move |at| origin + axes * at.extend(0.0))
        } else if let Some(items) = self.part(id, "SURFACE_OF_LINEAR_EXTRUSION") {
            let (curve, along) = (self.curve(items[1].atom()), self.vector(items[2].atom()));
            Box::new(move |at| curve(at.x) + at.y * along)
        } else if let Some(items) = self.part(id, "SURFACE_OF_REVOLUTION") {
            // Of half an ellipse around an axis.
            let axis = self.known(items[2].atom(), "AXIS1_PLACEMENT");
            let (origin, along) = (self.point(axis[1].atom()), self.direction(axis[2].atom()));
            let half = self.known(items[1].atom(), "TRIMMED_CURVE");
            let curve = self.curve(half[1].atom());
            Box::new(move |at| {
                origin + DMat3::from_axis_angle(along, at.x) * (curve(at.y) - origin)
            })
        } else {
            self.patch(id)
        }
    }

    /// A rational B-spline.
    fn patch(&self, id: &str) -> Surface {
        let items = self.known(id, "B_SPLINE_SURFACE");
        let sizes = self.known(id, "B_SPLINE_SURFACE_WITH_KNOTS");
        let weights = self.known(id, "RATIONAL_B_SPLINE_SURFACE");
        let degrees = [0, 1].map(|k: usize| items[k].number() as usize);
        let knots = [0, 1].map(|k: usize| knots(&sizes[k], &sizes[k + 2]));
        let rows = items[2].list().iter().zip(weights[0].list());
        let rows = rows.map(|(row, weights)| {
            let points = row.list().iter().zip(weights.numbers());
            points
                .map(|(id, weight)| (weight * self.point(id.atom())).extend(weight))
                .collect()
        });
        let rows: Vec<Vec<DVec4>> = rows.collect();
        Box::new(move |at| {
            let row = |points: &Vec<DVec4>| de_boor(degrees[1], points, &knots[1], at.y);
            let across: Vec<DVec4> = rows.iter().map(row).collect();
            let point = de_boor(degrees[0], &across, &knots[0], at.x);
            point.truncate() / point.w
        })
    }

    /// Points of a surface: all over a patch, and of others where a face may be.
    fn grid(&self, id: &str) -> Vec<DVec3> {
        let shares = || (0..=12).map(|k| f64::from(k) / 12.0);
        let ranges = if self.0[id].starts_with('(') {
            [[0.0, 1.0]; 2]
        } else {
            [[0.0, TAU], [-1.0, 1.0]]
        };
        let at = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
        let surface = self.surface(id);
        let places = shares().flat_map(|u| shares().map(move |v| (u, v)));
        places
            .map(|(u, v)| surface(DVec2::new(at(ranges[0], u), at(ranges[1], v))))
            .collect()
    }

    /// The edges around a face.
    fn edges_around(&self, face: &[Item<'a>]) -> Vec<&'a str> {
        let mut edges = Vec::new();
        for bound in face[1].list() {
            let outer = self.part(bound.atom(), "FACE_OUTER_BOUND");
            let bound = outer.unwrap_or_else(|| self.known(bound.atom(), "FACE_BOUND"));
            let around = self.known(bound[1].atom(), "EDGE_LOOP");
            let sides = around[1].list().iter();
            edges.extend(sides.map(|side| self.known(side.atom(), "ORIENTED_EDGE")[3].atom()));
        }
        edges
    }
}

/// Each knot as often as it is there.
fn knots(multiplicities: &Item<'_>, knots: &Item<'_>) -> Vec<f64> {
    let counts = multiplicities.numbers().into_iter();
    let knots = counts.zip(knots.numbers());
    knots
        .flat_map(|(count, knot)| vec![knot; count as usize])
        .collect()
}

/// The point of a B-spline, by de Boor's algorithm.
fn de_boor(degree: usize, points: &[DVec4], knots: &[f64], t: f64) -> DVec4 {
    let k = (degree..points.len())
        .rfind(|&k| knots[k] <= t)
        .unwrap_or(degree);
    let mut d = points[k - degree..=k].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let (a, b) = (knots[j + k - degree], knots[j + 1 + k - r]);
            d[j] = d[j - 1].lerp(d[j], (t - a) / (b - a));
        }
    }
    d[degree]
}

/// About how far a point is from a surface.
type Distance = Box<dyn Fn(DVec3) -> f64>;

/// A quadric of unit size under a map: x² + y² + z² = 1, or without z.
fn mapped(map: DAffine3, is_cylinder: bool) -> Distance {
    let inverse = map.inverse();
    let weights = if is_cylinder {
        dvec3(1.0, 1.0, 0.0)
    } else {
        DVec3::ONE
    };
    Box::new(move |point| {
        let p = inverse.transform_point3(point);
        let gradient = inverse.matrix3.transpose() * (2.0 * weights * p);
        (p.dot(weights * p) - 1.0).abs() / gradient.length()
    })
}

/// A plane across an axis, under a map.
fn plane(map: DAffine3, axis: DVec3, height: f64) -> Distance {
    let inverse = map.inverse();
    let length = (inverse.matrix3.transpose() * axis).length();
    Box::new(move |point| (inverse.transform_point3(point).dot(axis) - height).abs() / length)
}

/// Random numbers, by xorshift.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        [(); 3].map(|()| self.between(-size, size)).into()
    }

    /// A rotation, its numbers rounded to six digits in every other case, as OpenSCAD writes them.
    fn turn(&mut self) -> DMat3 {
        let [x, y, z] = self.vector(3.0).to_array();
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, x, y, z);
        if self.between(0.0, 1.0) < 0.5 {
            return turn;
        }
        DMat3::from_cols_array(&turn.to_cols_array().map(|x| (1e6 * x).round() * 1e-6))
    }
}

/// A solid with an ellipsoid, and the surfaces that it may have.
fn case(seed: u64) -> (Solid, Vec<Distance>) {
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (seed + 1));
    let random = &mut random;
    let ellipsoid = |random: &mut Random, shift: DVec3| {
        let [a, b, c] = [(); 3].map(|()| random.between(0.5, 2.0));
        // A ball, nearly one, a spheroid, and one without such axes.
        let radii = match seed % 4 {
            0 => DVec3::splat(a),
            1 => dvec3(a, a, a * (1.0 + 1e-6)),
            2 => dvec3(a, a, c),
            _ => dvec3(a, b, c),
        };
        let turn = DAffine3::from_mat3_translation(random.turn(), shift);
        let map = turn * DAffine3::from_scale(radii);
        (Solid::sphere(1.0).affine(map), map)
    };
    let shift = random.vector(5.0);
    let (body, map) = ellipsoid(random, shift);
    let mut surfaces = vec![mapped(map, false)];
    let near = shift + random.vector(0.5);
    let other = match seed % 3 {
        0 => {
            let map = DAffine3::from_mat3_translation(random.turn(), near);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                surfaces.extend([-0.8, 0.8].map(|side| plane(map, axis, side)));
            }
            Solid::cube(1.6).affine(map)
        }
        1 => {
            let turn = DAffine3::from_mat3_translation(random.turn(), near);
            let map = turn * DAffine3::from_scale(dvec3(0.4, 0.4, 9.0));
            surfaces.push(mapped(map, true));
            surfaces.extend([-1.0, 1.0].map(|side| plane(map, DVec3::Z, side)));
            Solid::cylinder(1.0, -1.0..1.0).affine(map)
        }
        _ => {
            let (other, map) = ellipsoid(random, near);
            surfaces.push(mapped(map, false));
            other
        }
    };
    let solid = match seed / 3 % 3 {
        0 => body - other,
        1 => body & other,
        _ => body | other,
    };
    (solid, surfaces)
}

/// How many faces, edges and images there were.
#[derive(Default)]
struct Tally {
    faces: usize,
    edges: usize,
    images: usize,
}

/// Surfaces to rounding, curves and their images within a tolerance.
fn check(file: &File<'_>, surfaces: &[Distance], tolerance: f64, seed: u64, tally: &mut Tally) {
    // Splines are held against their curves at some places only.
    let near = 1.5 * tolerance;
    // The one of the solid's surfaces on which a face's is all over, and the surfaces beside an edge.
    let mut truth: HashMap<&str, &Distance> = HashMap::new();
    let mut sides: HashMap<&str, Vec<&str>> = HashMap::new();
    for face in file.all("ADVANCED_FACE") {
        tally.faces += 1;
        let surface = face[2].atom();
        let grid = file.grid(surface);
        let farthest = |of: &Distance| grid.iter().map(|&point| of(point)).fold(0.0, f64::max);
        let best = surfaces
            .iter()
            .min_by(|a, b| farthest(a).total_cmp(&farthest(b)))
            .expect("some");
        // To rounding, at places as far as 10 from the origin.
        let off = farthest(best);
        assert!(off < 1e-13, "{seed}: {off} off: {}", file.0[surface]);
        truth.insert(surface, best);
        for edge in file.edges_around(&face) {
            sides.entry(edge).or_default().push(surface);
        }
    }
    for (edge, sides) in sides {
        tally.edges += 1;
        let edge = file.known(edge, "EDGE_CURVE");
        let curve = edge[3].atom();
        let Some(parts) = file.part(curve, "SURFACE_CURVE") else {
            continue;
        };
        let curve = parts[1].atom();
        let at = file.curve(curve);
        for image in parts[2].list() {
            tally.images += 1;
            let image = file.known(image.atom(), "PCURVE");
            let surface = image[1].atom();
            assert!(sides.contains(&surface), "{seed}");
            let representation = file.known(image[2].atom(), "DEFINITIONAL_REPRESENTATION");
            let ([from, until], place) = file.spline(representation[1].list()[0].atom());
            let surface = file.surface(surface);
            for k in 0..=97 {
                let t = from + (until - from) * f64::from(k) / 97.0;
                let point = at(t);
                let off = surface(place(t).truncate()).distance(point);
                let curve = file.0[curve];
                assert!(off < near, "{seed}: an image is {off} off: {curve}");
                for side in &sides {
                    let off = truth[side](point);
                    assert!(off < near, "{seed}: a curve is {off} off: {curve}");
                }
            }
            // From vertex to vertex.
            for (vertex, t) in [(1, from), (2, until)] {
                let vertex = file.known(edge[vertex].atom(), "VERTEX_POINT");
                let off = at(t).distance(file.point(vertex[1].atom()));
                assert!(off < near, "{seed}: a vertex is {off} off");
            }
        }
    }
}

#[test]
fn surfaces_and_curves_of_cut_ellipsoids_are_where_they_are() {
    let mut tally = Tally::default();
    let mut tried = 0;
    for seed in 0..72 {
        let (solid, surfaces) = case(seed);
        let program = Program::lower(&solid).expect("valid");
        let options = BoundaryOptions::new().cut_at_seams();
        let brep = program.boundary(&options).expect("a boundary");
        if brep.is_empty() {
            continue;
        }
        tried += 1;
        let tolerance = 1e-9;
        let options = StepOptions::default().tolerance(tolerance);
        let mut bytes = Vec::new();
        write_step(&brep, &options, &mut bytes).expect("written");
        let text = String::from_utf8(bytes).expect("text");
        check(&File::of(&text), &surfaces, tolerance, seed, &mut tally);
    }
    let Tally {
        faces,
        edges,
        images,
    } = tally;
    println!("{tried} solids, {faces} faces, {edges} edges, {images} images");
    assert!(tried > 60, "{tried}");
    assert!(images > edges, "{images} of {edges}");
}
