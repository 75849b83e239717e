//! Shards: files of one slab of a mesh each ([`csg::Slab`]), and the mesh that they make together.
//!
//! Slabs are made by whoever and wherever, and written to files; a [`csg::Merger`] then reads
//! these piece by piece, as often as it needs to. All numbers are little-endian:
//!
//! | bytes | what |
//! | --- | --- |
//! | 8 | `93 53 48 41 52 44 0d 0a`: 0x93, "SHARD", and an end of line that text modes change |
//! | 4 | the version of the format, 1 |
//! | 4 × 12 | of each of the four sections: its length in bytes (8) and its CRC-32 (4) |
//! | 4 | the CRC-32 of all bytes before |
//! | | the sections one after another, and nothing behind them: |
//! | | the head, in [postcard](https://postcard.jamesmunns.com/wire-format): counts, the lattice, a fingerprint of program and lattice, the keys of the vertices that other slabs may name, the triangles to be cleaned up |
//! | | the body, in postcard: the surfaces, names and colours of runs of triangles; keys and places of the vertices of other slabs that are named here |
//! | 24 each | the vertices: x, y and z in double precision, about the middle of the solid's bounds |
//! | 12 each | the triangles: three vertices, those of other slabs counted on from the slab's own |
//!
//! Head and body are as this version of the program has them: shards are for work in progress,
//! to be put together by the program that made them, not for keeping.

use std::borrow::Cow;
use std::fmt;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csg::{CancelToken, Merger, Slab, SlabBody, SlabHead, SlabSource};
use glam::DVec3;

use crate::atomic::AtomicFile;
use crate::gltf::{self, MergedGlb};
use crate::{Error, MeshFormat, WriteOptions, ply, stl, write_mesh};

/// The extension of such files, without the dot.
pub const EXTENSION: &str = "shard";

const MAGIC: [u8; 8] = *b"\x93SHARD\r\n";
const VERSION: u32 = 1;
const SECTIONS: usize = 4;
/// Bytes before the sections.
const PREFIX: usize = 8 + 4 + 12 * SECTIONS + 4;

/// Whether a file's name is that of a shard.
#[must_use]
pub fn is_shard(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

/// Writes a slab.
///
/// # Errors
/// Failed writing.
pub fn write_shard(slab: &Slab, out: &mut impl Write) -> Result<(), Error> {
    let encode = |error: postcard::Error| Error::Write(std::io::Error::other(error));
    let head = postcard::to_stdvec(&slab.head).map_err(encode)?;
    let body = postcard::to_stdvec(&slab.body).map_err(encode)?;
    let positions: &[f64] = bytemuck::cast_slice(&slab.positions);
    let positions = little_endian(positions, f64::to_le_bytes);
    let triangles = little_endian(slab.triangles.as_flattened(), u32::to_le_bytes);
    let sections = [&*head, &*body, &*positions, &*triangles];
    let mut prefix = MAGIC.to_vec();
    prefix.extend_from_slice(&VERSION.to_le_bytes());
    for section in sections {
        prefix.extend_from_slice(&(section.len() as u64).to_le_bytes());
        prefix.extend_from_slice(&crc32fast::hash(section).to_le_bytes());
    }
    let sum = crc32fast::hash(&prefix);
    prefix.extend_from_slice(&sum.to_le_bytes());
    out.write_all(&prefix)?;
    for section in sections {
        out.write_all(section)?;
    }
    Ok(())
}

/// Writes a slab to a file, whole or not at all.
///
/// # Errors
/// What the operating system refuses.
pub fn write_shard_file(path: impl AsRef<Path>, slab: &Slab) -> Result<(), Error> {
    let path = path.as_ref();
    let mut file = AtomicFile::create(path)?;
    write_shard(slab, &mut file).map_err(|error| error.in_file(path))?;
    file.commit()
}

/// Numbers as bytes; without a copy where the machine has them so.
fn little_endian<T: bytemuck::NoUninit, const N: usize>(
    numbers: &[T],
    bytes: impl Fn(T) -> [u8; N],
) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        Cow::Borrowed(bytemuck::cast_slice(numbers))
    } else {
        Cow::Owned(numbers.iter().flat_map(|&number| bytes(number)).collect())
    }
}

/// A shard whose head is read, and the rest when it is asked for: opened again for that, so that
/// there may be more of them than files may be open.
#[derive(Clone, Debug)]
pub struct ShardFile {
    path: PathBuf,
    sections: [Section; SECTIONS],
    head: SlabHead,
    reading: Reading,
}

/// What follows the reading of shards, and stops it: all that a merger does comes of that.
/// Clones are of the same reading.
#[derive(Clone, Default)]
pub struct Reading {
    cancel: CancelToken,
    read: Arc<AtomicU64>,
    told: Option<Arc<dyn Fn(u64) + Send + Sync>>,
}

impl Reading {
    /// Nobody follows it yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Cancelling ends it, and what is made of the shards, with [`csg::Error::Cancelled`].
    #[must_use]
    pub fn cancel_token(mut self, token: CancelToken) -> Self {
        self.cancel = token;
        self
    }

    /// `told` is called with the number of bytes that were read so far. A file is written when
    /// all of them ([`ShardFile::length`]) were read about once since it was begun.
    #[must_use]
    pub fn progress(mut self, told: impl Fn(u64) + Send + Sync + 'static) -> Self {
        self.told = Some(Arc::new(told));
        self
    }

    /// How many bytes were read so far.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.read.load(Ordering::Relaxed)
    }

    fn add(&self, bytes: u64) {
        let so_far = bytes + self.read.fetch_add(bytes, Ordering::Relaxed);
        if let Some(told) = &self.told {
            told(so_far);
        }
    }
}

impl fmt::Debug for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reading")
            .field("cancel", &self.cancel)
            .field("read", &self.read)
            .finish_non_exhaustive()
    }
}

#[derive(Clone, Debug)]
struct Section {
    bytes: Range<u64>,
    sum: u32,
}

impl ShardFile {
    /// Opens a shard.
    ///
    /// # Errors
    /// [`csg::Error::Slab`], with the file's name, if it cannot be read, is none, is of another
    /// version, or was cut off or changed.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::read(path).map_err(|problem| Error::Slab(faulty(path, problem)))
    }

    /// The same, followed and stopped by others.
    #[must_use]
    pub fn followed(mut self, reading: &Reading) -> Self {
        self.reading = reading.clone();
        self
    }

    /// How many bytes there are of vertices, triangles and what they lie on.
    #[must_use]
    pub fn length(&self) -> u64 {
        let sections = self.sections[1..].iter();
        sections
            .map(|section| section.bytes.end - section.bytes.start)
            .sum()
    }

    fn read(path: &Path) -> Result<Self, String> {
        let told = |error: std::io::Error| error.to_string();
        let mut file = File::open(path).map_err(told)?;
        let about = file.metadata().map_err(told)?;
        if !about.is_file() {
            return Err("it is not a file".to_owned());
        }
        let mut prefix = Vec::with_capacity(PREFIX);
        let mut start = Read::by_ref(&mut file).take(PREFIX as u64);
        start.read_to_end(&mut prefix).map_err(told)?;
        if !prefix.starts_with(&MAGIC[..prefix.len().min(MAGIC.len())]) || prefix.is_empty() {
            return Err("it is no shard: make one with `csg mesh --shard`".to_owned());
        }
        let cut_off = || "it was cut off: make it anew".to_owned();
        let mut rest = prefix.get(MAGIC.len()..).ok_or_else(cut_off)?;
        let version = u32::from_le_bytes(*first(&mut rest).ok_or_else(cut_off)?);
        if version != VERSION {
            return Err(format!(
                "it is a shard of version {version}, and this program reads version {VERSION}: \
                 make it with this program"
            ));
        }
        let mut sections = Vec::with_capacity(SECTIONS);
        let mut start = PREFIX as u64;
        for _ in 0..SECTIONS {
            let length = u64::from_le_bytes(*first(&mut rest).ok_or_else(cut_off)?);
            let sum = u32::from_le_bytes(*first(&mut rest).ok_or_else(cut_off)?);
            let end = start.saturating_add(length);
            sections.push(Section {
                bytes: start..end,
                sum,
            });
            start = end;
        }
        let sum = u32::from_le_bytes(*first(&mut rest).ok_or_else(cut_off)?);
        if crc32fast::hash(&prefix[..PREFIX - 4]) != sum {
            return Err(changed());
        }
        if about.len() < start {
            return Err(cut_off());
        }
        let sections: Result<[Section; SECTIONS], _> = sections.try_into();
        let sections = sections.map_err(|_| cut_off())?;
        if about.len() > start {
            return Err(changed());
        }
        let head = section(&mut file, &sections[0])?;
        let head: SlabHead = postcard::from_bytes(&head).map_err(|_| other_program())?;
        let length = |section: &Section| (section.bytes.end - section.bytes.start) as usize;
        if length(&sections[2]) != 24 * head.vertices()
            || length(&sections[3]) != 12 * head.triangles()
        {
            return Err(changed());
        }
        Ok(Self {
            path: path.to_owned(),
            sections,
            head,
            reading: Reading::new(),
        })
    }

    /// A section of the file.
    fn bytes(&self, index: usize) -> Result<Vec<u8>, csg::Error> {
        if self.reading.cancel.is_cancelled() {
            return Err(csg::Error::Cancelled);
        }
        let read = || {
            let mut file = File::open(&self.path).map_err(|error| error.to_string())?;
            section(&mut file, &self.sections[index])
        };
        let bytes = read().map_err(|problem| faulty(&self.path, problem))?;
        self.reading.add(bytes.len() as u64);
        Ok(bytes)
    }
}

/// The first bytes, which are taken off.
fn first<'a, const N: usize>(bytes: &mut &'a [u8]) -> Option<&'a [u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(first)
}

fn section(file: &mut File, section: &Section) -> Result<Vec<u8>, String> {
    let told = |error: std::io::Error| error.to_string();
    let Range { start, end } = section.bytes;
    file.seek(SeekFrom::Start(start)).map_err(told)?;
    let mut bytes = Vec::with_capacity((end - start) as usize);
    file.take(end - start)
        .read_to_end(&mut bytes)
        .map_err(told)?;
    if crc32fast::hash(&bytes) == section.sum {
        Ok(bytes)
    } else {
        Err(changed())
    }
}

fn changed() -> String {
    "it was changed since it was written, or badly copied: make it anew".to_owned()
}

fn other_program() -> String {
    "it was made by another version of the program: make it with this one".to_owned()
}

fn faulty(path: &Path, problem: String) -> csg::Error {
    csg::Error::Slab {
        slab: path.display().to_string(),
        problem,
    }
}

impl SlabSource for ShardFile {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn head(&self) -> &SlabHead {
        &self.head
    }

    fn body(&self) -> Result<Cow<'_, SlabBody>, csg::Error> {
        let body: Result<SlabBody, _> = postcard::from_bytes(&self.bytes(1)?);
        let body = body.map_err(|_| faulty(&self.path, other_program()))?;
        Ok(Cow::Owned(body))
    }

    fn positions(&self) -> Result<Cow<'_, [DVec3]>, csg::Error> {
        let bytes = self.bytes(2)?;
        let (numbers, _) = bytes.as_chunks::<8>();
        let (places, _) = numbers.as_chunks::<3>();
        let place = |place: &[[u8; 8]; 3]| DVec3::from_array(place.map(f64::from_le_bytes));
        Ok(Cow::Owned(places.iter().map(place).collect()))
    }

    fn triangles(&self) -> Result<Cow<'_, [[u32; 3]]>, csg::Error> {
        let bytes = self.bytes(3)?;
        let (numbers, _) = bytes.as_chunks::<4>();
        let (triangles, _) = numbers.as_chunks::<3>();
        let triangle = |corners: &[[u8; 4]; 3]| corners.map(u32::from_le_bytes);
        Ok(Cow::Owned(triangles.iter().map(triangle).collect()))
    }
}

/// Writes a mesh put together from slabs to a file whose extension names the format, and returns
/// the names of the files.
///
/// The bytes are those that [`write_mesh`] writes of the whole mesh with normals, but for GLB of
/// more than [`gltf::CHUNK`] triangles: that has a mesh without normals and names for every so
/// many of them, in files of [`gltf::CHUNKS_PER_FILE`] such chunks (`a.glb`, `a-2.glb`, …), each
/// whole by itself and all in one place. PLY, binary STL and such GLB are written piece by piece;
/// for the other formats the mesh is put together in memory. The bytes are the same for any
/// number of slabs.
///
/// # Errors
/// As [`write_mesh`]; and slabs that cannot be read, or no longer shall be ([`Reading`]).
pub fn write_merged(
    path: impl AsRef<Path>,
    merger: &Merger<impl SlabSource>,
) -> Result<Vec<PathBuf>, Error> {
    write_merged_by(path, merger, (gltf::CHUNK, gltf::CHUNKS_PER_FILE))
}

/// Writes it with chunks of so many triangles, and so many of them to a file, where a format has
/// some: for tests.
///
/// # Errors
/// As [`write_merged`].
#[doc(hidden)]
pub fn write_merged_by(
    path: impl AsRef<Path>,
    merger: &Merger<impl SlabSource>,
    chunks: (usize, usize),
) -> Result<Vec<PathBuf>, Error> {
    let path = path.as_ref();
    by_format(path, merger, chunks).map_err(|error| match error {
        // It names the shard.
        Error::Slab(_) => error,
        _ => error.in_file(path),
    })
}

fn by_format(
    path: &Path,
    merger: &Merger<impl SlabSource>,
    (chunk, chunks): (usize, usize),
) -> Result<Vec<PathBuf>, Error> {
    match MeshFormat::from_path(path)? {
        MeshFormat::Ply => {
            let mut file = AtomicFile::create(path)?;
            ply::write_merged_ply(merger, &mut file)?;
            file.commit()?;
        }
        MeshFormat::Stl => {
            let mut file = AtomicFile::create(path)?;
            stl::write_merged_stl(merger, &mut file)?;
            file.commit()?;
        }
        MeshFormat::Glb if merger.triangle_count() > chunk => {
            let glb = MergedGlb::new(merger, chunk);
            let names = (1..=glb.files(chunks)).map(|number| numbered(path, number));
            let names: Vec<PathBuf> = names.collect();
            let files = names.iter().map(AtomicFile::create);
            let mut files = files.collect::<Result<Vec<_>, _>>()?;
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            let data = || tempfile::tempfile_in(folder).map_err(Error::file("write in", folder));
            glb.write(chunks, &mut files, data)?;
            AtomicFile::commit_all(files)?;
            return Ok(names);
        }
        _ => {
            let mesh = merger.mesh_with_normals()?;
            write_mesh(path, &mesh, &WriteOptions::default())?;
        }
    }
    Ok(vec![path.to_owned()])
}

/// The name of one of several files.
fn numbered(path: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{number}.{extension}"))
}
