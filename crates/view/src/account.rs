//! What stands beside the picture: measures, and what the mesher reports.

use csg::Report;
use csg::brep::Bounded;
use glam::DVec3;
use serde::Serialize;

use crate::pick::{Row, number};
use crate::shown::Shown;

/// Measures of a model, and the mesher's report, for people.
#[derive(Clone, Debug, Serialize)]
pub struct Account {
    /// Of which [`Shown::revision`].
    pub revision: u64,
    /// The volume in the model's unit, cubed.
    pub volume: f64,
    /// The bound on its error, if one is known: that of a mesh from a file is not.
    pub volume_error: Option<f64>,
    /// How many metres the model's unit is.
    pub metres: f64,
    /// Volume, area, centroid and so on.
    pub measures: Vec<Row>,
    /// How the mesh came about.
    pub report: Vec<Row>,
}

impl Account {
    pub(crate) fn of(shown: &Shown) -> Self {
        let unit = shown.unit.symbol();
        let (square, cube) = (format!("{unit}²"), format!("{unit}³"));
        let mut measures = Vec::new();
        let volume = match (shown.measure(), &shown.brep) {
            (Some(exact), Some(brep)) => {
                measures.push(Row::bounded("volume", exact.volume, &cube));
                measures.push(Row::bounded("area", exact.area, &square));
                if let Some([x, y, z]) = exact.centroid {
                    for (label, value) in [("centroid x", x), ("centroid y", y), ("centroid z", z)]
                    {
                        measures.push(Row::bounded(label, value, unit));
                    }
                }
                if let Some(bounds) = brep.bounds() {
                    extent(bounds.min, bounds.max, unit, &mut measures);
                }
                let counts = [
                    ("bodies", brep.bodies().len()),
                    ("genus", brep.shells().map(|shell| shell.genus()).sum()),
                    ("faces", brep.faces().len()),
                    ("edges", brep.edges().len()),
                    ("vertices", brep.vertices().len()),
                ];
                measures.extend(counts.map(|(label, count)| Row::number(label, count as f64, "")));
                (exact.volume.value, Some(exact.volume.error))
            }
            _ => {
                let of_mesh = shown.mesh.measure();
                measures.push(Row::number("volume of the mesh", of_mesh.volume, &cube));
                measures.push(Row::number("area of the mesh", of_mesh.area, &square));
                if let Some((min, max)) = shown.mesh.bounds() {
                    extent(min, max, unit, &mut measures);
                }
                (of_mesh.volume, None)
            }
        };
        let mut report = vec![Row::number(
            "triangles",
            shown.mesh.triangles.len() as f64,
            "",
        )];
        if let Some(found) = &shown.report {
            told(found, unit, &mut report);
        }
        if let Some(moved) = shown.brep.as_ref().and_then(csg::Brep::moved) {
            let distance = number(moved.distance);
            let text = format!("surfaces of the exact boundary by at most {distance} {unit}");
            report.push(Row::text("moved", text));
        }
        Self {
            revision: shown.revision,
            volume: volume.0,
            volume_error: volume.1,
            metres: shown.unit.in_metres(),
            measures,
            report,
        }
    }
}

fn extent(min: DVec3, max: DVec3, unit: &str, rows: &mut Vec<Row>) {
    let [x, y, z] = (max - min).to_array().map(number);
    rows.push(Row::text("size", format!("{x} × {y} × {z} {unit}")));
    // What is rounding beside the size is 0.
    let least = 1e-14 * (max - min).max_element();
    let told = |p: DVec3| p.map(|x| if x.abs() <= least { 0.0 } else { x });
    rows.push(Row::point("from", told(min)));
    rows.push(Row::point("to", told(max)));
}

/// The mesher's report.
fn told(report: &Report, unit: &str, rows: &mut Vec<Row>) {
    rows.push(Row::text("method", report.method));
    if let Some(deviation) = report.deviation.filter(|deviation| deviation.is_finite()) {
        let state = if report.is_proven() {
            "proven"
        } else if report.moved.is_some() {
            "from the solid whose surfaces are moved so"
        } else {
            "where the mesh has the solid's topology"
        };
        let text = format!("at most {deviation:.3e} {unit} ({state})");
        rows.push(Row {
            value: Some(deviation),
            ..Row::text("deviation", text)
        });
    }
    rows.push(Row::text("state", report.check.to_string()));
    if let Some(moved) = report.moved {
        let distance = number(moved.distance);
        let text = format!(
            "surfaces by at most {distance} {unit}, as near {}",
            moved.place
        );
        rows.push(Row::text("moved", text));
    }
    for undecided in &report.undecided {
        rows.push(Row::text("undecided", undecided.to_string()));
    }
    if report.difference > 0.0 {
        let percent = Bounded {
            value: 100.0 * report.difference,
            error: 0.01,
        };
        rows.push(Row::text(
            "difference",
            format!("about {percent} % of the solid"),
        ));
    }
    for reached in &report.limits_reached {
        rows.push(Row::text("limit", reached.to_string()));
    }
    for fallback in &report.fallbacks {
        rows.push(Row::text("settled for", fallback.to_string()));
    }
    let seconds: f64 = report.stages.iter().map(|(_, seconds)| seconds).sum();
    rows.push(Row::text(
        "meshing took",
        format!("{:.1} ms", 1e3 * seconds),
    ));
}
