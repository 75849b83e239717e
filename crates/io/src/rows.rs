//! Large outputs, row by row: formatted in parallel, written in order.

use std::io::{self, Write};

use rayon::prelude::*;

/// Rows formatted by one task; some hundred kilobytes of text.
const BLOCK: usize = 1 << 12;
/// Blocks in memory at once.
const BATCH: usize = 32;

/// Lets `format` append row 0, 1, ... `rows - 1`, and writes them in order.
pub(crate) fn write_rows(
    out: &mut impl Write,
    rows: usize,
    format: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    let blocks = rows.div_ceil(BLOCK);
    for batch in (0..blocks).step_by(BATCH) {
        let formatted: Vec<Vec<u8>> = (batch..blocks.min(batch + BATCH))
            .into_par_iter()
            .map(|block| {
                let mut text = Vec::with_capacity(BLOCK * 64);
                for row in block * BLOCK..rows.min((block + 1) * BLOCK) {
                    format(row, &mut text);
                }
                text
            })
            .collect();
        for text in formatted {
            out.write_all(&text)?;
        }
    }
    Ok(())
}

/// Appends a number in the shortest form that reads back to the same bits.
pub(crate) fn push_f64(text: &mut Vec<u8>, number: f64) {
    // Whole numbers of moderate size need neither point nor exponent.
    if number == number.trunc()
        && number.abs() < 1e15
        && !(number == 0.0 && number.is_sign_negative())
    {
        text.extend_from_slice(itoa::Buffer::new().format(number as i64).as_bytes());
    } else {
        text.extend_from_slice(zmij::Buffer::new().format(number).as_bytes());
    }
}

/// As [`push_f64`], for single precision.
pub(crate) fn push_f32(text: &mut Vec<u8>, number: f32) {
    if number == number.trunc()
        && number.abs() < 1e6
        && !(number == 0.0 && number.is_sign_negative())
    {
        text.extend_from_slice(itoa::Buffer::new().format(number as i64).as_bytes());
    } else {
        text.extend_from_slice(zmij::Buffer::new().format(number).as_bytes());
    }
}

/// Appends a whole number.
pub(crate) fn push_index(text: &mut Vec<u8>, number: u64) {
    text.extend_from_slice(itoa::Buffer::new().format(number).as_bytes());
}
