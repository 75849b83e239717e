//! From the input to a mesh, as the options say, with the time it took.

use std::time::{Duration, Instant};

use csg::{BoundaryOptions, LengthUnit, Limits, Mesh, Mesher, Program, Report};
use glam::DVec3;

use crate::commands::figure::at_most;
use crate::commands::parse::{angle, length, whole};
use crate::failure::{Failure, exit_codes};
use crate::input::{Reader, Subject, Wanted};
use crate::nothing::Nothing;
use crate::progress::Progress;

/// The largest angle in degrees that a surface turns along an edge where nothing else is asked for:
/// a thousandth of the solid makes octahedra of balls that are small beside it.
pub(crate) const ANGLE: f64 = 20.0;

/// How to mesh a solid.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct MesherOptions {
    /// Uniform cells, so many along the longest side of the solid's bounds
    /// [default: 128 for a draft; else none, or cells as large as the solid is
    /// simple]
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = whole::<u32>(1..=u64::from(csg::MAX_CELLS)))]
    pub(crate) cells: Option<u32>,
    /// The largest distance between mesh and solid, in the model's unit: as many
    /// triangles as that takes [default, without cells, their size or a smallest
    /// feature: a thousandth of the solid's longest side, or for a picture a quarter of a pixel where the solid is nearest to
    /// the eye; the boundary of a solid bounded by planes alone is exact]. Chords and flat faces
    /// that a scene has in place of tori and twists take half of it
    #[arg(long, value_name = "DISTANCE", conflicts_with = "draft", value_parser = length,
          allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
    /// The largest angle in degrees, too, that a surface may turn along an edge of a mesh
    /// to a tolerance: 10 makes 36 corners of every circle at least [default: 20, or any with a
    /// tolerance or for a picture]
    #[arg(long, value_name = "DEGREES", conflicts_with = "draft", value_parser = angle,
          allow_negative_numbers = true)]
    pub(crate) angle: Option<f64>,
    /// Look for features down to this size, in the model's unit [default: the
    /// tolerance]
    #[arg(long, value_name = "LENGTH", conflicts_with_all = ["cells", "draft"],
          value_parser = length, allow_negative_numbers = true)]
    pub(crate) smallest_feature: Option<f64>,
    /// Uniform cells with sides of this length, in the model's unit, in place of
    /// their number
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_negative_numbers = true,
          conflicts_with_all = ["cells", "smallest_feature"])]
    pub(crate) cell_size: Option<f64>,
    /// Mesh with plain surface nets: bevelled edges, perhaps not manifold
    #[arg(long)]
    pub(crate) draft: bool,
    #[command(flatten)]
    pub(crate) limits: LimitOptions,
    /// The unit of the model's lengths, into which scenes convert what they import from .3mf, .glb
    /// and .gltf files; these have their own
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    pub(crate) unit: Unit,
}

impl MesherOptions {
    /// Whether any option asks for a mesh, or how fine it is to be.
    pub(crate) fn is_of_mesh(&self) -> bool {
        self.tolerance.is_some()
            || self.angle.is_some()
            || self.limits.limit_triangles.is_some()
            || !self.is_to_tolerance()
    }

    /// The same limits for a solid's boundary.
    pub(crate) fn boundary(&self, progress: &Progress) -> BoundaryOptions {
        BoundaryOptions::new()
            .limits(self.limits.limits())
            .progress(progress.callback())
    }

    /// What an input is read for.
    pub(crate) fn wanted(&self) -> Wanted {
        Wanted {
            within: self.tolerance.map(chords),
            ..Wanted::solid(self.unit)
        }
    }

    /// A mesher as fine as the options say.
    pub(crate) fn mesher(&self) -> Mesher {
        let mut mesher = Mesher::new();
        if let Some(cells) = self.cells {
            mesher = mesher.cells(cells);
        }
        if let Some(size) = self.cell_size {
            mesher = mesher.cell_size(size);
        }
        if let Some(size) = self.smallest_feature {
            mesher = mesher.smallest_feature(size);
        }
        if let Some(tolerance) = self.tolerance {
            mesher = mesher.tolerance(tolerance);
        }
        if let Some(angle) = self.angle {
            mesher = mesher.angle(angle.to_radians());
        }
        if self.draft {
            mesher = mesher.draft();
        }
        mesher
    }

    /// The same for a page that shows the model.
    #[cfg(feature = "view")]
    pub(crate) fn view_settings(&self) -> view::Settings {
        view::Settings {
            mesher: self.mesher(),
            is_sized: self.tolerance.is_some() || !self.is_to_tolerance(),
            unit: self.unit.length_unit(),
            limits: self.limits.limits(),
        }
    }

    /// Whether the mesh is to keep a tolerance, one that was given or the default.
    fn is_to_tolerance(&self) -> bool {
        let is_sized = self.draft
            || self.cells.is_some()
            || self.cell_size.is_some()
            || self.smallest_feature.is_some();
        self.tolerance.is_some() || !is_sized
    }
}

/// How much a mesh may cost.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitOptions {
    /// The most cells that may be looked at
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = whole::<u64>(0..=u64::MAX))]
    pub(crate) limit_cells: Option<u64>,
    /// The most triangles of the mesh
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = whole::<u64>(0..=u64::MAX))]
    pub(crate) limit_triangles: Option<u64>,
    /// The most memory for cells and triangles, in bytes, or with K, M or G: half of the
    /// machine's unless given
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_negative_numbers = true)]
    pub(crate) limit_memory: Option<u64>,
    /// The longest time for meshing, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) limit_time: Option<Duration>,
    /// Where a limit is reached, write what fits it: larger cells, or a larger
    /// tolerance, as the report says
    #[arg(long)]
    pub(crate) partial: bool,
}

impl LimitOptions {
    pub(crate) fn limits(&self) -> Limits {
        let mut limits = Limits::new();
        if let Some(most) = self.limit_cells {
            limits = limits.cells(most);
        }
        if let Some(most) = self.limit_triangles {
            limits = limits.triangles(most);
        }
        if let Some(most) = self.limit_memory {
            limits = limits.memory(most);
        }
        if let Some(most) = self.limit_time {
            limits = limits.time(most);
        }
        if self.partial {
            limits = limits.partial();
        }
        limits
    }
}

/// Bytes, by thousands with K, M or G.
fn bytes(text: &str) -> Result<u64, String> {
    let (digits, unit) = match text.strip_suffix(['K', 'M', 'G']) {
        Some(digits) => (digits, &text[digits.len()..]),
        None => (text, ""),
    };
    let factor = match unit {
        "K" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        _ => 1.0,
    };
    match digits.parse::<f64>() {
        Ok(number) if number >= 0.0 && number * factor < 1e18 => Ok((number * factor) as u64),
        _ => Err("give a number of bytes, such as 500M or 2G".into()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let number = text.trim().parse().ok();
    let time = number.and_then(|number| Duration::try_from_secs_f64(number).ok());
    time.ok_or_else(|| "give a number of seconds, from 0".into())
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
    /// Its symbol.
    pub(crate) fn symbol(self) -> &'static str {
        self.length_unit().symbol()
    }

    /// The unit of lengths that is called so.
    pub(crate) fn of(unit: LengthUnit) -> Self {
        match unit {
            LengthUnit::Micrometre => Self::Um,
            LengthUnit::Millimetre => Self::Mm,
            LengthUnit::Centimetre => Self::Cm,
            LengthUnit::Metre => Self::M,
            LengthUnit::Inch => Self::In,
            LengthUnit::Foot => Self::Ft,
        }
    }

    pub(crate) fn length_unit(self) -> LengthUnit {
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

/// Of a tolerance that is asked for, how much chords and flat faces may take that stand for what there
/// are no surfaces for: the mesh has the rest. Tunes the number of both.
pub(crate) fn chords(tolerance: f64) -> f64 {
    0.5 * tolerance
}

/// What the tolerance of a mesh leaves of one that is asked for, if the solid strays from what it
/// stands for; all of it, with a warning, if it strays by more.
pub(crate) fn tolerance_beside(strays: Option<f64>, tolerance: f64) -> f64 {
    match strays {
        Some(strays) if strays < tolerance => tolerance - strays,
        Some(strays) => {
            let strays = at_most(strays, 3);
            say!(
                "warning: parts of the solid stray by up to {strays} from what they stand for, \
                  more than the tolerance"
            );
            tolerance
        }
        None => tolerance,
    }
}

/// A mesh and how it came about.
pub(crate) struct Product {
    pub(crate) mesh: Mesh,
    /// Of the mesher; `None` for a mesh that was read from a file.
    pub(crate) report: Option<Report>,
    /// What was meshed; `None` for a mesh that was read from a file.
    pub(crate) program: Option<Program>,
    /// The tolerance that the mesh keeps, where that was chosen for it.
    pub(crate) tolerance: Option<f64>,
    /// How far the solid strays from what it stands for, if it does.
    pub(crate) strays: Option<f64>,
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

/// The tolerance that a model within these points needs, if they say.
pub(crate) type Needs<'a> = dyn Fn(&[DVec3]) -> Option<f64> + 'a;

/// Nothing is needed but what the options say.
pub(crate) fn no_needs(_: &[DVec3]) -> Option<f64> {
    None
}

/// Reads the subject and meshes it if it is a solid; `check` says whether
/// the mesher is to check what it made. Where the options leave the tolerance
/// open, it is what `needs` says.
pub(crate) fn produce(
    subject: Reader<'_>,
    options: &MesherOptions,
    check: bool,
    needs: &Needs,
    progress: &Progress,
) -> Result<Product, Failure> {
    if options.angle.is_some() && !options.is_to_tolerance() {
        let context = "an angle without a tolerance";
        let cause = "meshes by cells keep none: give a --tolerance, too, or leave them out";
        return Err(Failure::new(exit_codes::USAGE, context, cause));
    }
    let start = Instant::now();
    progress.stage("reading");
    let subject = subject()?;
    let mut seconds = vec![("read", start.elapsed().as_secs_f64())];
    match subject {
        Subject::Solid(solid, own) => {
            let unit = own.unwrap_or(options.unit);
            let start = Instant::now();
            let program = Program::lower(&solid)?;
            seconds.push(("lower", start.elapsed().as_secs_f64()));
            let mut mesher = options
                .mesher()
                .normals()
                // To a tolerance, a mesh that fails its check is made anew.
                .check(check || options.is_to_tolerance())
                .unit(unit.length_unit())
                .limits(options.limits.limits())
                .progress(progress.callback());
            let strays = solid.strays();
            if let Some(tolerance) = options.tolerance {
                mesher = mesher.tolerance(tolerance_beside(strays, tolerance));
            }
            let mut tolerance = None;
            if options.tolerance.is_none() && options.is_to_tolerance() {
                let start = Instant::now();
                tolerance = within(&program).and_then(|corners| needs(&corners));
                seconds.push(("bounds", start.elapsed().as_secs_f64()));
                if tolerance.is_none() && options.angle.is_none() {
                    mesher = mesher.angle(ANGLE.to_radians());
                }
            }
            let mesh = |tolerance: Option<f64>| {
                progress.stage("meshing");
                match tolerance {
                    Some(tolerance) => mesher.clone().tolerance(tolerance).mesh(&program),
                    None => mesher.mesh(&program),
                }
            };
            // The box is larger than the solid, which may need less.
            tolerance = tolerance.map(|tolerance| 0.7 * tolerance);
            let mut meshed = mesh(tolerance)?;
            seconds.extend(&meshed.report.stages);
            let needed = tolerance.and_then(|_| needs(&meshed.mesh.positions));
            let is_exact = meshed.report.method == "polyhedral";
            if needed.is_some() && needed < tolerance && !is_exact {
                tolerance = needed;
                meshed = mesh(tolerance)?;
                seconds.extend(&meshed.report.stages);
            }
            if meshed.mesh.triangles.is_empty() {
                say!("{}", Nothing::of(&solid));
            }
            Ok(Product {
                mesh: meshed.mesh,
                report: Some(meshed.report),
                program: Some(program),
                tolerance,
                strays,
                seconds,
            })
        }
        Subject::Mesh(file) => {
            if check && let Some([one, other]) = file.meeting_objects() {
                say!(
                    "warning: objects {} and {} of {} touch, overlap or lie in each other: volume and \
                     area count twice what both have; --repair makes one solid of them",
                    one + 1,
                    other + 1,
                    file.objects.len()
                );
            }
            Ok(Product {
                mesh: file.or_in(options.unit.length_unit()).mesh,
                report: None,
                program: None,
                tolerance: None,
                strays: None,
                seconds,
            })
        }
    }
}

/// The corners of a box around a solid, if it is bounded and there at all.
fn within(program: &Program) -> Option<Vec<DVec3>> {
    let bounds = program.bounds().ok()??;
    let corner = |k: usize| {
        let pick = |axis: usize| [bounds.min, bounds.max][k >> axis & 1][axis];
        DVec3::new(pick(0), pick(1), pick(2))
    };
    Some((0..8).map(corner).collect())
}
