//! `sweep`: a table of variants, one row a model, to one table of measures, and files.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use csg::{BoundaryOptions, Mesher, Program};
use io::WriteOptions;
use rayon::prelude::*;

use super::parse::{angle, length};
use crate::failure::{Failure, exit_codes};
use crate::input::Subject;
use crate::mesher::{ANGLE, LimitOptions, Unit};
use crate::output::{self, StepArguments, StreamFormat};
use crate::progress::Progress;
use crate::shard::Shard;

/// Options of `sweep`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The table of variants as comma-separated values: its first row has the names of
    /// variables, and each other row their values for one model
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Where to write the table of measures, as comma-separated values, or `-` for
    /// standard output: a row for each variant, with its number and variables
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Write files of each variant, too, meshes or .step; {row} in the name stands for the
    /// variant's number, and the name of a variable in braces for its value; may be given
    /// more than once
    #[arg(short, long, value_name = "NAME")]
    write: Vec<String>,
    /// Only the i-th of n parts of the table, as 1/4, the rows as in the whole: parts one after
    /// another are the whole, but for the first row of each
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Shard,
    /// The tolerance of meshes [default: as `mesh` has it]
    #[arg(long, value_name = "DISTANCE", value_parser = length, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// The largest angle in degrees that a surface may turn along an edge of meshes [default: as
    /// `mesh` has it]
    #[arg(long, value_name = "DEGREES", value_parser = angle, allow_negative_numbers = true)]
    angle: Option<f64>,
    #[command(flatten)]
    step: StepArguments,
    /// The unit of the models' lengths
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    unit: Unit,
    #[command(flatten)]
    limits: LimitOptions,
}

impl Options {
    /// The folder of the table.
    pub(crate) fn folder(&self) -> &Path {
        self.table.parent().unwrap_or(Path::new(""))
    }
}

/// A variable's name and value.
pub(crate) type Variable = (String, String);

/// Makes the model of a row of variables.
pub(crate) type Model<'a> = dyn Fn(&[Variable]) -> Result<Subject, Failure> + Sync + 'a;

/// What is measured of each model.
const MEASURES: [&str; 15] = [
    "volume",
    "volume_error",
    "area",
    "centroid_x",
    "centroid_y",
    "centroid_z",
    "min_x",
    "min_y",
    "min_z",
    "max_x",
    "max_y",
    "max_z",
    "components",
    "genus",
    "triangles",
];

pub(crate) fn run(
    model: &Model<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    progress.stage("reading");
    let table = Table::read(&options.table)?;
    let names: Vec<&str> = table.names.iter().map(String::as_str).collect();
    for name in &options.write {
        check_name(name, &names)?;
    }
    table.check_files(&options.write)?;
    output::check_folder(&options.output)?;
    let rows = options.shard.rows(table.rows.len());
    progress.stage("sweeping");
    let (done, count) = (AtomicUsize::new(0), rows.len().max(1));
    let tell = progress.callback();
    let made: Vec<Row> = rows
        .into_par_iter()
        .map(|index| {
            let row = Row::of(index + 1, &table.variables(index), model, options);
            tell((1 + done.fetch_add(1, Ordering::Relaxed)) as f64 / count as f64);
            row
        })
        .collect();
    progress.stage("writing");
    let mut out = csv::Writer::from_writer(Vec::new());
    let mut write = |fields: &[String]| {
        out.write_record(fields)
            .map_err(|error| Failure::output(&options.output.display().to_string(), error))
    };
    let head = ["row".to_owned()].into_iter().chain(table.names.clone());
    let head = head.chain(MEASURES.map(str::to_owned));
    let head: Vec<String> = head
        .chain(["files".to_owned(), "error".to_owned()])
        .collect();
    write(&head)?;
    for row in &made {
        write(&row.fields)?;
    }
    let text = out
        .into_inner()
        .map_err(|error| Failure::output("the table", error.to_string()))?;
    output::write_bytes(&options.output, &text)?;
    progress.end();
    let failed = made.iter().filter(|row| row.has_failed).count();
    progress.say(format_args!(
        "{} variants, {failed} of which failed",
        made.len()
    ));
    if failed > 0 {
        let cause = "their rows say why in the column `error`";
        let context = format!("{failed} of {} variants failed", made.len());
        return Err(Failure::new(exit_codes::MODEL, context, cause));
    }
    Ok(())
}

/// The table of variants.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, Failure> {
        let failure = |error: csv::Error| Failure::input(&path.display().to_string(), error);
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(failure)?;
        let names: Vec<String> = reader
            .headers()
            .map_err(failure)?
            .iter()
            .map(str::to_owned)
            .collect();
        let known = ["row", "files", "error"].into_iter().chain(MEASURES);
        let taken: Vec<&str> = known
            .filter(|known| names.iter().any(|name| name == known))
            .collect();
        if let Some(taken) = taken.first() {
            let cause = format!(
                "its column `{taken}` is one of those that are written: give it another name"
            );
            return Err(Failure::input(&path.display().to_string(), cause));
        }
        let rows = reader.records().map(|record| {
            let record = record.map_err(failure)?;
            Ok(record.iter().map(str::to_owned).collect())
        });
        let rows = rows.collect::<Result<_, Failure>>()?;
        Ok(Self { names, rows })
    }

    fn variables(&self, index: usize) -> Vec<Variable> {
        let values = self.rows[index].iter().cloned();
        self.names.iter().cloned().zip(values).collect()
    }

    /// Refuses names of files that are the same for two rows.
    fn check_files(&self, names: &[String]) -> Result<(), Failure> {
        let mut rows = HashMap::new();
        for index in 0..self.rows.len() {
            let variables = self.variables(index);
            for name in names {
                let file = named(name, index + 1, &variables);
                if let Some(other) = rows.insert(file.clone(), index + 1) {
                    let context = format!("rows {other} and {} would have one file", index + 1);
                    let cause = format!("{file}: put {{row}} into its name");
                    return Err(Failure::new(exit_codes::USAGE, context, cause));
                }
            }
        }
        Ok(())
    }
}

/// Refuses names of files that are the same for several rows, or of no known format.
fn check_name(name: &str, variables: &[&str]) -> Result<(), Failure> {
    let usage =
        |cause: String| Failure::new(exit_codes::USAGE, format!("no such name: {name}"), cause);
    let mut rest = name;
    let mut is_varied = false;
    while let Some((_, after)) = rest.split_once('{') {
        let (inside, after) = after.split_once('}').unwrap_or((after, ""));
        if inside != "row" && !variables.contains(&inside) {
            let cause = format!(
                "{{{inside}}} is no variable of the table: it has {}",
                variables.join(", ")
            );
            return Err(usage(cause));
        }
        is_varied = true;
        rest = after;
    }
    if !is_varied {
        return Err(usage(
            "all variants would have one file: put {row} into it".into(),
        ));
    }
    output::check(&[PathBuf::from(name)], None)
}

/// A row of the table of measures.
struct Row {
    fields: Vec<String>,
    has_failed: bool,
}

impl Row {
    fn of(number: usize, variables: &[Variable], model: &Model<'_>, options: &Options) -> Self {
        let mut fields = vec![number.to_string()];
        fields.extend(variables.iter().map(|(_, value)| value.clone()));
        let made = measured(number, variables, model, options);
        let has_failed = made.is_err();
        match made {
            Ok(measures) => {
                fields.extend(measures);
                fields.push(String::new());
            }
            Err(failure) => {
                fields.extend(vec![String::new(); MEASURES.len() + 1]);
                fields.push(one_line(&failure.to_string()));
            }
        }
        Self { fields, has_failed }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What is measured, and which files were written.
fn measured(
    number: usize,
    variables: &[Variable],
    model: &Model<'_>,
    options: &Options,
) -> Result<Vec<String>, Failure> {
    let solid = model(variables)?.solid()?;
    let program = Program::lower(&solid)?;
    let limits = options.limits.limits();
    let files: Vec<PathBuf> = options
        .write
        .iter()
        .map(|name| named(name, number, variables).into())
        .collect();
    let (steps, meshes): (Vec<_>, Vec<_>) = files.iter().partition(|path| io::step::is_step(path));
    let boundary = BoundaryOptions::new().limits(limits);
    let brep = match steps.is_empty() {
        true => program.boundary(&boundary)?,
        false => program.boundary(&boundary.cut_at_seams())?,
    };
    let unit = options.unit.length_unit();
    for path in steps {
        output::write_step(path, &brep, unit, options.step)?;
    }
    let mut triangles = String::new();
    if !meshes.is_empty() {
        let mut mesher = Mesher::new().normals().unit(unit).limits(limits);
        if let Some(tolerance) = options.tolerance {
            mesher = mesher.tolerance(tolerance);
        }
        let angle = options
            .angle
            .or(options.tolerance.is_none().then_some(ANGLE));
        if let Some(angle) = angle {
            mesher = mesher.angle(angle.to_radians());
        }
        let mesh = mesher.mesh(&program)?.mesh;
        for path in meshes {
            let options = WriteOptions::default();
            output::write_mesh(path, &mesh, StreamFormat::default(), &options)?;
        }
        triangles = mesh.triangles.len().to_string();
    }
    let measure = brep.measure();
    let mut numbers = vec![
        measure.volume.value,
        measure.volume.error,
        measure.area.value,
    ];
    let centroid = measure.centroid.map(|centroid| centroid.map(|x| x.value));
    numbers.extend(centroid.unwrap_or([f64::NAN; 3]));
    let bounds = brep
        .bounds()
        .map(|bounds| [bounds.min, bounds.max].map(|p| p.to_array()));
    numbers.extend(bounds.unwrap_or([[f64::NAN; 3]; 2]).concat());
    let told = |number: f64| match number.is_nan() {
        true => String::new(),
        // (With an exponent where that is shorter.)
        false => format!("{number:?}"),
    };
    let mut fields: Vec<String> = numbers.into_iter().map(told).collect();
    fields.push(brep.shells().len().to_string());
    fields.push(
        brep.shells()
            .map(|shell| shell.genus())
            .sum::<usize>()
            .to_string(),
    );
    fields.push(triangles);
    let files = files.iter().map(|path| path.display().to_string());
    fields.push(files.collect::<Vec<_>>().join(" "));
    Ok(fields)
}

/// A file's name, what is in braces filled in. Values that would name another folder do not.
fn named(name: &str, number: usize, variables: &[Variable]) -> String {
    let mut filled = String::new();
    let mut rest = name;
    while let Some((before, after)) = rest.split_once('{') {
        let (inside, after) = after.split_once('}').unwrap_or((after, ""));
        filled += before;
        match variables.iter().find(|(name, _)| name == inside) {
            Some((_, value)) => {
                let safe = |c: char| {
                    if matches!(c, '/' | '\\' | '"' | '\0') {
                        '_'
                    } else {
                        c
                    }
                };
                let is_folder = value.chars().all(|c| c == '.');
                filled.extend(value.chars().map(|c| if is_folder { '_' } else { safe(c) }));
            }
            // (Writing to a string cannot fail.)
            None => {
                let _ = write!(filled, "{number}");
            }
        }
        rest = after;
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_filled_in() {
        let variables = [("bore".to_owned(), "../0.5".to_owned())];
        assert_eq!(
            named("out/{row}-{bore}.stl", 3, &variables),
            "out/3-.._0.5.stl"
        );
        let variables = [("bore".to_owned(), "..".to_owned())];
        assert_eq!(named("{bore}/{row}.stl", 3, &variables), "__/3.stl");
        assert!(check_name("{row}.stl", &[]).is_ok());
        assert!(check_name("part.stl", &[]).is_err());
        assert!(check_name("{hole}.stl", &["bore"]).is_err());
        assert!(check_name("{bore}.dwg", &["bore"]).is_err());
    }
}
