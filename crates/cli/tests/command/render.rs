//! `csg render`.

use std::fs;

use crate::{Folder, failed, succeeded};

#[test]
fn render_frames_the_model() {
    let folder = Folder::new();
    let cameras = ["iso", "top", "-1,2,-1", "3,-4,2:0,0,0", "0,0,-1"];
    for (index, camera) in cameras.iter().enumerate() {
        let command = format!(
            "render in.csg -o {index}.png --size 96x64 --cells 32 --camera {camera} --background ffffff"
        );
        succeeded(&folder.run(&command));
        let file = fs::read(folder.file(&format!("{index}.png"))).expect("a file");
        // Width and height stand in the header.
        assert_eq!(&file[16..24], [0, 0, 0, 96, 0, 0, 0, 64]);
    }
    succeeded(&folder.run("render in.csg -o p.png --orthographic --cells 32 --size 96x64"));
    let [perspective, parallel] =
        ["0.png", "p.png"].map(|name| fs::read(folder.file(name)).expect("a file"));
    assert_ne!(perspective, parallel);
}

/// OpenSCAD's options: an eye anywhere sees all of the model as from its direction, or its middle.
#[test]
fn given_cameras_move_to_see_the_model() {
    let folder = Folder::new();
    let picture = |camera: &str| {
        let command = format!("render in.csg -o out.png --size 96x64 --cells 32 {camera}");
        succeeded(&folder.run(&command));
        fs::read(folder.file("out.png")).expect("a file")
    };
    let along = picture("--camera=-1,1,-1 --projection p");
    assert_eq!(
        picture("--camera 9,-9,9,0,0,0 --viewall --autocenter"),
        along
    );
    assert_eq!(picture("--camera 7,-1,8,5,1,6 --viewall"), along);
    let middle = picture("--camera 4,-4,4,0,0,0");
    assert_ne!(middle, along);
    assert_ne!(picture("--camera 5,-4,4,1,0,0"), middle);
    assert_eq!(picture("--camera 5,-4,4,1,0,0 --autocenter"), middle);
    assert_eq!(
        picture("--projection o --camera iso --viewall"),
        picture("--orthographic --camera iso")
    );
}

/// Every option for looks changes the picture, each in its own way.
#[test]
fn render_has_an_option_for_every_look() {
    let folder = Folder::new();
    let mut pictures = Vec::new();
    for looks in [
        "",
        "--plain",
        "--plain --shading flat",
        "--plain --shading gouraud",
        "--plain --anti-aliasing none",
        "--plain --anti-aliasing msaa8",
        "--plain --anti-aliasing supersample2",
        "--plain --anti-aliasing supersample4",
        "--plain --edges",
        "--plain --edges --line-width 3",
        "--plain --hidden-edges",
        "--plain --wireframe",
        "--plain --points",
        "--plain --section -y=0",
        "--plain --section -y=0 --section 0,0,1:0,0,0.4",
        "--plain --ambient-occlusion",
        "--plain --shadow",
        "--plain --material 0.5,0.5,0.8,4",
        "--plain --light 1,0,0:ff8800",
        "--plain --point-light 2,-2,3",
        "--plain --ambient 800000",
        "--plain --environment 4466ff:553311",
        "--plain --checker 0.3",
        "--plain --camera -1,1,-1 --up 1,0,0",
        "--plain --near 3.5",
        "--plain --far 3.5",
        "--hidden-surface zbuffer",
        "--hidden-surface wireframe",
        "--show depth --depth-bits 12",
        "--plain --axes",
        "--plain --show depth",
        "--plain --show normals",
        "--plain --show surfaces",
        "--plain --show occlusion",
        "--plain --projection ortho",
        "--plain --projection cavalier",
        "--plain --projection cabinet",
        "--plain --fov 60",
        "--plain --background ff0000",
        "--plain --sheet",
        "--plain --sheet first",
        "--plain --dimension bbox",
        "--plain --scale-bar",
        "--plain --color-by surface",
        "--plain --color-by draft",
        "--plain --color-by curvature",
        "--plain --color-by thickness",
        "--plain --color-by deviation",
        "--plain --checker 0.3 --checker-by surface",
        "--plain --vpn 1,-1,1",
        "--plain --vpn 1,-1,1 --vrp 0,0,0.5 --vup 1,0,0",
        "--plain --vpn 1,-1,1 --window -1,1,-0.75,0.75",
        "--plain --vpn 1,-1,1 --prp 0.5,0,2",
        "--plain --vpn 0,-1,0 --projection ortho --prp 2,1,4",
        "--plain --vpn 1,-1,1 --clip-planes 0.2,-2",
        "--plain --section -y=0 --cap-color ff0000",
        "--turntable 3",
    ] {
        let command = format!("render in.csg -o out.png --size 120x90 --cells 16 {looks}");
        succeeded(&folder.run(&command));
        let file = fs::read(folder.file("out.png")).expect("a file");
        assert_eq!(&file[16..24], [0, 0, 0, 120, 0, 0, 0, 90], "{looks}");
        assert!(!pictures.contains(&file), "{looks}");
        pictures.push(file);
    }
    // Two ways that are right show the same.
    let by_the_book = ["zbuffer", "scanline"].map(|way| {
        let command = format!("render in.csg -o out.png --cells 16 --hidden-surface {way}");
        succeeded(&folder.run(&command));
        fs::read(folder.file("out.png")).expect("a file")
    });
    assert_eq!(by_the_book[0], by_the_book[1]);
    // The look that needs no options is made of three that have one each.
    let all = "--plain --edges --ambient-occlusion --shadow";
    succeeded(&folder.run(&format!(
        "render in.csg -o out.png --size 120x90 --cells 16 {all}"
    )));
    assert_eq!(
        fs::read(folder.file("out.png")).expect("a file"),
        pictures[0]
    );
    let output = folder.run("render in.csg -o out.png --cells 16 --stats");
    assert!(String::from_utf8_lossy(&succeeded(&output).stderr).contains("pixels shaded"));
    succeeded(&folder.run("render in.csg -o out.gif --cells 16 --turntable 2 --size 64x48"));
    assert_eq!(
        &fs::read(folder.file("out.gif")).expect("a file")[..6],
        b"GIF89a"
    );
    failed(
        &folder.run("render in.csg -o out.png --dimension no:such"),
        4,
    );
    succeeded(&folder.run("mesh in.csg -o in.glb --cells 16"));
    let told = folder.run("render in.glb -o out.png --color-by deviation");
    assert!(failed(&told, 4).contains("solid"));
    let wide = "render in.csg -o out.png --vpn 0,-1,0 --window -2,2,-1,1 --size 90x90";
    assert!(failed(&folder.run(wide), 4).contains("stretched"));
    let message = failed(&folder.run("render in.csg -o out.png --section up"), 2);
    assert!(message.contains("y=0"), "{message}");
}
