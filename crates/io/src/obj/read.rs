//! The OBJ reader.
//!
//! Large files are cut into pieces that are read in parallel. Where anything
//! is wrong, or indices count backwards, which takes all that came before,
//! one thread goes over the whole file again, and says at which line.

use std::borrow::Cow;

use bytemuck::Zeroable;
use csg::{Color, LengthUnit, Mesh};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::assemble::Assembler;
use crate::parts::{DEFAULT_COLOR, DEFAULT_MATERIAL};
use crate::weld::split;
use crate::{Error, MeshFormat};

/// Reads an OBJ file; `load` fetches a material library by name, and where it
/// gives nothing the colours are left out.
///
/// Polygons are cut into triangles from their first corner. Groups and
/// objects become names, materials' diffuse colours (taken as sRGB) colours.
/// Lines, points, free-form surfaces and texture coordinates are passed over.
/// The unit is taken to be the millimetre.
///
/// # Errors
/// A face or number that is not valid, with its line.
pub fn read_obj(data: &[u8], load: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Mesh, Error> {
    let pieces = pieces(data);
    let parsed: Result<Vec<Piece>, Error> = pieces
        .into_par_iter()
        .map(|piece| Piece::parse(piece, false))
        .collect();
    let pieces = match parsed.ok().filter(|pieces| fit(pieces)) {
        Some(pieces) => pieces,
        None => vec![Piece::parse(data, true)?],
    };
    assemble(pieces, load)
}

/// Cuts a file into pieces of some megabytes that end with a line.
fn pieces(data: &[u8]) -> Vec<&[u8]> {
    const LEAST: usize = 1 << 21;
    let mut pieces = Vec::new();
    let mut rest = data;
    while rest.len() > 2 * LEAST {
        let mut end = LEAST;
        // (A line after a backslash goes on in the next one.)
        for line in rest[LEAST..].split_inclusive(|&b| b == b'\n') {
            end += line.len();
            if !line.trim_ascii_end().ends_with(b"\\") {
                break;
            }
        }
        let (piece, later) = rest.split_at(end);
        pieces.push(piece);
        rest = later;
    }
    pieces.push(rest);
    pieces
}

/// What a piece of a file says.
#[derive(Default)]
struct Piece {
    places: Vec<DVec3>,
    normals: Vec<Vec3>,
    /// Vertices of the whole file, counted from 0.
    triangles: Vec<[u32; 3]>,
    /// Normals of the whole file, for each triangle; empty if one of them has
    /// a corner without.
    triangle_normals: Vec<[u32; 3]>,
    /// What changes before a triangle, by its number.
    changes: Vec<(usize, Change)>,
    /// Vertices and normals that must come before the piece.
    needed: [usize; 2],
}

/// A line that says how the faces after it look.
enum Change {
    Name(Option<String>),
    Material(String),
    Libraries(String),
}

/// Whether the faces of each piece name vertices and normals that came before
/// them.
fn fit(pieces: &[Piece]) -> bool {
    let mut before = [0, 0];
    pieces.iter().all(|piece| {
        let fits = piece.needed[0] <= before[0] && piece.needed[1] <= before[1];
        before[0] += piece.places.len();
        before[1] += piece.normals.len();
        fits
    })
}

impl Piece {
    /// Reads the lines of a piece, or of the whole file where it stands
    /// `alone`.
    fn parse(data: &[u8], alone: bool) -> Result<Self, Error> {
        let mut piece = Self::default();
        let mut face: Vec<(u32, Option<u32>)> = Vec::new();
        let mut with_normals = true;
        for (number, line) in lines(data) {
            let mut words = words(&line);
            match words.next() {
                Some(b"v") => {
                    let place = vector(&mut words).filter(|place| place.is_finite());
                    let place =
                        place.ok_or_else(|| malformed(number, "v needs three finite numbers"))?;
                    piece.places.push(place);
                }
                Some(b"vn") => {
                    let normal = vector(&mut words);
                    let normal =
                        normal.ok_or_else(|| malformed(number, "vn needs three numbers"))?;
                    piece.normals.push(normal.normalize_or_zero().as_vec3());
                }
                Some(b"f") => {
                    face.clear();
                    for word in words {
                        let corner = piece.corner(word, alone);
                        face.push(corner.map_err(|problem| malformed(number, &problem))?);
                    }
                    if face.len() < 3 {
                        return Err(malformed(number, "a face needs at least three corners"));
                    }
                    for i in 1..face.len() - 1 {
                        let corners = [face[0], face[i], face[i + 1]];
                        piece.triangles.push(corners.map(|(vertex, _)| vertex));
                        let [a, b, c] = corners.map(|(_, normal)| normal);
                        match (a, b, c) {
                            (Some(a), Some(b), Some(c)) if with_normals => {
                                piece.triangle_normals.push([a, b, c]);
                            }
                            _ => with_normals = false,
                        }
                    }
                }
                Some(b"g" | b"o") => {
                    let name = words.next().map(text).filter(|name| name != "default");
                    piece.change(Change::Name(name));
                }
                Some(b"usemtl") => {
                    let material = words.next().map(text).unwrap_or_default();
                    piece.change(Change::Material(material));
                }
                Some(b"mtllib") => {
                    let names: Vec<_> = words.map(text).collect();
                    piece.change(Change::Libraries(names.join(" ")));
                }
                _ => {}
            }
        }
        if !with_normals {
            piece.triangle_normals.clear();
        }
        Ok(piece)
    }

    fn change(&mut self, change: Change) {
        self.changes.push((self.triangles.len(), change));
    }

    /// A corner `v`, `v/t`, `v//n` or `v/t/n`: indices from 1, or from -1
    /// backwards. The vertex and the normal, counted from 0.
    fn corner(&mut self, word: &[u8], alone: bool) -> Result<(u32, Option<u32>), String> {
        let [places, normals] = [self.places.len(), self.normals.len()];
        let [needed_places, needed_normals] = &mut self.needed;
        let mut fields = word.split(|&b| b == b'/');
        let vertex = fields.next().unwrap_or_default();
        let vertex = index(vertex, places, alone.then_some("vertices"), needed_places)?;
        let normal = match fields.nth(1) {
            Some(digits) if !digits.is_empty() => {
                let what = alone.then_some("normals");
                Some(index(digits, normals, what, needed_normals)?)
            }
            _ => None,
        };
        Ok((vertex, normal))
    }
}

/// An index into what has been listed, `count` so far in this piece, counted
/// from 0. Where the piece stands alone (and the list has a name), it must be
/// one of these; else `needed` says how many others must come before.
fn index(
    digits: &[u8],
    count: usize,
    alone: Option<&str>,
    needed: &mut usize,
) -> Result<u32, String> {
    let wrong = || {
        let digits = String::from_utf8_lossy(digits);
        let what = alone.unwrap_or_default();
        format!("{digits:?} names none of the {count} {what} so far")
    };
    let number = whole_number(digits).ok_or_else(wrong)?;
    let index = match number {
        1.. => number - 1,
        ..=-1 if alone.is_some() => count as i64 + number,
        _ => return Err(wrong()),
    };
    let index = u32::try_from(index).map_err(|_| wrong())?;
    let missing = (index as usize + 1).saturating_sub(count);
    if alone.is_some() && missing > 0 {
        return Err(wrong());
    }
    *needed = missing.max(*needed);
    Ok(index)
}

/// Puts the pieces together.
fn assemble(
    mut pieces: Vec<Piece>,
    mut load: impl FnMut(&str) -> Option<Vec<u8>>,
) -> Result<Mesh, Error> {
    let count: usize = pieces.iter().map(|piece| piece.places.len()).sum();
    if u32::try_from(count).is_err() {
        return Err(Error::Malformed {
            format: MeshFormat::Obj,
            place: "end of file".to_owned(),
            problem: "it has too many vertices".to_owned(),
        });
    }
    let places: Vec<Vec<DVec3>> = take(&mut pieces, |piece| &mut piece.places);
    let normals: Vec<Vec<Vec3>> = take(&mut pieces, |piece| &mut piece.normals);
    let normals = joined(normals);
    let mut mesh = Assembler::new(LengthUnit::Millimetre);
    mesh.add_vertices(joined(places));

    // Runs of triangles of one name and colour: piece, first and last.
    let mut runs: Vec<(usize, std::ops::Range<usize>)> = Vec::new();
    let mut looks: Vec<(Option<String>, Option<Color>)> = Vec::new();
    let mut materials: FxHashMap<String, Option<Color>> = FxHashMap::default();
    let mut now = (None, None);
    for (number, piece) in pieces.iter_mut().enumerate() {
        let mut first = 0;
        let mut run = |end: usize, look: &(Option<String>, Option<Color>)| {
            if first < end {
                runs.push((number, first..end));
                looks.push(look.clone());
                first = end;
            }
        };
        for (before, change) in piece.changes.drain(..) {
            run(before, &now);
            match change {
                Change::Name(name) => now.0 = name,
                Change::Material(name) => now.1 = materials.get(&name).copied().flatten(),
                Change::Libraries(names) => {
                    if let Some(library) = load(&names) {
                        read_mtl(&library, &mut materials);
                    }
                }
            }
        }
        run(piece.triangles.len(), &now);
    }
    let all_normals = |piece: &Piece| piece.triangle_normals.len() == piece.triangles.len();
    let with_normals = pieces.iter().all(all_normals);
    let lengths: Vec<usize> = runs.iter().map(|(_, range)| range.len()).collect();
    let part = |run: usize| (looks[run].0.as_deref(), looks[run].1);
    mesh.all_triangles(
        &lengths,
        with_normals,
        part,
        |run, triangles, to_normals| {
            let (piece, range) = &runs[run];
            let piece = &pieces[*piece];
            triangles.copy_from_slice(&piece.triangles[range.clone()]);
            if with_normals {
                let from = &piece.triangle_normals[range.clone()];
                for (to, from) in to_normals.iter_mut().zip(from) {
                    *to = from.map(|normal| normals[normal as usize]);
                }
            }
            Ok::<(), Error>(())
        },
    )?;
    Ok(mesh.finish())
}

/// Takes one list out of every piece.
fn take<T>(pieces: &mut [Piece], list: impl Fn(&mut Piece) -> &mut Vec<T>) -> Vec<Vec<T>> {
    let lists = pieces.iter_mut().map(|piece| std::mem::take(list(piece)));
    lists.collect()
}

/// All lists one after the other.
fn joined<T: Zeroable + Copy + Send + Sync>(mut lists: Vec<Vec<T>>) -> Vec<T> {
    if let [only] = &mut lists[..] {
        return std::mem::take(only);
    }
    let mut all: Vec<T> = bytemuck::zeroed_vec(lists.iter().map(Vec::len).sum());
    split(&mut all, lists.iter().map(Vec::len))
        .into_par_iter()
        .zip(&lists)
        .for_each(|(to, from)| to.copy_from_slice(from));
    all
}

/// Adds a library's materials; `None` for the one that stands for no colour.
fn read_mtl(data: &[u8], materials: &mut FxHashMap<String, Option<Color>>) {
    let mut current = String::new();
    for (_, line) in lines(data) {
        let mut words = words(&line);
        let keyword = words.next();
        if keyword == Some(b"newmtl") {
            current = words.next().map(text).unwrap_or_default();
            materials.insert(current.clone(), None);
        } else if let Some(color) = materials.get_mut(&current)
            && current != DEFAULT_MATERIAL
        {
            match keyword {
                Some(b"Kd") => {
                    if let Some(rgb) = vector(&mut words) {
                        let alpha = color.map_or(1.0, |c| c.alpha);
                        let opaque = Color::from_srgb(rgb.as_vec3().to_array());
                        *color = Some(opaque.with_alpha(alpha));
                    }
                }
                Some(b"d") => {
                    if let Some(alpha) = words.next().and_then(number) {
                        *color = Some(color.unwrap_or(DEFAULT_COLOR).with_alpha(alpha as f32));
                    }
                }
                _ => {}
            }
        }
    }
}

fn malformed(line: usize, problem: &str) -> Error {
    Error::Malformed {
        format: MeshFormat::Obj,
        place: format!("line {line}"),
        problem: problem.to_owned(),
    }
}

/// The lines with their numbers (from 1), continued ones joined, without
/// comments.
fn lines(data: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, [u8]>)> {
    let mut rest = data.split(|&b| b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (index, line) = rest.next()?;
        let mut line = Cow::Borrowed(line.trim_ascii_end());
        while line.ends_with(b"\\") {
            let line = line.to_mut();
            line.pop();
            line.push(b' ');
            if let Some((_, more)) = rest.next() {
                line.extend_from_slice(more.trim_ascii_end());
            }
        }
        if let Some(comment) = line.iter().position(|&b| b == b'#') {
            match &mut line {
                Cow::Borrowed(line) => *line = &line[..comment],
                Cow::Owned(line) => line.truncate(comment),
            }
        }
        Some((index + 1, line))
    })
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn vector<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<DVec3> {
    let mut next = || words.next().and_then(number);
    Some(DVec3::new(next()?, next()?, next()?))
}

/// A whole number in decimal digits, perhaps negative.
fn whole_number(word: &[u8]) -> Option<i64> {
    let (digits, sign) = match word {
        [b'-', digits @ ..] => (digits, -1),
        [b'+', digits @ ..] | digits => (digits, 1),
    };
    let number = digits.iter().try_fold(0i64, |number, &b| {
        let digit = b.is_ascii_digit().then(|| i64::from(b - b'0'))?;
        number.checked_mul(10)?.checked_add(digit)
    })?;
    (!digits.is_empty()).then_some(sign * number)
}
