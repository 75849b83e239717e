//! Questions to manifold3d. The benchmarks ask as well.

use std::fs;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use csg::{Mesh, Node, Primitive, Solid};
use glam::DVec3;
use serde_json::{Value, json};
use stereotomy::csg;

/// `crosscheck.py`, running: it answers one line of JSON by another.
pub struct Script {
    child: Child,
    questions: BufWriter<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Script {
    /// By a Python with the packages of `requirements.txt`.
    pub fn start(python: &Path) -> Self {
        let mut child = Command::new(python)
            .args(["-c", include_str!("crosscheck.py")])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{} does not run: {error}", python.display()));
        Self {
            questions: BufWriter::new(child.stdin.take().expect("its input")),
            answers: BufReader::new(child.stdout.take().expect("its output")),
            child,
        }
    }

    pub fn ask(&mut self, question: &Value) -> Value {
        writeln!(self.questions, "{question}").expect("the script reads");
        self.questions.flush().expect("the script reads");
        let mut line = String::new();
        self.answers
            .read_line(&mut line)
            .expect("the script writes");
        serde_json::from_str(&line)
            .unwrap_or_else(|_| panic!("the script gave up on {question}: see its messages above"))
    }

    /// The volume of a solid whose circles have so many segments, and a bound of
    /// what that is off.
    pub fn volume(&mut self, solid: &Solid, segments: u32) -> (f64, f64) {
        let said = self.ask(&json!({"solid": question(solid), "segments": segments}));
        let number = |name: &str| said[name].as_f64().expect("a number");
        (number("volume"), number("tessellation"))
    }

    /// The status of a mesh, `NoError` if it is manifold, and its volume without
    /// the degenerate triangles that are collapsed. Passed on in files of a
    /// folder.
    pub fn status(&mut self, mesh: &Mesh, folder: &Path) -> (String, f64) {
        let positions = folder.join("positions");
        let triangles = folder.join("triangles");
        let coordinates = mesh.positions.iter().flat_map(DVec3::to_array);
        let bytes: Vec<u8> = coordinates.flat_map(f64::to_le_bytes).collect();
        fs::write(&positions, bytes).expect("a file");
        let indices = mesh.triangles.as_flattened().iter().map(|&i| u64::from(i));
        let bytes: Vec<u8> = indices.flat_map(u64::to_le_bytes).collect();
        fs::write(&triangles, bytes).expect("a file");
        let said = self.ask(&json!({"positions": positions, "triangles": triangles}));
        let status = said["status"].as_str().expect("a name").to_owned();
        (status, said["volume"].as_f64().expect("a number"))
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        // It only waits for more questions.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The JSON of a solid: what both programs build.
pub fn question(solid: &Solid) -> Value {
    let all = |operands: &[Solid]| operands.iter().map(question).collect::<Vec<_>>();
    match solid.node() {
        Node::Primitive(Primitive::Empty) => json!({"empty": null}),
        Node::Primitive(Primitive::Cuboid { min, max }) => {
            json!({"cuboid": [min.to_array(), max.to_array()]})
        }
        Node::Primitive(Primitive::Ellipsoid { radii }) if *radii == DVec3::splat(radii.x) => {
            json!({"sphere": radii.x})
        }
        Node::Primitive(Primitive::Ellipsoid { radii }) => {
            stretched(*radii, &json!({"sphere": 1.0}))
        }
        Node::Primitive(Primitive::Cylinder { radii, z: Some(z) }) if radii.x == radii.y => {
            json!({"frustum": [radii.x, radii.y, z.start, z.end]})
        }
        Node::Primitive(Primitive::Prism { polygon, z }) => {
            let corners = |z: f64| polygon.iter().map(move |p| [p.x, p.y, z]);
            json!({"hull": corners(z.start).chain(corners(z.end)).collect::<Vec<_>>()})
        }
        Node::Primitive(Primitive::ConvexPolyhedron(planes)) => {
            let planes = planes.iter().map(|p| p.normal.extend(p.offset).to_array());
            json!({"planes": planes.collect::<Vec<_>>()})
        }
        Node::Primitive(Primitive::Polyhedron(polyhedron)) => {
            let positions = polyhedron.vertices().iter().map(DVec3::to_array);
            json!({"mesh": [positions.collect::<Vec<_>>(), polyhedron.triangles()]})
        }
        Node::Made(made) if made.solid.is_ok() => all(solid.node().operands())[0].clone(),
        Node::Primitive(Primitive::Frustum { bottom, top, z }) => {
            json!({"frustum": [bottom, top, z.start, z.end]})
        }
        Node::Transform(Ok(map), operand) => {
            let m = map.matrix3.transpose();
            let rows = [
                (m.x_axis, map.translation.x),
                (m.y_axis, map.translation.y),
                (m.z_axis, map.translation.z),
            ];
            let rows = rows.map(|(row, offset)| [row.x, row.y, row.z, offset]);
            json!({"map": [rows, question(operand)]})
        }
        Node::Union(operands) => json!({"union": all(operands)}),
        Node::Intersection(operands) => json!({"intersection": all(operands)}),
        Node::Difference(operands) => json!({"difference": all(operands)}),
        Node::Named(_, operand) | Node::Colored(_, operand) => question(operand),
        other => panic!("no such question: {}", other.kind()),
    }
}

fn stretched(by: DVec3, inner: &Value) -> Value {
    let rows = [
        [by.x, 0.0, 0.0, 0.0],
        [0.0, by.y, 0.0, 0.0],
        [0.0, 0.0, by.z, 0.0],
    ];
    json!({"map": [rows, inner]})
}
