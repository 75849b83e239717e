//! Functions that make profiles: ready-made ones, polygons, gears and text.

use csg::{FillRule, Gear, Profile};
use pyo3::prelude::*;
use text::{Font, HorizontalAlign, Text, VerticalAlign};

use crate::arguments::word;
use crate::arrays;
use crate::errors::{call, invalid};
use crate::files::warn;
use crate::profile::{PyProfile, checked_profile};
use crate::waiting::wait_out;

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(empty_profile, module)?)?;
    module.add_function(wrap_pyfunction!(circle, module)?)?;
    module.add_function(wrap_pyfunction!(ellipse, module)?)?;
    module.add_function(wrap_pyfunction!(rectangle, module)?)?;
    module.add_function(wrap_pyfunction!(rectangle_between, module)?)?;
    module.add_function(wrap_pyfunction!(rounded_rectangle, module)?)?;
    module.add_function(wrap_pyfunction!(regular_polygon, module)?)?;
    module.add_function(wrap_pyfunction!(slot_profile, module)?)?;
    module.add_function(wrap_pyfunction!(polygon, module)?)?;
    module.add_function(wrap_pyfunction!(polygons, module)?)?;
    module.add_function(wrap_pyfunction!(hull_profile, module)?)?;
    module.add_function(wrap_pyfunction!(gear, module)?)?;
    module.add_function(wrap_pyfunction!(knurled, module)?)?;
    module.add_function(wrap_pyfunction!(set_text, module)?)
}

/// The profile without any point.
#[pyfunction]
fn empty_profile() -> PyProfile {
    PyProfile(Profile::empty())
}

/// A disc around the origin.
///
/// >>> import stereotomy as st
/// >>> st.circle(0)
/// Traceback (most recent call last):
/// ValueError: circle(radius=0.0): a radius is 0: it must be positive and finite
#[pyfunction]
fn circle(radius: f64) -> PyResult<PyProfile> {
    checked_profile(Profile::circle(radius), call!("circle", radius))
}

/// An ellipse around the origin with semi-axes along x and y.
#[pyfunction]
fn ellipse(radii: [f64; 2]) -> PyResult<PyProfile> {
    checked_profile(Profile::ellipse(radii), call!("ellipse", radii))
}

/// A rectangle of these side lengths around the origin.
///
/// >>> import stereotomy as st
/// >>> st.rectangle([2, 3]).area()
/// 6.0
#[pyfunction]
fn rectangle(sides: [f64; 2]) -> PyResult<PyProfile> {
    checked_profile(Profile::rectangle(sides), call!("rectangle", sides))
}

/// The rectangle from its least to its greatest corner.
///
/// >>> import stereotomy as st
/// >>> st.rectangle_between([0, 0], [2, 3]).area()
/// 6.0
#[pyfunction]
fn rectangle_between(min: [f64; 2], max: [f64; 2]) -> PyResult<PyProfile> {
    checked_profile(
        Profile::rectangle_between(min, max),
        call!("rectangle_between", min, max),
    )
}

/// A rectangle around the origin with its corners rounded, at most by half the shorter side.
///
/// >>> import math, stereotomy as st
/// >>> abs(st.rounded_rectangle([4, 3], radius=1).area(1e-9) - (8 + math.pi)) < 1e-8
/// True
#[pyfunction]
fn rounded_rectangle(sides: [f64; 2], radius: f64) -> PyResult<PyProfile> {
    checked_profile(
        Profile::rounded_rectangle(sides, radius),
        call!("rounded_rectangle", sides, radius),
    )
}

/// A regular polygon with its corners on a circle, the first on +x.
///
/// >>> import stereotomy as st
/// >>> round(st.regular_polygon(4, circumradius=1).area(), 9)
/// 2.0
#[pyfunction]
fn regular_polygon(corners: usize, circumradius: f64) -> PyResult<PyProfile> {
    checked_profile(
        Profile::regular_polygon(corners, circumradius),
        call!("regular_polygon", corners, circumradius),
    )
}

/// All points within `radius` of a stretch of the x axis of this length, centred. (The hole
/// is `slot`.)
#[pyfunction]
fn slot_profile(length: f64, radius: f64) -> PyResult<PyProfile> {
    checked_profile(
        Profile::slot(length, radius),
        call!("slot_profile", length, radius),
    )
}

/// What a closed polygon encloses, an array of corners of shape (n, 2); it may cross itself
/// (even-odd rule).
///
/// >>> import stereotomy as st
/// >>> st.polygon([[0, 0], [2, 0], [0, 1]]).area()
/// 1.0
#[pyfunction]
fn polygon(corners: &Bound<'_, PyAny>) -> PyResult<PyProfile> {
    let corners: Vec<[f64; 2]> = arrays::rows("corners", corners)?;
    checked_profile(
        Profile::polygon(corners.iter().copied()),
        call!("polygon", corners),
    )
}

/// What several closed polygons enclose by a rule, "even-odd" or "non-zero"; they may cross.
///
/// >>> import stereotomy as st
/// >>> outer, inner = [[0, 0], [3, 0], [3, 3], [0, 3]], [[1, 1], [2, 1], [2, 2], [1, 2]]
/// >>> st.polygons([outer, inner]).area(), st.polygons([outer, inner], rule="non-zero").area()
/// (8.0, 9.0)
#[pyfunction]
#[pyo3(signature = (contours, *, rule="even-odd"))]
fn polygons(contours: &Bound<'_, PyAny>, rule: &str) -> PyResult<PyProfile> {
    let known = [
        ("even-odd", FillRule::EvenOdd),
        ("non-zero", FillRule::NonZero),
    ];
    let rule = word("rule", rule, &known)?;
    let mut all: Vec<Vec<[f64; 2]>> = Vec::new();
    for (index, contour) in contours.try_iter()?.enumerate() {
        let name = format!("contours[{index}]");
        all.push(arrays::rows(&name, &contour?)?);
    }
    let made = all.iter().map(|contour| contour.iter().copied());
    checked_profile(Profile::polygons_of(made, rule), call!("polygons", all))
}

/// The convex hull of points, an array of shape (n, 2).
///
/// >>> import stereotomy as st
/// >>> st.hull_profile([[0, 0], [2, 0], [1, 0.1], [0, 1]]).area()
/// 1.0
#[pyfunction]
fn hull_profile(points: &Bound<'_, PyAny>) -> PyResult<PyProfile> {
    let points: Vec<[f64; 2]> = arrays::rows("points", points)?;
    checked_profile(
        Profile::hull_of(points.iter().copied()),
        call!("hull_profile", points),
    )
}

/// The outline of a spur gear with involute flanks: `module` is the pitch circle's diameter
/// over the number of teeth; the pressure angle is in degrees.
///
/// >>> import stereotomy as st
/// >>> wheel = st.gear(module=2, teeth=12).extrude(5)
/// >>> wheel.contains([13.9, 0, 1]), wheel.contains([14.1, 0, 1])
/// (True, False)
#[pyfunction]
#[pyo3(signature = (module, teeth, *, pressure_angle=20.0, chords=6))]
fn gear(module: f64, teeth: usize, pressure_angle: f64, chords: usize) -> PyResult<PyProfile> {
    let gear = Gear {
        module,
        teeth,
        pressure_degrees: pressure_angle,
        chords,
    };
    checked_profile(
        gear.profile(),
        call!("gear", module, teeth, pressure_angle, chords),
    )
}

/// A circle with notches of 90° side by side, the tips on the circle.
#[pyfunction]
fn knurled(radius: f64, notches: usize) -> PyResult<PyProfile> {
    checked_profile(
        Profile::knurled(radius, notches),
        call!("knurled", radius, notches),
    )
}

/// A line of text as a profile: `size` is about the height of capitals. `font` is the name of
/// an installed font ("Liberation Sans:style=Bold"), `font_file` a file of one.
/// `horizontal` is "left", "center" or "right", `vertical` "baseline", "bottom", "center" or
/// "top"; `direction` "ltr", "rtl", "ttb" or "btt"; `language` and `script` are tags such as
/// "en" and "Latn". Curves of TrueType fonts stay such; those of others become chords within a
/// thousandth of the size. A warning names characters that the font has no glyph for.
///
/// >>> import stereotomy as st
/// >>> sign = st.text("st", size=10, horizontal="center").extrude(2)
/// >>> len(st.text("i").contours())
/// 2
#[pyfunction(name = "text")]
#[pyo3(signature = (text, size=10.0, *, font="Liberation Sans", font_file=None, spacing=1.0, horizontal="left", vertical="baseline", direction=None, language="en", script=None))]
#[allow(clippy::too_many_arguments, reason = "Python's keywords")]
fn set_text(
    py: Python<'_>,
    text: String,
    size: f64,
    font: &str,
    font_file: Option<std::path::PathBuf>,
    spacing: f64,
    horizontal: &str,
    vertical: &str,
    direction: Option<String>,
    language: &str,
    script: Option<String>,
) -> PyResult<PyProfile> {
    let across = [
        ("left", HorizontalAlign::Left),
        ("center", HorizontalAlign::Center),
        ("right", HorizontalAlign::Right),
    ];
    let up = [
        ("baseline", VerticalAlign::Baseline),
        ("bottom", VerticalAlign::Bottom),
        ("center", VerticalAlign::Center),
        ("top", VerticalAlign::Top),
    ];
    let call = call!("text", text, size);
    let mut line = Text::new(text.clone())
        .size(size)
        .spacing(spacing)
        .horizontal(word("horizontal", horizontal, &across)?)
        .vertical(word("vertical", vertical, &up)?)
        .language(language);
    if let Some(direction) = direction {
        line = line.direction(direction);
    }
    if let Some(script) = script {
        line = line.script(script);
    }
    let name = font.to_owned();
    // The first look at the installed fonts takes a while.
    let made = wait_out(py, move || {
        let font = match font_file {
            Some(file) => Font::from_file(file),
            None => Font::find(&name),
        };
        let font = font?;
        let missing = line.missing(&font)?;
        let lacking = (!missing.is_empty()).then(|| font.lacking(&missing));
        Ok((line.profile(&font)?, lacking))
    })?;
    let made = made.map_err(|error: text::TextError| invalid(format!("{}: {error}", call())))?;
    let (profile, lacking) = made;
    if let Some(lacking) = lacking {
        warn(py, &lacking)?;
    }
    checked_profile(profile, call)
}
