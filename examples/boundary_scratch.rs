//! Scratch.
#![allow(missing_docs)]
use csg::{Mesher, Program};
use std::time::Instant;
use stereotomy::scenes;
fn main() {
    for name in std::env::args().skip(1) {
        let program = if name.ends_with(".csg") {
            let s = match stereotomy::io::scene::read_file(
                &name,
                &stereotomy::io::scene::ReadOptions::default(),
            )
            .map(|r| r.solid)
            {
                Ok(s) => s,
                Err(e) => {
                    println!("{name}: {e:?}");
                    continue;
                }
            };
            Program::lower(&s).unwrap()
        } else {
            let s = match name.as_str() {
                "S1" => scenes::sphere(),
                "S2" => scenes::drilled(),
                "S3" => scenes::tricylinder(),
                "S4" => scenes::menger(2),
                "S5" => scenes::cheese(100),
                "S5-1000" => scenes::cheese(1000),
                "S6" => scenes::rotated_box(),
                "S7" => scenes::shell(1e-3),
                _ => scenes::flange(),
            };
            Program::lower(&s).unwrap()
        };
        let t = Instant::now();
        match program.boundary(&Default::default()) {
            Ok(b) => {
                let t1 = t.elapsed();

                let t = Instant::now();
                let m = b.measure();
                let t2 = t.elapsed();
                let mesh = Mesher::new().mesh(&program).unwrap();
                let g: Vec<_> = b.shells().map(|s| s.genus()).take(5).collect();
                let off = (m.volume.value - mesh.mesh.volume()).abs() / m.area.value;
                let dev = mesh.report.deviation.unwrap_or(f64::NAN);
                if off > dev + 1e-12 {
                    println!("WRONG? off {off:e} dev {dev:e} {:?}", mesh.report.fallbacks);
                }
                println!(
                    "{name}: {} shells {:?} {} faces {} loops {} edges {} vertices; {:?} measure {:?}; volume {:.16} +- {:e} (mesh {:.12}) area {:.15} +- {:e} moved {:?}",
                    b.shells().len(),
                    g,
                    b.faces().len(),
                    b.loops().len(),
                    b.edges().len(),
                    b.vertices().len(),
                    t1,
                    t2,
                    m.volume.value,
                    m.volume.error,
                    mesh.mesh.volume(),
                    m.area.value,
                    m.area.error,
                    b.moved().map(|m| m.distance)
                );
            }
            Err(e) => println!("{name}: {e}"),
        }
    }
}
