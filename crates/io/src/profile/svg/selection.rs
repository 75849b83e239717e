//! What is read of a document, and what an element has from those around it.

use roxmltree::Node;

use super::super::ProfileOptions;

const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// What an element has from those around it.
#[derive(Clone, Copy)]
pub(super) struct State {
    /// Whether it, or what it is in, is selected and displayed.
    is_included: bool,
    is_hidden: bool,
    is_in_layer: bool,
    /// Whether it is what was asked for itself.
    pub(super) is_match: bool,
    pub(super) has_no_fill: bool,
    pub(super) is_even_odd: bool,
}

impl State {
    pub(super) fn root(options: &ProfileOptions) -> Self {
        let is_all = wanted(&options.id).is_none() && wanted(&options.layer).is_none();
        Self {
            is_included: is_all,
            is_hidden: false,
            is_in_layer: wanted(&options.layer).is_none(),
            is_match: is_all,
            has_no_fill: false,
            is_even_odd: false,
        }
    }

    /// That of an element in one of this.
    pub(super) fn within(&self, node: Node<'_, '_>, options: &ProfileOptions) -> Self {
        let mut state = *self;
        let label = match node.attribute((INKSCAPE, "groupmode")) {
            Some("layer") => node.attribute((INKSCAPE, "label")),
            _ => None,
        };
        let is_layer = label.is_some() && label == wanted(&options.layer);
        state.is_in_layer |= is_layer;
        state.is_match = match wanted(&options.id) {
            Some(id) => state.is_in_layer && node.attribute("id") == Some(id),
            None => is_layer,
        };
        if property(node, "display") == Some("none") {
            state.is_included = false;
        }
        state.is_included |= state.is_match;
        match property(node, "visibility") {
            Some("hidden" | "collapse") => state.is_hidden = true,
            Some("visible") => state.is_hidden = false,
            _ => {}
        }
        match property(node, "fill") {
            Some("none" | "transparent") => state.has_no_fill = true,
            Some("inherit") | None => {}
            Some(_) => state.has_no_fill = false,
        }
        match property(node, "fill-rule") {
            Some("evenodd") => state.is_even_odd = true,
            Some("nonzero") => state.is_even_odd = false,
            _ => {}
        }
        state
    }

    pub(super) fn is_shown(&self) -> bool {
        self.is_included && !self.is_hidden
    }
}

/// What is asked for; a text without characters asks for nothing.
fn wanted(text: &Option<String>) -> Option<&str> {
    text.as_deref().filter(|text| !text.is_empty())
}

/// A property by an element's `style`, or else by an attribute.
pub(super) fn property<'a>(node: Node<'a, '_>, key: &str) -> Option<&'a str> {
    let styles = node.attribute("style").unwrap_or("").rsplit(';');
    let styled = styles
        .filter_map(|style| style.split_once(':'))
        .find(|(name, _)| name.trim() == key);
    match styled {
        Some((_, value)) => Some(value.trim()),
        None => node.attribute(key).map(str::trim),
    }
}
