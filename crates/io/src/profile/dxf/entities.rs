//! Entities: what their group codes say (Autodesk, *DXF Reference*).

use std::f64::consts::TAU;

use csg::elementary;
use glam::{DAffine2, DMat2, DVec2};

use super::super::curves::{Outline, Side, direction};
use super::super::warnings::Warnings;
use super::spline::Spline;
use super::tags::{Tag, Tags};
use super::{MOST_SIDES, fault};
use crate::Error;

/// A normal is that of the drawing's plane if its direction is off by no more.
const UPRIGHT: f64 = 1e-9;
/// Angles that are a whole turn but for rounding, in radians.
const WHOLE: f64 = 1e-9;

/// The tags of one entity.
#[derive(Default)]
pub(super) struct Entity<'a> {
    pub(super) kind: &'a str,
    pub(super) line: usize,
    tags: Vec<Tag<'a>>,
}

/// What an entity is.
pub(super) struct Item {
    pub(super) layer: String,
    pub(super) line: usize,
    pub(super) content: Content,
}

pub(super) enum Content {
    Closed(Outline),
    Open(Outline),
    Insert(Insert),
}

/// Copies of a block in rows and columns.
pub(super) struct Insert {
    pub(super) block: String,
    /// Where the first one is.
    map: DAffine2,
    counts: [i64; 2],
    steps: DVec2,
}

impl Insert {
    pub(super) fn places(&self) -> impl Iterator<Item = DAffine2> {
        let [columns, rows] = self.counts;
        let (map, steps) = (self.map, self.steps);
        // (Steps are turned with it, but not scaled.)
        let lean = map.matrix2.x_axis.normalize_or(DVec2::X);
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| {
                let step = steps * DVec2::new(column as f64, row as f64);
                DAffine2::from_translation(lean.rotate(step)) * map
            })
        })
    }
}

impl<'a> Entity<'a> {
    /// Reads the next one; whether there is one.
    pub(super) fn read(&mut self, tags: &mut Tags<'a>) -> Result<bool, Error> {
        self.tags.clear();
        let Some(first) = tags.next()? else {
            return Ok(false);
        };
        if first.code != 0 {
            let problem = format!(
                "group 0 should be here, not {}: is it a DXF file?",
                first.code
            );
            return Err(fault(first.line - 1, problem));
        }
        (self.kind, self.line) = (first.value, first.line);
        while let Some(tag) = tags.next()? {
            if tag.code == 0 {
                tags.back(tag);
                break;
            }
            self.tags.push(tag);
        }
        Ok(true)
    }

    fn first(&self, code: i32) -> Option<&Tag<'a>> {
        self.tags.iter().find(|tag| tag.code == code)
    }

    pub(super) fn text(&self, code: i32) -> Option<&'a str> {
        self.first(code).map(|tag| tag.value)
    }

    fn number(&self, code: i32) -> Result<Option<f64>, Error> {
        self.first(code).map(Tag::number).transpose()
    }

    fn flags(&self, code: i32) -> Result<i64, Error> {
        Ok(self.first(code).map(Tag::whole).transpose()?.unwrap_or(0))
    }

    /// The point of a code, whose y has one that is 10 more.
    pub(super) fn point(&self, code: i32) -> Result<Option<DVec2>, Error> {
        let [x, y] = [self.number(code)?, self.number(code + 10)?];
        Ok(x.zip(y).map(|(x, y)| DVec2::new(x, y)))
    }

    fn needed<T>(&self, value: Option<T>, what: &str) -> Result<T, Error> {
        value.ok_or_else(|| fault(self.line, format!("{} has no {what}", self.kind)))
    }

    /// A number above 0.
    fn size(&self, code: i32, what: &str) -> Result<f64, Error> {
        let size = self.needed(self.number(code)?, what)?;
        if size > 0.0 {
            return Ok(size);
        }
        Err(fault(
            self.line,
            format!("{}: its {what} is {size}: it must be above 0", self.kind),
        ))
    }

    /// Points of a code in their order.
    fn points(&self, code: i32) -> Result<Vec<DVec2>, Error> {
        let mut points: Vec<DVec2> = Vec::new();
        for tag in &self.tags {
            if tag.code == code {
                points.push(DVec2::new(tag.number()?, 0.0));
            } else if tag.code == code + 10
                && let Some(last) = points.last_mut()
            {
                last.y = tag.number()?;
            }
        }
        Ok(points)
    }

    /// What it is, if it is drawn and can be read; the vertices of a polyline are taken from `tags`.
    pub(super) fn item(
        &mut self,
        tags: &mut Tags<'a>,
        warnings: &mut Warnings,
    ) -> Result<Option<Item>, Error> {
        let (kind, line) = (self.kind, self.line);
        let mut left_out = |problem: String| {
            warnings.add(|| format!("line {line}"), problem);
            Ok(None)
        };
        let layer = self.text(8).unwrap_or("0").to_owned();
        let is_hidden = self.flags(60)? & 1 != 0;
        if self.flags(67)? == 1 {
            return left_out("what is on paper, not in the model, is left out".to_owned());
        }
        let normal = [210, 220, 230].map(|code| self.number(code));
        let [x, y, z] = normal;
        let normal = [x?.unwrap_or(0.0), y?.unwrap_or(0.0), z?.unwrap_or(1.0)];
        let content = match kind {
            "LINE" => {
                let from = self.needed(self.point(10)?, "start")?;
                let to = self.needed(self.point(11)?, "end")?;
                let mut outline = Outline::from(from);
                outline.push(Side::Line, to);
                Some(Content::Open(outline))
            }
            "CIRCLE" | "ARC" => Some(self.arc()?),
            "ELLIPSE" => Some(self.ellipse()?),
            "LWPOLYLINE" => self.light_polyline()?,
            "POLYLINE" => {
                let flags = self.flags(70)?;
                let content = self.polyline(tags)?;
                if flags & (16 | 64) != 0 {
                    return left_out("POLYLINE of a mesh is left out".to_owned());
                }
                content
            }
            "SPLINE" => match self.spline()? {
                Some(content) => Some(content),
                None => return left_out("SPLINE without control points is left out".to_owned()),
            },
            "INSERT" => Some(Content::Insert(self.insert()?)),
            // (Ends of lists, and of what an INSERT has.)
            "SEQEND" | "ATTRIB" | "VERTEX" => None,
            _ if is_hidden => None,
            _ => {
                let kind: String = kind.chars().take(40).collect();
                return left_out(format!("{kind} is left out: it is not read"));
            }
        };
        let Some(mut content) = content.filter(|_| !is_hidden) else {
            return Ok(None);
        };
        // Seen from below x points the other way, but for what is told in the model's coordinates.
        let is_of_model = matches!(kind, "LINE" | "ELLIPSE" | "SPLINE");
        let [x, y, z] = normal;
        let is_flat = x.abs().max(y.abs()) <= UPRIGHT * z.abs();
        if !is_flat && kind != "LINE" {
            return left_out(format!(
                "{kind} that is not in the drawing's plane is left out"
            ));
        }
        if z < 0.0 && !is_of_model {
            let mirror = DAffine2::from_scale(DVec2::new(-1.0, 1.0));
            match &mut content {
                Content::Closed(outline) | Content::Open(outline) => {
                    *outline = outline.mapped(&mirror);
                }
                Content::Insert(insert) => {
                    // (Of the steps, too, as they are turned by what is mirrored.)
                    insert.map = mirror * insert.map;
                    insert.steps.y = -insert.steps.y;
                }
            }
        }
        Ok(Some(Item {
            layer,
            line,
            content,
        }))
    }

    fn arc(&self) -> Result<Content, Error> {
        let center = self.needed(self.point(10)?, "centre")?;
        let radius = self.size(40, "radius")?;
        if self.kind == "CIRCLE" {
            return Ok(Content::Closed(circle(center, radius)));
        }
        let from = self.needed(self.number(50)?, "start angle")?;
        let to = self.needed(self.number(51)?, "end angle")?;
        let sweep = (to - from).rem_euclid(360.0);
        // (A whole one ends where it begins.)
        if sweep == 0.0 {
            return Ok(Content::Closed(circle(center, radius)));
        }
        let at = |degrees: f64| center + radius * direction(degrees);
        let mut outline = Outline::from(at(from));
        // The tangent of a quarter of the angle grows without end for a whole turn.
        let parts = if sweep > 180.0 { 2 } else { 1 };
        for k in 1..=parts {
            let share = f64::from(k) / f64::from(parts);
            let end = if k == parts {
                at(to)
            } else {
                at(from + share * sweep)
            };
            let bulge = elementary::tan((sweep / f64::from(4 * parts)).to_radians());
            outline.push(Side::Arc { bulge }, end);
        }
        Ok(Content::Open(outline))
    }

    fn ellipse(&self) -> Result<Content, Error> {
        let center = self.needed(self.point(10)?, "centre")?;
        let long = self.needed(self.point(11)?, "end of the major axis")?;
        let ratio = self.size(40, "ratio of the axes")?;
        let from = self.number(41)?.unwrap_or(0.0);
        let to = self.number(42)?.unwrap_or(TAU);
        if long == DVec2::ZERO {
            return Err(fault(self.line, "ELLIPSE: its major axis has no length"));
        }
        let side = if self.number(230)?.unwrap_or(1.0) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let axes = [long, side * ratio * long.perp()];
        let sweep = match (to - from).rem_euclid(TAU) {
            sweep if sweep <= WHOLE || sweep >= TAU - WHOLE => TAU,
            sweep => sweep,
        };
        if sweep == TAU && ratio == 1.0 {
            return Ok(Content::Closed(circle(center, long.length())));
        }
        let at = |t: f64| {
            let direction = elementary::direction(t);
            center + direction.x * axes[0] + direction.y * axes[1]
        };
        let mut outline = Outline::from(at(from));
        let end = if sweep == TAU { outline.start } else { at(to) };
        outline.push(
            Side::Ellipse {
                center,
                axes,
                from,
                sweep,
            },
            end,
        );
        Ok(if sweep == TAU {
            Content::Closed(outline)
        } else {
            Content::Open(outline)
        })
    }

    fn light_polyline(&self) -> Result<Option<Content>, Error> {
        let mut corners: Vec<(DVec2, f64)> = Vec::new();
        for tag in &self.tags {
            match (tag.code, corners.last_mut()) {
                (10, _) => corners.push((DVec2::new(tag.number()?, 0.0), 0.0)),
                (20, Some(last)) => last.0.y = tag.number()?,
                (42, Some(last)) => last.1 = tag.number()?,
                _ => {}
            }
        }
        Ok(polyline(&corners, self.flags(70)? & 1 != 0))
    }

    /// Takes its vertices from the tags.
    fn polyline(&self, tags: &mut Tags<'a>) -> Result<Option<Content>, Error> {
        let mut corners = Vec::new();
        let mut vertex = Entity::default();
        loop {
            let Some(ahead) = tags.next()? else {
                return Err(fault(
                    self.line,
                    "POLYLINE has no SEQEND: the file is cut off",
                ));
            };
            tags.back(ahead);
            match ahead.value {
                "VERTEX" | "SEQEND" => vertex.read(tags)?,
                other => {
                    let problem = format!(
                        "POLYLINE of line {} has no SEQEND before {other:?}",
                        self.line
                    );
                    return Err(fault(ahead.line, problem));
                }
            };
            if vertex.kind == "SEQEND" {
                break;
            }
            // (Those of the frame of a spline are not on it.)
            if vertex.flags(70)? & 16 == 0 {
                let point = vertex.needed(vertex.point(10)?, "place")?;
                corners.push((point, vertex.number(42)?.unwrap_or(0.0)));
            }
            if corners.len() > MOST_SIDES {
                return Err(fault(
                    vertex.line,
                    format!("POLYLINE has more than {MOST_SIDES} sides"),
                ));
            }
        }
        Ok(polyline(&corners, self.flags(70)? & 1 != 0))
    }

    fn spline(&self) -> Result<Option<Content>, Error> {
        let points = self.points(10)?;
        if points.is_empty() {
            return Ok(None);
        }
        let numbers = |code: i32| -> Result<Vec<f64>, Error> {
            let tags = self.tags.iter().filter(|tag| tag.code == code);
            tags.map(Tag::number).collect()
        };
        let degree = self.needed(self.first(71), "degree")?.whole()?;
        let spline = Spline::of(degree, numbers(40)?, &points, &numbers(41)?);
        let spline = spline.map_err(|problem| fault(self.line, format!("SPLINE: {problem}")))?;
        let outline = spline.outline();
        Ok(Some(if outline.start == outline.end() {
            Content::Closed(outline)
        } else {
            Content::Open(outline)
        }))
    }

    fn insert(&self) -> Result<Insert, Error> {
        let block = self.needed(self.text(2), "block")?.to_owned();
        let at = self.point(10)?.unwrap_or_default();
        let lean = direction(self.number(50)?.unwrap_or(0.0));
        let scale = DVec2::new(
            self.number(41)?.unwrap_or(1.0),
            self.number(42)?.unwrap_or(1.0),
        );
        let turn = DMat2::from_cols(lean, lean.perp());
        let counts = [self.flags(70)?.max(1), self.flags(71)?.max(1)];
        let steps = DVec2::new(
            self.number(44)?.unwrap_or(0.0),
            self.number(45)?.unwrap_or(0.0),
        );
        let negative = scale.x < 0.0;
        Ok(Insert {
            block,
            map: DAffine2 {
                matrix2: turn * DMat2::from_diagonal(scale),
                translation: at,
            },
            counts,
            steps: if negative { -steps } else { steps },
        })
    }
}

fn circle(center: DVec2, radius: f64) -> Outline {
    let [right, left] = [radius, -radius].map(|x| center + x * DVec2::X);
    let mut outline = Outline::from(right);
    outline.push(Side::Arc { bulge: 1.0 }, left);
    outline.push(Side::Arc { bulge: 1.0 }, right);
    outline
}

fn polyline(corners: &[(DVec2, f64)], is_closed: bool) -> Option<Content> {
    let (&(first, _), &(last, _)) = (corners.first()?, corners.last()?);
    let mut outline = Outline::from(first);
    let next = corners.iter().skip(1).map(|(point, _)| *point);
    let next = next.chain(is_closed.then_some(first));
    for (&(_, bulge), end) in corners.iter().zip(next) {
        let side = if bulge == 0.0 {
            Side::Line
        } else {
            Side::Arc { bulge }
        };
        outline.push(side, end);
    }
    if outline.sides.is_empty() {
        return None;
    }
    Some(if is_closed || first == last && corners.len() > 2 {
        Content::Closed(outline)
    } else {
        Content::Open(outline)
    })
}
