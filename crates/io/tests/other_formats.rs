//! STL, PLY and 3MF: round trips, and what other programs write.

use std::process::Command;

use crate::common::{colored_box, in_unit, small_box, sphere, srgb_bytes};
use csg::{LengthUnit, Mesh};
use glam::{DVec3, dvec3};
use io::WriteOptions;
use io::ply::{read_ply, write_ply, write_ply_with};
use io::stl::{read_stl, write_stl, write_stl_text};

fn bytes(write: impl FnOnce(&mut Vec<u8>) -> Result<(), io::Error>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes).expect("written");
    bytes
}

/// The corners of all triangles, in order.
fn corners(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect()
}

#[test]
fn binary_stl_returns_in_single_precision() {
    let mesh = sphere(dvec3(1.0, 2.0, 3.0), 0.7, 15);
    let file = bytes(|out| write_stl(&mesh, out));
    assert_eq!(file.len(), 84 + 50 * mesh.triangles.len());
    assert!(!file.starts_with(b"solid"));
    let back = read_stl(&file).expect("read");
    let rounded = corners(&mesh)
        .into_iter()
        .map(|t| t.map(|p| p.as_vec3().as_dvec3()));
    assert_eq!(corners(&back), rounded.collect::<Vec<_>>());
    assert_eq!(back.positions.len(), mesh.positions.len());
    assert!(back.check().is_manifold());
    // Record 7 as the format lays it out: a unit normal, three corners, zeros.
    let record = &file[84 + 7 * 50..84 + 8 * 50];
    let vector = |at: usize| {
        let real =
            |at: usize| f64::from(f32::from_le_bytes(record[at..at + 4].try_into().unwrap()));
        dvec3(real(at), real(at + 4), real(at + 8))
    };
    let [a, b, c] = mesh.corners(7);
    assert!((vector(0) - (b - a).cross(c - a).normalize()).length() < 1e-6);
    assert_eq!(
        [12, 24, 36].map(vector),
        mesh.corners(7).map(|p| p.as_vec3().as_dvec3())
    );
    assert_eq!(record[48..], [0, 0]);
}

#[test]
fn text_stl_returns_every_bit() {
    let mesh = sphere(dvec3(1e6 / 3.0, 0.1, -1e-7), 1.0 / 3.0, 9);
    let file = bytes(|out| write_stl_text(&mesh, out));
    let back = read_stl(&file).expect("read");
    assert_eq!(corners(&back), corners(&mesh));
    assert_eq!(back.positions.len(), mesh.positions.len());
    // A binary file whose header begins like text is still binary.
    let mut file = bytes(|out| write_stl(&small_box(), out));
    file[..5].copy_from_slice(b"solid");
    assert_eq!(read_stl(&file).expect("read").volume(), 6.0);
}

#[test]
fn stl_files_with_faults_are_named() {
    let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n";
    assert_eq!(
        read_stl(text.as_bytes()).expect("read").triangles,
        [[0, 1, 2]]
    );
    for (broken, words) in [
        (
            text.replace("1 0 0", "1 zero 0"),
            "line 5: vertex needs three",
        ),
        (
            text.replace("vertex 1 0 0\n", ""),
            "line 6: a facet needs exactly",
        ),
        (
            text.replace("endfacet\nendsolid x\n", ""),
            "\"endsolid\" is missing",
        ),
        (text.replace("facet normal", "faucet"), "line 2: \"faucet\""),
        ("no".to_owned(), "too short"),
    ] {
        let error = read_stl(broken.as_bytes()).expect_err(&broken).to_string();
        assert!(error.contains(words), "{error}");
    }
    let mut file = bytes(|out| write_stl(&small_box(), out));
    file.truncate(400);
    assert!(
        read_stl(&file)
            .expect_err("cut")
            .to_string()
            .contains("cut off")
    );
    file = bytes(|out| write_stl(&small_box(), out));
    file[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(
        read_stl(&file)
            .expect_err("NaN")
            .to_string()
            .contains("triangle 0")
    );
}

#[test]
fn ply_returns_every_bit_and_the_colours() {
    let mesh = colored_box(dvec3(0.1, 0.2, 0.3), dvec3(1e6 / 3.0, 2.0, 5.0));
    let back = read_ply(&bytes(|out| write_ply(&mesh, out))).expect("read");
    assert_eq!(back.positions, mesh.positions);
    assert_eq!(back.triangles, mesh.triangles);
    for index in 0..12 {
        let color = |mesh: &Mesh| mesh.surface_of(index).and_then(|s| s.color).map(srgb_bytes);
        // Where others have a colour, none is a light grey.
        let expected = color(&mesh).unwrap_or([203, 203, 203, 255]);
        assert_eq!(color(&back), Some(expected));
    }
    let plain = Mesh::new(mesh.positions, mesh.triangles);
    assert_eq!(
        read_ply(&bytes(|out| write_ply(&plain, out))).expect("read"),
        plain
    );
}

/// With colours of vertices the file says the same to readers that know only these, and the mesh
/// that is read back is that of the plain file.
#[test]
fn ply_has_colours_at_vertices_on_request() {
    let mesh = colored_box(dvec3(0.1, 0.2, 0.3), dvec3(1e6 / 3.0, 2.0, 5.0));
    let mut options = WriteOptions::default();
    options.vertex_colors = true;
    let file = bytes(|out| write_ply_with(&mesh, &options, out));
    let plain_file = bytes(|out| write_ply(&mesh, out));
    let plain = read_ply(&plain_file).expect("read");
    assert_eq!(read_ply(&file).expect("read"), plain);
    // As another program takes it apart: 28 bytes a vertex, 17 a triangle.
    let end = b"end_header\n";
    let header = file.windows(end.len()).position(|w| w == end);
    let data = header.expect("a header") + end.len();
    let text = std::str::from_utf8(&file[..data]).expect("text");
    let count = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        line.expect("a count").parse::<usize>().expect("a number")
    };
    let (vertices, faces) = (count("element vertex "), count("element face "));
    let copies = count("element vertex_copy ");
    // At each of 8 corners three sides meet, of which at some two have one colour.
    let mut pairs = std::collections::BTreeSet::new();
    for index in 0..12 {
        let color = plain
            .surface_of(index)
            .and_then(|s| s.color)
            .map(srgb_bytes);
        pairs.extend(plain.triangles[index].map(|vertex| (vertex, color)));
    }
    assert_eq!(
        (vertices, faces, copies),
        (pairs.len(), 12, pairs.len() - 8)
    );
    assert_eq!(file.len(), data + 28 * vertices + 17 * faces + 4 * copies);
    let (rows, rest) = file[data..].split_at(28 * vertices);
    for index in 0..faces {
        let face = &rest[17 * index..][..17];
        assert_eq!(face[0], 3);
        for (k, corner) in plain.corners(index).into_iter().enumerate() {
            let vertex = u32::from_le_bytes(face[1 + 4 * k..][..4].try_into().expect("four"));
            let row = &rows[28 * vertex as usize..][..28];
            let number =
                |i: usize| f64::from_le_bytes(row[8 * i..][..8].try_into().expect("eight"));
            assert_eq!(DVec3::new(number(0), number(1), number(2)), corner);
            assert_eq!(row[24..], face[13..]);
        }
    }
    // Without colours there is nothing to say.
    let bare = Mesh::new(mesh.positions, mesh.triangles);
    let file = |options| bytes(|out| write_ply_with(&bare, options, out));
    assert_eq!(file(&options), file(&WriteOptions::default()));
}

#[test]
fn ply_copies_of_vertices_that_are_none_are_refused() {
    let text = |of: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
             element vertex_copy 1\nproperty int of\nend_header\n\
             0 0 0\n1 0 0\n0 1 0\n1 0 0\n3 0 3 2\n{of}\n"
        )
    };
    let mesh = read_ply(text("1").as_bytes()).expect("read");
    assert_eq!(
        (mesh.positions.len(), &mesh.triangles[..]),
        (3, &[[0, 1, 2]][..])
    );
    for of in ["3", "-1", "0.5", "nan", "1e9"] {
        let error = read_ply(text(of).as_bytes()).expect_err(of);
        assert!(error.to_string().contains("vertex_copy 0"), "{error}");
    }
}

#[test]
fn ply_of_other_programs_is_read() {
    let text = "ply\nformat ascii 1.0\ncomment by hand\nelement face 1\n\
        property list uchar int vertex_index\nelement vertex 4\nproperty float x\n\
        property float y\nproperty float z\nproperty uchar red\nelement edge 1\n\
        property int a\nend_header\n4 0 1 2 3\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n5\n";
    let mesh = read_ply(text.as_bytes()).expect("read");
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.area(), 1.0);
    // The same in big-endian bytes, with floats.
    let mut data = text[..text.find("4 0 1").expect("data")]
        .replace("ascii", "binary_big_endian")
        .into_bytes();
    data.push(4);
    (0..4i32).for_each(|i| data.extend(i.to_be_bytes()));
    for p in [
        [0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ] {
        p.iter().for_each(|x| data.extend(x.to_be_bytes()));
        data.push(9);
    }
    data.extend(5i32.to_be_bytes());
    assert_eq!(read_ply(&data).expect("read"), mesh);
    for (broken, words) in [
        (
            text.replace("4 0 1 2 3", "4 0 1 2 4"),
            "face 0: it names vertex 4",
        ),
        (text.replace("4 0 1 2 3", "4 0 1 2 -1"), "vertex -1"),
        (text.replace("float z", "real z"), "line 9: unknown type"),
        (
            text.replace("end_header", ""),
            "line 14: this does not belong",
        ),
        (
            text.split("end_header").next().unwrap().to_owned(),
            "\"end_header\" is missing",
        ),
        (text.replace("\n5\n", ""), "edge 0: the data ends here"),
        (text.replace("ply\n", "plyx\n"), "line 1"),
    ] {
        let error = read_ply(broken.as_bytes()).expect_err(&broken).to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// Unpacks a 3MF file with Python's own ZIP and XML modules and prints its
/// unit, counts, volume and colours of triangles.
const INSPECT: &str = r#"
import sys, zipfile, xml.etree.ElementTree as ET
archive = zipfile.ZipFile(sys.argv[1])
assert archive.testzip() is None
core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
rels = ET.fromstring(archive.read("_rels/.rels"))
ET.fromstring(archive.read("[Content_Types].xml"))
model = ET.fromstring(archive.read(rels[0].get("Target")[1:]))
colors = [b.get("displaycolor") for b in model.iter(core + "base")]
item = model.find(core + "build")[0].get("objectid")
mesh = [o for o in model.iter(core + "object") if o.get("id") == item][0][0]
points = [tuple(float(v.get(k)) for k in "xyz") for v in mesh[0]]
volume, shades = 0, []
for t in mesh[1]:
    a, b, c = (points[int(t.get(k))] for k in ("v1", "v2", "v3"))
    volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
               + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    shades.append(colors[int(t.get("p1"))] if t.get("pid") == "1" else "-")
print(model.get("unit"), len(points), len(mesh[1]), volume, *shades)
"#;

#[test]
fn python_finds_the_solid_in_a_3mf_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let inspect = |mesh: &Mesh| {
        let path = folder.path().join("box.3mf");
        io::write_mesh(&path, mesh, &WriteOptions::default()).expect("written");
        let python = if cfg!(windows) { "python" } else { "python3" };
        let output = Command::new(python)
            .args(["-c", INSPECT])
            .arg(&path)
            .output()
            .unwrap_or_else(|error| panic!("this test needs Python 3 ({error})"));
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout)
            .expect("UTF-8")
            .trim_end()
            .to_owned()
    };
    let grey = "#CBCBCB #CBCBCB";
    let orange = "#FF8000 #FF8000";
    let blue = "#0040FF80 #0040FF80";
    assert_eq!(
        inspect(&in_unit(small_box(), LengthUnit::Inch)),
        format!("inch 8 12 6.0 {grey} {orange} {grey} {grey} {blue} {orange}")
    );
    let plain = Mesh::new(small_box().positions, small_box().triangles);
    assert_eq!(
        inspect(&plain),
        format!("millimeter 8 12 6.0{}", " -".repeat(12))
    );
}

/// Files of several megabytes are read in pieces.
#[test]
fn long_text_stl_is_read_as_a_whole_and_its_faults_have_their_line() {
    let mesh = sphere(dvec3(0.1, 0.2, 0.3), 0.7, 120);
    let file = bytes(|out| write_stl_text(&mesh, out));
    assert!(file.len() > 10 << 20, "{}", file.len());
    let back = read_stl(&file).expect("read");
    assert_eq!(corners(&back), corners(&mesh));
    assert_eq!(back.positions.len(), mesh.positions.len());

    let text = String::from_utf8(file).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    for at in [lines.len() / 3, lines.len() / 2, lines.len() - 200] {
        let line = (at..).find(|&k| lines[k].contains("vertex")).expect("one");
        let mut broken = lines.clone();
        broken[line] = "  vertex 1 2";
        let error = read_stl(broken.join("\n").as_bytes()).expect_err("a fault");
        let place = format!("line {}:", line + 1);
        assert!(error.to_string().starts_with(&place), "{error}");
        // A facet without its end runs into the next one.
        let line = (at..).find(|&k| lines[k].contains("endloop")).expect("one");
        let mut broken = lines.clone();
        broken[line] = "";
        let error = read_stl(broken.join("\n").as_bytes()).expect_err("a fault");
        assert!(error.to_string().contains("exactly three"), "{error}");
    }
    let error = read_stl(lines[..lines.len() - 1].join("\n").as_bytes());
    let error = error.expect_err("cut off").to_string();
    assert!(error.contains("endsolid"), "{error}");
}
