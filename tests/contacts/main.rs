//! Every kind of contact, in every Boolean operation, at home, turned, far away, tiny and
//! huge: each mesh is judged by rays through the tree and the mesh's exact checks, and the
//! verdicts are those of the page `contacts.md` beside this file, right and wrong.
//!
//! To write the page anew, run this test with STEREOTOMY_WRITE_CONTACTS=1.

mod pairs;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use csg::{Error, Limits, Meshed, Mesher, Program, Solid};
use rayon::prelude::*;
use stereotomy::csg;

use self::pairs::pairs;
use crate::judge::{Case, Tree, is_seen, judge};

/// At home; elsewhere it is as large a part of the solid.
const TOLERANCE: f64 = 0.01;
/// A mesh that takes longer is not waited for.
const SLOW: Duration = Duration::from_secs(2);

const OPERATIONS: [&str; 4] = ["a ∪ b", "a − b", "b − a", "a ∩ b"];

fn combined(operation: usize, [a, b]: &[Solid; 2]) -> Solid {
    match operation {
        0 => a | b,
        1 => a - b,
        2 => b - a,
        _ => a & b,
    }
}

const POSES: [&str; 9] = [
    "home", "turned", "+1e3", "+1e6", "+1e9", "×1e-9", "×1e-6", "×1e6", "×1e9",
];

/// A solid in a pose, and how much larger it is there.
fn posed(pose: usize, solid: &Solid) -> (Solid, f64) {
    let scale = [1.0, 1.0, 1.0, 1.0, 1.0, 1e-9, 1e-6, 1e6, 1e9][pose];
    let far = [0.0, 0.0, 1e3, 1e6, 1e9, 0.0, 0.0, 0.0, 0.0][pose];
    let solid = match pose {
        0 => solid.clone(),
        1 => solid.rotate_x(1.0).rotate_y(-0.37).rotate_z(0.5),
        2..5 => solid.translate([far, -0.7 * far, 0.3 * far]),
        _ => solid.scale(scale),
    };
    (solid, scale)
}

/// What became of one.
#[derive(Clone, Debug, PartialEq)]
enum Cell {
    /// Right, with so many components and of this genus.
    Right(usize, Option<i64>),
    Slow,
    Wrong(String),
}

fn cell(solid: &Solid, scale: f64, most: Duration) -> Cell {
    const SEED: u64 = 7;
    let wrong = |words: &str| Cell::Wrong(words.to_owned());
    let tolerance = TOLERANCE * scale;
    let mesher = Mesher::new().tolerance(tolerance);
    let mesher = mesher.limits(Limits::new().time(most));
    let made = Program::lower(solid).and_then(|program| mesher.mesh(&program));
    let Meshed { mesh, report, .. } = match made {
        Ok(meshed) => meshed,
        Err(Error::LimitReached(_)) => return Cell::Slow,
        Err(_) if is_seen(solid, SEED) => return wrong("no mesh, though the solid is not empty"),
        Err(_) => return wrong("no mesh of an empty solid"),
    };
    let tree = Tree::new(solid);
    let verdict = judge(&Case {
        tree: &tree,
        mesh: &mesh,
        tolerance,
        unseen: report.moved.map_or(0.0, |moved| 2.0 * moved.distance),
        seed: SEED,
    });
    let silently = if report.fallbacks.is_empty() {
        ", and nothing is said"
    } else {
        ""
    };
    if let Some(fault) = verdict.faults.first() {
        let kinds = ["crossings", "differs", "points", "volume"];
        let kind = kinds.into_iter().find(|kind| fault.contains(kind));
        let words = match kind {
            Some("crossings") => "runs through itself",
            Some("differs") => "differs from the solid along rays",
            Some("points") => "has points far from the boundary",
            Some(_) => "has another volume",
            None => "is not manifold",
        };
        return Cell::Wrong(format!("{words}{silently}"));
    }
    let (low, high) = mesh.bounds().unwrap_or_default();
    let rounding = 1e-9 * low.distance(high) + 1e-14 * low.abs().max(high.abs()).max_element();
    let moved = report.moved.map_or(0.0, |moved| moved.distance);
    if report.largest_vertex_distance > rounding + 2.0 * moved {
        return wrong("has vertices off their surfaces");
    }
    if let Some(fallback) = report.fallbacks.first() {
        return Cell::Wrong(format!("is right, but reports: {}", fallback.kind));
    }
    Cell::Right(report.check.components, report.check.genus())
}

/// The verdicts of one row, those that are slow by another page left out.
fn row(pair: &[Solid; 2], operation: usize, before: Option<&str>) -> Vec<Cell> {
    let solid = combined(operation, pair);
    let is_slow = |pose: usize| {
        let mut cells = before?.split('|').skip(3 + 2);
        cells.nth(pose).map(|cell| cell.trim() == "slow")
    };
    let cell = |pose: usize| {
        if is_slow(pose) == Some(true) {
            return Cell::Slow;
        }
        let (solid, scale) = posed(pose, &solid);
        // Where the page says that it is fast, the machine may be busy.
        let most = if before.is_some() { 20 * SLOW } else { SLOW };
        cell(&solid, scale, most)
    };
    let mut cells: Vec<Cell> = (0..POSES.len()).map(cell).collect();
    if let Cell::Right(components, genus) = cells[0] {
        for cell in &mut cells[1..] {
            if matches!(*cell, Cell::Right(c, g) if (c, g) != (components, genus)) {
                *cell = Cell::Wrong("has other components or holes than at home".into());
            }
        }
    }
    cells
}

fn page(before: Option<&str>) -> String {
    let pairs = pairs();
    let rows: Vec<(usize, usize)> = (0..pairs.len())
        .flat_map(|pair| (0..OPERATIONS.len()).map(move |operation| (pair, operation)))
        .collect();
    let head = |pair: usize, operation: usize| {
        format!("| {} | {} |", pairs[pair].0, OPERATIONS[operation])
    };
    let verdicts: Vec<Vec<Cell>> = rows
        .par_iter()
        .map(|&(pair, operation)| {
            let head = head(pair, operation);
            let before = before.and_then(|page| page.lines().find(|line| line.starts_with(&head)));
            row(&pairs[pair].1, operation, before)
        })
        .collect();
    let mut reasons: Vec<String> = Vec::new();
    let mut table = String::new();
    let mut counts = [0; 3];
    for (&(pair, operation), cells) in rows.iter().zip(&verdicts) {
        let parts = match cells[0] {
            Cell::Right(components, Some(genus)) => format!("{components} | {genus}"),
            Cell::Right(components, None) => format!("{components} | "),
            _ => " | ".to_owned(),
        };
        write!(table, "{} {parts} |", head(pair, operation)).expect("a text");
        for cell in cells {
            let text = match cell {
                Cell::Right(..) => "✓".to_owned(),
                Cell::Slow => "slow".to_owned(),
                Cell::Wrong(reason) => {
                    let known = reasons.iter().position(|r| r == reason);
                    let number = known.unwrap_or_else(|| {
                        reasons.push(reason.clone());
                        reasons.len() - 1
                    });
                    format!("**{}**", number + 1)
                }
            };
            counts[match cell {
                Cell::Right(..) => 0,
                Cell::Slow => 1,
                Cell::Wrong(_) => 2,
            }] += 1;
            write!(table, " {text} |").expect("a text");
        }
        table.push('\n');
    }
    let [right, slow, wrong] = counts;
    let mut page = format!(
        "# Contacts\n\n\
         {} pairs of solids in every kind of contact, in every operation, meshed to a hundredth: \
         {right} meshes are right, {wrong} are not, and {slow} take longer than {} s and are left \
         out. Right is a mesh that is closed, manifold, without self-intersections, with the \
         volume of the tree by rays, nowhere farther from its boundary than the tolerance, with \
         vertices on their surfaces, with the components and the genus that it has at home, and \
         with nothing to report. A number is a reason below.\n\n\
         This page is written by a test, which fails when a cell becomes another one.\n\n\
         | pair | operation | components | genus | {} |\n",
        pairs.len(),
        SLOW.as_secs(),
        POSES.join(" | "),
    );
    page += &format!("{}|\n{table}\n", "| --- ".repeat(4 + POSES.len()));
    for (number, reason) in (1..).zip(&reasons) {
        writeln!(page, "{number}. The mesh {reason}.").expect("a text");
    }
    page
}

#[test]
fn contacts_are_as_the_page_says() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("contacts/contacts.md");
    if std::env::var_os("STEREOTOMY_WRITE_CONTACTS").is_some() {
        std::fs::write(&path, page(None)).expect("written");
        return;
    }
    let known = std::fs::read_to_string(&path).expect("the page");
    let found = page(Some(&known));
    let differing = known.lines().zip(found.lines()).filter(|(k, f)| k != f);
    let differing: Vec<String> = differing.map(|(k, f)| format!("- {k}\n+ {f}")).collect();
    assert!(
        known == found,
        "contacts.md is stale: run this test with STEREOTOMY_WRITE_CONTACTS=1\n{}",
        differing.join("\n")
    );
}
