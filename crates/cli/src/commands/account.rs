//! What `mesh` and `measure` say of a mesh, as JSON and for people.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt;

use csg::{MeshMeasure, Moved, Report};
use glam::DVec3;
use serde::Serialize;

use super::figure::{Figure, at_most, coordinate, place, short};
use crate::mesher::Product;

/// Measures, checks and times of a mesh. In the model's unit and its powers.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Account {
    // (The mesh's own, and where the solid's is: of area and centroid nobody knows.)
    volume: Figure,
    area: Figure,
    centroid: Option<[Figure; 3]>,
    triangles: usize,
    vertices: usize,
    components: usize,
    /// Summed over the components; null unless the mesh is manifold.
    genus: Option<i64>,
    manifold: bool,
    closed: bool,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    bounds: Option<Bounds>,
    /// How far parts of the solid stray at most from what they stand for: chords and flat faces, from
    /// what there are no surfaces for. Null if all is what was asked for, and for files with meshes.
    strays: Option<f64>,
    unit: &'static str,
    /// Per stage, and the total.
    seconds: BTreeMap<&'static str, f64>,
    report: Option<ReportAccount>,
}

/// A box.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

impl Bounds {
    pub(crate) fn new(min: DVec3, max: DVec3) -> Self {
        Self {
            min: min.to_array(),
            max: max.to_array(),
        }
    }
}

/// How far parts of a solid stray from what they stand for.
pub(super) fn told(strays: f64, unit: &str) -> String {
    let strays = at_most(strays, 3);
    format!("strays      by at most {strays} {unit}: chords and flat faces, from curved ones")
}

/// Digits of coordinates: boxes are known to about a thousand millionth of their size.
const DIGITS: usize = 10;

impl Bounds {
    /// A point within it, or a corner, as it is told.
    fn told(&self, point: [f64; 3]) -> String {
        place(point, self.size(), DIGITS)
    }

    /// Its least coordinates and its largest, as they are told.
    pub(crate) fn rounded(&self) -> [f64; 6] {
        let [a, b, c] = self.min;
        let [d, e, f] = self.max;
        [a, b, c, d, e, f].map(|x| coordinate(x, self.size(), DIGITS))
    }

    /// The longest side.
    fn size(&self) -> f64 {
        let size = [0, 1, 2].map(|axis| self.max[axis] - self.min[axis]);
        size.into_iter().fold(0.0, f64::max)
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "from        {}", self.told(self.min))?;
        write!(f, "to          {}", self.told(self.max))
    }
}

/// The mesher's report.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ReportAccount {
    method: &'static str,
    cell_size: f64,
    cells_visited: u64,
    cells_pruned: u64,
    surface_cells: u64,
    largest_vertex_distance: f64,
    largest_centroid_distance: f64,
    /// Null unless a tolerance was asked for.
    deviation: Option<f64>,
    farthest: Option<[f64; 3]>,
    /// Whether the deviation holds without any condition.
    proven: bool,
    /// Where the exact boundary could not be told, once for each try.
    undecided: Vec<UndecidedAccount>,
    /// Null unless surfaces that nearly coincide or touch were moved.
    moved: Option<MovedAccount>,
    limits_reached: Vec<String>,
    fallbacks: Vec<FallbackAccount>,
    /// Of the length of rays in the solid or in the mesh, what is in one alone.
    difference: f64,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct UndecidedAccount {
    why: &'static str,
    place: [f64; 3],
}

/// Surfaces that were moved.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct MovedAccount {
    merged: usize,
    distance: f64,
    place: [f64; 3],
}

impl From<Moved> for MovedAccount {
    fn from(moved: Moved) -> Self {
        Self {
            merged: moved.merged,
            distance: moved.distance,
            place: moved.place.to_array(),
        }
    }
}

impl fmt::Display for MovedAccount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { merged, .. } = self;
        let distance = at_most(self.distance, 3);
        let [x, y, z] = self.place.map(|x| short(x, 6));
        write!(
            f,
            "moved       surfaces by at most {distance} ({merged} made one with others), as about {x} {y} {z}"
        )
    }
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FallbackAccount {
    kind: String,
    count: usize,
    places: Vec<[f64; 3]>,
}

impl Account {
    /// Checks the mesh, unless the mesher did, and measures it.
    pub(crate) fn of(product: &mut Product) -> Self {
        let check = match &product.report {
            Some(report) => report.check.clone(),
            None => product.stage("check", |product| product.mesh.check()),
        };
        let measure = product.stage("measure", |product| product.mesh.measure());
        let mesh = &product.mesh;
        let mut seconds: BTreeMap<&str, f64> = BTreeMap::new();
        let mut total = 0.0;
        for &(stage, time) in &product.seconds {
            *seconds.entry(stage).or_default() += time;
            total += time;
        }
        seconds.insert("total", total);
        let unbounded = |value: f64| Figure::within(value, None);
        Self {
            volume: Figure::within(measure.volume, volume_error(product, &measure)),
            area: unbounded(measure.area),
            centroid: measure.centroid.map(|c| c.to_array().map(unbounded)),
            triangles: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            components: check.components,
            genus: check.genus(),
            manifold: check.is_manifold(),
            closed: check.is_closed(),
            non_manifold_edges: check.non_manifold_edges,
            non_manifold_vertices: check.non_manifold_vertices,
            bounds: mesh.bounds().map(|(min, max)| Bounds::new(min, max)),
            strays: product.strays,
            unit: mesh.unit.symbol(),
            seconds,
            report: product.report.as_ref().map(ReportAccount::of),
        }
    }
}

/// How far the volume of a mesh may be from that of its solid, if the mesh is proven to deviate
/// by no more than a distance d: what lies in one alone is nowhere farther from the mesh. Of
/// such points there are no more than on both sides of all triangles up to d, and within d of
/// all edges and corners (Steiner). Corners are off by rounding, too, and so is the sum.
fn volume_error(product: &Product, measure: &MeshMeasure) -> Option<f64> {
    /// How far corners are off where they should be, of the farthest coordinate: fewer than 16 roundings
    /// lead to each.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    let report = product
        .report
        .as_ref()
        .filter(|report| report.is_proven())?;
    let mesh = &product.mesh;
    let (low, high) = mesh.bounds()?;
    let farthest = low.abs().max(high.abs()).max_element();
    let distance = report.deviation? + ROUNDING * farthest;
    let (mut areas, mut edges) = (0.0, 0.0);
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        areas += 0.5 * (b - a).cross(c - a).length();
        edges += 0.5 * (a.distance(b) + b.distance(c) + c.distance(a));
    }
    let corners = mesh.positions.len() as f64;
    let tube = edges + 4.0 / 3.0 * distance * corners;
    Some(measure.volume_rounding + 2.0 * distance * areas + PI * distance * distance * tube)
}

impl ReportAccount {
    pub(super) fn of(report: &Report) -> Self {
        Self {
            method: report.method,
            cell_size: report.cell_size,
            cells_visited: report.cells_visited,
            cells_pruned: report.cells_pruned,
            surface_cells: report.surface_cells,
            largest_vertex_distance: report.largest_vertex_distance,
            largest_centroid_distance: report.largest_centroid_distance,
            // JSON knows no infinity.
            deviation: report.deviation.filter(|d| d.is_finite()),
            farthest: report.farthest.map(|p| p.to_array()),
            proven: report.is_proven(),
            undecided: report
                .undecided
                .iter()
                .map(|undecided| UndecidedAccount {
                    why: undecided.why.describe(),
                    place: undecided.place.to_array(),
                })
                .collect(),
            moved: report.moved.map(MovedAccount::from),
            limits_reached: report
                .limits_reached
                .iter()
                .map(ToString::to_string)
                .collect(),
            fallbacks: report
                .fallbacks
                .iter()
                .map(|fallback| FallbackAccount {
                    kind: fallback.kind.to_string(),
                    count: fallback.count,
                    places: fallback.places.iter().map(DVec3::to_array).collect(),
                })
                .collect(),
            difference: report.difference,
        }
    }
}

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (volume, unit) = (short(self.volume.value(), 10), self.unit);
        match self.volume.error() {
            Some(error) => {
                let error = at_most(error, 2);
                writeln!(
                    f,
                    "volume      {volume} {unit}³ (the solid's within {error})"
                )?;
            }
            None => writeln!(f, "volume      {volume} {unit}³")?,
        }
        writeln!(f, "area        {} {unit}²", short(self.area.value(), 10))?;
        if let (Some(centroid), Some(bounds)) = (self.centroid, &self.bounds) {
            let centroid = centroid.map(|figure| figure.value());
            writeln!(f, "centroid    {}", bounds.told(centroid))?;
        }
        if let Some(bounds) = &self.bounds {
            writeln!(f, "{bounds}")?;
        }
        writeln!(f, "triangles   {}", self.triangles)?;
        writeln!(f, "vertices    {}", self.vertices)?;
        writeln!(f, "components  {}", self.components)?;
        if let Some(genus) = self.genus {
            writeln!(f, "genus       {genus}")?;
        }
        let state = match (self.closed, self.manifold) {
            (_, true) => "closed and manifold".to_owned(),
            (true, false) => format!(
                "closed, but not manifold: {} edges, {} vertices",
                self.non_manifold_edges, self.non_manifold_vertices
            ),
            (false, false) => "not closed: the volume means little".to_owned(),
        };
        writeln!(f, "state       {state}")?;
        if let Some(report) = &self.report {
            if let Some(deviation) = report.deviation {
                let state = match (report.proven, &report.moved) {
                    (true, _) => "proven",
                    (false, Some(_)) => "from the solid whose surfaces are moved so",
                    (false, None) => "where the mesh has the solid's topology",
                };
                let deviation = at_most(deviation, 3);
                writeln!(f, "deviation   at most {deviation} ({state})")?;
            }
            if let Some(strays) = self.strays {
                writeln!(f, "{}", told(strays, unit))?;
            }
            if let Some(moved) = &report.moved {
                writeln!(f, "{moved}")?;
            }
            for undecided in &report.undecided {
                let [x, y, z] = undecided.place.map(|x| short(x, 6));
                writeln!(f, "undecided   {}, near {x} {y} {z}", undecided.why)?;
            }
            if report.difference > 0.0 {
                let percent = 100.0 * report.difference;
                writeln!(f, "difference  about {percent:.2} % of the solid")?;
            }
            for reached in &report.limits_reached {
                writeln!(f, "limit       {reached}")?;
            }
            for fallback in &report.fallbacks {
                write!(f, "settled for {} x {}", fallback.count, fallback.kind)?;
                match fallback.places.first() {
                    Some(place) => {
                        let [x, y, z] = place.map(|x| short(x, 6));
                        writeln!(f, ", first at {x} {y} {z}")?;
                    }
                    None => writeln!(f)?,
                }
            }
        }
        if let Some(total) = self.seconds.get("total") {
            writeln!(f, "seconds     {total:.3}")?;
        }
        Ok(())
    }
}
