//! Where the curve of two surfaces touches a third one, decided once for all three.
//!
//! Rounding makes no root of a contact, or two or four, and on each of the three pairs'
//! curves others: their order along the curves says nothing then. So what is between
//! roots that rounding may have made is one place, and if one of the three curves
//! tells that it is a contact, it is one on all of them, at one point.

use glam::DVec3;
use smallvec::SmallVec;

use super::ball::{Ball, Touching};
use super::curve::{Curve, Meets};
use super::piece::CurveId;
use super::roots::{Roots, bracketed};
use super::scene::Scene;
use crate::numeric::tolerance::DOUBTFUL;
use crate::program::{Surface, SurfaceId};
use crate::surface::solve;

/// A root, or several that cannot be told apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cluster {
    /// Where the sign changes, in order.
    pub roots: SmallVec<[f64; 2]>,
    /// Where it may not, too.
    pub from: f64,
    pub to: f64,
    /// Whether it is a contact by what this curve tells.
    pub is_contact: bool,
    /// Where the curve's node is, if that cannot be told apart from it.
    pub node: Option<f64>,
}

impl Cluster {
    pub fn is_single_root(&self) -> bool {
        self.roots.len() == 1 && !self.is_contact && self.node.is_none()
    }

    /// Whether the third surface crosses the curve at its node.
    pub fn crosses_at_node(&self) -> bool {
        self.node.is_some() && self.is_contact && self.roots.len() == 1
    }

    /// Whether the sign is another one behind it.
    pub fn crosses(&self) -> bool {
        self.roots.len() % 2 == 1
    }
}

/// What is at a place of a curve.
#[derive(Clone, Copy)]
enum Found {
    Root,
    Touch,
    Node,
}

/// The clusters, in order, of the places where a function is 0 that else stays within
/// `rounding` of that only by chance; `nodes` are those of the curve. Sorts the roots.
fn clusters(
    roots: &mut Roots,
    nodes: &[f64],
    value: impl Fn(f64) -> f64,
    rounding: f64,
) -> SmallVec<[Cluster; 4]> {
    let Roots {
        simple, touching, ..
    } = roots;
    simple.sort_unstable_by(f64::total_cmp);
    let mut places: SmallVec<[(f64, Found); 8]> =
        simple.iter().map(|&t| (t, Found::Root)).collect();
    // Far from them it is not 0.
    let doubtful = DOUBTFUL * rounding;
    let alone = touching
        .iter()
        .filter(|&&t| !simple.contains(&t) && value(t).abs() <= doubtful);
    places.extend(alone.map(|&t| (t, Found::Touch)));
    let on_it = nodes.iter().filter(|&&t| value(t).abs() <= doubtful);
    places.extend(on_it.map(|&t| (t, Found::Node)));
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Where it touches 0 between two roots it stays there at one place alone.
    let stays = |a: f64, b: f64, within: f64| {
        let is_near = |share: &f64| value(a + share * (b - a)).abs() <= within;
        [0.2, 0.5, 0.8].iter().all(is_near)
    };
    let mut clusters: SmallVec<[Cluster; 4]> = SmallVec::new();
    let mut touches: SmallVec<[bool; 4]> = SmallVec::new();
    for (at, found) in places {
        let joins = |last: &&mut Cluster| stays(last.to, at, doubtful);
        let cluster = match clusters.last_mut().filter(joins) {
            Some(last) => {
                last.is_contact |= stays(last.to, at, rounding);
                last
            }
            None => {
                clusters.push(Cluster {
                    from: at,
                    ..Cluster::default()
                });
                touches.push(false);
                let new = clusters.len() - 1;
                &mut clusters[new]
            }
        };
        cluster.to = at;
        match found {
            Found::Root => {
                cluster.is_contact |= touching.contains(&at);
                cluster.roots.push(at);
            }
            Found::Node => cluster.node = Some(at),
            Found::Touch => touches[clusters.len() - 1] = true,
        }
    }
    // Of two roots that can be told apart the one between them tells nothing.
    for (cluster, touches) in clusters.iter_mut().zip(touches) {
        cluster.is_contact |= touches && cluster.roots.len() < 2;
    }
    clusters.retain(|cluster| cluster.is_contact || !cluster.roots.is_empty());
    clusters
}

/// A curve of two surfaces, and a third one.
#[derive(Clone, Copy)]
pub(super) struct Triple<'a> {
    pub curve: &'a Curve,
    /// Where others of the same pair pass through it.
    pub nodes: &'a [f64],
    pub pair: [&'a Surface; 2],
    pub third: &'a Surface,
}

impl Triple<'_> {
    /// How far the third surface is from a place on the curve, to first order.
    pub fn distance(&self, t: f64) -> f64 {
        let at = self.curve.at(t);
        self.third.value(at) / self.third.gradient(at).length()
    }

    /// How far off the curve is known to be at a place, or any of the three surfaces.
    fn off(&self, t: f64) -> f64 {
        solve::known_to(self.pair, self.third, self.curve.at(t))
    }

    /// Where the curve runs along the surface's tangent plane, from near it. The
    /// distance from the surface itself is 0 to second order there, so that it
    /// tells only half the digits.
    pub fn nearest(&self, near: f64, range: f64) -> f64 {
        /// How far from it, of the range.
        const REACHES: [f64; 3] = [1e-5, 1e-4, 1e-3];
        let [a, b] = self.pair;
        let slope = |t: f64| {
            let at = self.curve.at(t);
            // Along rulings directions are differences; along the others the
            // surfaces may touch.
            let along = match self.curve {
                Curve::Rulings(_) => a.gradient(at).cross(b.gradient(at)),
                curve => curve.direction(t),
            };
            self.third.gradient(at).dot(along)
        };
        for reach in REACHES {
            let ends = [near - reach * range, near + reach * range];
            let values = ends.map(slope);
            if values[0] * values[1] < 0.0 {
                return bracketed(slope, ends, values);
            }
        }
        near
    }

    /// Where the curve meets the third surface, by the roots found. Sorts these.
    pub fn clusters(&self, roots: &mut Roots, rounding: f64) -> SmallVec<[Cluster; 4]> {
        // What the curve itself is off its own surfaces, of which there may be much where its
        // surfaces are thin and it is long, no third one is told from.
        let value = |t: f64| (self.distance(t).abs() - self.off(t)).max(0.0);
        clusters(roots, self.nodes, value, rounding)
    }

    /// The one place of a cluster: that of the node, or where the sign changes, or where the
    /// surface is nearest.
    pub fn place(&self, cluster: &Cluster, range: f64) -> f64 {
        if let Some(node) = cluster.node {
            node
        } else if cluster.crosses() {
            cluster.roots[cluster.roots.len() / 2]
        } else {
            self.nearest(0.5 * (cluster.from + cluster.to), range)
        }
    }

    /// A ball around a cluster.
    pub fn around(&self, cluster: &Cluster, at: f64) -> Ball {
        let center = self.curve.at(at);
        let off = [cluster.from, cluster.to].map(|t| self.curve.at(t).distance(center));
        Ball {
            center,
            radius: off[0].max(off[1]),
        }
    }
}

impl Ball {
    /// Whether what three surfaces have in another ball cannot be told from what they have
    /// in this one: all between the two is common to them.
    pub fn is_same(&self, scene: &Scene<'_>, surfaces: &[&Surface; 3], other: &Self) -> bool {
        let distance = self.center.distance(other.center);
        if distance <= self.radius + other.radius + scene.weld {
            return true;
        }
        if distance > scene.blurred_reach() {
            return false;
        }
        let middle = self.center.midpoint(other.center);
        let common = solve::common_point(surfaces, middle, distance);
        common.residual <= scene.rounding && common.point.distance(middle) <= 0.25 * distance
    }

    /// The smallest around both.
    fn with(&self, other: &Self) -> Self {
        let distance = self.center.distance(other.center);
        Self {
            center: self.center,
            radius: self.radius.max(distance + other.radius),
        }
    }
}

/// Where three surfaces, ascending, touch. To be asked for by [`Scene::contacts`].
pub(super) fn contacts(scene: &Scene<'_>, ids: [SurfaceId; 3]) -> SmallVec<[Touching; 2]> {
    let surfaces = ids.map(|id| scene.surface(id));
    let mut found: SmallVec<[Doubtful; 8]> = SmallVec::new();
    let mut sharp: SmallVec<[Crossing; 8]> = SmallVec::new();
    for [a, b, third] in [[0, 1, 2], [0, 2, 1], [1, 2, 0]] {
        let common = scene.common(CurveId::first_of([ids[a], ids[b]]));
        for branch in common.iter().flat_map(|branches| branches.iter()) {
            let triple = Triple {
                curve: &branch.curve,
                nodes: &branch.nodes,
                pair: [surfaces[a], surfaces[b]],
                third: surfaces[third],
            };
            if let Some((range, clusters)) = triple.met(scene) {
                found.extend(triple.doubtful(scene, range, &clusters));
                sharp.extend(triple.crossings(scene, [a, b, third], &clusters));
            }
        }
    }
    // The curve on which a contact is sharpest tells where it is: where one surface meets
    // two that touch each other along a curve, only along that one it is no more than
    // tangent.
    found.sort_by(|one, other| one.blur.total_cmp(&other.blur));
    // Whatever cannot be told from one of them is the same. What pairs have in common alone
    // tells sharper still where it is.
    let nodes = scene.nodes(&ids);
    let mut contacts: SmallVec<[Touching; 2]> = SmallVec::new();
    while let Some(first) = found.iter().position(|place| place.is_contact) {
        let Doubtful { mut ball, blur, .. } = found.remove(first);
        while let Some(same) = found
            .iter()
            .position(|other| ball.is_same(scene, &surfaces, &other.ball))
        {
            ball = ball.with(&found.remove(same).ball);
        }
        let apexes = surfaces.iter().filter_map(|surface| surface.apex());
        let mut near = apexes.filter(|apex| apex.distance(ball.center) <= ball.radius + scene.near);
        let mut nodes = nodes.iter().copied();
        let node = nodes.find(|&center| {
            let radius = 0.0;
            ball.is_same(scene, &surfaces, &Ball { center, radius })
        });
        let sharper = || sharper(scene, ids, ball.center, blur);
        if let Some(sharp) = near.next().or(node).or_else(sharper) {
            ball.center = sharp;
        }
        let crossings = parts(scene, &surfaces, ball.center, &sharp);
        contacts.push(Touching { ball, crossings });
    }
    for &center in &nodes {
        let radius = 0.0;
        let ball = Ball { center, radius };
        let crossings = parts(scene, &surfaces, center, &sharp);
        let is_same = |known: &Touching| known.ball.is_same(scene, &surfaces, &ball);
        if !crossings.is_empty() && !contacts.iter().any(is_same) {
            contacts.push(Touching { ball, crossings });
        }
    }
    contacts
}

/// Where three surfaces are found to cross beside a point in which two of them are said to touch
/// that nearly do, if the third one passes through it: there these crossings are.
fn parts(
    scene: &Scene<'_>,
    surfaces: &[&Surface; 3],
    contact: DVec3,
    found: &[Crossing],
) -> SmallVec<[Ball; 2]> {
    /// It is in the middle of both: they are apart by twice what it is off.
    const BOTH: f64 = 2.0;
    let off = solve::residual(surfaces.iter().copied(), contact);
    if off > scene.weld {
        return SmallVec::new();
    }
    let is_part = |&&Crossing { at, on, .. }: &&Crossing| {
        let curve = on.map(|k| surfaces[k]);
        at.distance(contact) <= scene.touching_reach()
            && off_between(scene, curve, [contact, at]) <= BOTH * off
    };
    found.iter().filter(is_part).map(Crossing::ball).collect()
}

/// How far, between two places on a curve of two surfaces, a third one is from it.
fn off_between(scene: &Scene<'_>, [a, b, third]: [&Surface; 3], [from, to]: [DVec3; 2]) -> f64 {
    let middle = scene.common_to(&[a, b], from.midpoint(to));
    third.value(middle).abs() / third.gradient(middle).length()
}

/// Where two of three surfaces cross another one next to a contact of the three that none of
/// their curves tells better than to `blur`: of a contact of the fourth order a quarter of the
/// digits are known, and others that pass through it know it better.
fn sharper(scene: &Scene<'_>, ids: [SurfaceId; 3], contact: DVec3, blur: f64) -> Option<DVec3> {
    if blur <= scene.touching_reach() {
        return None;
    }
    let surfaces = ids.map(|id| scene.surface(id));
    let is_near = |surface: &Surface| {
        surface.value(contact).abs() <= blur * surface.gradient(contact).length()
    };
    let others = (0..).map(SurfaceId).zip(scene.surfaces);
    let others = others.filter(|(id, surface)| !ids.contains(id) && is_near(surface));
    let [a, b, c] = ids;
    let pairs = others.flat_map(|(other, _)| [[a, b, other], [a, c, other], [b, c, other]]);
    let points = pairs.flat_map(|ids| scene.crossings(ids).to_vec());
    let is_common = |point: &DVec3| {
        point.distance(contact) <= blur
            && solve::residual(surfaces.into_iter(), *point) <= scene.rounding
    };
    let distance = |point: &DVec3| point.distance(contact);
    let common = points.filter(is_common);
    common.min_by(|p, q| distance(p).total_cmp(&distance(q)))
}

/// The points in which three surfaces, ascending, cross, each by that of their curves which
/// tells it best. To be asked for by [`Scene::crossings`].
pub(super) fn crossings(scene: &Scene<'_>, ids: [SurfaceId; 3]) -> SmallVec<[DVec3; 2]> {
    let surfaces = ids.map(|id| scene.surface(id));
    let mut found: SmallVec<[Crossing; 8]> = SmallVec::new();
    for [a, b, third] in [[0, 1, 2], [0, 2, 1], [1, 2, 0]] {
        let common = scene.common(CurveId::first_of([ids[a], ids[b]]));
        for branch in common.iter().flat_map(|branches| branches.iter()) {
            let triple = Triple {
                curve: &branch.curve,
                nodes: &branch.nodes,
                pair: [surfaces[a], surfaces[b]],
                third: surfaces[third],
            };
            if let Some((_, clusters)) = triple.met(scene) {
                found.extend(triple.crossings(scene, [a, b, third], &clusters));
            }
        }
    }
    found.sort_by(|one, other| one.blur.total_cmp(&other.blur));
    let mut points: SmallVec<[DVec3; 2]> = SmallVec::new();
    for Crossing { at, blur, .. } in found {
        if points.iter().all(|known| known.distance(at) > blur) {
            points.push(at);
        }
    }
    points
}

/// How far from where a curve was found to cross a surface, at an angle of that sine, rounding
/// lets it cross as well, along this curve or others of the three surfaces.
pub(super) fn crossing_blur(rounding: f64, sine: f64) -> f64 {
    /// How far rounding may part roots along one curve and along another, in what it may
    /// part those along one.
    const MARGIN: f64 = 16.0;
    MARGIN * rounding / sine.abs()
}

/// Where a curve crosses a surface.
struct Crossing {
    at: DVec3,
    /// How far from there it may as well be.
    blur: f64,
    /// Which two of the three that curve is on, and the third one.
    on: [usize; 3],
}

impl Crossing {
    fn ball(&self) -> Ball {
        Ball {
            center: self.at,
            radius: self.blur,
        }
    }
}

/// Where roots along a curve cannot be told apart for sure.
struct Doubtful {
    ball: Ball,
    /// Whether that is a contact by what this curve tells.
    is_contact: bool,
    /// How far along the curve it may as well be.
    blur: f64,
}

impl Triple<'_> {
    /// How far along the curve from a place the third surface is no farther than rounding
    /// tells.
    fn blur(&self, at: f64, range: f64, rounding: f64) -> f64 {
        /// Shares of the range.
        const LEAST: f64 = 1e-10;
        const MOST: f64 = 1e-2;
        let is_nothing = |t: f64| self.distance(t).abs() <= DOUBTFUL * rounding;
        let mut reach = LEAST * range;
        while reach < MOST * range && is_nothing(at - reach) && is_nothing(at + reach) {
            reach *= 2.0;
        }
        self.curve.at(at + reach).distance(self.curve.at(at))
    }

    /// Where the curve crosses the third surface, also where roots cannot be told apart
    /// for sure: whether they are a contact is another question.
    fn crossings(
        &self,
        scene: &Scene<'_>,
        on: [usize; 3],
        clusters: &[Cluster],
    ) -> impl Iterator<Item = Crossing> {
        let [a, b] = self.pair;
        let apart = clusters
            .iter()
            .filter(|cluster| !cluster.is_contact && cluster.node.is_none());
        apart.flat_map(|cluster| &cluster.roots).map(move |&root| {
            let at = scene.common_to(&[a, b, self.third], self.curve.at(root));
            let [normal, along] = [self.third.gradient(at), self.curve.direction(root)];
            let sine = normal.normalize_or_zero().dot(along.normalize_or_zero());
            let blur = crossing_blur(scene.rounding, sine);
            Crossing { at, blur, on }
        })
    }

    /// How long the curve is in the scene, by its parameter, and where it meets the third
    /// surface; none if it runs along it, or that is not known.
    fn met(&self, scene: &Scene<'_>) -> Option<(f64, SmallVec<[Cluster; 4]>)> {
        let range = self.curve.range(DVec3::ZERO, scene.reach)?;
        let mut roots = Roots::default();
        let own = (self.curve, self.pair);
        let tolerances = scene.tolerances_beside(self.third, own, range);
        let meets = self.curve.meet(self.third, range, tolerances, &mut roots);
        let is_known = meets == Meets::Points && !roots.is_lost;
        is_known.then(|| {
            let clusters = self.clusters(&mut roots, scene.rounding);
            (range[1] - range[0], clusters)
        })
    }

    /// Where roots cannot be told apart for sure.
    fn doubtful(
        &self,
        scene: &Scene<'_>,
        range: f64,
        clusters: &[Cluster],
    ) -> impl Iterator<Item = Doubtful> {
        let [a, b] = self.pair;
        let several = clusters.iter().filter(|cluster| !cluster.is_single_root());
        several.map(move |cluster| {
            let at = self.place(cluster, range);
            let mut ball = self.around(cluster, at);
            ball.center = scene.common_to(&[a, b], ball.center);
            Doubtful {
                ball,
                is_contact: cluster.is_contact,
                blur: self.blur(at, range, scene.rounding),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUNDING: f64 = 1e-12;

    fn of(simple: &[f64], value: impl Fn(f64) -> f64) -> SmallVec<[Cluster; 4]> {
        with_nodes(simple, &[], value)
    }

    fn with_nodes(
        simple: &[f64],
        nodes: &[f64],
        value: impl Fn(f64) -> f64,
    ) -> SmallVec<[Cluster; 4]> {
        let mut roots = Roots {
            simple: simple.to_vec(),
            ..Roots::default()
        };
        clusters(&mut roots, nodes, value, ROUNDING)
    }

    /// A contact that dips below 0 by a share of rounding, and roots beside it.
    #[test]
    fn roots_that_rounding_parts_are_one_place() {
        for (share, is_contact, count) in [(0.5, true, 3), (50.0, false, 3), (5e4, false, 4)] {
            let dip: f64 = share * ROUNDING;
            let half = dip.sqrt();
            let value = |t: f64| ((t - 0.3).powi(2) - dip) * (t - 0.7) * (t - 0.8);
            let found = of(&[0.3 - half, 0.3 + half, 0.7, 0.8], value);
            assert_eq!(found.len(), count, "{found:?}");
            assert_eq!(found[0].is_contact, is_contact);
            assert!(found[count - 1].is_single_root() && found[count - 2].is_single_root());
        }
    }

    #[test]
    fn of_three_roots_one_is_left() {
        let found = of(&[0.3 + 1e-7, 0.3, 0.3 - 1e-7], |_| 0.0);
        assert_eq!(found.len(), 1);
        assert!(found[0].crosses() && found[0].is_contact);
        assert_eq!(found[0].roots[1], 0.3);
    }

    /// Between two roots it may touch 0, and in their middle at that.
    #[test]
    fn roots_about_a_contact_stay() {
        let found = of(&[-1.0, 1.0], |t| (t * t - 1.0) * t * t);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(Cluster::is_single_root));
    }

    /// A surface that crosses at a small angle, where rounding moves its root, and one that
    /// passes beside the node.
    #[test]
    fn roots_beside_a_node_are_there() {
        let node = 0.3;
        for (slope, off) in [(1e-6, 1e-7), (1.0, 0.0)] {
            let value = |t: f64| slope * (t - node - off) * (t - 2.0);
            let found = with_nodes(&[node + off, 2.0], &[node], value);
            assert_eq!(found.len(), 2, "{found:?}");
            assert!(found[0].crosses_at_node() && found[1].is_single_root());
            assert_eq!(found[0].node, Some(node));
        }
        let found = with_nodes(&[0.4], &[node], |t| t - 0.4);
        assert_eq!(found.len(), 1);
        assert!(found[0].is_single_root());
    }
}
