//! Drawing exchange format, as text: group codes, entities, and contours of what meets.

mod chains;
mod entities;
mod spline;
mod tags;

use std::collections::HashMap;

use csg::FillRule;
use glam::{DAffine2, DVec2};

use self::chains::contours;
use self::entities::{Content, Entity, Insert, Item};
use self::tags::Tags;
use super::curves::Outline;
use super::warnings::Warnings;
use super::{Figure, MOST_SIDES, ProfileOptions, Step, malformed};
use crate::Error;
use crate::drawing::DrawingFormat;

/// Blocks may lie in each other so deep.
const DEEPEST: usize = 32;

fn fault(line: usize, problem: impl Into<String>) -> Error {
    malformed(DrawingFormat::Dxf, format!("line {line}"), problem)
}

/// What a `BLOCK` holds.
#[derive(Default)]
struct Block {
    base: DVec2,
    items: Vec<Item>,
}

/// What contours enclose by the even-odd rule.
pub(super) fn steps(
    data: &[u8],
    options: &ProfileOptions,
    warnings: &mut Warnings,
) -> Result<Vec<Step>, Error> {
    if data.starts_with(b"AutoCAD Binary DXF") {
        return Err(fault(1, "it is a binary DXF file: save it as text (ASCII)"));
    }
    // (Numbers and names of layers are all that is wanted of it.)
    let text = String::from_utf8_lossy(data);
    let (items, blocks) = sections(&text, warnings)?;
    let layer = options.layer.as_deref().filter(|layer| !layer.is_empty());
    if options.id.as_deref().is_some_and(|id| !id.is_empty()) {
        warnings.add(
            || "the drawing".to_owned(),
            "its entities have no `id` to be selected by".to_owned(),
        );
    }
    let chosen = |item: &&Item| layer.is_none_or(|layer| item.layer == layer);
    if let Some(layer) = layer
        && !items.iter().any(|item| item.layer == layer)
    {
        let mut layers: Vec<&str> = items.iter().map(|item| item.layer.as_str()).collect();
        layers.sort_unstable();
        layers.dedup();
        let problem = format!(
            "nothing is on layer {layer:?}; there are {}",
            layers.join(", ")
        );
        warnings.add(|| "the drawing".to_owned(), problem);
    }
    let mut drawing = Expanded {
        blocks: &blocks,
        budget: MOST_SIDES,
        closed: Vec::new(),
        open: Vec::new(),
        warnings,
    };
    let map = DAffine2::from_scale_angle_translation(
        DVec2::splat(options.scale),
        0.0,
        -options.scale * options.origin,
    );
    for item in items.iter().filter(chosen) {
        drawing.add(item, &map, 0)?;
    }
    let Expanded { closed, open, .. } = drawing;
    let outlines = contours(closed, open, warnings);
    let figure = Figure::Contours(outlines, FillRule::EvenOdd);
    Ok(vec![Step::added(figure)])
}

/// The items of the entities' section, and the blocks by their names.
fn sections(
    text: &str,
    warnings: &mut Warnings,
) -> Result<(Vec<Item>, HashMap<String, Block>), Error> {
    let mut tags = Tags::of(text);
    let mut items = Vec::new();
    let mut blocks: HashMap<String, Block> = HashMap::new();
    let mut section = String::new();
    let mut block: Option<(String, Block)> = None;
    let mut has_entities = false;
    let mut entity = Entity::default();
    let mut count = 0;
    while entity.read(&mut tags)? {
        match (section.as_str(), entity.kind) {
            (_, "EOF") => break,
            (_, "SECTION") => {
                section = entity.text(2).unwrap_or("").to_owned();
                has_entities |= section == "ENTITIES";
            }
            (_, "ENDSEC") => section.clear(),
            ("BLOCKS", "BLOCK") => {
                let name = entity.text(2).unwrap_or("").to_owned();
                let base = entity.point(10)?.unwrap_or_default();
                block = Some((
                    name,
                    Block {
                        base,
                        items: Vec::new(),
                    },
                ));
            }
            ("BLOCKS", "ENDBLK") => {
                if let Some((name, block)) = block.take() {
                    blocks.insert(name, block);
                }
            }
            ("BLOCKS" | "ENTITIES", _) => {
                count += 1;
                if count > MOST_SIDES {
                    return Err(fault(
                        entity.line,
                        format!("there are more than {MOST_SIDES} entities"),
                    ));
                }
                let item = entity.item(&mut tags, warnings)?;
                let into = match &mut block {
                    Some((_, block)) => &mut block.items,
                    None => &mut items,
                };
                into.extend(item);
            }
            _ => {}
        }
    }
    if !has_entities {
        return Err(fault(
            tags.line(),
            "there is no section ENTITIES: is it a DXF file, and whole?",
        ));
    }
    if section == "ENTITIES" {
        return Err(fault(
            tags.line(),
            "the section ENTITIES does not end: the file is cut off",
        ));
    }
    Ok((items, blocks))
}

/// Entities with blocks put where they are inserted.
struct Expanded<'a> {
    blocks: &'a HashMap<String, Block>,
    /// Sides and copies that may still come.
    budget: usize,
    closed: Vec<Outline>,
    open: Vec<Outline>,
    warnings: &'a mut Warnings,
}

impl Expanded<'_> {
    fn add(&mut self, item: &Item, map: &DAffine2, depth: usize) -> Result<(), Error> {
        let line = item.line;
        let spent = match &item.content {
            Content::Closed(outline) | Content::Open(outline) => outline.sides.len(),
            Content::Insert(_) => 1,
        };
        self.budget = self.budget.checked_sub(spent).ok_or_else(|| {
            fault(
                line,
                format!("with it there are more than {MOST_SIDES} sides, copies included"),
            )
        })?;
        match &item.content {
            Content::Closed(outline) => self.closed.push(outline.mapped(map)),
            Content::Open(outline) => self.open.push(outline.mapped(map)),
            Content::Insert(insert) => self.insert(insert, line, map, depth)?,
        }
        Ok(())
    }

    fn insert(
        &mut self,
        insert: &Insert,
        line: usize,
        map: &DAffine2,
        depth: usize,
    ) -> Result<(), Error> {
        let name = &insert.block;
        let Some(block) = self.blocks.get(name) else {
            self.warnings.add(
                || format!("line {line}"),
                format!("there is no block {name:?} to insert"),
            );
            return Ok(());
        };
        if depth >= DEEPEST {
            let problem =
                format!("the block {name:?} is inserted {DEEPEST} deep: does it insert itself?");
            return Err(fault(line, problem));
        }
        for place in insert.places() {
            let map = *map * place * DAffine2::from_translation(-block.base);
            if !map.is_finite() || map.matrix2.determinant() == 0.0 {
                let problem = format!(
                    "the block {name:?} is inserted with a scale of 0 or too large: it is left out"
                );
                self.warnings.add(|| format!("line {line}"), problem);
                return Ok(());
            }
            for item in &block.items {
                self.add(item, &map, depth + 1)?;
            }
            self.budget = self.budget.checked_sub(1).ok_or_else(|| {
                fault(
                    line,
                    format!("with it there are more than {MOST_SIDES} copies"),
                )
            })?;
        }
        Ok(())
    }
}
