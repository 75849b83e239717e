//! A nameplate with raised letters and two holes (needs Liberation Sans, or another font
//! by name): `cargo run --release --example nameplate -- --name Ada render -o name.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Color, Join, Profile, Solid};
use stereotomy::text::{Font, HorizontalAlign, Text, VerticalAlign};

#[derive(Clone, clap::Args)]
struct Arguments {
    /// What is written
    #[arg(long, default_value = "Stereotomy")]
    name: String,
    /// The font, as in `Liberation Serif:style=Italic`
    #[arg(long, default_value = "Liberation Sans:style=Bold")]
    font: String,
}

fn nameplate(arguments: Arguments) -> Solid {
    let letters = Font::find(&arguments.font).map_err(|error| error.to_string());
    let letters = letters.and_then(|font| {
        let text = Text::new(arguments.name)
            .size(12.0)
            .horizontal(HorizontalAlign::Center)
            .vertical(VerticalAlign::Center);
        text.profile(&font).map_err(|error| error.to_string())
    });
    let letters = letters.unwrap_or_else(|error| {
        eprintln!("warning: {error}: the plate is left blank");
        Profile::empty()
    });
    let bounds = letters.bounds(0.1).ok().flatten();
    let width = bounds.map_or(40.0, |(min, max)| max.x - min.x) + 34.0;
    let plate = Profile::rounded_rectangle([width, 28.0], 6.0);
    let rim = &plate - plate.offset(-1.6, Join::Round);
    let holes = [-1.0, 1.0].map(|side| {
        let hole = Solid::countersink(1.7, 5.0, 3.2);
        hole.translate_xyz(side * (0.5 * width - 8.0), 0.0, 3.0)
    });
    let plate = Solid::extrude(&plate, 0.0..3.0) - Solid::union(holes).named("holes");
    let raised = Solid::extrude(&(letters | rim), 2.5..4.0);
    plate
        .colored(Color::from_srgb([0.16, 0.30, 0.42]))
        .named("plate")
        | raised
            .colored(Color::from_srgb([0.93, 0.90, 0.80]))
            .named("letters")
}

fn main() -> ExitCode {
    cli::run_with(nameplate)
}
