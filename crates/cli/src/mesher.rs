//! From the input to a mesh, as the options say, with the time it took.

use std::time::Instant;

use csg::{LengthUnit, Mesh, MeshCheck, Mesher, Program, Report};

use crate::failure::Failure;
use crate::input::Subject;
use crate::progress::Progress;

/// How to mesh a solid.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct MesherOptions {
    /// Uniform cells, so many along the longest side of the solid's bounds
    /// [default: 128; with a tolerance or a smallest feature, cells as large as
    /// the solid is simple]
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(csg::MAX_CELLS)))]
    pub(crate) cells: Option<u32>,
    /// The largest distance between mesh and solid, in the model's unit: as many
    /// triangles as that takes
    #[arg(long, value_name = "DISTANCE", conflicts_with = "draft")]
    pub(crate) tolerance: Option<f64>,
    /// With a tolerance, the largest angle in degrees that a surface may turn
    /// along an edge of the mesh
    #[arg(long, value_name = "DEGREES", requires = "tolerance")]
    pub(crate) angle: Option<f64>,
    /// Look for features down to this size, in the model's unit [default: the
    /// tolerance]
    #[arg(long, value_name = "LENGTH", conflicts_with_all = ["cells", "draft"])]
    pub(crate) smallest_feature: Option<f64>,
    /// Mesh with plain surface nets: bevelled edges, perhaps not manifold
    #[arg(long)]
    pub(crate) draft: bool,
    /// The unit of the model's lengths
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    pub(crate) unit: Unit,
}

/// Units by their symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Unit {
    /// Micrometres
    Um,
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
    /// Feet
    Ft,
}

impl Unit {
    fn length_unit(self) -> LengthUnit {
        match self {
            Self::Um => LengthUnit::Micrometre,
            Self::Mm => LengthUnit::Millimetre,
            Self::Cm => LengthUnit::Centimetre,
            Self::M => LengthUnit::Metre,
            Self::In => LengthUnit::Inch,
            Self::Ft => LengthUnit::Foot,
        }
    }
}

/// A mesh, how it came about and what state it is in.
pub(crate) struct Product {
    pub(crate) mesh: Mesh,
    /// Of the mesher; `None` for a mesh that was read from a file.
    pub(crate) report: Option<Report>,
    pub(crate) check: MeshCheck,
    /// Seconds of each stage so far.
    pub(crate) seconds: Vec<(&'static str, f64)>,
}

impl Product {
    /// Runs `work` as a stage, and notes its time.
    pub(crate) fn stage<T>(&mut self, name: &'static str, work: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let result = work(self);
        self.seconds.push((name, start.elapsed().as_secs_f64()));
        result
    }
}

/// Reads the subject and meshes it if it is a solid.
pub(crate) fn produce(
    subject: impl FnOnce() -> Result<Subject, Failure>,
    options: &MesherOptions,
    progress: &Progress,
) -> Result<Product, Failure> {
    let start = Instant::now();
    progress.stage("reading");
    let subject = subject()?;
    let mut seconds = vec![("read", start.elapsed().as_secs_f64())];
    let start = Instant::now();
    match subject {
        Subject::Solid(solid) => {
            let program = Program::lower(&solid)?;
            seconds.push(("lower", start.elapsed().as_secs_f64()));
            progress.stage("meshing");
            let mut mesher = Mesher::new()
                .normals()
                .unit(options.unit.length_unit())
                .progress(progress.callback());
            if let Some(cells) = options.cells {
                mesher = mesher.cells(cells);
            }
            if let Some(size) = options.smallest_feature {
                mesher = mesher.smallest_feature(size);
            }
            if let Some(tolerance) = options.tolerance {
                mesher = mesher.tolerance(tolerance);
            }
            if let Some(angle) = options.angle {
                mesher = mesher.angle(angle.to_radians());
            }
            if options.draft {
                mesher = mesher.draft();
            }
            let meshed = mesher.mesh(&program)?;
            seconds.extend(&meshed.report.stages);
            Ok(Product {
                check: meshed.report.check.clone(),
                mesh: meshed.mesh,
                report: Some(meshed.report),
                seconds,
            })
        }
        Subject::Mesh(mesh) => {
            let check = mesh.check();
            seconds.push(("check", start.elapsed().as_secs_f64()));
            Ok(Product {
                mesh,
                report: None,
                check,
                seconds,
            })
        }
    }
}
