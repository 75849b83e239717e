//! The conics in which planes of a pencil cut its quadrics.

use glam::DVec3;

use crate::arrangement::conic::conic;
use crate::arrangement::curve::Branches;
use crate::arrangement::intersection::{Contacts, Nearness, Unknown};
use crate::program::Surface;

/// The conics in which planes cut a quadric, with nodes where they cross.
pub(super) fn conics(
    planes: &[Surface],
    nodes: &[DVec3],
    quadric: &Surface,
    nearness: Nearness,
) -> Result<Branches, Unknown> {
    let mut branches = Branches::new();
    let mut contacts = Contacts::new();
    for plane in planes {
        let conic = match conic(plane, quadric, nearness) {
            Err(Unknown::Touch(at)) => {
                contacts.extend(at);
                continue;
            }
            other => other?,
        };
        for mut branch in conic {
            let places = nodes.iter().filter_map(|&node| branch.curve.place(node));
            branch.nodes.extend(places);
            branches.push(branch);
        }
    }
    if branches.is_empty() && !contacts.is_empty() {
        return Err(Unknown::Touch(contacts));
    }
    Ok(branches)
}
