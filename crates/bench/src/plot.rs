//! Time against error, of distance and of volume: a panel for each scene, a line
//! for each mesher.

use std::error::Error;
use std::fs;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use raster::Image;

use crate::figure::Figure;

const MESHERS: [(&str, RGBColor); 5] = [
    ("ours", RGBColor(200, 30, 30)),
    ("ours uniform", RGBColor(240, 150, 90)),
    ("fidget", RGBColor(40, 90, 200)),
    ("fast-surface-nets", RGBColor(40, 150, 70)),
    ("manifold3d", RGBColor(60, 60, 60)),
];
/// A kind of error, a picture of its own.
struct Measure {
    /// What it adds to the name of the file.
    suffix: &'static str,
    description: &'static str,
    of: fn(&Figure) -> f64,
    /// What is below this is drawn here: the mesh is exact up to rounding.
    exact: f64,
}

const MEASURES: [Measure; 2] = [
    Measure {
        suffix: "",
        description: "measured two-sided deviation",
        of: |figure| figure.deviation,
        exact: 1e-8,
    },
    Measure {
        suffix: "-volume",
        description: "relative error of the volume",
        of: |figure| figure.volume_error,
        exact: 1e-9,
    },
];

/// Pixels of the PNG for each of the SVG, along each side.
const PNG_SCALE: u32 = 2;
/// Samples for each pixel of the PNG, along each side.
const SAMPLES: u32 = 2;

/// Draws an SVG, and a PNG beside it; and both again for volumes, with `-volume`
/// in their names.
pub fn draw(path: &Path, figures: &[Figure]) -> Result<(), Box<dyn Error>> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    for measure in &MEASURES {
        let path = path.with_file_name(format!("{stem}{}.svg", measure.suffix));
        draw_one(&path, figures, measure)?;
    }
    Ok(())
}

fn draw_one(path: &Path, figures: &[Figure], measure: &Measure) -> Result<(), Box<dyn Error>> {
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font("sans-serif", FontStyle::Normal, font).map_err(|_| "a font without outlines")?;
    let mut scenes: Vec<&str> = Vec::new();
    for figure in figures {
        if !scenes.contains(&figure.scene.as_str()) {
            scenes.push(&figure.scene);
        }
    }
    let size = (1000, 380 * scenes.len().div_ceil(2).max(1) as u32);
    draw_on(
        &SVGBackend::new(path, size).into_drawing_area(),
        &scenes,
        figures,
        measure,
        1,
    )?;
    let scale = PNG_SCALE * SAMPLES;
    let (width, height) = (scale * size.0, scale * size.1);
    let mut samples = vec![0; 3 * width as usize * height as usize];
    draw_on(
        &BitMapBackend::with_buffer(&mut samples, (width, height)).into_drawing_area(),
        &scenes,
        figures,
        measure,
        scale,
    )?;
    let (pixels, _) = samples.as_chunks();
    let image = Image {
        width,
        height,
        pixels: pixels.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
    };
    fs::write(path.with_extension("png"), image.shrink(SAMPLES).to_png()?)?;
    Ok(())
}

/// Draws all panels, lengths and letters so many times as large.
fn draw_on<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    scenes: &[&str],
    figures: &[Figure],
    measure: &Measure,
    scale: u32,
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    let letters = |size: u32| ("sans-serif", scale * size).into_font();
    root.fill(&WHITE)?;
    let rows = scenes.len().div_ceil(2).max(1);
    for (panel, scene) in root.split_evenly((rows, 2)).iter().zip(scenes) {
        let mut chart = ChartBuilder::on(panel)
            .caption(scene, letters(18))
            .margin(8 * scale)
            .x_label_area_size(36 * scale)
            .y_label_area_size(56 * scale)
            .build_cartesian_2d((measure.exact..0.2).log_scale(), (1e-5..20.0).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .axis_style(BLACK.stroke_width(scale))
            .bold_line_style(BLACK.mix(0.2).stroke_width(scale))
            .label_style(letters(12))
            .x_desc(measure.description)
            .y_desc("seconds, one thread")
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        for (mesher, color) in MESHERS {
            let points: Vec<(f64, f64)> = figures
                .iter()
                .filter(|f| f.scene == *scene && f.mesher == mesher)
                .map(|f| ((measure.of)(f), f.seconds))
                .filter(|(error, _)| error.is_finite())
                .map(|(error, seconds)| (error.max(measure.exact), seconds))
                .collect();
            if points.is_empty() {
                continue;
            }
            let line = LineSeries::new(points, color.stroke_width(2 * scale));
            let length = 16 * scale as i32;
            chart
                .draw_series(line.point_size(3 * scale))?
                .label(mesher)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + length, y)], color.stroke_width(scale))
                });
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3).stroke_width(scale))
            .label_font(letters(12))
            .legend_area_size(30 * scale)
            .margin(10 * scale)
            .position(SeriesLabelPosition::LowerLeft)
            .draw()?;
    }
    root.present()?;
    Ok(())
}
