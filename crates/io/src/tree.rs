//! Parts within each other, by their names.

use rustc_hash::FxHashMap;

/// A name around parts.
pub(crate) struct Branch<'a> {
    /// Empty at the root, which is around all.
    pub name: &'a str,
    /// The part whose names end with this one.
    pub part: Option<usize>,
    /// The names straight within this one, by their numbers.
    pub inner: Vec<usize>,
}

/// The tree of the names of parts, the outermost of each first: the root, then each name before
/// those within it.
pub(crate) fn tree<'a>(parts: impl IntoIterator<Item = &'a [&'a str]>) -> Vec<Branch<'a>> {
    let branch = |name| Branch {
        name,
        part: None,
        inner: Vec::new(),
    };
    let mut tree = vec![branch("")];
    let mut known: FxHashMap<(usize, &str), usize> = FxHashMap::default();
    for (part, names) in parts.into_iter().enumerate() {
        let mut at = 0;
        for &name in names {
            let next = tree.len();
            let inner = *known.entry((at, name)).or_insert(next);
            if inner == next {
                tree.push(branch(name));
                tree[at].inner.push(inner);
            }
            at = inner;
        }
        tree[at].part = Some(part);
    }
    tree
}
