//! Lettering in pictures: strokes, one letter in a cell of 4 by 6 units with the
//! base line at 0.

use csg::Color;
use glam::DVec2;

use crate::image::Image;
use crate::line::{Layer, Segment};

/// The strokes of a letter: points of polylines, as digits x and y, parted by
/// spaces.
fn strokes(letter: char, units: bool) -> &'static str {
    // Small letters where units have them.
    let small = match letter {
        _ if !units => "",
        'm' => "0004 03142320 23344340",
        'c' => "4334140301103041",
        'i' => "2024 2526",
        'n' => "0004 0314344340",
        'f' => "36262520 1434",
        't' => "26213041 1434",
        _ => "",
    };
    if !small.is_empty() {
        return small;
    }
    match letter.to_ascii_uppercase() {
        '0' | 'O' => "100105163645413010",
        '1' => "042620 1030",
        '2' => "05163645440040",
        '3' => "0516364544334241301001 1333",
        '4' => "30360242",
        '5' => "460603334241301001",
        '6' => "36160501103041423303",
        '7' => "064610",
        '8' => "130405163645443313 1302011030414233",
        '9' => "10304145361605041343",
        'A' => "002640 1232",
        'B' => "000636454433 0333 3342413000",
        'C' => "4536160501103041",
        'D' => "00062645412000",
        'E' => "46060040 0333",
        'F' => "460600 0333",
        'G' => "45361605011030414323",
        'H' => "0006 4046 0343",
        'I' => "1030 2026 1636",
        'J' => "4641301001",
        'K' => "0006 4603 1340",
        'L' => "060040",
        'M' => "0006234640",
        'N' => "00064046",
        'P' => "00063645443303",
        'Q' => "100105163645413010 2240",
        'R' => "00063645443303 2340",
        'S' => "453616050413334241301001",
        'T' => "0646 2620",
        'U' => "060110304146",
        'V' => "062046",
        'W' => "0610243046",
        'X' => "0046 0640",
        'Y' => "062346 2320",
        'Z' => "06460040",
        '.' => "2021",
        ',' => "2110",
        '-' => "1333",
        '+' => "1333 2224",
        ':' => "2122 2425",
        '/' => "0046",
        '(' => "36242230",
        ')' => "16242210",
        '%' => "0046 0616 3040",
        '=' => "1232 1434",
        '_' => "0040",
        '°' => "1526352415",
        'µ' => "0004 01103041 4440",
        _ => "",
    }
}

/// A text to be put into a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lettering<'a> {
    pub text: &'a str,
    /// Left end of the base line, in pixels.
    pub at: DVec2,
    /// Height of capitals in pixels.
    pub height: f64,
    pub color: Color,
}

/// Units from one letter to the next.
const ADVANCE: f64 = 5.6;
/// Units of a capital's height.
const CAPITAL: f64 = 6.0;

/// How wide a text is, in pixels, at a height of capitals.
pub(crate) fn text_width(text: &str, height: f64) -> f64 {
    let letters = text.chars().count() as f64;
    (letters * ADVANCE - (ADVANCE - 4.0)).max(0.0) * height / CAPITAL
}

impl Lettering<'_> {
    /// Draws it.
    pub fn draw(&self, image: &mut Image) {
        let mut layer = Layer::new(image.width, image.height);
        self.draw_on(&mut layer);
        layer.composite(image, self.color);
    }

    /// Adds its strokes to a layer.
    pub fn draw_on(&self, layer: &mut Layer) {
        let unit = self.height / CAPITAL;
        let width = (self.height / 8.0).clamp(1.0, 6.0);
        let units = self
            .text
            .starts_with(|c: char| c.is_ascii_digit() || c == '-');
        for (number, letter) in self.text.chars().enumerate() {
            let left = self.at + DVec2::X * (number as f64 * ADVANCE * unit);
            for line in lines(strokes(letter, units)) {
                for pair in line.windows(2) {
                    let [a, b] = [pair[0], pair[1]]
                        .map(|p: DVec2| (left + DVec2::new(p.x, -p.y) * unit).extend(0.0));
                    layer.draw(&Segment { a, b, start: 0.0 }, width);
                }
            }
        }
    }
}

/// The polylines of strokes.
fn lines(strokes: &str) -> impl Iterator<Item = Vec<DVec2>> {
    strokes.split(' ').map(|line| {
        let digits: Vec<f64> = line
            .bytes()
            .map(|b| f64::from(b.saturating_sub(b'0')))
            .collect();
        digits
            .chunks_exact(2)
            .map(|p| DVec2::new(p[0], p[1]))
            .collect()
    })
}
