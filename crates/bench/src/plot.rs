//! Time against measured deviation: a panel for each scene, a line for each
//! mesher.

use std::error::Error;
use std::path::Path;

use plotters::prelude::*;

use crate::error::Figure;

const MESHERS: [(&str, RGBColor); 5] = [
    ("ours", RGBColor(200, 30, 30)),
    ("ours uniform", RGBColor(240, 150, 90)),
    ("fidget", RGBColor(40, 90, 200)),
    ("fast-surface-nets", RGBColor(40, 150, 70)),
    ("manifold3d", RGBColor(60, 60, 60)),
];
/// Deviations below this are drawn here: the mesh is exact up to rounding.
const EXACT: f64 = 1e-8;

/// Draws an SVG.
pub fn draw(path: &Path, figures: &[Figure]) -> Result<(), Box<dyn Error>> {
    let mut scenes: Vec<&str> = Vec::new();
    for figure in figures {
        if !scenes.contains(&figure.scene.as_str()) {
            scenes.push(&figure.scene);
        }
    }
    let rows = scenes.len().div_ceil(2).max(1);
    let root = SVGBackend::new(path, (1000, 380 * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (panel, scene) in root.split_evenly((rows, 2)).iter().zip(&scenes) {
        let mut chart = ChartBuilder::on(panel)
            .caption(scene, ("sans-serif", 18))
            .margin(8)
            .x_label_area_size(36)
            .y_label_area_size(56)
            .build_cartesian_2d((EXACT..0.2).log_scale(), (1e-5..20.0).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc("measured two-sided deviation")
            .y_desc("seconds, one thread")
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        for (mesher, color) in MESHERS {
            let points: Vec<(f64, f64)> = figures
                .iter()
                .filter(|f| f.scene == *scene && f.mesher == mesher)
                .filter(|f| f.deviation.is_finite())
                .map(|f| (f.deviation.max(EXACT), f.seconds))
                .collect();
            if points.is_empty() {
                continue;
            }
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)).point_size(3))?
                .label(mesher)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color));
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .position(SeriesLabelPosition::LowerLeft)
            .draw()?;
    }
    root.present()?;
    Ok(())
}
