//! Scalable Vector Graphics: the elements that have an area.

mod elements;
mod page;
mod path;
mod selection;

use std::collections::HashMap;

use csg::FillRule;
use glam::{DAffine2, DVec2};
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{TransformListParser, TransformListToken};

use self::elements::Shape;
use self::page::View;
use self::selection::{State, property};
use super::curves::{Outline, direction};
use super::warnings::Warnings;
use super::{Figure, MOST_SIDES, ProfileOptions, Step, malformed};
use crate::Error;
use crate::drawing::DrawingFormat;

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";
/// Elements may lie in each other, and copies in copies, so deep.
const DEEPEST: usize = 128;
/// The most bytes that entities may come to.
const MOST_EXPANDED: usize = 1 << 28;

/// The figures of a document, in its order.
pub(super) fn steps(
    data: &[u8],
    options: &ProfileOptions,
    warnings: &mut Warnings,
) -> Result<Vec<Step>, Error> {
    let bad = |place: String, problem: String| malformed(DrawingFormat::Svg, place, problem);
    let text = std::str::from_utf8(data).map_err(|e| {
        let line = 1 + data[..e.valid_up_to()]
            .iter()
            .filter(|&&b| b == b'\n')
            .count();
        bad(
            format!("line {line}"),
            "the text is not UTF-8 from here on: save it as UTF-8".to_owned(),
        )
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // An entity's value may name 255 others at most, each of which is shorter than the declarations.
    if let Some(last) = text.rfind("<!ENTITY") {
        let first = text.find("<!ENTITY").unwrap_or(last);
        let declared = last - first + text[last..].find('>').unwrap_or(0);
        let named = text.matches('&').count();
        if declared.saturating_mul(named).saturating_mul(255) > MOST_EXPANDED {
            let problem = "its entities may come to more than 256 MiB: write them out";
            return Err(bad("the document type".to_owned(), problem.to_owned()));
        }
    }
    let parsing = ParsingOptions {
        allow_dtd: true,
        nodes_limit: MOST_SIDES as u32,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, parsing).map_err(|e| {
        let pos = e.pos();
        bad(format!("line {}", pos.row), format!("it is not XML: {e}"))
    })?;
    let root = document.root_element();
    let mut reader = Reader {
        document: &document,
        options,
        warnings,
        ids: HashMap::new(),
        using: Vec::new(),
        budget: MOST_SIDES,
        reference: DVec2::ZERO,
        steps: Vec::new(),
        has_match: false,
    };
    if !reader.is_known(root) || root.tag_name().name() != "svg" {
        return Err(reader.fault(root, "it should be an `svg` element"));
    }
    for node in document.descendants() {
        if let Some(id) = node.attribute("id") {
            reader.ids.entry(id).or_insert(node);
        }
    }
    let (map, reference) = reader.page(root)?;
    reader.reference = reference;
    let whole = State::root(options);
    let state = whole.within(root, options);
    reader.has_match = whole.is_match || state.is_match;
    reader.children(root, map, &state, 0)?;
    if !reader.has_match {
        let wanted = [("id", &options.id), ("layer", &options.layer)];
        let wanted = wanted
            .iter()
            .filter_map(|(key, value)| Some(format!("{key} {:?}", value.as_ref()?)));
        let wanted = wanted.collect::<Vec<_>>().join(" and ");
        reader.warnings.add(
            || "the drawing".to_owned(),
            format!("no element has the {wanted}"),
        );
    }
    Ok(reader.steps)
}

struct Reader<'a, 'input> {
    document: &'a Document<'input>,
    options: &'a ProfileOptions,
    warnings: &'a mut Warnings,
    ids: HashMap<&'a str, Node<'a, 'input>>,
    /// What is being copied.
    using: Vec<Node<'a, 'input>>,
    /// Elements and sides that may still come.
    budget: usize,
    /// What percentages are of.
    reference: DVec2,
    steps: Vec<Step>,
    has_match: bool,
}

impl<'a, 'input> Reader<'a, 'input> {
    fn place(document: &Document<'input>, node: Node<'_, '_>) -> String {
        let line = document.text_pos_at(node.range().start).row;
        let name = node.tag_name().name();
        match node.attribute("id") {
            Some(id) => format!("line {line}, <{name} id={id:?}>"),
            None => format!("line {line}, <{name}>"),
        }
    }

    fn fault(&self, node: Node<'_, '_>, problem: &str) -> Error {
        malformed(
            DrawingFormat::Svg,
            Self::place(self.document, node),
            problem,
        )
    }

    fn warn(&mut self, node: Node<'_, '_>, problem: impl Into<String>) {
        let document = self.document;
        self.warnings
            .add(|| Self::place(document, node), problem.into());
    }

    fn spend(&mut self, node: Node<'_, '_>, count: usize) -> Result<(), Error> {
        self.budget = self.budget.checked_sub(count).ok_or_else(|| {
            let problem = format!(
                "with it there are more than {MOST_SIDES} elements and sides, copies included"
            );
            self.fault(node, &problem)
        })?;
        Ok(())
    }

    /// Whether an element is one of the format, which some files do not name.
    fn is_known(&self, node: Node<'_, '_>) -> bool {
        matches!(node.tag_name().namespace(), None | Some(SVG))
    }

    fn children(
        &mut self,
        node: Node<'a, 'input>,
        map: DAffine2,
        state: &State,
        depth: usize,
    ) -> Result<(), Error> {
        for child in node.children().filter(Node::is_element) {
            self.element(child, map, state, depth)?;
        }
        Ok(())
    }

    fn element(
        &mut self,
        node: Node<'a, 'input>,
        map: DAffine2,
        around: &State,
        depth: usize,
    ) -> Result<(), Error> {
        if !self.is_known(node) {
            return Ok(());
        }
        if depth >= DEEPEST {
            let problem = format!("elements lie more than {DEEPEST} deep in each other");
            return Err(self.fault(node, &problem));
        }
        self.spend(node, 1)?;
        let name = node.tag_name().name();
        match name {
            "g" | "a" | "switch" | "svg" | "use" | "path" | "rect" | "circle" | "ellipse"
            | "polygon" | "polyline" | "line" => {}
            "text" | "image" | "foreignObject" => {
                if around.within(node, self.options).is_shown() {
                    self.warn(node, format!("`{name}` is left out: convert it to paths"));
                }
                return Ok(());
            }
            "style"
                if ["display", "visibility"].iter().any(|key| {
                    node.descendants()
                        .filter_map(|n| n.text())
                        .any(|text| text.contains(key))
                }) =>
            {
                self.warn(node, "style sheets are passed over: what they hide is read");
                return Ok(());
            }
            // Definitions, descriptions and what is not of the standard.
            _ => return Ok(()),
        }
        let state = around.within(node, self.options);
        self.has_match |= state.is_match;
        let map = map * self.transform(node)?;
        for key in ["clip-path", "mask"] {
            if property(node, key).is_some_and(|value| value != "none") && state.is_shown() {
                self.warn(
                    node,
                    format!("`{key}` is passed over: the whole element is read"),
                );
            }
        }
        match name {
            "g" | "a" | "switch" => self.children(node, map, &state, depth + 1),
            "svg" => {
                let map = map * self.inner_view(node, node)?;
                self.children(node, map, &state, depth + 1)
            }
            "use" => self.copy(node, map, &state, depth + 1),
            _ => self.shape(node, map, &state),
        }
    }

    /// What a `use` stands for.
    fn copy(
        &mut self,
        node: Node<'a, 'input>,
        map: DAffine2,
        state: &State,
        depth: usize,
    ) -> Result<(), Error> {
        let href = node
            .attribute("href")
            .or_else(|| node.attribute((XLINK, "href")));
        let Some(id) = href.and_then(|href| href.strip_prefix('#')) else {
            self.warn(node, "it is left out: it names no element of this file");
            return Ok(());
        };
        let Some(&target) = self.ids.get(id) else {
            self.warn(
                node,
                format!("it is left out: no element has the id {id:?}"),
            );
            return Ok(());
        };
        if self.using.contains(&target) || node.ancestors().any(|around| around == target) {
            return Err(self.fault(node, "it is a copy of what it is in"));
        }
        let [x, y] = [self.length(node, "x", 0)?, self.length(node, "y", 1)?];
        let map = map * DAffine2::from_translation(DVec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0)));
        self.using.push(target);
        if target.tag_name().name() == "symbol" && self.is_known(target) {
            let map = map * self.transform(target)? * self.inner_view(target, node)?;
            let state = state.within(target, self.options);
            self.has_match |= state.is_match;
            self.children(target, map, &state, depth + 1)?;
        } else {
            self.element(target, map, state, depth)?;
        }
        self.using.pop();
        Ok(())
    }

    fn shape(&mut self, node: Node<'a, 'input>, map: DAffine2, state: &State) -> Result<(), Error> {
        let shape = self.read_shape(node)?;
        if !state.is_shown() {
            return Ok(());
        }
        match shape {
            Shape::Nothing => {}
            Shape::Line => self.warn(node, "strokes are passed over: it has no area"),
            _ if !map.is_finite() || map.matrix2.determinant() == 0.0 => {
                self.warn(
                    node,
                    "its transform is not finite or has no inverse: it is left out",
                );
            }
            Shape::Disc(own) => {
                let disc = Figure::Disc(map * own, Vec::new());
                self.steps.push(Step::added(disc));
            }
            Shape::Contours(contours) => {
                let mut outlines: Vec<Outline> = Vec::with_capacity(contours.len());
                for contour in contours {
                    if contour.is_open && state.has_no_fill {
                        self.warn(node, "an open contour without a filling is left out: strokes are passed over");
                        continue;
                    }
                    if contour.is_open {
                        let (from, to) = (contour.outline.end(), contour.outline.start);
                        let wide = from.distance(to);
                        let document = self.document;
                        let place = || {
                            let place = Self::place(document, node);
                            format!("{place} ({wide} units from {}, {})", from.x, from.y)
                        };
                        let problem = "an open contour is closed by a straight side";
                        self.warnings.add(place, problem.to_owned());
                    }
                    outlines.push(contour.outline.mapped(&map));
                }
                let sides = outlines.iter().map(|outline| outline.sides.len()).sum();
                self.spend(node, sides)?;
                let rule = if state.is_even_odd {
                    FillRule::EvenOdd
                } else {
                    FillRule::NonZero
                };
                self.steps
                    .push(Step::added(Figure::Contours(outlines, rule)));
            }
        }
        Ok(())
    }

    fn transform(&self, node: Node<'_, '_>) -> Result<DAffine2, Error> {
        let Some(text) = node.attribute("transform") else {
            return Ok(DAffine2::IDENTITY);
        };
        let mut map = DAffine2::IDENTITY;
        for token in TransformListParser::from(text) {
            let token = token.map_err(|e| self.fault(node, &format!("its transform: {e}")))?;
            let columns = |columns: [f64; 6]| DAffine2::from_cols_array(&columns);
            map *= match token {
                TransformListToken::Matrix { a, b, c, d, e, f } => columns([a, b, c, d, e, f]),
                TransformListToken::Translate { tx, ty } => {
                    DAffine2::from_translation(DVec2::new(tx, ty))
                }
                TransformListToken::Scale { sx, sy } => DAffine2::from_scale(DVec2::new(sx, sy)),
                TransformListToken::Rotate { angle } => {
                    let DVec2 { x, y } = direction(angle);
                    columns([x, y, -y, x, 0.0, 0.0])
                }
                TransformListToken::SkewX { angle } => {
                    columns([1.0, 0.0, tangent(angle), 1.0, 0.0, 0.0])
                }
                TransformListToken::SkewY { angle } => {
                    columns([1.0, tangent(angle), 0.0, 1.0, 0.0, 0.0])
                }
            };
        }
        Ok(map)
    }

    /// The view of an inner `svg`, or of a `symbol` whose size its copy may tell.
    fn inner_view(&self, node: Node<'_, '_>, sized: Node<'_, '_>) -> Result<DAffine2, Error> {
        let moved = if node == sized {
            let [x, y] = [self.length(node, "x", 0)?, self.length(node, "y", 1)?];
            DAffine2::from_translation(DVec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0)))
        } else {
            DAffine2::IDENTITY
        };
        let Some(view) = View::of(node).map_err(|problem| self.fault(node, &problem))? else {
            return Ok(moved);
        };
        let mut size = view.size;
        for (axis, key) in ["width", "height"].into_iter().enumerate() {
            let own = self.length(node, key, axis)?;
            size[axis] = self
                .length(sized, key, axis)?
                .or(own)
                .unwrap_or(self.reference[axis]);
        }
        Ok(moved * view.fitted(size))
    }
}

fn tangent(degrees: f64) -> f64 {
    let direction = direction(degrees);
    direction.y / direction.x
}
