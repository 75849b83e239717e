//! The OBJ reader.
//!
//! Large files are cut into pieces that are read in parallel, most lines in
//! one quick pass ([`quick_vector`], [`quick_face`]), all others word by word.
//! Where anything is wrong, or indices count backwards, which takes all that
//! came before, one thread goes over the whole file again, and says at which
//! line.

use std::borrow::Cow;

use bytemuck::Zeroable;
use csg::{Color, LengthUnit, Mesh};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::assemble::{Assembled, Assembler, with_triangles};
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
/// A face or number that is not valid, with its line; no faces at all.
pub fn read_obj(data: &[u8], load: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Mesh, Error> {
    read_obj_objects(data, load).map(|read| read.mesh)
}

/// [`read_obj`]; objects begin with lines `o`.
pub(crate) fn read_obj_objects(
    data: &[u8],
    load: impl FnMut(&str) -> Option<Vec<u8>>,
) -> Result<Assembled, Error> {
    let pieces = pieces(data);
    let parsed: Result<Vec<Piece>, Error> = pieces
        .into_par_iter()
        .with_max_len(1)
        .map(|piece| Piece::parse(piece, false))
        .collect();
    let pieces = match parsed.ok().filter(|pieces| fit(pieces)) {
        Some(pieces) => pieces,
        None => vec![Piece::parse(data, true)?],
    };
    with_triangles(assemble(pieces, load)?, MeshFormat::Obj, data)
}

/// Cuts a file into a few pieces for each thread that end with a line.
fn pieces(data: &[u8]) -> Vec<&[u8]> {
    let share = data.len() / (8 * rayon::current_num_threads());
    let least = share.max(1 << 18);
    let mut pieces = Vec::new();
    let mut rest = data;
    while rest.len() > 2 * least {
        let mut end = least;
        for line in rest[least..].split_inclusive(|&b| b == b'\n') {
            end += line.len();
            // (A line after a backslash goes on in the next one.)
            if !rest[..end].trim_ascii_end().ends_with(b"\\") {
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
    /// Normals of the whole file, for each triangle; fewer if one of them has
    /// a corner without.
    triangle_normals: Vec<[u32; 3]>,
    /// What changes before a triangle, by its number.
    changes: Vec<(usize, Change)>,
    /// Vertices and normals that must come before the piece.
    needed: [usize; 2],
}

/// A line that says how the faces after it look.
enum Change {
    /// Groups of the object before are over with it.
    Object(Option<String>),
    Group(Option<String>),
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

/// A corner of a face: the numbers of its vertex and of its normal.
type Corner = (i64, Option<i64>);

impl Piece {
    /// Reads the lines of a piece, or of the whole file where it stands
    /// `alone`.
    fn parse(data: &[u8], alone: bool) -> Result<Self, Error> {
        // Room for some of each; lines are about as long.
        let some = data.len() / 64;
        let mut piece = Self {
            places: Vec::with_capacity(some),
            normals: Vec::with_capacity(some),
            triangles: Vec::with_capacity(some),
            triangle_normals: Vec::with_capacity(some),
            ..Self::default()
        };
        let mut face = Vec::new();
        let (mut rest, mut number) = (data, 1);
        while !rest.is_empty() {
            if let Some(length) = piece.quick_line(rest, &mut face, alone) {
                rest = &rest[length..];
                number += 1;
            } else {
                let (line, breaks, later) = line(rest);
                let read = piece.line(&line, &mut face, alone);
                read.map_err(|problem| malformed(number, &problem))?;
                rest = later;
                number += breaks;
            }
        }
        Ok(piece)
    }

    /// Reads the line that `text` begins with, if it is one of the kinds that
    /// files consist of; returns its length.
    fn quick_line(&mut self, text: &[u8], face: &mut Vec<Corner>, alone: bool) -> Option<usize> {
        match text {
            [b'v', b' ', numbers @ ..] => {
                let (place, length) = quick_vector(numbers)?;
                self.places.push(place);
                Some(2 + length)
            }
            [b'v', b'n', b' ', numbers @ ..] => {
                let (normal, length) = quick_vector(numbers)?;
                self.normals.push(normal.normalize_or_zero().as_vec3());
                Some(3 + length)
            }
            [b'f', b' ', corners @ ..] => {
                let length = quick_face(corners, face)?;
                self.face(face, alone).ok()?;
                Some(2 + length)
            }
            _ => None,
        }
    }

    /// Reads any line.
    fn line(&mut self, line: &[u8], face: &mut Vec<Corner>, alone: bool) -> Result<(), String> {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => {
                let place = vector(&mut words).filter(|place| place.is_finite());
                self.places
                    .push(place.ok_or("v needs three finite numbers")?);
            }
            Some(b"vn") => {
                let normal = vector(&mut words).ok_or("vn needs three numbers")?;
                self.normals.push(normal.normalize_or_zero().as_vec3());
            }
            Some(b"f") => {
                face.clear();
                for word in words {
                    face.push(corner(word)?);
                }
                let wrong = match self.face(face, alone) {
                    Ok(()) => return Ok(()),
                    Err(wrong) => wrong,
                };
                return Err(match wrong {
                    WrongFace::TooShort => "a face needs at least three corners".to_owned(),
                    WrongFace::NoVertex(number) => {
                        let count = self.places.len();
                        format!("\"{number}\" names none of the {count} vertices so far")
                    }
                    WrongFace::NoNormal(number) => {
                        let count = self.normals.len();
                        format!("\"{number}\" names none of the {count} normals so far")
                    }
                });
            }
            Some(keyword @ (b"g" | b"o")) => {
                let name = words.next().map(text).filter(|name| name != "default");
                self.change(if keyword == b"o" {
                    Change::Object(name)
                } else {
                    Change::Group(name)
                });
            }
            Some(b"usemtl") => {
                let material = words.next().map(text).unwrap_or_default();
                self.change(Change::Material(material));
            }
            Some(b"mtllib") => {
                let names: Vec<_> = words.map(text).collect();
                self.change(Change::Libraries(names.join(" ")));
            }
            _ => {}
        }
        Ok(())
    }

    fn change(&mut self, change: Change) {
        self.changes.push((self.triangles.len(), change));
    }

    /// Adds the triangles of a face.
    #[inline]
    fn face(&mut self, face: &[Corner], alone: bool) -> Result<(), WrongFace> {
        let [first, second, rest @ ..] = face else {
            return Err(WrongFace::TooShort);
        };
        if rest.is_empty() {
            return Err(WrongFace::TooShort);
        }
        let (first, mut last) = (self.corner(*first, alone)?, self.corner(*second, alone)?);
        for &corner in rest {
            let next = self.corner(corner, alone)?;
            let [a, b, c] = [first, last, next];
            self.triangles.push([a.0, b.0, c.0]);
            if let (Some(a), Some(b), Some(c)) = (a.1, b.1, c.1) {
                self.triangle_normals.push([a, b, c]);
            }
            last = next;
        }
        Ok(())
    }

    /// A corner's vertex and normal, counted from 0.
    #[inline]
    fn corner(
        &mut self,
        (vertex, normal): Corner,
        alone: bool,
    ) -> Result<(u32, Option<u32>), WrongFace> {
        let [places, normals] = [self.places.len(), self.normals.len()];
        let [needed_places, needed_normals] = &mut self.needed;
        let found = index(vertex, places, alone, needed_places);
        let found = found.ok_or(WrongFace::NoVertex(vertex))?;
        let normal = match normal {
            Some(number) => {
                let found = index(number, normals, alone, needed_normals);
                Some(found.ok_or(WrongFace::NoNormal(number))?)
            }
            None => None,
        };
        Ok((found, normal))
    }
}

/// What is wrong with a face: too few corners, or a number that names nothing.
enum WrongFace {
    TooShort,
    NoVertex(i64),
    NoNormal(i64),
}

/// The three numbers, apart by spaces, that end a line, and their length with
/// its end.
#[inline]
fn quick_vector(text: &[u8]) -> Option<(DVec3, usize)> {
    let mut at = 0;
    let mut vector = [0.0; 3];
    for (axis, number) in vector.iter_mut().enumerate() {
        // (What else ends a number, such as another sign or point, is wrong.)
        if axis > 0 && text.get(at) != Some(&b' ') {
            return None;
        }
        while text.get(at) == Some(&b' ') {
            at += 1;
        }
        let length;
        (*number, length) = fast_float2::parse_partial(&text[at..]).ok()?;
        // (Others are told with their line.)
        if !f64::is_finite(*number) {
            return None;
        }
        at += length;
    }
    let end = line_break(&text[at..])?;
    Some((vector.into(), at + end))
}

/// The corners, apart by single spaces, that end a line, and their length with
/// its end.
#[inline]
fn quick_face(text: &[u8], face: &mut Vec<Corner>) -> Option<usize> {
    face.clear();
    let mut at = 0;
    let number = |at: &mut usize| {
        let digits = text[*at..].iter().take_while(|b| b.is_ascii_digit());
        let length = digits.count();
        // (So many always fit.)
        let digits = text[*at..][..length].iter().filter(|_| length < 19);
        let number = digits.fold(None, |number, &b| {
            Some(10 * number.unwrap_or(0) + i64::from(b - b'0'))
        })?;
        *at += length;
        Some(number)
    };
    loop {
        let vertex = number(&mut at)?;
        let mut normal = None;
        if text.get(at) == Some(&b'/') {
            at += 1;
            if text.get(at) != Some(&b'/') {
                number(&mut at)?;
            }
            if text.get(at) == Some(&b'/') {
                at += 1;
                normal = Some(number(&mut at)?);
            }
        }
        face.push((vertex, normal));
        if text.get(at) != Some(&b' ') {
            let end = line_break(&text[at..])?;
            return Some(at + end);
        }
        at += 1;
    }
}

/// The length of the line break that `text` begins with.
#[inline]
fn line_break(text: &[u8]) -> Option<usize> {
    match text {
        [b'\n', ..] => Some(1),
        [b'\r', b'\n', ..] => Some(2),
        _ => None,
    }
}

/// A corner `v`, `v/t`, `v//n` or `v/t/n`.
fn corner(word: &[u8]) -> Result<Corner, String> {
    let number = |digits: &[u8]| {
        let wrong = || format!("{:?} is no index", String::from_utf8_lossy(digits));
        whole_number(digits).ok_or_else(wrong)
    };
    let mut fields = word.split(|&b| b == b'/');
    let vertex = number(fields.next().unwrap_or_default())?;
    let normal = fields.nth(1).filter(|digits| !digits.is_empty());
    Ok((vertex, normal.map(number).transpose()?))
}

/// What a number, from 1, or from -1 backwards, names in a list of which there
/// have been `count` in this piece, counted from 0. Where the piece stands
/// alone, it must be one of these; else `needed` says how many others must
/// come before.
#[inline]
fn index(number: i64, count: usize, alone: bool, needed: &mut usize) -> Option<u32> {
    let index = match number {
        1.. => number - 1,
        ..=-1 if alone => count as i64 + number,
        _ => return None,
    };
    let index = u32::try_from(index).ok()?;
    let missing = (index as usize + 1).saturating_sub(count);
    if alone && missing > 0 {
        return None;
    }
    *needed = missing.max(*needed);
    Some(index)
}

/// Puts the pieces together.
fn assemble(
    mut pieces: Vec<Piece>,
    mut load: impl FnMut(&str) -> Option<Vec<u8>>,
) -> Result<Assembled, Error> {
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
    let mut looks: Vec<Look> = Vec::new();
    let mut materials: FxHashMap<String, Option<Color>> = FxHashMap::default();
    let mut now = Look::default();
    let (mut objects, mut before) = (vec![0], 0);
    for (number, piece) in pieces.iter_mut().enumerate() {
        let mut first = 0;
        let mut run = |end: usize, look: &Look| {
            if first < end {
                runs.push((number, first..end));
                looks.push(look.clone());
                first = end;
            }
        };
        for (end, change) in piece.changes.drain(..) {
            run(end, &now);
            match change {
                Change::Object(name) => {
                    objects.push(before + end);
                    (now.object, now.group) = (name, None);
                }
                Change::Group(name) => now.group = name,
                Change::Material(name) => now.color = materials.get(&name).copied().flatten(),
                Change::Libraries(names) => {
                    if let Some(library) = load(&names) {
                        read_mtl(&library, &mut materials);
                    }
                }
            }
        }
        run(piece.triangles.len(), &now);
        before += piece.triangles.len();
    }
    mesh.begin_objects(objects);
    let all_normals = |piece: &Piece| piece.triangle_normals.len() == piece.triangles.len();
    let with_normals = pieces.iter().all(all_normals);
    let lengths: Vec<usize> = runs.iter().map(|(_, range)| range.len()).collect();
    let part = |run: usize| (looks[run].names(), looks[run].color);
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

/// How triangles look.
#[derive(Clone, Default)]
struct Look {
    object: Option<String>,
    group: Option<String>,
    color: Option<Color>,
}

impl Look {
    /// The object's, and a group's of another name in it.
    fn names(&self) -> Vec<&str> {
        let group = self.group.as_ref().filter(|_| self.group != self.object);
        let names = self.object.iter().chain(group);
        names.map(String::as_str).collect()
    }
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
    let mut rest = data;
    while !rest.is_empty() {
        let (line, _, later) = line(rest);
        rest = later;
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

/// The line that `text` begins with, joined with those that continue it and
/// without its comment; how many breaks end them, and what comes after.
fn line(text: &[u8]) -> (Cow<'_, [u8]>, usize, &[u8]) {
    let mut breaks = 0;
    let mut rest = text;
    let mut next = || {
        breaks += 1;
        let end = rest.iter().position(|&b| b == b'\n');
        let line = &rest[..end.unwrap_or(rest.len())];
        rest = end.map_or(&[], |end| &rest[end + 1..]);
        line.trim_ascii_end()
    };
    let mut line = Cow::Borrowed(next());
    while line.ends_with(b"\\") {
        let line = line.to_mut();
        line.pop();
        line.push(b' ');
        line.extend_from_slice(next());
    }
    if let Some(comment) = line.iter().position(|&b| b == b'#') {
        match &mut line {
            Cow::Borrowed(line) => *line = &line[..comment],
            Cow::Owned(line) => line.truncate(comment),
        }
    }
    (line, breaks, rest)
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
