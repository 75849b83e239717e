//! No file, however damaged, makes a reader panic; and what is read without
//! an error is a mesh that the checks accept.

use crate::common::{MODEL, archive, small_box};
use csg::Mesh;
use io::Error;
use io::{gltf, obj, off, ply, stl, threemf};
use proptest::prelude::*;
use proptest::sample::Index;

type Reader = fn(&[u8]) -> Result<Mesh, Error>;

/// A small whole file of every kind, with its reader.
fn samples() -> Vec<(&'static str, Vec<u8>, Reader)> {
    let mesh = small_box();
    let write = |write: &dyn Fn(&mut Vec<u8>) -> Result<(), Error>| {
        let mut bytes = Vec::new();
        write(&mut bytes).expect("written");
        bytes
    };
    let embedded = write(&|out| {
        use base64::Engine;
        let (mut json, mut bin) = (Vec::new(), Vec::new());
        gltf::write_gltf(&mesh, "DATA", &mut json, &mut bin)?;
        let text = base64::engine::general_purpose::STANDARD.encode(&bin);
        let json = String::from_utf8_lossy(&json).replace(
            "DATA",
            &format!("data:application/octet-stream;base64,{text}"),
        );
        out.extend(json.into_bytes());
        Ok(())
    });
    let text_ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\n\
        property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 9 9\n";
    let read_obj: Reader = |data| obj::read_obj(data, |_| Some(data.to_vec()));
    // (Materials that a triangle uses.)
    let read_mtl: Reader = |data| {
        let faces = b"mtllib m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl color1-ff8000\nf 1 2 3\n";
        obj::read_obj(faces, |_| Some(data.to_vec()))
    };
    let read_json: Reader = |data| gltf::read_gltf(data, |_| Ok(Vec::new()));
    vec![
        (
            "glb",
            write(&|out| gltf::write_glb(&mesh, out)),
            gltf::read_glb,
        ),
        ("gltf", embedded, read_json),
        (
            "obj",
            write(&|out| obj::write_obj(&mesh, Some("m"), out)),
            read_obj,
        ),
        ("mtl", write(&|out| obj::write_mtl(&mesh, out)), read_mtl),
        (
            "stl",
            write(&|out| stl::write_stl(&mesh, out)),
            stl::read_stl,
        ),
        (
            "text stl",
            write(&|out| stl::write_stl_text(&mesh, out)),
            stl::read_stl,
        ),
        (
            "ply",
            write(&|out| ply::write_ply(&mesh, out)),
            ply::read_ply,
        ),
        (
            "off",
            write(&|out| off::write_off(&mesh, out)),
            off::read_off,
        ),
        (
            "3mf",
            write(&|out| threemf::write_3mf(&mesh, out)),
            threemf::read_3mf,
        ),
        ("3mf model", MODEL.into(), |data| {
            threemf::read_3mf(&archive(data))
        }),
        ("text ply", text_ply.to_vec(), ply::read_ply),
    ]
}

/// Reads, and checks what comes out.
fn read(name: &str, data: &[u8], reader: Reader) {
    if let Ok(mesh) = reader(data) {
        let check = mesh.check();
        assert_eq!(check.out_of_range_triangles, 0, "{name}");
        assert_eq!(check.degenerate_triangles, 0, "{name}");
        assert_eq!(check.non_finite_vertices, 0, "{name}");
        let as_many = |length: usize| length == 0 || length == mesh.triangles.len();
        assert!(as_many(mesh.corner_normals.len()) && as_many(mesh.triangle_surfaces.len()));
    }
}

#[test]
fn every_truncation_is_survived() {
    for (name, data, reader) in samples() {
        reader(&data).expect(name);
        for length in 0..data.len() {
            read(name, &data[..length], reader);
        }
    }
}

/// Text that is likely to matter somewhere.
const TOKENS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"1e309",
    b"nan",
    b"4294967296",
    b"99999999999999999999",
    b"\n",
    b" ",
    b"/",
    b"null",
    b"[]",
    b"{",
    b"\"",
    b"\\\n",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_damage_is_survived(
        kind in any::<Index>(),
        edits in prop::collection::vec((any::<Index>(), any::<u8>(), any::<Index>(), 0..4u8), 1..6),
    ) {
        let samples = samples();
        let (name, data, reader) = kind.get(&samples);
        let mut data = data.clone();
        for (at, byte, other, action) in edits {
            if data.is_empty() {
                break;
            }
            let at = at.index(data.len());
            match action {
                0 => data[at] = byte,
                1 => {
                    let token = other.get(&TOKENS);
                    let end = data.len().min(at + token.len());
                    data.splice(at..end, token.iter().copied());
                }
                2 => {
                    let end = other.index(data.len() + 1);
                    data.drain(at.min(end)..at.max(end));
                }
                _ => {
                    let end = (at + usize::from(byte)).min(data.len());
                    let copy = data[at..end].to_vec();
                    let place = other.index(data.len() + 1);
                    data.splice(place..place, copy);
                }
            }
        }
        read(name, &data, *reader);
    }
}
