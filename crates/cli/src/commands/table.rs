//! Tables of measures: their columns, and how they are written, as CSV or Parquet.

#[cfg(feature = "parquet")]
mod parquet;

use std::path::Path;

use crate::failure::{Failure, exit_codes};
use crate::output::is_stream;

/// What the fields of a column are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Text,
    /// A whole number.
    Count,
    Number,
}

/// A field of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Field {
    /// There is none.
    Nothing,
    Text(String),
    Count(i64),
    Number(f64),
}

impl Field {
    /// A number, if it is one.
    pub(super) fn number(number: f64) -> Self {
        match number.is_nan() {
            true => Self::Nothing,
            false => Self::Number(number),
        }
    }

    /// How many.
    pub(super) fn count(count: usize) -> Self {
        // (More than that do not fit into memory.)
        i64::try_from(count).map_or(Self::Nothing, Self::Count)
    }

    /// A text that was given, in a column of a kind.
    pub(super) fn given(text: &str, kind: Kind) -> Self {
        match (kind, text.parse()) {
            _ if text.is_empty() => Self::Nothing,
            (Kind::Number, Ok(number)) => Self::Number(number),
            _ => Self::Text(text.to_owned()),
        }
    }

    /// As CSV has it.
    fn text(&self) -> String {
        match self {
            Self::Nothing => String::new(),
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            // (With an exponent where that is shorter.)
            Self::Number(number) => format!("{number:?}"),
        }
    }
}

/// What names of tables there may be.
#[cfg(feature = "parquet")]
const ENDINGS: &str = "tables are written as comma-separated values or Parquet: give a name that \
                       ends in .csv or .parquet, or - for comma-separated values on standard \
                       output";
#[cfg(not(feature = "parquet"))]
const ENDINGS: &str = "this command was built without Parquet (cargo's feature `parquet`), and \
                       writes tables as comma-separated values: give a name that ends in .csv, \
                       or - for standard output; Python's stereotomy.distributed writes Parquet";

/// Formats of tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TableFormat {
    Csv,
    #[cfg(feature = "parquet")]
    Parquet,
}

impl TableFormat {
    /// The format that a file's ending says; CSV on standard output.
    ///
    /// # Errors
    /// Which endings there are, for any other.
    pub(super) fn from_path(path: &Path) -> Result<Self, Failure> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            _ if is_stream(path) => Ok(Self::Csv),
            Some("csv") => Ok(Self::Csv),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(Self::Parquet),
            _ => {
                let context = format!("no such format of tables: {}", path.display());
                Err(Failure::new(exit_codes::USAGE, context, ENDINGS))
            }
        }
    }
}

/// A table in memory.
pub(super) struct Table {
    pub(super) columns: Vec<(String, Kind)>,
    /// Each has a field of its kind, or none, for each column.
    pub(super) rows: Vec<Vec<Field>>,
}

impl Table {
    /// The bytes of a file.
    pub(super) fn to_bytes(&self, format: TableFormat) -> Result<Vec<u8>, Failure> {
        match format {
            TableFormat::Csv => self.csv(),
            #[cfg(feature = "parquet")]
            TableFormat::Parquet => self.parquet().map_err(|error| error.to_string()),
        }
        .map_err(|error| Failure::output("the table", error))
    }

    fn csv(&self) -> Result<Vec<u8>, String> {
        let mut out = csv::Writer::from_writer(Vec::new());
        let names = self.columns.iter().map(|(name, _)| name.clone()).collect();
        let rows = self.rows.iter();
        let rows = rows.map(|row| row.iter().map(Field::text).collect());
        for record in std::iter::once(names).chain(rows) {
            let record: Vec<String> = record;
            out.write_record(record)
                .map_err(|error| error.to_string())?;
        }
        out.into_inner().map_err(|error| error.to_string())
    }
}
