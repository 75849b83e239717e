//! What the exact boundary tells of each tree of the corpus, beside two other kernels: a page, and a
//! picture of each.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use csg::{BoundaryOptions, Color, Limits, Mesher, Program, Solid};
use raster::{RenderOptions, Scene};
use stereotomy::io::scene::{ReadOptions, read_file};

use crate::timing::Passes;

#[derive(clap::Args)]
pub struct Options {
    /// The folder of the corpus [default: that which STEREOTOMY_CORPUS names]
    folder: Option<PathBuf>,
    /// Where to write the page; the pictures are written to a folder of that name beside it
    #[arg(short, long, default_value = "tests/corpus.md")]
    output: PathBuf,
    /// Seconds after which a boundary is given up
    #[arg(long, default_value_t = 60)]
    patience: u64,
}

/// What is known of a tree whose references differ, or that is told otherwise than they say.
const WHY: [(&str, &str); 10] = [
    (
        "issue1061",
        "The polyhedron's 24 side faces have four corners that are not in one plane, so that its volume is \
         not given: cut along one diagonal or the other each face differs by a tetrahedron, of 11.67. Cut along \
         the diagonal from its first corner all of them give 1923.486602 (fans of det / 6 over the \
         faces), which is told here and by manifold3d; all cut along the other one 1643.352541. OpenSCAD's \
         1876.7976 is the first less 46.6890, four of the tetrahedra: its tessellation turns four diagonals.",
    ),
    (
        "issue591",
        "4.5 is right. A square of side 1 that is extruded by 3 with scale [0, 1] has the width 1 - z / 3 at the \
         height z, and what lies below 1.5, where the cube begins, the volume ∫ (1 - z / 3) dz = 1.5 - 0.375 = \
         1.125. There are four such wedges, in two groups that are 2 apart and 1 deep: 4.5. The box around OpenSCAD's \
         result (y from 1.5 to 2.5) has only one group: the other one, whose two squares are one extrusion \
         and meet in a line at the top, is lost.",
    ),
    (
        "linear_extrude_invisible-tests",
        "Told as OpenSCAD's kernel does, to the six digits of its file.",
    ),
    (
        "issue2259",
        "Both are right of what they are given: the sides of two of the four extrusions, of a triangle with \
         scale [1, 0], have corners that are not in one plane. As ruled surfaces they would bound 200 (1 - z \
         / 10) at the height z, 1000 each, and with two pyramids of 200 · 10 / 3 the whole were 3333.333333; \
         cut along a diagonal each side of one slice takes or adds half of a tetrahedron of 333.333333, and \
         of two slices less. Told is what OpenSCAD's diagonals bound, as its kernel does.",
    ),
    (
        "intersection-tests",
        "An intersection of a cube of side 5 and a flat circle is nothing, here and in OpenSCAD; the reference by \
         manifold3d leaves the circle out and counts the cube, 125.",
    ),
    (
        "polyhedron-nonplanar-tests",
        "Faces with corners that are not in one plane: cut along other diagonals.",
    ),
    (
        "issue1198",
        "Faces with corners that are not in one plane but for six digits: cut along other diagonals.",
    ),
    (
        "resize-tests",
        "Circles that are resized unevenly are cut into other polygons.",
    ),
    (
        "polyhedron-tests",
        "Refused: one of its surfaces is not closed.",
    ),
    ("non-aff-matrix", "Refused: a projective matrix."),
];

/// A row of the corpus's table.
struct Tree {
    file: String,
    nodes: String,
    /// Of OpenSCAD's kernel, to six digits.
    cgal: Option<f64>,
    /// Of manifold3d.
    manifold: Option<f64>,
    /// Of 256 corners in place of circles.
    smooth: Option<f64>,
}

fn trees(folder: &Path) -> Result<Vec<Tree>, String> {
    let table = folder.join("corpus.csv");
    let text = fs::read_to_string(&table).map_err(|e| format!("{}: {e}", table.display()))?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let found = names.iter().position(|&known| known == name);
        found.ok_or_else(|| format!("{}: no column {name}", table.display()))
    };
    let [file, nodes, cgal, manifold, smooth] = [
        column("file")?,
        column("nodes")?,
        column("volume_faceted")?,
        column("volume_faceted_f64")?,
        column("volume_smooth_256")?,
    ];
    let tree = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let field = |column: usize| fields.get(column).copied().unwrap_or_default();
        let number = |column: usize| field(column).parse().ok();
        Tree {
            file: field(file).to_owned(),
            nodes: field(nodes).to_owned(),
            cgal: number(cgal),
            manifold: number(manifold),
            smooth: number(smooth),
        }
    };
    Ok(lines.map(tree).collect())
}

/// A volume, how it was found, and the seconds that took.
struct Told {
    volume: f64,
    is_exact: bool,
    seconds: f64,
    solid: Solid,
}

fn told(path: &Path, faceted: bool, patience: u64) -> Result<Told, String> {
    let options = ReadOptions::default().faceted(faceted);
    let solid = read_file(path, &options)
        .map_err(|e| short(&e.to_string(), path))?
        .solid;
    let measured = |solid: &Solid| -> Result<(f64, bool), csg::Error> {
        let program = Program::lower(solid)?;
        let limits = Limits::new().time(Duration::from_secs(patience));
        let boundary = program.boundary(&BoundaryOptions::new().limits(limits));
        match boundary {
            Ok(boundary) => Ok((boundary.measure().volume.value, true)),
            Err(csg::Error::Undecided(_)) => {
                let meshed = Mesher::new().limits(limits).mesh(&program)?;
                Ok((meshed.mesh.volume(), false))
            }
            Err(error) => Err(error),
        }
    };
    let (times, result) = Passes::within(0.05, 1.0).best(|| measured(&solid));
    let (volume, is_exact) = result.map_err(|e| short(&e.to_string(), path))?;
    Ok(Told {
        volume,
        is_exact,
        seconds: times.wall,
        solid,
    })
}

/// Of a picture of a tree, in pixels.
const SIZE: [u32; 2] = [120, 90];

/// Pictures are drawn so many times as large, for edges that are as much thinner than a pixel: on
/// small parts they would be all that is seen.
const FINER: u32 = 3;

/// Draws a solid from ahead and above.
fn draw(solid: &Solid, patience: u64, path: &Path) -> Result<(), Box<dyn Error>> {
    let program = Program::lower(solid)?;
    let size = program.bounds()?.ok_or("there is nothing")?.size();
    // A tenth of a pixel of what fills the picture.
    let tolerance = 0.1 * size.max_element() / f64::from(SIZE[0]);
    let limits = Limits::new().time(Duration::from_secs(patience));
    let mesher = Mesher::new().normals().tolerance(tolerance).limits(limits);
    let scene = Scene::new().add(mesher.mesh(&program)?.mesh);
    let options = RenderOptions::presentation()
        .size(FINER * SIZE[0], FINER * SIZE[1])
        .background(Color::from_srgb([1.0; 3]));
    let image = scene.render(&scene.camera(&options)?, &options)?;
    image.shrink(FINER).save(path)?;
    Ok(())
}

/// The first of what is said, without the path.
fn short(problem: &str, path: &Path) -> String {
    let problem = problem.replace(&format!("{}:", path.display()), "");
    let first = problem.split([';', '\n']).next().unwrap_or_default();
    first.replace('|', "/").trim().to_owned()
}

/// How far from a reference, of it.
fn off(told: f64, reference: Option<f64>) -> String {
    match reference {
        Some(reference) if reference != 0.0 => format!("{:.0e}", (told / reference - 1.0).abs()),
        _ => String::new(),
    }
}

pub fn run(options: &Options) {
    let page = page(options).unwrap_or_else(|problem| panic!("{problem}"));
    fs::write(&options.output, page)
        .unwrap_or_else(|e| panic!("{}: {e}", options.output.display()));
    println!("wrote {}", options.output.display());
}

fn page(options: &Options) -> Result<String, String> {
    let folder = options.folder.clone();
    let folder = folder.or_else(|| std::env::var_os("STEREOTOMY_CORPUS").map(PathBuf::from));
    let folder = folder.ok_or("name the folder of the corpus, or set STEREOTOMY_CORPUS")?;
    let trees = trees(&folder)?;
    let pictures = options.output.with_extension("");
    fs::create_dir_all(&pictures).map_err(|e| format!("{}: {e}", pictures.display()))?;
    let shown = pictures.file_name().unwrap_or_default().display();
    let mut rows = String::new();
    let (mut same, mut told_all) = (0, 0);
    let mut differ = Vec::new();
    for tree in &trees {
        let path = folder.join("csg").join(&tree.file);
        let name = tree.file.trim_end_matches(".csg").replace("__", "/");
        let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.9}"));
        let picture = Path::new(&tree.file).with_extension("png");
        let mut cells = [
            String::new(),
            name.clone(),
            tree.nodes.clone(),
            number(tree.cgal),
            number(tree.manifold),
        ]
        .to_vec();
        match told(&path, true, options.patience) {
            Ok(told) => {
                told_all += 1;
                // Files of six digits hold to 2e-5; two kernels in doubles to rounding.
                let is_near = |reference: Option<f64>, precision: f64| {
                    reference.is_some_and(|r| (told.volume - r).abs() <= precision * r.abs())
                };
                let [near_cgal, near_manifold] =
                    [is_near(tree.cgal, 2e-5), is_near(tree.manifold, 1e-9)];
                let verdict = match (near_cgal, near_manifold, tree.manifold) {
                    (true, true, _) => "both",
                    (true, false, None) => "OpenSCAD",
                    (true, false, Some(_)) => "OpenSCAD alone",
                    (false, true, _) => "manifold3d alone",
                    (false, false, _) => "neither",
                };
                same += usize::from(near_cgal && (near_manifold || tree.manifold.is_none()));
                if !near_cgal || (tree.manifold.is_some() && !near_manifold) {
                    differ.push((name.clone(), verdict));
                }
                match draw(&told.solid, options.patience, &pictures.join(&picture)) {
                    Ok(()) => cells[0] = format!("![{name}]({shown}/{})", picture.display()),
                    Err(problem) => println!("{name}: no picture: {problem}"),
                }
                let mark = if told.is_exact { "" } else { " (mesh)" };
                cells.extend([
                    format!("{:.9}{mark}", told.volume),
                    off(told.volume, tree.manifold.or(tree.cgal)),
                    verdict.to_owned(),
                    format!("{:.4}", told.seconds),
                ]);
            }
            Err(problem) => {
                differ.push((name, "refused"));
                cells.extend([problem, String::new(), "refused".to_owned(), String::new()]);
            }
        }
        let round = told(&path, false, options.patience).ok();
        cells.push(
            round
                .as_ref()
                .map_or(String::new(), |told| format!("{:.9}", told.volume)),
        );
        cells.push(round.map_or(String::new(), |told| off(told.volume, tree.smooth)));
        let _ = writeln!(rows, "| {} |", cells.join(" | "));
    }
    let build = if cfg!(debug_assertions) {
        " (of a development build, which is slower)"
    } else {
        ""
    };
    let mut page = format!(
        "# The corpus, tree by tree\n\n\
         Trees of OpenSCAD's own examples and tests (`STEREOTOMY_CORPUS`), which are not part of this \
         repository. Volumes of the exact boundary with OpenSCAD's facets, beside those of OpenSCAD's exact kernel \
         (from a file of six digits) and of manifold3d in doubles, how far the one told is off the second of them (or \
         the first, where that is all there is), and with which it agrees (to 2e-5 and 1e-9); the \
         seconds that lowering, boundary and measures take, the best of three or more{build}; and the volume with \
         true circles, and how far that is off one with 256 corners in their place, which cut off some 1e-4. Pictures are drawn \
         with facets, by this project's rasteriser.\n\n\
         Written by `cargo run -p bench --release -- corpus`. Of {} trees {told_all} are told, and {same} agree with all \
         references there are.\n\n\
         | | tree | nodes | OpenSCAD | manifold3d | told | off | agrees with | seconds | with circles | off |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        trees.len(),
    );
    page += &rows;
    page += "\n## Where they differ\n\n";
    for (name, verdict) in differ {
        let why = WHY.iter().find(|(tree, _)| name.ends_with(tree));
        let why = why.map_or("Not looked into.", |(_, why)| why);
        let _ = writeln!(page, "- `{name}` ({verdict}): {why}");
    }
    Ok(page)
}
