//! Bodies that are there several times, written once in glTF files and read back.

use crate::common;
use crate::common::{small_box, sphere};
use csg::{BoundaryOptions, Mesh, Mesher, Program, Solid};
use glam::{DMat3, DVec3, dvec3};
use io::WriteOptions;
use io::gltf::{read_glb, write_glb, write_glb_with};
use serde_json::Value;

/// A file with instances, and its document.
fn instanced(mesh: &Mesh) -> (Vec<u8>, Value) {
    let mut options = WriteOptions::default();
    options.instances = true;
    let mut bytes = Vec::new();
    write_glb_with(mesh, &options, &mut bytes).expect("written");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("a length"));
    let json = serde_json::from_slice(&bytes[20..20 + length as usize]).expect("JSON");
    (bytes, json)
}

/// How often each mesh is there that is there several times, ascending; and whether it is turned.
fn counts(document: &Value) -> Vec<(u64, bool)> {
    let nodes = document["nodes"].as_array().expect("nodes");
    let mut counts: Vec<_> = nodes
        .iter()
        .map(|node| &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"])
        .filter(|attributes| attributes.is_object())
        .map(|attributes| {
            let accessor = attributes["TRANSLATION"].as_u64().expect("a number");
            let count = &document["accessors"][accessor as usize]["count"];
            let is_turned = !attributes["ROTATION"].is_null();
            (count.as_u64().expect("a number"), is_turned)
        })
        .collect();
    counts.sort_unstable();
    counts
}

/// Puts a body into the mesh, its places moved by `place`, its triangles in another order.
fn add(mesh: &mut Mesh, body: &Mesh, linear: DMat3, place: impl Fn(DVec3) -> DVec3) {
    let first = mesh.positions.len() as u32;
    mesh.surfaces.clone_from(&body.surfaces);
    mesh.positions
        .extend(body.positions.iter().map(|&p| place(p)));
    let count = body.triangles.len();
    let is_mirrored = linear.determinant() < 0.0;
    for k in 0..count {
        // (The step has no divisor in common with the counts here.)
        let (triangle, turn) = ((k + count / 3) * 11 % count, k % 3);
        let order = match is_mirrored {
            true => [2, 1, 0],
            false => [turn, (turn + 1) % 3, (turn + 2) % 3],
        };
        let corners = body.triangles[triangle];
        mesh.triangles.push(order.map(|k| first + corners[k]));
        if let Some(normals) = body.corner_normals.get(triangle) {
            let turned = |k: usize| (linear * normals[k].as_dvec3()).as_vec3();
            mesh.corner_normals.push(order.map(turned));
        }
        if let Some(&surface) = body.triangle_surfaces.get(triangle) {
            mesh.triangle_surfaces.push(surface);
        }
    }
}

fn turn(k: usize) -> DMat3 {
    let axis = dvec3(1.0, 2.0, k as f64).normalize();
    csg::elementary::rotation(axis, 0.7 * k as f64)
}

/// How far a corner is at most from the one that is the same triangle's in the other mesh, which has
/// the same names and colours; and how far its normal is.
fn farthest(mesh: &Mesh, other: &Mesh) -> (f64, f64) {
    assert_eq!(mesh.triangles.len(), other.triangles.len());
    let look = |mesh: &Mesh, index: usize| {
        let surface = mesh.surface_of(index).cloned().unwrap_or_default();
        (
            surface.name,
            surface.parts,
            surface.color.map(common::srgb_bytes),
        )
    };
    let mut is_used = vec![false; other.triangles.len()];
    let (mut worst, mut worst_normal) = (0.0_f64, 0.0_f32);
    for index in 0..mesh.triangles.len() {
        let corners = mesh.corners(index);
        let (distance, found, turn) = (0..other.triangles.len())
            .filter(|&found| !is_used[found])
            .flat_map(|found| (0..3).map(move |turn| (found, turn)))
            .map(|(found, turn)| {
                let others = other.corners(found);
                let distance = |k: usize| corners[k].distance(others[(k + turn) % 3]);
                let farthest = (0..3).map(distance).fold(0.0, f64::max);
                (farthest, found, turn)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("a triangle that is left");
        is_used[found] = true;
        assert_eq!(look(mesh, index), look(other, found));
        worst = worst.max(distance);
        if let Some(normals) = mesh.corner_normals.get(index) {
            for (k, normal) in normals.iter().enumerate() {
                let other = other.corner_normals[found][(k + turn) % 3];
                worst_normal = worst_normal.max(normal.distance(other));
            }
        }
    }
    (worst, worst_normal.into())
}

fn longest_side(mesh: &Mesh) -> f64 {
    let (low, high) = mesh.bounds().expect("bounds");
    (high - low).max_element()
}

/// Boxes with names and colours, moved and turned, and others that are nearly the same.
fn boxes() -> Mesh {
    let body = small_box();
    let mut mesh = Mesh::default();
    for k in 0..9 {
        let at = dvec3(10.0 * k as f64, 1.0 / 3.0, 0.1 * k as f64);
        add(&mut mesh, &body, turn(k), |p| turn(k) * p + at);
    }
    // Mirrored, larger, with one corner elsewhere, and with another colour on a side.
    let mirrored = DMat3::from_diagonal(dvec3(-1.0, 1.0, 1.0));
    add(&mut mesh, &body, mirrored, |p| {
        mirrored * p + dvec3(0.0, 50.0, 0.0)
    });
    add(&mut mesh, &body, DMat3::IDENTITY, |p| {
        1.000_01 * p + dvec3(20.0, 50.0, 0.0)
    });
    add(&mut mesh, &body, DMat3::IDENTITY, |p| {
        let nudge = if p == DVec3::ZERO { 1e-5 } else { 0.0 };
        p + dvec3(40.0, 50.0, nudge)
    });
    let mut other = body.clone();
    other.triangle_surfaces[0] = 1;
    add(&mut mesh, &other, DMat3::IDENTITY, |p| {
        p + dvec3(60.0, 50.0, 0.0)
    });
    mesh
}

#[test]
fn bodies_that_are_the_same_are_written_once() {
    let mesh = boxes();
    let (bytes, document) = instanced(&mesh);
    assert_eq!(counts(&document), [(9, true)]);
    let extension = serde_json::json!(["EXT_mesh_gpu_instancing"]);
    assert_eq!(document["extensionsUsed"], extension);
    assert_eq!(document["extensionsRequired"], extension);
    let read = read_glb(&bytes).expect("read");
    let (distance, normal) = farthest(&mesh, &read);
    let bound = longest_side(&mesh) / f64::from(1 << 22);
    assert!(distance <= bound, "{distance} > {bound}");
    assert!(normal < 2e-6, "{normal}");
    assert!(read.check().is_manifold());
    // The measure itself finds what is another mesh.
    let mut moved = mesh.clone();
    moved.positions[0].x += 2.0 * bound;
    assert!(farthest(&moved, &read).0 > bound);
}

#[test]
fn balls_are_written_once_if_only_moved_and_if_turned() {
    let ball = sphere(dvec3(0.3, 0.1, 0.0), 1.0, 7);
    let mut bare = ball.clone();
    bare.corner_normals.clear();
    for body in [ball, bare] {
        for is_turned in [false, true] {
            let mut mesh = Mesh::default();
            for k in 0..12 {
                let linear = if is_turned { turn(k) } else { DMat3::IDENTITY };
                let at = 3.0 * dvec3(k as f64, (k % 3) as f64, 1e3 / 3.0);
                add(&mut mesh, &body, linear, |p| linear * p + at);
            }
            let (bytes, document) = instanced(&mesh);
            assert_eq!(counts(&document), [(12, is_turned)]);
            let mut plain = Vec::new();
            write_glb(&mesh, &mut plain).expect("written");
            assert!(4 * bytes.len() < plain.len());
            let read = read_glb(&bytes).expect("read");
            let (distance, normal) = farthest(&mesh, &read);
            assert!(distance <= longest_side(&mesh) / f64::from(1 << 22));
            assert!(normal < 2e-6, "{normal}");
            assert!((read.volume() / mesh.volume() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn without_bodies_that_are_the_same_the_file_is_the_plain_one() {
    let mut two = Mesh::default();
    add(&mut two, &small_box(), DMat3::IDENTITY, |p| p);
    add(&mut two, &small_box(), DMat3::IDENTITY, |p| 1.5 * p + 9.0);
    // Bodies that are the same, but so small that a node of their own would be larger.
    let mut small = Mesh::default();
    let tetrahedron = Mesh::new(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    );
    for k in 0..3 {
        add(&mut small, &tetrahedron, DMat3::IDENTITY, |p| {
            p + 3.0 * k as f64
        });
    }
    for mesh in [small_box(), sphere(DVec3::ZERO, 1.0, 9), two, small] {
        let mut plain = Vec::new();
        write_glb(&mesh, &mut plain).expect("written");
        assert_eq!(instanced(&mesh).0, plain);
    }
}

/// What the mesher makes of balls and boxes in rows and around an axis, in parts of an assembly.
#[test]
fn patterns_of_solids_are_written_once() {
    let row = |solid: &Solid| {
        Solid::union((0..6).map(|k| solid.translate([3.0 * f64::from(k), 0.0, 0.0])))
    };
    let balls = row(&Solid::sphere(1.0)).named("balls");
    let around = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 20.0;
        let plate = Solid::cube(2.0) - Solid::cuboid([1.0, 1.0, 9.0]);
        plate.translate([30.0, 0.0, 0.0]).rotate_z(angle)
    };
    let ring = Solid::union((0..20).map(around)).named("ring");
    let loose = Solid::cuboid([5.0, 4.0, 3.0])
        .translate([0.0, 0.0, 20.0])
        .named("balls");
    let solid = (balls | ring | loose).named("all");
    let program = Program::lower(&solid).expect("valid");
    let mesh = Mesher::new()
        .tolerance(0.05)
        .mesh(&program)
        .expect("meshed")
        .mesh;
    let (bytes, document) = instanced(&mesh);
    let counts = counts(&document);
    let (balls, rings): (Vec<_>, Vec<_>) = counts.iter().partition(|(_, turned)| !turned);
    assert_eq!(balls, [(6, false)], "{counts:?}");
    assert!(
        rings.iter().map(|(count, _)| count).sum::<u64>() >= 10,
        "{counts:?}"
    );
    let read = read_glb(&bytes).expect("read");
    let (distance, _) = farthest(&mesh, &read);
    assert!(distance <= longest_side(&mesh) / f64::from(1 << 22));
    assert!(read.check().is_manifold());
    // They are within the nodes of their parts.
    let nodes = document["nodes"].as_array().expect("nodes");
    let named = |name: &str| {
        nodes
            .iter()
            .find(|node| node["name"] == name)
            .expect("a node")
    };
    let inner = |name: &str| named(name)["children"].as_array().map_or(0, Vec::len);
    assert_eq!(inner("balls"), 1);
    assert_eq!(inner("ring"), rings.len());
    assert!(named("balls")["mesh"].is_u64());
}

/// What bodies in rows, around an axis and turned about any axis have in common: none of these are of
/// planes alone, so that the mesher makes other triangles of each.
fn patterns() -> [(&'static str, Solid); 6] {
    let bolt = Solid::extrude(&csg::Profile::regular_polygon(6, 5.0), 0.0..4.0)
        | Solid::cylinder(2.5, -20.0..1.0).named("shank");
    let plate = Solid::cuboid([8.0, 6.0, 2.0]) - Solid::cylinder(1.5, -2.0..2.0);
    let bore = Solid::cylinder(1.0, -9.0..9.0).rotate_x(1.1);
    let shaft = Solid::cylinder(2.0, -6.0..6.0) - bore;
    let pin = Solid::cone(2.0, -6.0..6.0) | Solid::sphere(1.0).translate([0.0, 0.0, 6.0]);
    let hollow = Solid::cuboid([6.0, 6.0, 16.0]) - &pin;
    let tee = Solid::cylinder(1.5, -5.0..5.0) | Solid::cylinder(1.0, 0.0..6.0).rotate_y(1.3);
    [
        ("bolts", bolt),
        ("plates", plate),
        ("shafts", shaft),
        ("pins", pin),
        ("hollow blocks", hollow),
        ("tees", tee),
    ]
}

fn at(k: usize) -> DVec3 {
    dvec3(40.0 * k as f64, 7.0 * (k % 3) as f64, 0.3 * k as f64)
}

fn placed(body: &Solid, k: usize, linear: DMat3) -> Solid {
    body.affine(glam::DAffine3::from_mat3_translation(linear, at(k)))
}

/// A mesh to a tolerance, and its boundary.
fn meshed(solid: &Solid, tolerance: f64) -> (Program, Mesh, csg::Brep) {
    let program = Program::lower(solid).expect("valid");
    let brep = program.boundary(&BoundaryOptions::new()).expect("bounded");
    let mesher = Mesher::new().tolerance(tolerance).normals();
    let mesh = mesher.mesh(&program).expect("meshed").mesh;
    (program, mesh, brep)
}

/// How far corners of triangles are at most from the surface whose number they have, how far their
/// normals are from its gradient, and how far feature edges are from two of the surfaces.
fn off_surfaces(program: &Program, mesh: &Mesh) -> [f64; 3] {
    let surfaces = program.surfaces();
    let mut worst = [0.0_f64; 3];
    let distance =
        |surface: &csg::Surface, p| surface.value(p).abs() / surface.gradient(p).length().max(1e-3);
    for index in 0..mesh.triangles.len() {
        let surface = &surfaces[mesh.surface_of(index).expect("a surface").surface as usize];
        let corners = mesh.corners(index);
        for (p, normal) in corners.into_iter().zip(mesh.corner_normals[index]) {
            worst[0] = worst[0].max(distance(surface, p));
            let gradient = surface.gradient(p).normalize();
            let sine = normal.as_dvec3().cross(gradient).length();
            worst[1] = worst[1].max(sine);
        }
    }
    for &vertex in mesh.feature_edges.iter().flatten() {
        let p = mesh.positions[vertex as usize];
        let mut all: Vec<f64> = surfaces
            .iter()
            .map(|surface| distance(surface, p))
            .collect();
        all.sort_by(f64::total_cmp);
        worst[2] = worst[2].max(all[1]);
    }
    worst
}

#[test]
fn bodies_that_are_the_same_in_the_solid_get_the_same_triangles() {
    for (name, body) in patterns() {
        for is_turned in [false, true] {
            let linear = |k| if is_turned { turn(k) } else { DMat3::IDENTITY };
            let solid = Solid::union((0..8).map(|k| placed(&body, k, linear(k))));
            let (program, plain, brep) = meshed(&solid, 0.01);
            let mut mesh = plain.clone();
            let count = io::share_triangles(&mut mesh, &brep);
            let shells = brep.shells().len();
            assert_eq!(count, shells - shells / 8, "{name}");
            let instances = counts(&instanced(&mesh).1);
            let expected = vec![(8, is_turned); shells / 8];
            assert_eq!(instances, expected, "{name}");
            assert!(mesh.check().is_manifold() && mesh.self_intersections().is_empty());
            assert_eq!(mesh.components().count, shells);
            let [place, normal, edge] = off_surfaces(&program, &mesh);
            assert!(
                place < 1e-9 && normal < 1e-6 && edge < 1e-9,
                "{name}: {place} {normal} {edge}"
            );
            // The measure itself finds what is elsewhere.
            let mut moved = mesh.clone();
            moved.positions[0] += DVec3::splat(1e-6);
            assert!(off_surfaces(&program, &moved)[0] > 1e-8);
            // No more than a layer as thick as the tolerance is missing.
            let exact = brep.measure();
            let missing = (mesh.volume() - exact.volume.value).abs();
            assert!(missing < 0.01 * exact.area.value, "{name}: {missing}");
        }
    }
}

#[test]
fn bodies_that_are_not_the_same_keep_their_triangles() {
    let bored = |at: f64, radius: f64| {
        Solid::cuboid([8.0, 6.0, 2.0])
            - Solid::cylinder(radius, -2.0..2.0).translate([at, 1.0, 0.0])
    };
    let first = bored(1.0, 1.5);
    let mirrored = DMat3::from_diagonal(dvec3(-1.0, 1.0, 1.0));
    let slanted = Solid::cylinder(0.5, -9.0..9.0).rotate_x(0.5);
    // (Slanted so that it has no half turn.)
    let chiral = |body: &Solid| body - &slanted.translate([-2.0, 0.0, 0.0]);
    let others = [
        (
            "mirrored",
            chiral(&first),
            chiral(&first).affine(glam::DAffine3::from_mat3(mirrored)),
        ),
        ("larger bore", first.clone(), bored(1.0, 1.500_001)),
        ("bore elsewhere", first.clone(), bored(1.000_001, 1.5)),
        (
            "other colour",
            first.clone(),
            first.colored(csg::Color::from_linear([1.0, 0.0, 0.0])),
        ),
        (
            "inside out",
            Solid::sphere(1.0),
            Solid::cube(4.0) - Solid::sphere(1.0),
        ),
        // One arc of a circle, and the other one.
        (
            "rest of the ball",
            Solid::sphere(2.0) & Solid::half_space(DVec3::Z, 1.0),
            Solid::sphere(2.0) & Solid::half_space(DVec3::NEG_Z, -1.0),
        ),
    ];
    for (name, first, other) in others {
        let solid = placed(&first, 0, DMat3::IDENTITY) | placed(&other, 1, turn(1));
        let (_, plain, brep) = meshed(&solid, 0.01);
        let mut mesh = plain.clone();
        assert_eq!(io::share_triangles(&mut mesh, &brep), 0, "{name}");
        assert_eq!(mesh, plain, "{name}");
    }
}

/// Rods that are nearer to each other than their meshes are to them, turned so that one's corners would
/// be in the other's sides.
#[test]
fn bodies_keep_their_triangles_if_those_of_others_would_run_through_each_other() {
    let rod = Solid::cylinder(1.0, -3.0..3.0);
    let hole = Solid::cylinder(1.000_1, -3.0..3.0);
    let sleeve = Solid::cuboid([4.0, 4.0, 5.0]) - hole;
    let loose = rod.translate([9.0, 0.0, 0.0]).rotate_z(0.05);
    let solid = loose | rod | sleeve;
    let (_, plain, brep) = meshed(&solid, 0.05);
    assert!(plain.self_intersections().is_empty());
    let mut mesh = plain.clone();
    let count = io::share_triangles(&mut mesh, &brep);
    assert!(mesh.self_intersections().is_empty());
    assert!(count == 1 || mesh == plain);
}

/// A document of one triangle with instances as told.
fn document(attributes: &Value, count: u64) -> Vec<u8> {
    let data: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .into_iter()
        // Two translations, two quarter turns about z, two scales.
        .chain([0.0, 0.0, 0.0, 5.0, 0.0, 0.0])
        .chain([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0])
        .chain([1.0, 1.0, 1.0, 2.0, 2.0, -2.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    let accessor = |offset: u64, count: u64, kind: &str| {
        serde_json::json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5126,
            "count": count, "type": kind })
    };
    let json = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": ["EXT_mesh_gpu_instancing"],
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing":
            { "attributes": attributes } } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [accessor(0, 3, "VEC3"), accessor(36, 2, "VEC3"), accessor(60, count, "VEC4"),
            accessor(92, 2, "VEC3"), accessor(60, 2, "VEC3")],
        "bufferViews": [{ "buffer": 0, "byteLength": data.len() }],
        "buffers": [{ "byteLength": data.len() }],
    });
    let mut json = serde_json::to_vec(&json).expect("JSON");
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 28 + json.len() + data.len();
    let mut bytes = b"glTF".to_vec();
    for word in [2, total, json.len()] {
        bytes.extend((word as u32).to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}

/// The standard's order, by a file of another's making: scaled, turned, moved.
#[test]
fn instances_are_scaled_then_turned_then_moved() {
    let all = serde_json::json!({ "TRANSLATION": 1, "ROTATION": 2, "SCALE": 3 });
    let mesh = read_glb(&document(&all, 2)).expect("read");
    assert_eq!(mesh.triangles.len(), 2);
    // Y up in metres there, Z up in millimetres here: (x, y, z) is (x, -z, y) here. The second one
    // is mirrored, so that its corners come in the other order; its corner (1, 0, 0) becomes
    // (2, 0, 0), (0, 2, 0), (5, 2, 0).
    let at = |x: f64, y: f64, z: f64| 1000.0 * dvec3(x, -z, y);
    let expected = [
        [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0)],
        [at(5.0, 0.0, 0.0), at(3.0, 0.0, 0.0), at(5.0, 2.0, 0.0)],
    ];
    for (index, expected) in expected.iter().enumerate() {
        for (found, expected) in mesh.corners(index).iter().zip(expected) {
            assert!(found.distance(*expected) < 1e-3, "{found} {expected}");
        }
    }
}

#[test]
fn instances_that_cannot_be_are_refused() {
    let refused = |attributes: Value, count: u64, said: &str| {
        let error = read_glb(&document(&attributes, count)).expect_err(said);
        assert!(error.to_string().contains(said), "{error}");
    };
    let json = |text: &str| serde_json::from_str(text).expect("JSON");
    refused(json(r#"{"TRANSLATION":1,"ROTATION":2}"#), 1, "not as many");
    refused(json(r#"{"TRANSLATION":9}"#), 2, "no such accessor");
    refused(json(r#"{"ROTATION":1}"#), 2, "VEC4");
    // Without attributes it is nowhere.
    refused(json("{}"), 2, "no triangle");
}

/// Whatever byte is another one, the file is refused, or something is read of it.
#[test]
fn damaged_instances_are_refused_or_read_as_something() {
    let (bytes, _) = instanced(&boxes());
    let mut refused = 0;
    // (All of them, a dozen times slower, were tried once.)
    for at in (12..bytes.len()).step_by(13) {
        for byte in [b'0', b'9', 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = byte;
            match read_glb(&damaged) {
                Ok(mesh) => assert_eq!(mesh.check().out_of_range_triangles, 0),
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > bytes.len() / 26, "{refused}");
}
