//! Images of edges on surfaces: curves of the surface's parameters, beside those in space.
//!
//! The standard leaves them to the writer. Where there are none programs that need them lay some through
//! a few points, and take areas and volumes within them: of a cap of an ellipsoid by a circle
//! Open CASCADE has 24 points, between which its image strays by 1e-4 of the solid's size.

use glam::{DVec2, DVec3};

use super::chart::Chart;
use super::curves::{self, Course, CourseShape};
use super::text::{Entities, Id, List, Reals};
use crate::spline::{self, Spline};

/// Of coordinates, by how much rounding alone may lead an image astray, where a surface is as long as
/// it is wide ([`Chart::stretch`]). The second derivative at the end
/// of a span is a sum over points whose weights are (14⁴ - 1) / 15 at most (Trefethen, *Spectral Methods
/// in MATLAB*, 6), and a control point has a twentieth of it: 128 times the rounding of a point, and no
/// more than eight operations make that.
const ROUNDING: f64 = 1024.0 * f64::EPSILON;

/// Writes the curve of an edge with its images on surfaces, as far as some are found that stray by no
/// more than a tolerance, or than rounding: the curve alone if there are none.
pub(super) fn write(
    to: &mut Entities,
    course: &Course,
    surfaces: &[(Id, &Chart)],
    tolerance: f64,
) -> Id {
    let curve = course.write(to);
    let images: Vec<Id> = surfaces
        .iter()
        .filter(|(_, chart)| !is_plain(course, chart))
        .filter_map(|(surface, chart)| {
            let image = image(course, chart, tolerance)?;
            Some(parametric(to, *surface, &image, course.range))
        })
        .collect();
    if images.is_empty() {
        return curve;
    }
    let images = List(&images);
    to.add(format_args!(
        "SURFACE_CURVE('',{curve},{images},.CURVE_3D.)"
    ))
}

/// Whether an image is a line, which others find without error: those of lines, and of circles around
/// an axis.
fn is_plain(course: &Course, chart: &Chart) -> bool {
    match (&course.shape, chart) {
        (CourseShape::Line { .. }, _) => true,
        (CourseShape::Ellipse { axes, .. }, Chart::Turned { .. }) => axes.is_circle,
        _ => false,
    }
}

/// What places on a surface a curve has.
enum Image {
    /// From one to another, evenly.
    Straight([DVec2; 2]),
    Curved(Spline),
}

/// The image of a course, whose parameters go from 0 to 1.
fn image(course: &Course, chart: &Chart, tolerance: f64) -> Option<Image> {
    const SAMPLES: u32 = 16;
    let [from, to] = course.range;
    let at = |u: f64| course.at(from + u * (to - from));
    let coordinate = [0.0, 0.5, 1.0].map(|u| at(u).abs().max_element());
    let size = coordinate.into_iter().fold(0.0, f64::max);
    let tolerance = tolerance.max(ROUNDING * chart.stretch() * size);
    let turns = Turns::new(&at, chart);
    let place = |u: f64| turns.place(chart, u, at(u)).extend(0.0);
    let is_near = |u: f64, image: DVec3| chart.point(image.truncate()).distance(at(u)) <= tolerance;
    let ends = [0.0, 1.0].map(|u| place(u).truncate());
    let is_straight = (1..SAMPLES).all(|k| {
        let u = f64::from(k) / f64::from(SAMPLES);
        is_near(u, ends[0].lerp(ends[1], u).extend(0.0))
    });
    if is_straight {
        return Some(Image::Straight(ends));
    }
    // A spline in space has jumps of the third derivative, and so has its image.
    let knots: &[f64] = match &course.shape {
        CourseShape::Quintic(spline) => &spline.knots,
        _ => &spline::QUARTERS,
    };
    // (None if the chart has a pole on the edge.)
    spline::fit_as_given(place, knots, is_near).map(Image::Curved)
}

/// Of parameters that come again after a period those that go on and on along a curve.
struct Turns {
    /// At even steps along the curve.
    places: Vec<f64>,
    period: Option<f64>,
}

impl Turns {
    fn new(at: &impl Fn(f64) -> DVec3, chart: &Chart) -> Self {
        const STEPS: u32 = 64;
        let mut turns = Self {
            places: Vec::new(),
            period: chart.period(),
        };
        let Some(period) = turns.period else {
            return turns;
        };
        for step in 0..=STEPS {
            let place = chart.place(at(f64::from(step) / f64::from(STEPS))).x;
            let last = turns.places.last();
            let next = last.map_or(place, |&last| near(place, last, period));
            turns.places.push(next);
        }
        // The whole is where the surface's own parameters are.
        let middle = turns.places.iter().sum::<f64>() / f64::from(STEPS + 1);
        let shift = middle.rem_euclid(period) - middle;
        for place in &mut turns.places {
            *place += shift;
        }
        turns
    }

    /// The parameters of a point at a share of the curve.
    fn place(&self, chart: &Chart, share: f64, point: DVec3) -> DVec2 {
        let mut place = chart.place(point);
        if let Some(period) = self.period {
            let nearest = share * (self.places.len() - 1) as f64;
            place.x = near(place.x, self.places[nearest.round() as usize], period);
        }
        place
    }
}

/// A value less as many periods as bring it nearest to another one.
fn near(value: f64, other: f64, period: f64) -> f64 {
    value - period * ((value - other) / period).round()
}

/// Writes an image on a surface.
fn parametric(to: &mut Entities, surface: Id, image: &Image, [from, until]: [f64; 2]) -> Id {
    let mut point = |x: f64, y: f64| {
        let at = Reals(&[x, y]).to_string();
        to.add(format_args!("CARTESIAN_POINT('',{at})"))
    };
    let curve = match image {
        Image::Straight(ends) => {
            let ends = ends.map(|end| point(end.x, end.y));
            let (ends, knots) = (List(&ends), Reals(&[from, until]));
            to.add(format_args!(
                "B_SPLINE_CURVE_WITH_KNOTS('',1,{ends},.UNSPECIFIED.,.F.,.F.,(2,2),{knots},\
                 .UNSPECIFIED.)"
            ))
        }
        Image::Curved(spline) => {
            let points = spline.points.iter().map(|p| point(p.x, p.y));
            let points: Vec<Id> = points.collect();
            let place = |&knot: &f64| {
                if knot == 1.0 {
                    until
                } else {
                    from + knot * (until - from)
                }
            };
            let knots: Vec<f64> = spline.knots.iter().map(place).collect();
            curves::quintic(to, &points, &knots)
        }
    };
    let context = to.share(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()\
         REPRESENTATION_CONTEXT('2D SPACE',''))",
    );
    let image = to.add(format_args!(
        "DEFINITIONAL_REPRESENTATION('',({curve}),{context})"
    ));
    to.add(format_args!("PCURVE('',{surface},{image})"))
}
