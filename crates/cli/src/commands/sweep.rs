//! `sweep`: a table of variants, one row a model, to one table of measures, and files.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use csg::{BoundaryOptions, Mesher, Program};
use io::WriteOptions;
use rayon::prelude::*;

use super::account::Bounds;
use super::figure::Figure;
use super::parse::{angle, length};
use super::table::{self, Field, Kind, TableFormat};
use crate::failure::{Failure, exit_codes};
use crate::input::{Subject, Wanted};
use crate::mesher::{ANGLE, LimitOptions, Unit, chords, tolerance_beside};
use crate::output::{self, StepArguments, StreamFormat};
use crate::progress::Progress;
use crate::shard::Shard;

/// Options of `sweep`.
#[derive(Debug, clap::Args)]
#[command(after_help = columns_help())]
pub(crate) struct Options {
    /// The table of variants as comma-separated values (or with semicolons or tabulators, if the
    /// first row has no comma): its first row has the names of variables, and each other row
    /// their values for one model
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Where to write the table of measures, as comma-separated values (.csv) or Parquet
    /// (.parquet), or `-` for comma-separated values on standard output: a row for each variant,
    /// with its number and variables
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
    pub(crate) unit: Unit,
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

/// The first column.
const ROW: Column = Column("row", Kind::Count, "the variant's number, from 1");

/// What is measured of each model.
const MEASURES: [Column; 15] = [
    Column("volume", Kind::Number, "in the unit's cube"),
    Column("volume_error", Kind::Number, "the volume is off by no more"),
    Column("area", Kind::Number, "of the surface, in the unit's square"),
    Column("centroid_x", Kind::Number, "where the centroid is"),
    Column("centroid_y", Kind::Number, ""),
    Column("centroid_z", Kind::Number, ""),
    Column("min_x", Kind::Number, "the box around it"),
    Column("min_y", Kind::Number, ""),
    Column("min_z", Kind::Number, ""),
    Column("max_x", Kind::Number, ""),
    Column("max_y", Kind::Number, ""),
    Column("max_z", Kind::Number, ""),
    Column("components", Kind::Count, "connected parts of the boundary"),
    Column("genus", Kind::Count, "handles, of all of them"),
    Column("triangles", Kind::Count, "of the mesh, if one is written"),
];

/// What comes after the measures.
const LAST: [Column; 2] = [
    Column(
        "files",
        Kind::Text,
        "that were written, with spaces between",
    ),
    Column(
        "error",
        Kind::Text,
        "why the variant failed; it has no measures then",
    ),
];

/// The name of a column, what its fields are, and what they say.
struct Column(&'static str, Kind, &'static str);

/// The columns as a Table Schema (Frictionless Data): their names, types and what they say. The
/// variables of the table of variants stand between the first two, as they are there.
#[cfg(test)]
pub(super) fn table_schema() -> serde_json::Value {
    let field = |&Column(name, kind, says): &Column| {
        let kind = match kind {
            Kind::Text => "string",
            Kind::Count => "integer",
            Kind::Number => "number",
        };
        let mut field = serde_json::json!({ "name": name, "type": kind });
        if !says.is_empty() {
            field["description"] = says.into();
        }
        field
    };
    let columns = [ROW].iter().chain(&MEASURES).chain(&LAST).map(field);
    let fields: Vec<serde_json::Value> = columns.collect();
    serde_json::json!({
        "$schema": "https://datapackage.org/profiles/2.0/tableschema.json",
        "title": "The table of measures that `csg sweep` writes; the variables follow `row`",
        "fieldsMatch": ["superset"],
        "fields": fields,
        "missingValues": [""],
        "primaryKey": ["row"],
    })
}

/// What the columns of the table of measures are, for `--help`.
fn columns_help() -> String {
    let mut help = "Columns of OUT, numbers with the digits that are known; what there is not is \
                    empty:\n"
        .to_owned();
    let mut line = |name: &str, kind: &str, says: &str| {
        help += format!("  {name:<13} {kind:<7} {says}").trim_end();
        help.push('\n');
    };
    let told = |kind: Kind| match kind {
        Kind::Text => "text",
        Kind::Count => "whole",
        Kind::Number => "number",
    };
    line(ROW.0, told(ROW.1), ROW.2);
    line(
        "...",
        "",
        "the variables of TABLE, as they are there; in Parquet",
    );
    line("", "", "numbers where all of a column are");
    for Column(name, kind, says) in MEASURES.iter().chain(&LAST) {
        line(name, told(*kind), says);
    }
    help
}

pub(crate) fn run(
    model: &Model<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    let format = TableFormat::from_path(&options.output)?;
    progress.stage("reading");
    let table = Table::read(&options.table)?;
    let names: Vec<&str> = table.names.iter().map(String::as_str).collect();
    for name in &options.write {
        check_name(name, &names)?;
    }
    table.check_files(&options.write)?;
    output::check_folders([options.output.as_path()])?;
    if output::is_same_file(&options.output, &options.table) {
        let context = format!(
            "the output {} is the table of variants",
            options.output.display()
        );
        let cause = "it would be replaced: give the table of measures another name";
        return Err(Failure::new(exit_codes::USAGE, context, cause));
    }
    if table.rows.is_empty() {
        say!(
            "warning: {} has no rows below its names: there is nothing to measure",
            options.table.display()
        );
    }
    let rows = options.shard.rows(table.rows.len());
    progress.stage("sweeping");
    let (done, count) = (AtomicUsize::new(0), rows.len().max(1));
    let tell = progress.callback();
    let kinds = match format {
        // (As it is given.)
        TableFormat::Csv => vec![Kind::Text; names.len()],
        #[cfg(feature = "parquet")]
        TableFormat::Parquet => table.kinds(),
    };
    let made: Vec<Row> = rows
        .into_par_iter()
        .map(|index| {
            let row = Row::of(index + 1, &table.variables(index), &kinds, model, options);
            tell((1 + done.fetch_add(1, Ordering::Relaxed)) as f64 / count as f64);
            row
        })
        .collect();
    progress.stage("writing");
    let (count, failed) = (made.len(), made.iter().filter(|row| row.has_failed).count());
    let of_measures = |columns: &[Column]| -> Vec<(String, Kind)> {
        let columns = columns.iter();
        columns
            .map(|Column(name, kind, _)| ((*name).to_owned(), *kind))
            .collect()
    };
    let variables = table.names.iter().cloned().zip(kinds).collect();
    let told = table::Table {
        columns: [
            of_measures(&[ROW]),
            variables,
            of_measures(&MEASURES),
            of_measures(&LAST),
        ]
        .concat(),
        rows: made.into_iter().map(|row| row.fields).collect(),
    };
    output::write_bytes(&options.output, &told.to_bytes(format)?)?;
    progress.end();
    progress.say(format_args!("{count} variants, {failed} of which failed"));
    if failed > 0 {
        let cause = "their rows say why in the column `error`";
        let context = format!("{failed} of {count} variants failed");
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
        let name = path.display().to_string();
        check_table(path)?;
        let failure = |error: csv::Error| match error.kind() {
            csv::ErrorKind::UnequalLengths { .. } => Failure::input(&name, error).hint(
                "every row has a field for each name in the first: put texts with commas in quotes",
            ),
            _ => Failure::input(&name, error),
        };
        let text = std::fs::read(path).map_err(|error| Failure::input(&name, error))?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(COMMENT))
            .delimiter(delimiter(&text))
            .from_reader(text.as_slice());
        let names: Vec<String> = reader
            .headers()
            .map_err(failure)?
            .iter()
            .map(str::to_owned)
            .collect();
        if names.iter().all(String::is_empty) {
            let cause = "it is empty: its first row has the names of variables, or `model`";
            return Err(Failure::input(&name, cause));
        }
        let written = [ROW].into_iter().chain(MEASURES).chain(LAST);
        let mut taken = written.map(|Column(name, ..)| name);
        let taken = taken.find(|known| names.iter().any(|name| name == known));
        if let Some(taken) = taken {
            let cause = format!(
                "its column `{taken}` is one of those that are written: give it another name"
            );
            return Err(Failure::input(&name, cause));
        }
        let twice = (1..names.len()).find(|&k| names[..k].contains(&names[k]));
        if let Some(k) = twice {
            let cause = format!(
                "two of its columns are called `{}`: give one another name",
                names[k]
            );
            return Err(Failure::input(&name, cause));
        }
        let rows = reader.records().map(|record| {
            let record = record.map_err(failure)?;
            Ok(record.iter().map(str::to_owned).collect())
        });
        let rows = rows.collect::<Result<_, Failure>>()?;
        Ok(Self { names, rows })
    }

    /// What each variable is in all rows: a number, if it is one wherever it is given.
    #[cfg(feature = "parquet")]
    fn kinds(&self) -> Vec<Kind> {
        let is_number = |value: &String| value.is_empty() || value.parse::<f64>().is_ok();
        let is_of_numbers = |column| self.rows.iter().all(|row| is_number(&row[column]));
        let kind = |column| match is_of_numbers(column) {
            true => Kind::Number,
            false => Kind::Text,
        };
        (0..self.names.len()).map(kind).collect()
    }

    fn variables(&self, index: usize) -> Vec<Variable> {
        let values = self.rows[index].iter().cloned();
        self.names.iter().cloned().zip(values).collect()
    }

    /// Refuses names of files that are the same for two rows, or in folders that are not there.
    fn check_files(&self, names: &[String]) -> Result<(), Failure> {
        let mut rows = HashMap::new();
        let mut folders = HashSet::new();
        for index in 0..self.rows.len() {
            let variables = self.variables(index);
            for name in names {
                let file = named(name, index + 1, &variables);
                let path = Path::new(&file);
                if folders.insert(path.parent().map(Path::to_owned)) {
                    output::check_folders([path])?;
                }
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

/// What lines begin with that are passed over.
const COMMENT: u8 = b'#';

/// What stands between fields: commas, or else the semicolons or tabulators of the first row.
fn delimiter(text: &[u8]) -> u8 {
    let mut lines = text.split(|&byte| byte == b'\n');
    let first = lines.find(|line| !(line.trim_ascii().is_empty() || line.starts_with(&[COMMENT])));
    let first = first.unwrap_or_default();
    let known = [b',', b';', b'\t'];
    let found = known
        .into_iter()
        .find(|delimiter| first.contains(delimiter));
    found.unwrap_or(b',')
}

/// Refuses what is no table by its name: a scene, a model, a mesh, or a table of another format.
fn check_table(path: &Path) -> Result<(), Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let ending = ending.map(str::to_ascii_lowercase);
    let is_model = matches!(ending.as_deref(), Some("csg" | "scad"))
        || io::step::is_step(path)
        || io::MeshFormat::from_path(path).is_ok();
    let name = path.display().to_string();
    if is_model {
        let cause = "it is a model, not a table of variants";
        return Err(Failure::input(&name, cause).hint(
            "name a table of comma-separated values (.csv): models stand in its column `model`, \
             or one for all rows is given by --model",
        ));
    }
    if matches!(ending.as_deref(), Some("parquet" | "xlsx" | "ods")) {
        let cause = "tables of variants are read as comma-separated values alone: save it as .csv";
        return Err(Failure::input(&name, cause));
    }
    Ok(())
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
    // (Folders are looked for once the names are filled in.)
    output::check_format(Path::new(name))
}

/// A row of the table of measures.
struct Row {
    fields: Vec<Field>,
    has_failed: bool,
}

impl Row {
    fn of(
        number: usize,
        variables: &[Variable],
        kinds: &[Kind],
        model: &Model<'_>,
        options: &Options,
    ) -> Self {
        let mut fields = vec![Field::count(number)];
        let given = variables.iter().zip(kinds);
        fields.extend(given.map(|((_, value), kind)| Field::given(value, *kind)));
        let made = measured(number, variables, model, options);
        let has_failed = made.is_err();
        match made {
            Ok(measures) => {
                fields.extend(measures);
                fields.push(Field::Nothing);
            }
            Err(failure) => {
                fields.extend(vec![Field::Nothing; MEASURES.len() + 1]);
                fields.push(Field::Text(one_line(&failure.to_string())));
            }
        }
        Self { fields, has_failed }
    }
}

impl Options {
    /// What models are read for.
    pub(crate) fn wanted(&self) -> Wanted {
        Wanted {
            within: self.tolerance.map(chords),
            ..Wanted::solid(self.unit)
        }
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
) -> Result<Vec<Field>, Failure> {
    let solid = model(variables)?.solid(options.unit)?;
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
    let mut triangles = Field::Nothing;
    if !meshes.is_empty() {
        let mut mesher = Mesher::new().normals().unit(unit).limits(limits);
        if let Some(tolerance) = options.tolerance {
            mesher = mesher.tolerance(tolerance_beside(solid.strays(), tolerance));
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
        triangles = Field::count(mesh.triangles.len());
    }
    let measure = brep.measure();
    let volume = Figure::from(measure.volume);
    let numbers = [
        volume.told(),
        volume.error_told(),
        Figure::from(measure.area).told(),
    ];
    let centroid = measure
        .centroid
        .map(|centroid| centroid.map(|x| Figure::from(x).told()));
    let bounds = brep
        .bounds()
        .map(|bounds| Bounds::new(bounds.min, bounds.max).rounded());
    let mut fields: Vec<Field> = numbers.into_iter().map(Field::number).collect();
    fields.extend(centroid.map_or([const { Field::Nothing }; 3], |c| c.map(Field::number)));
    fields.extend(bounds.map_or([const { Field::Nothing }; 6], |b| b.map(Field::number)));
    fields.push(Field::count(brep.shells().len()));
    fields.push(Field::count(brep.shells().map(|shell| shell.genus()).sum()));
    fields.push(triangles);
    let files: Vec<String> = files
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    fields.push(Field::given(&files.join(" "), Kind::Text));
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
