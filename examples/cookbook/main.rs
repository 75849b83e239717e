//! The pictures of the cookbook, `models/cookbook/*.png`:
//! `cargo run --release --example cookbook`, or with names of recipes, these alone.
//!
//! The page of [`stereotomy::cookbook`] is made of the files beside this one, in the order of the
//! list below.

use std::error::Error;
use std::path::Path;

use stereotomy::csg::{Color, Mesher, Program, Solid};
use stereotomy::raster::{RenderOptions, Scene};

/// Names of files, each with a function `solid`, and what they show.
macro_rules! recipes {
    ($($name:ident: $title:literal,)*) => {
        $(
            #[allow(dead_code, reason = "what is not drawn is run by the page's tests")]
            mod $name;
        )*

        const RECIPES: &[(&str, fn() -> Solid)] = &[$((stringify!($name), $name::solid)),*];
    };
}

recipes! {
    rounded_box: "A box with rounded corners",
    chamfered_plate: "A plate with chamfers, at holes too",
    open_box: "A box that is open above",
    slots: "A plate with slots",
    bolt_circle: "A ring with a circle of holes",
    countersunk_holes: "Countersunk holes in a row",
    l_bracket: "A bracket from an outline",
    turned_knob: "A knob, turned from half of a section",
    tube_bend: "A bent tube",
    pipe_cross: "A cross of pipes",
    spoked_wheel: "A wheel with spokes",
    hexagon_nut: "A nut with rounded corners",
    threaded_rod: "A thread",
    spur_gear: "A gear",
    knurled_handle: "A knurled handle",
    letters_raised: "Raised letters",
    heat_sink: "Fins in a row",
    perforated_sheet: "A perforated sheet",
    twisted_vase: "A twisted prism",
    drilled_ball: "A cube within a ball, drilled",
    dome_shell: "A dome with windows",
    dish: "A parabolic dish",
    cooling_tower: "A hyperboloid",
    rounded_hull: "The hull of balls",
    die: "A die",
    named_parts: "Parts with names and colours, cut open",
    measured: "Volume, area and their bounds",
    exported: "Files to print, and for CAD",
    drawn: "Drawings",
    thousand_variants: "A thousand variants on a cluster",
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/cookbook");
    std::fs::create_dir_all(&folder)?;
    let names: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |name: &str| names.is_empty() || names.iter().any(|other| other == name);
    for (name, solid) in RECIPES.iter().filter(|(name, _)| wanted(name)) {
        let program = Program::lower(&solid())?;
        let side = program.bounds()?.ok_or("an unbounded solid")?.size();
        let mesher = Mesher::new().normals().tolerance(5e-4 * side.max_element());
        let scene = Scene::new().add(mesher.mesh(&program)?.mesh);
        let white = Color::from_srgb([1.0; 3]);
        let options = RenderOptions::presentation()
            .size(200, 150)
            .background(white);
        let image = scene.render(&scene.camera(&options)?, &options)?;
        image.save(folder.join(format!("{name}.png")))?;
        println!("{name}");
    }
    Ok(())
}
