//! Tables as Parquet: a column for each of theirs, in which fields may be missing.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::{Field, Kind, Table};

impl Table {
    pub(super) fn parquet(&self) -> Result<Vec<u8>, ParquetError> {
        let columns = self.columns.iter().map(|(name, kind)| column(name, *kind));
        let columns = columns.collect::<Result<Vec<_>, _>>()?;
        let schema = Type::group_type_builder("schema").with_fields(columns);
        let schema = Arc::new(schema.build()?);
        let properties = WriterProperties::builder().build();
        let mut bytes = Vec::new();
        let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
        let mut rows = file.next_row_group()?;
        let mut index = 0;
        while let Some(mut column) = rows.next_column()? {
            self.write_column(index, &mut column)?;
            column.close()?;
            index += 1;
        }
        rows.close()?;
        file.close()?;
        Ok(bytes)
    }

    fn write_column(
        &self,
        index: usize,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<(), ParquetError> {
        let fields = || self.rows.iter().map(|row| &row[index]);
        // (1 where there is a value, 0 where there is none.)
        let given: Vec<i16> = fields()
            .map(|field| i16::from(*field != Field::Nothing))
            .collect();
        match self.columns[index].1 {
            Kind::Text => write::<ByteArrayType>(column, &given, fields(), |field| match field {
                Field::Text(text) => Some(ByteArray::from(text.as_str())),
                _ => None,
            }),
            Kind::Count => write::<Int64Type>(column, &given, fields(), |field| match field {
                Field::Count(count) => Some(*count),
                _ => None,
            }),
            Kind::Number => write::<DoubleType>(column, &given, fields(), |field| match field {
                Field::Number(number) => Some(*number),
                _ => None,
            }),
        }
    }
}

/// Writes the values that fields of one kind have.
fn write<'a, T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    given: &[i16],
    fields: impl Iterator<Item = &'a Field>,
    value: impl Fn(&'a Field) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let values: Vec<T::T> = fields.filter_map(value).collect();
    let column = column.typed::<T>();
    column.write_batch(&values, Some(given), None)?;
    Ok(())
}

/// A column of Parquet in which fields may be missing.
fn column(name: &str, kind: Kind) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = match kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Count => (Physical::INT64, None),
        Kind::Number => (Physical::DOUBLE, None),
    };
    let column = Type::primitive_type_builder(name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical);
    column.build().map(Arc::new)
}
