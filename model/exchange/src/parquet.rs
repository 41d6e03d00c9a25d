//! Parquet: one row a cycle, one column a field of a channel, for pandas, polars and DuckDB.
//!
//! The columns are `cycle`, `monotonic_ns`, `missed`, `time_s`, then `CHANNEL.FIELD` for every field of every channel, each of
//! its own kind: doubles and unsigned integers, bit for bit as recorded, nothing is null (NaN is a double). The file's
//! key-value metadata have `sinew` (JSON: rig, rate, versions, channels, fields with their units) and `rig.toml`.

use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};
use sinew_recording::session::{About, Kind, Layout};
use sinew_recording::{Error, Part};

use crate::table::{Cycle, Table};
use crate::unwritable;

/// Bytes of a row group before compression: what is in memory at a time. Groups are what readers skip by.
pub const GROUP_BYTES: usize = 48 << 20;

/// The columns before the channels'.
const HEAD: [&str; 4] = ["cycle", "monotonic_ns", "missed", "time_s"];

/// Collects the rows of a group, column by column.
struct Group {
    cycle: Vec<i64>,
    monotonic_ns: Vec<i64>,
    missed: Vec<i64>,
    time_s: Vec<f64>,
    fields: Vec<Values>,
    most: usize,
}

/// One column of a group. Unsigned numbers travel as signed ones of the same bits, which is Parquet's way.
enum Values {
    Doubles(Vec<f64>),
    Codes(Vec<i32>),
}

impl Group {
    fn new(layout: &Layout, channels: &[usize]) -> Group {
        let fields = channels.iter().flat_map(|_| &layout.fields).map(|field| match field.kind {
            Kind::F64 => Values::Doubles(Vec::new()),
            Kind::U32 => Values::Codes(Vec::new()),
        });
        let row = 8 * HEAD.len() + channels.len() * layout.stride();
        Group {
            cycle: Vec::new(),
            monotonic_ns: Vec::new(),
            missed: Vec::new(),
            time_s: Vec::new(),
            fields: fields.collect(),
            most: (GROUP_BYTES / row).max(1),
        }
    }

    fn push(&mut self, part: &Cycle<'_>, stride: usize, channels: &[usize]) {
        self.cycle.push(part.head.cycle as i64);
        self.monotonic_ns.push(part.head.monotonic_ns as i64);
        self.missed.push(part.head.missed as i64);
        self.time_s.push(part.time_s);
        let a_channel = self.fields.len() / channels.len().max(1);
        for (fields, channel) in self.fields.chunks_mut(a_channel.max(1)).zip(channels) {
            let mut rest = &part.bytes[channel * stride..(channel + 1) * stride];
            for field in fields {
                // a layout has no holes, so that one field stands right behind the other
                match field {
                    Values::Doubles(values) => {
                        let Some((bytes, behind)) = rest.split_first_chunk() else { return };
                        values.push(f64::from_le_bytes(*bytes));
                        rest = behind;
                    }
                    Values::Codes(values) => {
                        let Some((bytes, behind)) = rest.split_first_chunk() else { return };
                        values.push(i32::from_le_bytes(*bytes));
                        rest = behind;
                    }
                }
            }
        }
    }

    fn is_full(&self) -> bool {
        self.cycle.len() >= self.most
    }

    /// Writes the group, if there is anything in it, and empties it.
    fn flush<W: std::io::Write + Send>(&mut self, file: &mut SerializedFileWriter<W>) -> Result<(), ParquetError> {
        if self.cycle.is_empty() {
            return Ok(());
        }
        let missing = || ParquetError::General("a column too few".into());
        let mut group = file.next_row_group()?;
        for numbers in [&mut self.cycle, &mut self.monotonic_ns, &mut self.missed] {
            let mut column = group.next_column()?.ok_or_else(missing)?;
            column.typed::<Int64Type>().write_batch(numbers, None, None)?;
            column.close()?;
            numbers.clear();
        }
        let mut column = group.next_column()?.ok_or_else(missing)?;
        column.typed::<DoubleType>().write_batch(&self.time_s, None, None)?;
        column.close()?;
        self.time_s.clear();
        for values in &mut self.fields {
            let mut column = group.next_column()?.ok_or_else(missing)?;
            match values {
                Values::Doubles(values) => {
                    column.typed::<DoubleType>().write_batch(values, None, None)?;
                    values.clear();
                }
                Values::Codes(values) => {
                    column.typed::<Int32Type>().write_batch(values, None, None)?;
                    values.clear();
                }
            }
            column.close()?;
        }
        group.close()?;
        Ok(())
    }
}

/// Writes the cycles of these channels (by their index; empty = all) as Parquet; a file of that name is replaced once the new one
/// is whole. Gives how many rows there are.
///
/// # Errors
/// Where the table cannot be read or the file not be written.
pub fn parquet(table: &dyn Table, channels: &[usize], path: &Path) -> Result<u64, Error> {
    let failed = |error: ParquetError| unwritable(path, &error);
    let all: Vec<usize> = (0..table.layout().channels.len()).collect();
    let channels = if channels.is_empty() { &all } else { channels };
    let layout = table.layout();
    let (part, file) = Part::create(path).map_err(|e| unwritable(path, &e))?;
    let schema = schema(layout, channels).map_err(failed)?;
    let properties = properties(table.about(), layout, channels).map_err(failed)?;
    let sink = BufWriter::with_capacity(1 << 20, &file);
    let mut writer = SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
    let mut group = Group::new(layout, channels);
    let (stride, mut rows) = (layout.stride(), 0);
    table.each(&mut |cycle| {
        group.push(cycle, stride, channels);
        rows += 1;
        if group.is_full() { group.flush(&mut writer).map_err(failed) } else { Ok(()) }
    })?;
    group.flush(&mut writer).map_err(failed)?;
    let sink = writer.into_inner().map_err(failed)?;
    sink.into_inner().map_err(|e| unwritable(path, e.error()))?;
    part.publish(&file).map_err(|e| unwritable(path, &e))?;
    Ok(rows)
}

/// Names of the columns behind the head's, and what they are made of.
fn columns<'a>(layout: &'a Layout, channels: &'a [usize]) -> impl Iterator<Item = (String, Kind)> + 'a {
    let names = channels.iter().map(|channel| &layout.channels[*channel]);
    names.flat_map(|name| layout.fields.iter().map(move |field| (format!("{name}.{}", field.name), field.kind)))
}

fn schema(layout: &Layout, channels: &[usize]) -> Result<Type, ParquetError> {
    let field = |name: &str, kind: Physical, unsigned: Option<i8>| {
        let logical = unsigned.map(|bit_width| LogicalType::integer(bit_width, false));
        let built = Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED);
        built.with_logical_type(logical).build().map(Arc::new)
    };
    let mut fields = Vec::new();
    for name in &HEAD[..3] {
        fields.push(field(name, Physical::INT64, Some(64))?);
    }
    fields.push(field(HEAD[3], Physical::DOUBLE, None)?);
    for (name, kind) in columns(layout, channels) {
        fields.push(match kind {
            Kind::F64 => field(&name, Physical::DOUBLE, None)?,
            Kind::U32 => field(&name, Physical::INT32, Some(32))?,
        });
    }
    Type::group_type_builder("recording").with_fields(fields).build()
}

fn properties(about: &About, layout: &Layout, channels: &[usize]) -> Result<WriterProperties, ParquetError> {
    let mut properties = WriterProperties::builder()
        .set_created_by(about.software.clone())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(1)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        // numbers with noise hardly ever repeat: a dictionary of them would only be thrown away again
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .set_max_row_group_row_count(None)
        .set_key_value_metadata(Some(metadata(about, layout, channels)));
    for name in &HEAD[..3] {
        properties = properties.set_column_encoding(ColumnPath::from(*name), Encoding::DELTA_BINARY_PACKED);
    }
    for (name, kind) in columns(layout, channels) {
        if kind == Kind::U32 {
            let path = ColumnPath::new(vec![name]);
            properties = properties.set_column_dictionary_enabled(path, true);
        }
    }
    Ok(properties.build())
}

fn metadata(about: &About, layout: &Layout, channels: &[usize]) -> Vec<KeyValue> {
    let fields: Vec<_> = layout
        .fields
        .iter()
        .map(|field| {
            let kind = match field.kind {
                Kind::F64 => "float64",
                Kind::U32 => "uint32",
            };
            serde_json::json!({ "name": field.name, "kind": kind, "unit": field.unit })
        })
        .collect();
    let names: Vec<&String> = channels.iter().map(|channel| &layout.channels[*channel]).collect();
    let said = serde_json::json!({
        "schema": "sinew.parquet/1",
        "rig": about.rig,
        "rate_hz": about.rate_hz,
        "software": about.software,
        "kind": about.kind,
        "simulated": about.simulated,
        "started_unix_ns": about.started_unix_ns,
        "started_monotonic_ns": about.started_monotonic_ns,
        "channels": names,
        "fields": fields,
        "extra": about.extra,
    });
    let mut entries = vec![KeyValue::new("sinew".into(), said.to_string())];
    entries.extend(about.rig_toml.as_ref().map(|text| KeyValue::new("rig.toml".into(), text.clone())));
    entries
}
