//! Surfaces that nearly touch, meet in a point or a circle, or are in line, moved until they do.
//!
//! What an author meant to be tangent, concentric or flush, and missed by less than can be seen,
//! is found by what the numbers of planes, balls, cylinders and cones nearly satisfy, those that
//! are nearly round made round before: each such relation is an equation, linear but for second
//! order, and all of them together are satisfied by the least moves there are (Newton's method,
//! each step by conjugate gradients on the normal equations, which from nothing end at the
//! shortest solution). Directions are turned only where no moves alone do.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::element::{Element, Form};
use crate::numeric::tolerance::VALUE;
use crate::program::Surface;

/// More surfaces are left as they are: their relations are looked for pair by pair, and along
/// each axis for each plane across.
const MOST: usize = 1000;

/// What is nearly so: a value that ought to be 0.
#[derive(Clone, Copy, Debug)]
enum Relation {
    /// Planes of one normal, or opposite ones.
    Flush([usize; 2]),
    /// A plane through a point or along an axis, or so many radii from there.
    OnPlane([usize; 2], f64),
    /// Points or axes in one place, as seen along a direction.
    InLine([usize; 2], DVec3),
    /// Points or axes at a distance of the radii times signs.
    Apart([usize; 2], [f64; 2]),
    /// Sizes of one kind.
    SameSize([usize; 2]),
    /// Two surfaces about one axis meet in a circle in a plane across it.
    Circle(usize, [usize; 2]),
    /// Directions at right angles.
    Square([usize; 2]),
}

/// What a value changes with.
#[derive(Clone, Copy, Debug)]
enum Slope {
    /// With the place and the size of an element.
    Move(usize, DVec3, f64),
    /// With how an element's axis is turned, of the scene's reach.
    Turn(usize, DVec3),
}

type Slopes = SmallVec<[Slope; 6]>;

/// All that is moved at once.
#[derive(Clone, Debug)]
struct Assembly {
    elements: Vec<Element>,
    directions: Vec<DVec3>,
    reach: f64,
}

/// Surfaces about the middle of the scene with the places, directions and sizes that their
/// relations ask for that are missed by no more than `within`; those that are fixed stay. None if
/// there is nothing to be moved, or one would be farther than `most`.
pub(super) fn aligned(
    surfaces: &[Surface],
    is_fixed: impl Fn(usize) -> bool,
    reach: f64,
    (within, most): (f64, f64),
) -> Option<Vec<Surface>> {
    if surfaces.len() > MOST {
        return None;
    }
    let of = |(index, surface): (usize, &Surface)| {
        let element = Element::of(surface, reach, within);
        match is_fixed(index) {
            true => Element {
                form: Form::Fixed,
                ..element
            },
            false => element,
        }
    };
    let before: Vec<Element> = surfaces.iter().enumerate().map(of).collect();
    let straight = Assembly::straightened(before.clone(), reach, within);
    let mut relations = relations(&straight.elements, reach, within);
    let mut unsatisfied = None;
    for turns in [Turns::No, Turns::Yes] {
        let mut moved = straight.clone();
        let is_satisfied = moved.satisfy(&relations, turns);
        let after = surfaces.iter().zip(&before).zip(&moved.elements);
        let after = after.map(|((surface, before), after)| {
            let by = before.at.distance(after.at) + (before.size - after.size).abs();
            let turned = before.axis.distance(after.axis) * reach;
            let is_same = by + turned <= VALUE * reach && after.spread == 0.0;
            (!is_same).then(|| after.applied_to(surface, reach))
        });
        let after: Vec<Option<Surface>> = after.collect();
        // (Nothing but a point in place of all satisfies most relations, too.)
        let is_near = surfaces.iter().zip(&after).all(|(before, after)| {
            let off = after.map_or(0.0, |after| before.distance_bound(&after, reach));
            off <= most
        });
        if is_near && is_satisfied {
            return applied(surfaces, &after);
        }
        if is_near && turns == Turns::No {
            unsatisfied = Some(after);
        }
        relations.extend(straight.squares(within));
    }
    applied(surfaces, &unsatisfied?)
}

/// The surfaces with others in place of some; none if all stay.
fn applied(surfaces: &[Surface], after: &[Option<Surface>]) -> Option<Vec<Surface>> {
    let is_moved = after.iter().any(Option::is_some);
    let all = surfaces.iter().zip(after);
    is_moved.then(|| {
        all.map(|(before, after)| after.unwrap_or(*before))
            .collect()
    })
}

/// Whether directions may be turned.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turns {
    No,
    Yes,
}

impl Assembly {
    /// Makes directions that are nearly the same, or nearly at right angles, so: those that
    /// more surfaces have stay, with all that fits them as they are.
    fn straightened(mut elements: Vec<Element>, reach: f64, within: f64) -> Self {
        let within = within / reach;
        let mut known: Vec<DVec3> = Vec::new();
        for index in most_common_first(&elements) {
            let element = &mut elements[index];
            let axis = element.axis;
            let same = known.iter().position(|k| k.cross(axis).length() <= within);
            if let Some(same) = same {
                element.direction = same;
                element.axis = known[same].dot(axis).signum() * known[same];
            } else {
                let mut across = known.iter().filter(|k| k.dot(axis).abs() <= within);
                element.axis = match (across.next(), across.next()) {
                    (None, _) => axis,
                    (Some(one), other) => {
                        let normal = other.map(|other| one.cross(*other));
                        let normal = normal.filter(|normal| normal.length() > 0.1);
                        let straight = match normal {
                            Some(normal) => normal.dot(axis).signum() * normal,
                            None => axis.reject_from_normalized(*one),
                        };
                        straight.normalize()
                    }
                };
                element.direction = known.len();
                known.push(element.axis);
            }
            element.at = match element.form {
                Form::Plane => {
                    element.at.dot(axis) * axis.dot(element.axis).signum() * element.axis
                }
                Form::Rod => element.at.reject_from_normalized(element.axis),
                _ => element.at,
            };
        }
        Self {
            elements,
            directions: known,
            reach,
        }
    }

    /// The directions that are nearly at right angles.
    fn squares(&self, within: f64) -> Vec<Relation> {
        let mut found = Vec::new();
        for (i, a) in self.directions.iter().enumerate() {
            for (k, b) in self.directions.iter().enumerate().skip(i + 1) {
                if (a.dot(*b) * self.reach).abs() <= within {
                    found.push(Relation::Square([i, k]));
                }
            }
        }
        found
    }

    /// Moves all by the least that satisfies relations; false if that is not to be done.
    fn satisfy(&mut self, relations: &[Relation], turns: Turns) -> bool {
        const STEPS: usize = 5;
        let rounding = VALUE * self.reach;
        for step in 0..=STEPS {
            let values = relations.iter().map(|relation| relation.value(self));
            let values: Vec<(f64, Slopes)> = values.collect();
            if values.iter().all(|(value, _)| value.abs() <= rounding) {
                return true;
            }
            if step < STEPS {
                let rows: Vec<(f64, Row)> = values
                    .into_iter()
                    .map(|(value, slopes)| (value, self.row(&slopes, turns)))
                    .collect();
                let count = 4 * self.elements.len() + 3 * self.directions.len();
                self.move_by(&least_moves(&rows, count));
            }
        }
        false
    }

    /// What a value changes with, by number: place and size of each element, then each direction.
    fn row(&self, slopes: &Slopes, turns: Turns) -> Row {
        let mut row = Row::new();
        for slope in slopes {
            match *slope {
                Slope::Move(element, place, size) => {
                    let each = place.to_array().into_iter().chain([size]);
                    row.extend((4 * element..).zip(each));
                }
                Slope::Turn(direction, by) if turns == Turns::Yes => {
                    let first = 4 * self.elements.len() + 3 * direction;
                    row.extend((first..).zip((by / self.reach).to_array()));
                }
                Slope::Turn(..) => {}
            }
        }
        row
    }

    fn move_by(&mut self, moves: &[f64]) {
        let (places, turns) = moves.split_at(4 * self.elements.len());
        let turned = self.directions.iter().zip(turns.chunks_exact(3));
        let turned = turned.map(|(d, by)| (d + DVec3::from_slice(by) / self.reach).normalize());
        let turned: Vec<DVec3> = turned.collect();
        for (element, by) in self.elements.iter_mut().zip(places.chunks_exact(4)) {
            element.at += DVec3::from_slice(by);
            element.size += by[3];
            if element.has_axis() {
                let before = self.directions[element.direction];
                element.axis = element.axis.dot(before).signum() * turned[element.direction];
            }
        }
        self.directions = turned;
    }

    /// How a value changes with an element's axis, by what it changes with that.
    fn turn(&self, element: usize, by: DVec3) -> Slope {
        let Element {
            axis, direction, ..
        } = self.elements[element];
        Slope::Turn(
            direction,
            axis.dot(self.directions[direction]).signum() * by,
        )
    }

    /// How the distance between two elements, as seen along a direction in which they are free,
    /// changes with their axes.
    fn turns_between(&self, [i, k]: [usize; 2], along: DVec3) -> Slopes {
        let [a, b] = [i, k].map(|index| &self.elements[index]);
        let off = b.at - a.at;
        match [a, b].map(|element| element.form == Form::Rod) {
            [false, false] => Slopes::new(),
            [true, true] if !is_parallel(a.axis, b.axis) => {
                let normal = a.axis.cross(b.axis);
                let share = normal.dot(along).signum() / normal.length();
                smallvec![
                    self.turn(i, share * b.axis.cross(off)),
                    self.turn(k, share * off.cross(a.axis))
                ]
            }
            [true, _] => smallvec![self.turn(i, -off.dot(a.axis) * along)],
            [false, true] => smallvec![self.turn(k, -off.dot(b.axis) * along)],
        }
    }
}

/// The elements with an axis, those first whose direction most of them have.
fn most_common_first(elements: &[Element]) -> Vec<usize> {
    let with_axis = || elements.iter().enumerate().filter(|(_, e)| e.has_axis());
    let count = |axis: DVec3| {
        with_axis()
            .filter(|(_, e)| is_parallel(e.axis, axis))
            .count()
    };
    let mut counted: Vec<(usize, usize)> = with_axis().map(|(k, e)| (count(e.axis), k)).collect();
    counted.sort_by_key(|&(count, _)| std::cmp::Reverse(count));
    counted.into_iter().map(|(_, index)| index).collect()
}

/// Whether directions are the same or opposite, once they were straightened.
fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= VALUE
}

fn is_across(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= VALUE
}

/// The directions in which places of two elements differ: all, or those across axes.
fn free_directions(a: &Element, b: &Element) -> SmallVec<[DVec3; 3]> {
    let axis = |element: &Element| (element.form == Form::Rod).then_some(element.axis);
    let across = |axis: DVec3| <[DVec3; 2]>::from(axis.any_orthonormal_pair());
    match (axis(a), axis(b)) {
        (None, None) => smallvec![DVec3::X, DVec3::Y, DVec3::Z],
        (Some(axis), Some(other)) if !is_parallel(axis, other) => {
            smallvec![axis.cross(other).normalize()]
        }
        (Some(axis), _) | (_, Some(axis)) => SmallVec::from_slice(&across(axis)),
    }
}

/// From one place to the other, in the directions in which they differ.
fn separation(a: &Element, b: &Element) -> DVec3 {
    let directions = free_directions(a, b);
    let off = b.at - a.at;
    directions.iter().map(|&e| off.dot(e) * e).sum()
}

fn relations(elements: &[Element], reach: f64, within: f64) -> Vec<Relation> {
    let mut found = Vec::new();
    let is_near = |value: f64| value.abs() <= within;
    for (i, a) in elements.iter().enumerate() {
        for (k, b) in elements.iter().enumerate().skip(i + 1) {
            let pair = [i, k];
            match (a.form, b.form) {
                (Form::Fixed, _) | (_, Form::Fixed) => {}
                (Form::Plane, Form::Plane) => {
                    let off = (a.at - b.at).dot(a.axis);
                    if is_parallel(a.axis, b.axis) && is_near(off) {
                        found.push(Relation::Flush(pair));
                    }
                }
                (Form::Plane, _) => found.extend(on_plane(elements, [i, k], within)),
                (_, Form::Plane) => found.extend(on_plane(elements, [k, i], within)),
                _ => found.extend(between(elements, pair, within)),
            }
            let are_sized = match (a.form, b.form) {
                // A ball fits a rod about it.
                (Form::Ball, Form::Rod) | (Form::Rod, Form::Ball) => {
                    separation(a, b).length() <= within
                }
                (Form::Ball | Form::Rod | Form::Cone, form) => form == a.form,
                _ => false,
            };
            let is_same = are_sized && is_near(a.size - b.size);
            found.extend(is_same.then_some(Relation::SameSize(pair)));
        }
    }
    let planes = (0..elements.len()).filter(|&p| elements[p].form == Form::Plane);
    let planes: Vec<usize> = planes.collect();
    for (i, a) in elements.iter().enumerate() {
        for (k, b) in elements.iter().enumerate().skip(i + 1) {
            let Some(axis) = common_axis(a, b, within) else {
                continue;
            };
            let across = planes
                .iter()
                .filter(|&&p| is_parallel(elements[p].axis, axis));
            for &plane in across {
                let radii = [a, b].map(|round| round_at(round, &elements[plane], reach));
                if let [Some((one, ..)), Some((other, ..))] = radii
                    && is_near(one - other)
                {
                    found.push(Relation::Circle(plane, [i, k]));
                }
            }
        }
    }
    found
}

fn on_plane(elements: &[Element], pair: [usize; 2], within: f64) -> Option<Relation> {
    let [plane, other] = pair.map(|index| &elements[index]);
    let is_along = other.form != Form::Rod || is_across(plane.axis, other.axis);
    let off = (other.at - plane.at).dot(plane.axis);
    let radii = [0.0, 1.0, -1.0].into_iter();
    let mut near = radii.filter(|radii| (off - radii * other.radius()).abs() <= within);
    let radii = near.next().filter(|_| is_along && other.has_place())?;
    Some(Relation::OnPlane(pair, radii))
}

fn between(elements: &[Element], pair: [usize; 2], within: f64) -> SmallVec<[Relation; 3]> {
    let [a, b] = pair.map(|index| &elements[index]);
    let apart = separation(a, b).length();
    if apart <= within {
        let directions = free_directions(a, b).into_iter();
        return directions.map(|e| Relation::InLine(pair, e)).collect();
    }
    let [r, s] = [a.radius(), b.radius()];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]];
    let mut signs = signs.into_iter().filter(|_| r + s > 0.0);
    let near = signs.find(|[p, q]| (p * r + q * s - apart).abs() <= within);
    near.map(|signs| Relation::Apart(pair, signs))
        .into_iter()
        .collect()
}

/// The axis about which both are round.
fn common_axis(a: &Element, b: &Element, within: f64) -> Option<DVec3> {
    let is_round = |e: &Element| matches!(e.form, Form::Ball | Form::Rod | Form::Cone);
    let of = |e: &Element| (e.form != Form::Ball).then_some(e.axis);
    let axis = match (of(a), of(b)) {
        (Some(axis), Some(other)) if is_parallel(axis, other) => axis,
        (Some(axis), None) | (None, Some(axis)) => axis,
        _ => return None,
    };
    let off = (b.at - a.at).reject_from_normalized(axis).length();
    (is_round(a) && is_round(b) && off <= within).then_some(axis)
}

/// The radius of something round in a plane across its axis, and by how much it changes with
/// the plane's offset, with its own place along the plane's normal, and with its size.
fn round_at(round: &Element, plane: &Element, reach: f64) -> Option<(f64, f64, f64, f64)> {
    /// Of a ball's radius: a circle nearer to its pole says little of it.
    const LEAST: f64 = 1e-3;
    let height = (plane.at - round.at).dot(plane.axis);
    match round.form {
        Form::Rod => Some((round.size, 0.0, 0.0, 1.0)),
        Form::Cone => {
            let slope = round.size / reach * height.signum();
            Some((slope * height, slope, -slope, height.abs() / reach))
        }
        Form::Ball => {
            let radius = (round.size * round.size - height * height).max(0.0).sqrt();
            let slope = height / radius;
            (radius > LEAST * round.size).then_some((radius, -slope, slope, round.size / radius))
        }
        _ => None,
    }
}

impl Relation {
    fn value(&self, all: &Assembly) -> (f64, Slopes) {
        let elements = &all.elements;
        match *self {
            Self::Flush([i, k]) => {
                let normal = elements[i].axis;
                let off = elements[i].at - elements[k].at;
                let slopes = smallvec![
                    Slope::Move(i, normal, 0.0),
                    Slope::Move(k, -normal, 0.0),
                    all.turn(i, off)
                ];
                (off.dot(normal), slopes)
            }
            Self::OnPlane([plane, other], radii) => {
                let normal = elements[plane].axis;
                let off = elements[other].at - elements[plane].at;
                let value = off.dot(normal) - radii * elements[other].radius();
                let slopes = smallvec![
                    Slope::Move(plane, -normal, 0.0),
                    Slope::Move(other, normal, -radii),
                    all.turn(plane, off)
                ];
                (value, slopes)
            }
            Self::InLine([i, k], along) => {
                let [a, b] = [&elements[i], &elements[k]];
                let value = separation(a, b).dot(along);
                let mut slopes = all.turns_between([i, k], along);
                slopes.push(Slope::Move(i, -along, 0.0));
                slopes.push(Slope::Move(k, along, 0.0));
                (value, slopes)
            }
            Self::Apart([i, k], [p, q]) => {
                let [a, b] = [&elements[i], &elements[k]];
                let apart = separation(a, b);
                let along = apart.normalize_or_zero();
                let value = apart.length() - p * a.radius() - q * b.radius();
                let has_size = |e: &Element, sign: f64| match e.radius() {
                    0.0 => 0.0,
                    _ => -sign,
                };
                let mut slopes = all.turns_between([i, k], along);
                slopes.push(Slope::Move(i, -along, has_size(a, p)));
                slopes.push(Slope::Move(k, along, has_size(b, q)));
                (value, slopes)
            }
            Self::SameSize([i, k]) => {
                let value = elements[i].size - elements[k].size;
                let slope = |element, sign| Slope::Move(element, DVec3::ZERO, sign);
                (value, smallvec![slope(i, 1.0), slope(k, -1.0)])
            }
            Self::Circle(plane, [i, k]) => {
                let across = &elements[plane];
                let radii = [i, k].map(|round| round_at(&elements[round], across, all.reach));
                let [Some(one), Some(other)] = radii else {
                    return (0.0, Slopes::new());
                };
                let normal = across.axis;
                let [to_one, to_other] = [i, k].map(|round| across.at - elements[round].at);
                let slopes = smallvec![
                    Slope::Move(plane, (one.1 - other.1) * normal, 0.0),
                    Slope::Move(i, one.2 * normal, one.3),
                    Slope::Move(k, -other.2 * normal, -other.3),
                    all.turn(plane, one.1 * to_one - other.1 * to_other)
                ];
                (one.0 - other.0, slopes)
            }
            Self::Square([i, k]) => {
                let [a, b] = [i, k].map(|index| all.directions[index]);
                let slopes = [(i, b), (k, a)].map(|(d, by)| Slope::Turn(d, all.reach * by));
                (all.reach * a.dot(b), Slopes::from_iter(slopes))
            }
        }
    }
}

/// Numbers to be moved, with how fast a value changes with each.
type Row = SmallVec<[(usize, f64); 16]>;

/// The least moves by which all values become 0 to first order: by conjugate gradients on the
/// normal equations (Hestenes and Stiefel, *Methods of Conjugate Gradients for Solving Linear
/// Systems*, 1952).
fn least_moves(rows: &[(f64, Row)], count: usize) -> Vec<f64> {
    /// Of the square at first.
    const SMALL: f64 = 1e-30;
    let along = |moves: &[f64]| -> Vec<f64> {
        let change = |(_, row): &(f64, Row)| row.iter().map(|&(k, slope)| slope * moves[k]).sum();
        rows.iter().map(change).collect()
    };
    let back = |values: &[f64]| {
        let mut sums = vec![0.0; count];
        for ((_, row), &value) in rows.iter().zip(values) {
            for &(k, slope) in row {
                sums[k] += value * slope;
            }
        }
        sums
    };
    let square = |moves: &[f64]| -> f64 { moves.iter().map(|by| by * by).sum() };
    let mut moves = vec![0.0; count];
    let mut left: Vec<f64> = rows.iter().map(|(value, _)| -value).collect();
    let mut slope = back(&left);
    let mut direction = slope.clone();
    let first = square(&slope);
    let mut steepness = first;
    for _ in 0..2 * count {
        if steepness <= SMALL * first || steepness == 0.0 {
            break;
        }
        let change = along(&direction);
        let length = square(&change);
        if length == 0.0 {
            break;
        }
        let step = steepness / length;
        for (all, one) in moves.iter_mut().zip(&direction) {
            *all += step * one;
        }
        for (left, change) in left.iter_mut().zip(&change) {
            *left -= step * change;
        }
        slope = back(&left);
        let next = square(&slope);
        let share = next / steepness;
        for (all, one) in direction.iter_mut().zip(&slope) {
            *all = one + share * *all;
        }
        steepness = next;
    }
    moves
}
