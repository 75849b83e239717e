//! What is shown of a model, made in stages: at once coarse, then fine with its exact boundary.

use std::sync::OnceLock;

use csg::brep::SolidMeasure;
use csg::{
    BoundaryOptions, Brep, CancelToken, Error, LengthUnit, Limits, Mesh, Mesher, Program, Report,
    Solid,
};

use crate::account::Account;
use crate::distance;
use crate::packing;
use crate::pick::{Pick, Row};
use crate::source::{Loaded, Problem, Subject};

/// How a model is to be meshed.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The mesher; normals, limits and the unit are added.
    pub mesher: Mesher,
    /// Whether the mesher was told how fine to be; if not, the tolerance is
    /// [`Settings::TOLERANCE`].
    pub is_sized: bool,
    /// The unit of the model's lengths.
    pub unit: LengthUnit,
    /// How much meshes and boundaries may cost.
    pub limits: Limits,
}

impl Settings {
    /// Unless said otherwise, the tolerance of the longest side of the solid's bounds: half a
    /// pixel where that side fills a screen.
    pub const TOLERANCE: f64 = 5e-4;
    /// Cells along the longest side of what is shown at once.
    const COARSE: u32 = 48;
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mesher: Mesher::new(),
            is_sized: false,
            unit: LengthUnit::default(),
            limits: Limits::new(),
        }
    }
}

/// A model as it is shown. It does not change: a finer or another one takes its place.
#[derive(Debug)]
pub struct Shown {
    /// Counts what was shown before.
    pub revision: u64,
    /// What the model is called.
    pub name: String,
    /// Whether a finer one is on its way.
    pub is_coarse: bool,
    pub(crate) unit: LengthUnit,
    pub(crate) solid: Option<Solid>,
    pub(crate) program: Option<Program>,
    pub(crate) mesh: Mesh,
    pub(crate) report: Option<Report>,
    pub(crate) brep: Option<Brep>,
    /// What the reader had to say, and why there is no exact boundary.
    pub(crate) warnings: Vec<String>,
    measure: OnceLock<Option<SolidMeasure>>,
}

impl Shown {
    fn new(name: &str, unit: LengthUnit, mesh: Mesh) -> Self {
        Self {
            revision: 0,
            name: name.to_owned(),
            is_coarse: false,
            unit,
            solid: None,
            program: None,
            mesh,
            report: None,
            brep: None,
            warnings: Vec::new(),
            measure: OnceLock::new(),
        }
    }

    /// Measures of the exact boundary, if there is one; they take some time when they are
    /// asked for first.
    pub(crate) fn measure(&self) -> Option<&SolidMeasure> {
        let measured = self
            .measure
            .get_or_init(|| self.brep.as_ref().map(Brep::measure));
        measured.as_ref()
    }

    /// All that a page draws, as one block of bytes (`packing.rs` says which).
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        packing::pack(self)
    }

    /// Volume, area and the rest, and what the mesher reports.
    #[must_use]
    pub fn account(&self) -> Account {
        Account::of(self)
    }

    /// What there is to say of a face, an edge or a vertex; `None` if there is no such one,
    /// or no exact boundary.
    #[must_use]
    pub fn describe(&self, pick: Pick) -> Option<Vec<Row>> {
        let picked = pick.of(self.brep.as_ref()?)?;
        Some(picked.describe(self.unit.symbol()))
    }

    /// Distances and angles between two of them; `None` as for [`Self::describe`].
    #[must_use]
    pub fn between(&self, picks: [Pick; 2]) -> Option<Vec<Row>> {
        let brep = self.brep.as_ref()?;
        let [one, other] = picks.map(|pick| pick.of(brep));
        Some(distance::between(&one?, &other?, self.unit.symbol()))
    }
}

/// Makes what is shown of a model, and hands each stage on as soon as it is there: of a solid
/// a coarse one by a few cells, and a fine one with the exact boundary.
///
/// # Errors
/// What is wrong with the model, for people; `None` if the work was cancelled.
pub fn stages(
    name: &str,
    loaded: Loaded,
    settings: &Settings,
    cancel: &CancelToken,
    mut publish: impl FnMut(Shown),
) -> Result<(), Option<Problem>> {
    let problem = |error: Error| match error {
        Error::Cancelled => None,
        error => Some(Problem::new(error.to_string())),
    };
    let Loaded { subject, warnings } = loaded;
    let solid = match subject {
        Subject::Solid(solid) => solid,
        Subject::Mesh(mesh) => {
            let unit = mesh.unit;
            let warnings = warnings.clone();
            publish(Shown {
                warnings,
                ..Shown::new(name, unit, mesh)
            });
            return Ok(());
        }
    };
    let program = Program::lower(&solid).map_err(problem)?;
    let bounds = program.bounds().map_err(problem)?;
    let size = bounds.map_or(0.0, |bounds| bounds.size().max_element());
    let shown = |mesh: Mesh| Shown {
        solid: Some(solid.clone()),
        program: Some(program.clone()),
        warnings: warnings.clone(),
        ..Shown::new(name, settings.unit, mesh)
    };
    let of_ten_degrees = 10f64.to_radians();
    let prepared = |mesher: &Mesher| {
        let mesher = mesher.clone().normals().feature_edges(of_ten_degrees);
        mesher
            .unit(settings.unit)
            .limits(settings.limits)
            .cancel_token(cancel.clone())
    };
    let coarse = prepared(&Mesher::new())
        .cells(Settings::COARSE)
        .check(false);
    // (If it cannot be had, the fine one may be all the same, or say why not.)
    if let Ok(meshed) = coarse.mesh(&program) {
        publish(Shown {
            is_coarse: true,
            ..shown(meshed.mesh)
        });
    }
    let mut mesher = prepared(&settings.mesher);
    if !settings.is_sized && size > 0.0 {
        mesher = mesher.tolerance(Settings::TOLERANCE * size);
    }
    let meshed = mesher.mesh(&program).map_err(problem)?;
    let mut fine = shown(meshed.mesh);
    fine.report = Some(meshed.report);
    let options = BoundaryOptions::new()
        .limits(settings.limits)
        .cancel_token(cancel.clone());
    match program.boundary(&options) {
        Ok(brep) if brep.is_empty() => fine.warnings.push(
            "nothing is left of the model: what is subtracted or intersected takes all of it"
                .to_owned(),
        ),
        Ok(brep) => fine.brep = Some(brep),
        Err(Error::Cancelled) => return Err(None),
        Err(error) => fine.warnings.push(format!("no exact boundary: {error}")),
    }
    publish(fine);
    Ok(())
}
