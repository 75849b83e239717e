//! Which triangles lie side by side.

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// For each half-edge `3 * triangle + side`, from a triangle's corner `side` to its next
/// one, another one that runs the other way along the same edge, each of one other;
/// [`NONE`] if there is none, or if it is not found soon.
///
/// Linear. Each triangle must have three different vertices.
pub(super) fn twins(triangles: &[[u32; 3]]) -> Vec<u32> {
    /// Half-edges at a vertex that are looked at.
    const MOST: u32 = 32;
    /// Vertices for each triangle.
    const WIDEST: usize = 16;
    let mut twins = vec![NONE; 3 * triangles.len()];
    let vertices = triangles.as_flattened().iter();
    let (lowest, highest) =
        vertices.fold((u32::MAX, 0), |(low, high), &v| (low.min(v), high.max(v)));
    let range = (highest as usize + 1).saturating_sub(lowest as usize);
    if range > WIDEST * triangles.len() {
        // (Few of the triangles are neighbours.)
        return twins;
    }
    // The half-edges without a twin so far, in lists at the lower of their vertices: the
    // next one stands in the place of the twin.
    let mut first = vec![NONE; range];
    let ends = |half: u32| {
        let [a, b, c] = triangles[half as usize / 3];
        match half % 3 {
            0 => [a, b],
            1 => [b, c],
            _ => [c, a],
        }
    };
    for half in 0..twins.len() as u32 {
        let [from, to] = ends(half);
        let list = (from.min(to) - lowest) as usize;
        let (mut before, mut twin) = (NONE, first[list]);
        for _ in 0..MOST {
            if twin == NONE || ends(twin) == [to, from] {
                break;
            }
            (before, twin) = (twin, twins[twin as usize]);
        }
        if twin == NONE || ends(twin) != [to, from] {
            twins[half as usize] = first[list];
            first[list] = half;
            continue;
        }
        let after = twins[twin as usize];
        if before == NONE {
            first[list] = after;
        } else {
            twins[before as usize] = after;
        }
        twins[half as usize] = twin;
        twins[twin as usize] = half;
    }
    for mut half in first {
        while half != NONE {
            half = std::mem::replace(&mut twins[half as usize], NONE);
        }
    }
    twins
}
