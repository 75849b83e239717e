//! The glTF writer against the `gltf` crate, and the reader against both.

use crate::common::{colored_box, faces, in_unit, small_box, sphere};
use csg::{LengthUnit, Mesh};
use glam::{DMat4, DVec3, Vec3, dvec3};
use io::Error;
use io::gltf::{read_glb, read_gltf, write_glb, write_gltf};

fn glb(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_glb(mesh, &mut bytes).expect("written");
    bytes
}

/// Corners, their normals, the names of the primitive, the base colour.
type Seen = ([DVec3; 3], Option<[Vec3; 3]>, Option<String>, [f32; 4]);

/// The triangles as the `gltf` crate sees them, in metres with Y up, with
/// names and base colours; composed in double precision.
fn seen_by_gltf(bytes: &[u8]) -> Vec<Seen> {
    let file = gltf::Gltf::from_slice(bytes).expect("valid glTF");
    let blob = file.blob.clone().expect("a binary chunk");
    let mut seen = Vec::new();
    let scene = file.default_scene().expect("a scene");
    let mut stack: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((node, parent)) = stack.pop() {
        let local = glam::Mat4::from_cols_array_2d(&node.transform().matrix());
        let transform = parent * local.as_dmat4();
        stack.extend(node.children().map(|child| (child, transform)));
        for primitive in node
            .mesh()
            .into_iter()
            .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>())
        {
            let reader = primitive.reader(|_| Some(&blob[..]));
            let places: Vec<DVec3> = reader
                .read_positions()
                .expect("positions")
                .map(|p| transform.transform_point3(Vec3::from_array(p).as_dvec3()))
                .collect();
            let normals: Option<Vec<Vec3>> = reader
                .read_normals()
                .map(|normals| normals.map(Vec3::from_array).collect());
            let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
            let factor = primitive
                .material()
                .pbr_metallic_roughness()
                .base_color_factor();
            for triangle in indices.chunks(3) {
                let corners = [0, 1, 2].map(|i| triangle[i] as usize);
                seen.push((
                    corners.map(|c| places[c]),
                    normals.as_ref().map(|normals| corners.map(|c| normals[c])),
                    primitive
                        .extras()
                        .as_ref()
                        .map(|extras| extras.get().to_owned()),
                    factor,
                ));
            }
        }
    }
    seen
}

#[test]
fn the_gltf_crate_sees_the_same_solid_in_metres_with_y_up() {
    let mesh = small_box();
    let seen = seen_by_gltf(&glb(&mesh));
    assert_eq!(seen.len(), 12);
    let mut volume = 0.0;
    let mut high = DVec3::NEG_INFINITY;
    let mut low = DVec3::INFINITY;
    for ([a, b, c], normals, name, factor) in &seen {
        volume += a.dot(b.cross(*c)) / 6.0;
        for p in [a, b, c] {
            (low, high) = (low.min(*p), high.max(*p));
        }
        // Node-local normals turned like the positions agree with the winding.
        let face = (b - a).cross(c - a).normalize();
        for normal in normals.expect("normals") {
            let turned = dvec3(normal.x.into(), normal.z.into(), -f64::from(normal.y));
            assert!((turned - face).length() < 1e-6);
        }
        // The model's +Z face is the one in glTF's +Y, and is an orange hub.
        if face.y > 0.5 {
            assert_eq!(name.as_deref(), Some(r#"{"names":["hub"]}"#));
            let orange = csg::Color::from_srgb([1.0, 0.5, 0.0]);
            assert_eq!(factor, &[orange.rgb[0], orange.rgb[1], orange.rgb[2], 1.0]);
        }
    }
    // 1 x 2 x 3 mm; z becomes y, y becomes -z. (0.001 in single precision.)
    assert!((volume / 6e-9 - 1.0).abs() < 1e-6);
    assert!((low - dvec3(0.0, 0.0, -0.002)).length() < 1e-9);
    assert!((high - dvec3(0.001, 0.003, 0.0)).length() < 1e-9);
}

#[test]
fn materials_and_names_are_few() {
    let bytes = glb(&small_box());
    let file = gltf::Gltf::from_slice(&bytes).expect("valid");
    // One body, whose faces have no name in common.
    let names: Vec<_> = file.nodes().map(|n| n.name().map(str::to_owned)).collect();
    assert_eq!(names, [None, Some("model".to_owned())]);
    let primitives = file.meshes().flat_map(|mesh| mesh.primitives());
    let extras = primitives.map(|p| {
        p.extras()
            .as_ref()
            .map_or("", |extras| extras.get())
            .to_owned()
    });
    let hub = r#"{"names":["hub"]}"#;
    assert_eq!(
        extras.collect::<Vec<_>>(),
        ["", "", hub, hub, r#"{"names":["Nabe 2 <&\">"]}"#]
    );
    let materials: Vec<_> = file
        .materials()
        .filter_map(|m| m.name().map(str::to_owned))
        .collect();
    assert_eq!(materials, ["default", "color1-FF8000", "color2-0040FF80"]);
    let blended = file
        .materials()
        .filter(|m| m.alpha_mode() == gltf::material::AlphaMode::Blend)
        .count();
    assert_eq!(blended, 1);
    let extras = file.as_json().asset.extras.as_ref().expect("extras");
    assert_eq!(
        extras.get(),
        r#"{"modelUpAxis":"Z","unit":"millimetre","unitInMetres":0.001}"#
    );
}

#[test]
fn corners_with_one_place_and_normal_are_one_vertex() {
    // Eight corners with three normals each.
    let mut mesh = small_box();
    mesh.triangle_surfaces.clear();
    let count = |mesh: &Mesh| {
        let file = gltf::Gltf::from_slice(&glb(mesh)).expect("valid");
        file.accessors().next().expect("an accessor").count()
    };
    assert_eq!(count(&mesh), 24);
    mesh.corner_normals.clear();
    assert_eq!(count(&mesh), 8);
    assert_eq!(count(&sphere(DVec3::ZERO, 1.0, 10)), 2 + 9 * 20);
}

#[test]
fn a_mesh_returns_as_it_was_in_every_unit() {
    for unit in [
        LengthUnit::Micrometre,
        LengthUnit::Millimetre,
        LengthUnit::Centimetre,
        LengthUnit::Metre,
        LengthUnit::Inch,
        LengthUnit::Foot,
    ] {
        // Coordinates that single precision holds exactly.
        let mesh = in_unit(
            colored_box(dvec3(-0.5, 3.0, 7.25), dvec3(1.5, 4.0, 8.0)),
            unit,
        );
        let back = read_glb(&glb(&mesh)).expect("read");
        assert_eq!(back.unit, unit);
        assert_eq!(faces(&back), faces(&mesh));
        let check = back.check();
        assert!(check.is_manifold(), "{check}");
        for (index, normals) in back.corner_normals.iter().enumerate() {
            let [a, b, c] = back.corners(index);
            let face = (b - a).cross(c - a).normalize();
            assert!(
                normals
                    .iter()
                    .all(|n| (n.as_dvec3() - face).length() < 1e-6)
            );
        }
        let (mut json, mut bin) = (Vec::new(), Vec::new());
        write_gltf(&mesh, "two%20words.bin", &mut json, &mut bin).expect("written");
        let pair = read_gltf(&json, |name| {
            assert_eq!(name, "two words.bin");
            Ok(bin.clone())
        });
        assert_eq!(pair.expect("read"), back);
    }
}

#[test]
fn digits_survive_far_from_the_origin() {
    for offset in [
        dvec3(1e6, -1e6, 5e5),
        dvec3(-1e9, 1e7, 0.1),
        DVec3::splat(1e12),
    ] {
        let mesh = sphere(offset, 1.0, 16);
        let back = read_glb(&glb(&mesh)).expect("read");
        assert_eq!(back.triangles.len(), mesh.triangles.len());
        assert!(back.check().is_manifold());
        // Single precision of the radius, plus the double's own at the offset.
        let allowed = 2e-7 + 4.0 * f64::EPSILON * offset.length();
        for index in 0..back.positions.len() {
            let radius = (back.positions[index] - offset).length();
            assert!((radius - 1.0).abs() < allowed, "{radius} at {offset}");
        }
        // Readers that know only single precision get the same numbers, up to
        // their own 24 bits for the offset.
        if offset.abs().max_element() < 1e7 {
            for (corners, ..) in seen_by_gltf(&glb(&mesh)) {
                for p in corners {
                    let p = dvec3(p.x, -p.z, p.y) / f64::from(0.001f32);
                    assert!(((p - offset).length() - 1.0).abs() < 1e-6, "{p}");
                }
            }
        }
    }
}

#[test]
fn nothing_and_nonsense_are_clear_errors() {
    let mut out = Vec::new();
    let error = write_glb(&Mesh::default(), &mut out).expect_err("empty");
    assert!(matches!(error, Error::EmptyMesh));
    assert!(error.to_string().contains("no triangles"));
    let mut mesh = small_box();
    mesh.triangles[3][1] = 99;
    let error = write_glb(&mesh, &mut out).expect_err("out of range");
    assert!(error.to_string().contains("triangle 3"), "{error}");
    let mut mesh = small_box();
    mesh.positions[5].y = f64::INFINITY;
    let error = write_glb(&mesh, &mut out).expect_err("infinite");
    assert!(error.to_string().contains("vertex 5"), "{error}");
    let mut mesh = small_box();
    mesh.corner_normals.pop();
    let error = write_glb(&mesh, &mut out).expect_err("wrong length");
    assert!(error.to_string().contains("corner_normals"), "{error}");
    let vast = sphere(DVec3::ZERO, 1e200, 5);
    let error = write_glb(&vast, &mut out).expect_err("beyond single precision");
    assert!(matches!(error, Error::DoesNotFit { .. }), "{error}");
    assert!(out.is_empty(), "nothing was written");
}

#[test]
fn other_programs_files_are_read() {
    // Transforms by parts, mirrored; a strip of 16-bit indices; data embedded.
    let mut data: Vec<u8> = Vec::new();
    for p in [
        [0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ] {
        p.iter().for_each(|x| data.extend(x.to_le_bytes()));
    }
    [0u16, 1, 2, 3]
        .iter()
        .for_each(|i| data.extend(i.to_le_bytes()));
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(&data);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[
            {{"children":[1],"scale":[-1,1,1]}},
            {{"mesh":0,"name":"strip","translation":[2,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476]}}],
          "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":5}}]}}],
          "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
                       {{"bufferView":1,"componentType":5123,"count":4,"type":"SCALAR"}}],
          "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":8}}],
          "buffers":[{{"byteLength":56,"uri":"data:application/octet-stream;base64,{text}"}}]}}"#
    );
    let mesh = read_gltf(json.as_bytes(), |_| panic!("nothing to load")).expect("read");
    assert_eq!(mesh.surfaces[0].name.as_deref(), Some("strip"));
    assert_eq!(mesh.triangles.len(), 2);
    // Turned by 90 degrees about z, moved by 2 in x, mirrored in x; then from
    // metres with Y up to millimetres with Z up: (x, y, 0) -> (y - 2, 0, x).
    let corner = |x: f64, y: f64| dvec3(y - 2.0, 0.0, x) * 1000.0;
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        assert!(
            mesh.positions
                .iter()
                .any(|p| (*p - corner(x, y)).length() < 1e-9)
        );
    }
    // The strip faced +z before; a rotation about z and a mirror leave glTF's
    // +z, which is the model's -y, in front.
    for index in 0..2 {
        let [a, b, c] = mesh.corners(index);
        assert!((b - a).cross(c - a).y < -0.9e6);
    }
    let compressed = json.replace(
        r#""nodes""#,
        r#""extensionsRequired":["KHR_draco_mesh_compression"],"nodes""#,
    );
    let error = read_gltf(compressed.as_bytes(), |_| panic!()).expect_err("compressed");
    assert!(error.to_string().contains("KHR_draco_mesh_compression"));
    let cyclic = json.replace(r#""mesh":0"#, r#""mesh":0,"children":[0]"#);
    let cyclic = cyclic.replace(
        r#""nodes""#,
        r#""scene":0,"scenes":[{"nodes":[0]}],"nodes""#,
    );
    let error = read_gltf(cyclic.as_bytes(), |_| panic!()).expect_err("cyclic");
    assert!(error.to_string().contains("tree"), "{error}");
}

#[test]
fn indices_take_16_bits_where_they_fit() {
    // A sphere of 79602 vertices, three triangles of which are a part of their own,
    // and one of 14 vertices.
    let mut wide = sphere(DVec3::ZERO, 1.0, 200);
    wide.surfaces = small_box().surfaces;
    wide.triangle_surfaces = vec![0; wide.triangles.len()];
    wide.triangle_surfaces[..3].copy_from_slice(&[1, 1, 1]);
    for (mesh, sizes) in [(wide, vec![2, 4]), (sphere(DVec3::ZERO, 1.0, 3), vec![2])] {
        let bytes = glb(&mesh);
        assert_eq!(bytes.len() % 4, 0);
        let file = gltf::Gltf::from_slice(&bytes).expect("valid");
        let primitives = file.meshes().flat_map(|mesh| mesh.primitives());
        let indices = primitives.map(|p| p.indices().expect("indices").data_type().size());
        let mut found: Vec<usize> = indices.collect();
        found.sort_unstable();
        assert_eq!(found, sizes);
        // (Read back in single precision, and once more the same.)
        let read = read_glb(&bytes).expect("read");
        let again = read_glb(&glb(&read)).expect("read");
        assert_eq!(faces(&again), faces(&read));
        assert_eq!(read.triangles.len(), mesh.triangles.len());
        assert_eq!(seen_by_gltf(&bytes).len(), mesh.triangles.len());
    }
}
