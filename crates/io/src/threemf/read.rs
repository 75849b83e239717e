//! Reading 3MF: the objects that a file builds, where it puts them.

use std::io::{BufRead, BufReader, Cursor, Read};

use csg::{Color, LengthUnit, Mesh};
use glam::{DAffine3, DMat3, DVec3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rustc_hash::FxHashMap;
use zip::ZipArchive;

use crate::assemble::{Assembled, Assembler, with_triangles};
use crate::{Error, MeshFormat};

/// Where the model is, if nothing else is said.
const MODEL: &str = "3D/3dmodel.model";
/// A model unpacks to no more than so many times the file, and some bytes: text of meshes to
/// ten times.
const MOST_UNPACKED: u64 = 200;
const FREE: u64 = 1 << 24;
/// Objects are put together from others, and these again, no more triangles than this.
const MOST_TRIANGLES: usize = 1 << 28;

/// Reads what a 3MF file builds: meshes of objects, those that components put together in their
/// places, with the unit, names of objects and of those that they are components of, and colours of base materials and colour groups, a
/// triangle's by its first corner. Textures, beams, slices and encrypted parts are not read.
///
/// # Errors
/// A damaged archive or model, with the place in it; what names objects or materials that are
/// not there before it; no triangles.
pub fn read_3mf(data: &[u8]) -> Result<Mesh, Error> {
    read_3mf_objects(data).map(|read| read.mesh)
}

/// [`read_3mf`]; each mesh in each of its places is an object.
pub(crate) fn read_3mf_objects(data: &[u8]) -> Result<Assembled, Error> {
    let archive = |error: zip::result::ZipError| malformed("the archive", error.to_string());
    let mut zip = ZipArchive::new(Cursor::new(data)).map_err(archive)?;
    let path = match zip.by_name("_rels/.rels") {
        Ok(file) => root(BufReader::new(file.take(FREE)))?.unwrap_or_else(|| MODEL.to_owned()),
        Err(_) => MODEL.to_owned(),
    };
    let path = path.trim_start_matches('/');
    let file = zip
        .by_name(path)
        .map_err(|error| malformed(path, error.to_string()))?;
    let most = FREE + MOST_UNPACKED * data.len() as u64;
    if file.size() > most {
        let problem = format!(
            "it unpacks to {} bytes, far more than a mesh does",
            file.size()
        );
        return Err(malformed(path, problem));
    }
    let read = Model::default().read(BufReader::new(file.take(most)), path)?;
    with_triangles(read, MeshFormat::ThreeMf, data)
}

/// The model that the archive's relationships name.
fn root(file: impl BufRead) -> Result<Option<String>, Error> {
    let mut xml = Reader::from_reader(file);
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = xml.read_event_into(&mut buffer);
        match event.map_err(|error| malformed("_rels/.rels", error.to_string()))? {
            Event::Start(node) | Event::Empty(node) => {
                let node = Node::of(&node, "_rels/.rels", 0)?;
                if node
                    .get("Type")
                    .is_some_and(|kind| kind.ends_with("/3dmodel"))
                {
                    return Ok(node.get("Target").map(str::to_owned));
                }
            }
            Event::Eof => return Ok(None),
            _ => {}
        }
    }
}

fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::ThreeMf,
        place: place.into(),
        problem: problem.into(),
    }
}

/// An element: its name without a prefix, and its attributes.
struct Node {
    name: String,
    attributes: Vec<(String, String)>,
    place: String,
}

impl Node {
    fn of(node: &BytesStart<'_>, path: &str, at: u64) -> Result<Self, Error> {
        let place = format!("{path}, byte {at}");
        let mut attributes = Vec::new();
        for attribute in node.attributes() {
            let attribute = attribute.map_err(|error| malformed(&place, error.to_string()))?;
            let value = quick_xml::escape::unescape(&attribute.value)
                .map_err(|error| malformed(&place, error.to_string()))?;
            attributes.push((
                attribute.key.local_name().as_ref().to_owned(),
                value.into_owned(),
            ));
        }
        Ok(Self {
            name: node.local_name().as_ref().to_owned(),
            attributes,
            place,
        })
    }

    fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| value.as_str())
    }

    fn number<T: std::str::FromStr>(&self, name: &str) -> Result<T, Error> {
        let value = self.get(name).and_then(|value| value.trim().parse().ok());
        value.ok_or_else(|| self.fault(format!("<{}> needs a number `{name}`", self.name)))
    }

    fn optional<T: std::str::FromStr>(&self, name: &str) -> Result<Option<T>, Error> {
        match self.get(name) {
            Some(_) => self.number(name).map(Some),
            None => Ok(None),
        }
    }

    /// Rows of a matrix for row vectors, the last the offset.
    fn transform(&self) -> Result<DAffine3, Error> {
        let Some(text) = self.get("transform") else {
            return Ok(DAffine3::IDENTITY);
        };
        let numbers = text.split_ascii_whitespace().map(str::parse::<f64>);
        let numbers: Vec<f64> = numbers.map_while(Result::ok).collect();
        match numbers.as_slice() {
            &[a, b, c, d, e, f, g, h, i, x, y, z] if numbers.iter().all(|n| n.is_finite()) => {
                let matrix = DMat3::from_cols_array(&[a, b, c, d, e, f, g, h, i]);
                Ok(DAffine3::from_mat3_translation(matrix, DVec3::new(x, y, z)))
            }
            _ => Err(self.fault("a transform needs twelve finite numbers".to_owned())),
        }
    }

    fn fault(&self, problem: String) -> Error {
        malformed(&self.place, problem)
    }
}

/// What is on a triangle: which entry of which group.
type Property = Option<(u32, usize)>;

#[derive(Default)]
struct Object {
    name: Option<String>,
    /// For triangles that name none themselves.
    property: Property,
    vertices: Vec<DVec3>,
    triangles: Vec<([u32; 3], Property)>,
    components: Vec<(u32, DAffine3)>,
    /// With those of components.
    count: usize,
}

/// What was read so far.
#[derive(Default)]
struct Model {
    unit: LengthUnit,
    colors: FxHashMap<u32, Vec<Option<Color>>>,
    objects: FxHashMap<u32, Object>,
    items: Vec<(u32, DAffine3)>,
}

impl Model {
    fn read(mut self, file: impl BufRead, path: &str) -> Result<Assembled, Error> {
        let mut xml = Reader::from_reader(file);
        let mut buffer = Vec::new();
        let (mut group, mut object, mut depth) = (0, None, 0_u32);
        loop {
            buffer.clear();
            let at = xml.buffer_position();
            let event = xml.read_event_into(&mut buffer);
            match event
                .map_err(|error| malformed(format!("{path}, byte {at}"), error.to_string()))?
            {
                event @ (Event::Start(_) | Event::Empty(_)) => {
                    let (node, opens) = match &event {
                        Event::Start(node) => (node, 1),
                        Event::Empty(node) => (node, 0),
                        _ => continue,
                    };
                    depth += opens;
                    let node = Node::of(node, path, at)?;
                    self.node(&node, &mut group, &mut object)?;
                }
                Event::End(end) => {
                    depth = depth.saturating_sub(1);
                    if end.local_name().as_ref() == "object"
                        && let Some((id, object)) = object.take()
                    {
                        self.objects.insert(id, object);
                    }
                }
                Event::Eof if depth > 0 => {
                    let problem = "it ends within an element: it may have been cut off";
                    return Err(malformed(format!("{path}, byte {at}"), problem));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        self.build()
    }

    fn node(
        &mut self,
        node: &Node,
        group: &mut u32,
        object: &mut Option<(u32, Object)>,
    ) -> Result<(), Error> {
        match (node.name.as_str(), object) {
            ("model", _) => self.unit = unit(node)?,
            ("basematerials" | "colorgroup", _) => {
                *group = node.number("id")?;
                self.colors.insert(*group, Vec::new());
            }
            ("base", _) => self.color(node, *group, "displaycolor"),
            ("color", _) => self.color(node, *group, "color"),
            ("object", slot) => {
                let property = property(node.optional("pid")?, node.optional("pindex")?);
                let name = node.get("name").filter(|name| !name.is_empty());
                let name = name.map(str::to_owned);
                let started = Object {
                    name,
                    property,
                    ..Object::default()
                };
                *slot = Some((node.number("id")?, started));
            }
            ("vertex", Some((_, object))) => {
                let place = DVec3::new(node.number("x")?, node.number("y")?, node.number("z")?);
                if !place.is_finite() {
                    return Err(node.fault("a vertex is not finite".to_owned()));
                }
                object.vertices.push(place);
            }
            ("triangle", Some((_, object))) => {
                let corners = [node.number("v1")?, node.number("v2")?, node.number("v3")?];
                let count = object.vertices.len();
                if let Some(bad) = corners
                    .iter()
                    .find(|&&corner: &&u32| corner as usize >= count)
                {
                    let problem = format!("it names vertex {bad}, but there are only {count}");
                    return Err(node.fault(problem));
                }
                let own = match (node.optional("pid")?, node.optional("p1")?) {
                    (None, None) => object.property,
                    (None, index) => property(object.property.map(|(group, _)| group), index),
                    (group, index) => property(group, index),
                };
                object.triangles.push((corners, own));
                object.count += 1;
            }
            ("component", Some((_, object))) => {
                let id = node.number("objectid")?;
                let count = self.known(node, id)?.count;
                object.count = object.count.saturating_add(count);
                if object.count > MOST_TRIANGLES {
                    return Err(node.fault("its components have too many triangles".to_owned()));
                }
                object.components.push((id, node.transform()?));
            }
            ("item", _) => {
                let id = node.number("objectid")?;
                self.known(node, id)?;
                self.items.push((id, node.transform()?));
            }
            _ => {}
        }
        Ok(())
    }

    /// An object that is there already: so none is a part of itself.
    fn known(&self, node: &Node, id: u32) -> Result<&Object, Error> {
        let object = self.objects.get(&id);
        object.ok_or_else(|| node.fault(format!("there is no object {id} before it")))
    }

    fn color(&mut self, node: &Node, group: u32, attribute: &str) {
        let color = node.get(attribute).and_then(color);
        self.colors.entry(group).or_default().push(color);
    }

    fn build(self) -> Result<Assembled, Error> {
        let mut assembler = Assembler::new(self.unit);
        let total = self.items.iter().map(|(id, _)| self.objects[id].count);
        if total.fold(0, usize::saturating_add) > MOST_TRIANGLES {
            return Err(malformed("the build", "its items have too many triangles"));
        }
        let items = self.items.iter().rev();
        let mut waiting: Vec<(u32, DAffine3, usize)> =
            items.map(|&(id, place)| (id, place, 0)).collect();
        let mut names: Vec<&str> = Vec::new();
        while let Some((id, place, depth)) = waiting.pop() {
            let object = &self.objects[&id];
            names.truncate(depth);
            // One straight within the same is that one.
            let name = object.name.as_deref();
            names.extend(name.filter(|name| names.last() != Some(name)));
            self.put((object, &names), place, &mut assembler)?;
            let parts = object.components.iter().rev();
            waiting.extend(parts.map(|&(part, within)| (part, place * within, names.len())));
        }
        Ok(assembler.finish())
    }

    fn put(
        &self,
        (object, names): (&Object, &[&str]),
        place: DAffine3,
        to: &mut Assembler,
    ) -> Result<(), Error> {
        let mut first = None;
        for &vertex in &object.vertices {
            let vertex = to.vertex(place.transform_point3(vertex));
            let vertex = vertex.ok_or_else(|| {
                malformed("the build", "a vertex is not finite, or there are too many")
            })?;
            first.get_or_insert(vertex);
        }
        let first = first.unwrap_or_default();
        to.begin_object();
        // What is mirrored is turned over.
        let is_mirrored = place.matrix3.determinant() < 0.0;
        let mut before = None;
        for &(corners, property) in &object.triangles {
            if before != Some(property) {
                let color = property.and_then(|(group, index)| {
                    self.colors.get(&group)?.get(index).copied().flatten()
                });
                to.begin_part(names, color);
                before = Some(property);
            }
            let [a, b, c] = corners.map(|corner| first + corner);
            to.triangle(if is_mirrored { [a, c, b] } else { [a, b, c] }, None);
        }
        Ok(())
    }
}

fn property(group: Option<u32>, index: Option<usize>) -> Property {
    group.zip(index)
}

fn unit(node: &Node) -> Result<LengthUnit, Error> {
    Ok(match node.get("unit") {
        Some("micron") => LengthUnit::Micrometre,
        None | Some("millimeter") => LengthUnit::Millimetre,
        Some("centimeter") => LengthUnit::Centimetre,
        Some("meter") => LengthUnit::Metre,
        Some("inch") => LengthUnit::Inch,
        Some("foot") => LengthUnit::Foot,
        Some(other) => {
            let known = "micron, millimeter, centimeter, meter, inch or foot";
            return Err(node.fault(format!("its unit is {other}, and not {known}")));
        }
    })
}

/// `#RRGGBB` or `#RRGGBBAA`, sRGB.
fn color(text: &str) -> Option<Color> {
    let digits = text.trim().strip_prefix('#')?;
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let byte = |k: usize| u8::from_str_radix(digits.get(2 * k..2 * k + 2)?, 16).ok();
    let [r, g, b] = [byte(0)?, byte(1)?, byte(2)?].map(|byte| f32::from(byte) / 255.0);
    let alpha = byte(3).map_or(1.0, |byte| f32::from(byte) / 255.0);
    Some(Color::from_srgb([r, g, b]).with_alpha(alpha))
}
