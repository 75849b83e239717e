//! Heights over a grid, from rows of numbers or a picture, and the solid below them, for `surface`.

use std::io::Cursor;

use glam::DVec3;
use png::{ColorType, Decoder, Limits, Reader, Transformations};

/// Heights over a grid.
pub(super) struct Heights {
    rows: Vec<Vec<f64>>,
    /// Where the solid ends below.
    bottom: f64,
}

/// The most that solids are made from.
const MOST_FACETS: f64 = 4e6;

/// How many faces are made of so many columns and rows: four of every square.
pub(super) fn facets([columns, rows]: [usize; 2]) -> f64 {
    4.0 * (columns as f64 - 1.0) * (rows as f64 - 1.0)
}

/// A PNG file, of which only the head was read.
pub(super) struct Picture<'data>(Reader<Cursor<&'data [u8]>>);

impl<'data> Picture<'data> {
    /// None if it is none, which its first bytes tell.
    pub fn of(data: &'data [u8]) -> Result<Option<Self>, String> {
        const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
        /// More than all that is said about a picture takes.
        const MOST_BYTES: usize = 1 << 26;
        if !data.starts_with(SIGNATURE) {
            return Ok(None);
        }
        let limits = Limits { bytes: MOST_BYTES };
        let mut decoder = Decoder::new_with_limits(Cursor::new(data), limits);
        decoder.set_transformations(Transformations::normalize_to_color8());
        let reader = decoder.read_info().map_err(|e| unreadable(&e))?;
        Ok(Some(Self(reader)))
    }

    /// Columns and rows.
    fn size(&self) -> [usize; 2] {
        let (columns, rows) = self.0.info().size();
        [columns as usize, rows as usize]
    }

    /// The luminance of each pixel as a height, black 0 and white 100, without regard to opacity;
    /// the last row first. As in OpenSCAD, which with `invert` takes 1 minus it in place of 255
    /// minus it before it scales: heights are those of the negative less 99.6.
    pub fn heights(mut self, invert: bool) -> Result<Heights, String> {
        /// Of red, green and blue (ITU-R BT.709).
        const SHARES: [f64; 3] = [0.2126, 0.7152, 0.0722];
        // (Before all of it is read.)
        let [columns, rows] = self.size();
        if facets([columns, rows]) > MOST_FACETS {
            return Err(format!(
                "{columns} x {rows} pixels are too many for a solid: give a picture of at most a million"
            ));
        }
        let size = self.0.output_buffer_size().ok_or("it is too large")?;
        let mut bytes = vec![0; size];
        let frame = self.0.next_frame(&mut bytes).map_err(|e| unreadable(&e))?;
        let channels = frame.color_type.samples();
        let is_grey = matches!(
            frame.color_type,
            ColorType::Grayscale | ColorType::GrayscaleAlpha
        );
        let height = |pixel: &[u8]| {
            let channel = |k: usize| f64::from(pixel[if is_grey { 0 } else { k }]);
            let light = SHARES[0] * channel(0) + SHARES[1] * channel(1) + SHARES[2] * channel(2);
            100.0 / 255.0 * if invert { 1.0 - light } else { light }
        };
        let rows = bytes.chunks_exact(frame.line_size).rev();
        let rows = rows.map(|row| row.chunks_exact(channels).map(height).collect());
        let rows: Vec<Vec<f64>> = rows.collect();
        let least = rows.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        Ok(Heights {
            rows,
            bottom: least - 1.0,
        })
    }
}

fn unreadable(error: &png::DecodingError) -> String {
    format!("the picture cannot be read: {error}")
}

impl Heights {
    /// Rows of numbers, without empty lines and those that begin with `#`.
    pub fn of_text(data: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(data)
            .map_err(|_| "it is neither a PNG picture nor a text of rows of numbers".to_owned())?;
        let mut rows = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let words = line.split_whitespace().map(|word| {
                let height = word.parse::<f64>().ok().filter(|h| h.is_finite());
                height.ok_or_else(|| format!("line {number}: {word:?} is not a number"))
            });
            rows.push(words.collect::<Result<Vec<f64>, String>>()?);
        }
        let least = rows.iter().flatten().copied().fold(1.0, f64::min);
        Ok(Self {
            rows,
            bottom: least - 1.0,
        })
    }

    /// Columns, of the longest row, and rows.
    pub fn size(&self) -> [usize; 2] {
        [
            self.rows.iter().map(Vec::len).max().unwrap_or(0),
            self.rows.len(),
        ]
    }

    /// The solid below the heights, as OpenSCAD makes it: the first row at
    /// y = 0; four triangles over every square that meet at its mean height; down to 1
    /// below the least height, or of numbers to 0 if that is lower. Heights that a row does not
    /// have are 0. Of at least two rows and columns.
    pub fn relief(&self) -> (Vec<DVec3>, Vec<Vec<u32>>) {
        let Self { rows, bottom } = self;
        let [columns, _] = self.size();
        let height = |i: usize, j: usize| rows[i].get(j).copied().unwrap_or(0.0);
        let mut points = Vec::new();
        for i in 0..rows.len() {
            for j in 0..columns {
                points.push(DVec3::new(j as f64, i as f64, height(i, j)));
            }
        }
        let top = |i: usize, j: usize| (i * columns + j) as u32;
        let mut faces = Vec::new();
        for i in 1..rows.len() {
            for j in 1..columns {
                let corners = [top(i - 1, j - 1), top(i - 1, j), top(i, j), top(i, j - 1)];
                let sum: f64 = corners.iter().map(|&c| points[c as usize].z).sum();
                let middle = DVec3::new(j as f64 - 0.5, i as f64 - 0.5, 0.25 * sum);
                let center = points.len() as u32;
                points.push(middle);
                for k in 0..4 {
                    faces.push(vec![corners[k], corners[(k + 1) % 4], center]);
                }
            }
        }
        // Around the grid, counter-clockwise.
        let (last_row, last_column) = (rows.len() - 1, columns - 1);
        let rim: Vec<u32> = (0..last_column)
            .map(|j| top(0, j))
            .chain((0..last_row).map(|i| top(i, last_column)))
            .chain((1..=last_column).rev().map(|j| top(last_row, j)))
            .chain((1..=last_row).rev().map(|i| top(i, 0)))
            .collect();
        let below = points.len() as u32;
        let floor = rim.iter().map(|&corner| {
            let point = points[corner as usize];
            DVec3::new(point.x, point.y, *bottom)
        });
        let floor: Vec<DVec3> = floor.collect();
        points.extend(floor);
        let count = rim.len() as u32;
        for k in 0..count {
            let next = (k + 1) % count;
            let (a, b) = (rim[k as usize], rim[next as usize]);
            faces.push(vec![below + k, below + next, b, a]);
        }
        faces.push((below..below + count).rev().collect());
        (points, faces)
    }
}
