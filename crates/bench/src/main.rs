//! Measurements of the mesher, side by side with its peers, and of the
//! command: one subcommand for each question asked.

mod cells;
mod claims;
mod cold;
mod corpus;
#[path = "../../../tests/meshing/defects.rs"]
mod defects;
mod deviation;
mod error;
mod field;
mod figure;
mod files;
mod imports;
#[path = "../../../tests/judge/mod.rs"]
mod judge;
mod many;
mod measure;
mod memory;
mod peers;
mod plot;
mod poses;
mod random_tree;
mod robust;
mod scaling;
mod scenes;
#[path = "../../../tests/manifold3d/script.rs"]
mod script;
mod tally;
mod timing;
mod triangles;
mod truth;
mod uniform;

use clap::Parser;

/// Measures the mesher beside its peers, and the command.
#[derive(Parser)]
#[command(name = "bench")]
enum Question {
    /// How fast and how right at a fixed number of cells a side?
    Uniform(uniform::Options),
    /// How long does a mesh of a given error take?
    Error(error::Options),
    /// What does a surface cell cost, and where does the time go?
    Cells(cells::Options),
    /// How much faster are several threads, and could they be?
    Scaling(scaling::Options),
    /// Is every mesh manifold?
    Robust(robust::Options),
    /// Is every mesh of scene files sound, and does manifold3d agree?
    Files(files::Options),
    /// What is told of each tree of the corpus, and what do others say?
    Corpus(corpus::Options),
    /// Does every mesh keep what is promised of it?
    Claims(claims::Options),
    /// How much memory does one mesh take?
    Memory(memory::Options),
    /// How long from a file to a picture, by a process just started?
    Cold(cold::Options),
    /// How long do scenes of many primitives take?
    Many(many::Options),
    /// How long does it take to read large meshes as solids, and to cut them?
    Imports(imports::Options),
}

fn main() {
    match Question::parse() {
        Question::Uniform(options) => uniform::run(&options),
        Question::Error(options) => error::run(&options),
        Question::Cells(options) => cells::run(&options),
        Question::Scaling(options) => scaling::run(&options),
        Question::Robust(options) => robust::run(&options),
        Question::Files(options) => files::run(&options),
        Question::Corpus(options) => corpus::run(&options),
        Question::Claims(options) => claims::run(&options),
        Question::Memory(options) => memory::run(&options),
        Question::Cold(options) => cold::run(&options),
        Question::Many(options) => many::run(&options),
        Question::Imports(options) => imports::run(&options),
    }
}
