//! Surfaces that the standard has no name for: rational polynomials of degree two in both
//! parameters, as far as a face goes.

use csg::brep::Face;
use csg::elementary;
use glam::{DVec3, DVec4};

use super::chart::{self, Bezier, Chart, Parameters, Profile, Written};
use super::scaled::Scaled;
use super::text::{Entities, Flag, Id, List, Reals};

/// A circle of unit radius from one angle to another as a rational polynomial of degree two:
/// points times weights, and weights.
fn arc([from, to]: [f64; 2]) -> [[f64; 3]; 3] {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    [
        [elementary::cos(from), elementary::sin(from), 1.0],
        [
            elementary::cos(middle),
            elementary::sin(middle),
            elementary::cos(half),
        ],
        [elementary::cos(to), elementary::sin(to), 1.0],
    ]
}

/// A profile, by radius, height and weight, turned around the axis as far as the face goes.
pub(super) fn revolved(
    to: &mut Entities,
    face: &Face<'_>,
    scaled: Scaled,
    (points, profile): (&[[f64; 3]], Profile),
) -> Written {
    let angles = scaled.sector(face);
    let arc = arc(angles);
    let net: Vec<Vec<DVec4>> = arc
        .iter()
        .map(|[cos, sin, weight]| {
            let row = points.iter().map(|[radius, height, w]| {
                DVec4::new(radius * cos, radius * sin, height * weight, w * weight)
            });
            row.collect()
        })
        .collect();
    let parameters = Parameters::Revolved { angles, profile };
    bezier(to, face, scaled, (net, parameters))
}

/// A part of a unit sphere, seen from the point opposite of the face's middle.
pub(super) fn stereographic(to: &mut Entities, face: &Face<'_>, scaled: Scaled) -> Written {
    let view = scaled
        .coordinates(scaled.placement.origin + face.view())
        .normalize_or_zero();
    let (u, v) = view.any_orthonormal_pair();
    let flat = |p: DVec3| chart::stereographic(p, view, [u, v]);
    let [x0, x1] = scaled.range(face, |p| flat(p).x);
    let [y0, y1] = scaled.range(face, |p| flat(p).y);
    // Polar values of 2x u + 2y v + (1 - x² - y²) view over 1 + x² + y².
    let net: Vec<Vec<DVec4>> = steps(x0, x1)
        .iter()
        .map(|&(x, xx)| {
            let row = steps(y0, y1);
            let row = row.iter().map(|&(y, yy)| {
                let point = 2.0 * x * u + 2.0 * y * v + (1.0 - xx - yy) * view;
                point.extend(1.0 + xx + yy)
            });
            row.collect()
        })
        .collect();
    let parameters = Parameters::Stereographic {
        view,
        axes: [u, v],
        x: [x0, x1],
        y: [y0, y1],
    };
    bezier(to, face, scaled, (net, parameters))
}

/// z = a x² + b y², whose x and y are its parameters; a saddle if the signs differ.
pub(super) fn paraboloid(
    to: &mut Entities,
    face: &Face<'_>,
    scaled: Scaled,
    [a, b]: [f64; 2],
) -> Written {
    let [x0, x1] = scaled.range(face, |p| p.x);
    let [y0, y1] = scaled.range(face, |p| p.y);
    let net: Vec<Vec<DVec4>> = steps(x0, x1)
        .iter()
        .map(|&(x, xx)| {
            let row = steps(y0, y1);
            let row = row
                .iter()
                .map(|&(y, yy)| DVec4::new(x, y, a * xx + b * yy, 1.0));
            row.collect()
        })
        .collect();
    let parameters = Parameters::Plain {
        x: [x0, x1],
        y: [y0, y1],
    };
    bezier(to, face, scaled, (net, parameters))
}

/// The polar values of x and x² between two places.
fn steps(from: f64, to: f64) -> [(f64, f64); 3] {
    [
        (from, from * from),
        (0.5 * (from + to), from * to),
        (to, to * to),
    ]
}

/// A rational polynomial surface, by points times weights, and weights.
fn bezier(
    to: &mut Entities,
    face: &Face<'_>,
    scaled: Scaled,
    (net, parameters): (Vec<Vec<DVec4>>, Parameters),
) -> Written {
    let place = |p: &DVec4| scaled.point(p.truncate() / p.w);
    let at: Vec<Vec<DVec3>> = net
        .iter()
        .map(|row| row.iter().map(place).collect())
        .collect();
    let (us, vs) = (net.len() - 1, net[0].len() - 1);
    // At the corner without a pole, if there is one.
    let (last, before) = (at[0][vs], at[0][vs - 1]);
    let normal = (at[1][vs] - last).cross(last - before);
    let rows: Vec<String> = at
        .iter()
        .map(|row| {
            let ids: Vec<Id> = row.iter().map(|&point| to.point(point)).collect();
            List(&ids).to_string()
        })
        .collect();
    let weights: Vec<String> = net
        .iter()
        .map(|row| {
            let weights: Vec<f64> = row.iter().map(|p| p.w).collect();
            Reals(&weights).to_string()
        })
        .collect();
    let (rows, weights) = (List(&rows), List(&weights));
    let (u, v) = (us + 1, vs + 1);
    let no = Flag(false);
    let surface = to.add(format_args!(
        "(BOUNDED_SURFACE()B_SPLINE_SURFACE({us},{vs},{rows},.UNSPECIFIED.,{no},{no},{no})\
         B_SPLINE_SURFACE_WITH_KNOTS(({u},{u}),({v},{v}),(0.,1.),(0.,1.),.UNSPECIFIED.)\
         GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE({weights})\
         REPRESENTATION_ITEM('')SURFACE())"
    ));
    Written {
        surface,
        is_outward: normal.dot(face.normal(last)) > 0.0,
        chart: Some(Chart::Bezier(Box::new(Bezier {
            scaled,
            net,
            parameters,
        }))),
    }
}
