//! The reference scenes, each as a solid for the mesher, as a field for its
//! peers, and with what is known of it.

use csg::{Node, Primitive, Solid};
use glam::DVec3;
use stereotomy::scenes;

use crate::field::Field;

/// One scene, both ways.
pub struct Scene {
    /// What tables call it.
    pub name: String,
    /// For the mesher.
    pub solid: Solid,
    /// For the peers.
    pub field: Field,
    /// The exact volume, or to nine digits.
    pub volume: f64,
    /// The sum of genera over the boundary's components, where known.
    pub genus: Option<i64>,
    /// The cube that cells are counted along goes from -half to half.
    pub half: f64,
}

/// Names of the scenes, in the order of tables.
pub const NAMES: [&str; 12] = [
    "S1",
    "S2",
    "S3",
    "S8",
    "S4-2",
    "S4-3",
    "S4-4",
    "S5-1000",
    "S5-10000",
    "S5-100000",
    "S6",
    "S7-1e-2",
];

/// The scene called `name`: S1 to S8, where S4 takes a level, S5 a number and
/// S7 a thickness after a hyphen.
pub fn scene(name: &str) -> Option<Scene> {
    let (kind, argument) = name.split_once('-').unwrap_or((name, ""));
    let (solid, field, volume, genus) = match kind {
        "S1" => {
            let field = ball(DVec3::ZERO, 1.0);
            (scenes::sphere(), field, scenes::SPHERE_VOLUME, Some(0))
        }
        "S2" => (
            scenes::drilled(),
            drilled(),
            scenes::DRILLED_VOLUME,
            Some(5),
        ),
        "S3" => {
            let field = Field::Intersection((0..3).map(|axis| rod(axis, 1.0)).collect());
            let volume = scenes::TRICYLINDER_VOLUME;
            (scenes::tricylinder(), field, volume, Some(0))
        }
        "S4" => {
            let level: u32 = argument.parse().ok()?;
            let genus = [0, 5, 81, 1409, 26433].get(level as usize).copied();
            let volume = scenes::menger_volume(level);
            (scenes::menger(level), menger(level), volume, genus)
        }
        "S5" => {
            let n: u32 = argument.parse().ok()?;
            let solid = scenes::cheese(n);
            let holes = Field::Union(balls_of(&solid));
            let field = Field::difference(cube(1.0), holes);
            (solid, field, scenes::cheese_volume(n)?, None)
        }
        "S6" => {
            let volume = scenes::ROTATED_BOX_VOLUME;
            (scenes::rotated_box(), rotated_box(), volume, Some(0))
        }
        "S7" => {
            let t: f64 = argument.parse().ok().filter(|t| (0.0..1.0).contains(t))?;
            let (outer, inner) = (ball(DVec3::ZERO, 1.0), ball(DVec3::ZERO, 1.0 - t));
            let field = Field::difference(outer, inner);
            (scenes::shell(t), field, scenes::shell_volume(t), Some(0))
        }
        "S8" => (scenes::flange(), flange(), scenes::FLANGE_VOLUME, Some(9)),
        _ => return None,
    };
    let half = if matches!(kind, "S4" | "S5") {
        1.2
    } else {
        1.6
    };
    Some(Scene {
        name: name.to_owned(),
        solid,
        field,
        volume,
        genus,
        half,
    })
}

fn ball(center: DVec3, radius: f64) -> Field {
    Field::Ball {
        center: center.to_array(),
        radius,
    }
}

fn rod(axis: usize, radius: f64) -> Field {
    Field::Rod {
        axis,
        center: [0.0; 3],
        radius,
    }
}

fn cube(half: f64) -> Field {
    Field::Block {
        low: [-half; 3],
        high: [half; 3],
    }
}

fn drilled() -> Field {
    let blank = Field::Intersection(vec![cube(0.75), ball(DVec3::ZERO, 1.0)]);
    let bores = (0..3).map(|axis| rod(axis, 0.5)).collect();
    Field::difference(blank, Field::Union(bores))
}

fn menger(level: u32) -> Field {
    let mut bars = Vec::new();
    for k in 0..level {
        let tiles = 3_u32.pow(k);
        let tile = 2.0 / f64::from(tiles);
        let middle = |i: u32| f64::from(2 * i + 1) / f64::from(tiles) - 1.0;
        for axis in 0..3 {
            for i in 0..tiles {
                for j in 0..tiles {
                    let mut low = [-f64::INFINITY; 3];
                    let mut high = [f64::INFINITY; 3];
                    for (across, at) in [(1, middle(i)), (2, middle(j))] {
                        low[(axis + across) % 3] = at - tile / 6.0;
                        high[(axis + across) % 3] = at + tile / 6.0;
                    }
                    bars.push(Field::Block { low, high });
                }
            }
        }
    }
    Field::difference(cube(1.0), Field::Union(bars))
}

fn rotated_box() -> Field {
    let half = DVec3::new(1.0, 0.6, 0.3);
    let turn = glam::DMat3::from_rotation_z(0.3)
        * glam::DMat3::from_rotation_y(0.5)
        * glam::DMat3::from_rotation_x(0.7);
    let faces = (0..6).map(|i| {
        let (axis, sign) = (i / 2, if i % 2 == 0 { -1.0 } else { 1.0 });
        Field::HalfSpace {
            normal: (turn.col(axis) * sign).to_array(),
            offset: half[axis],
        }
    });
    Field::Intersection(faces.collect())
}

fn flange() -> Field {
    let slab = |low: f64, high: f64| Field::Block {
        low: [-f64::INFINITY, -f64::INFINITY, low],
        high: [f64::INFINITY, f64::INFINITY, high],
    };
    let disc = Field::Intersection(vec![rod(2, 1.0), slab(0.0, 0.2)]);
    let hub = Field::Intersection(vec![rod(2, 0.45), slab(0.0, 0.7)]);
    let mut taken = vec![
        rod(2, 0.3),
        Field::Block {
            low: [-0.06, 0.0, -f64::INFINITY],
            high: [0.06, 0.38, f64::INFINITY],
        },
    ];
    taken.extend((0..8).map(|i| {
        let angle = f64::from(i) * std::f64::consts::FRAC_PI_4;
        Field::Rod {
            axis: 2,
            center: [0.75 * angle.cos(), 0.75 * angle.sin(), 0.0],
            radius: 0.08,
        }
    }));
    Field::difference(Field::Union(vec![disc, hub]), Field::Union(taken))
}

/// All spheres of a solid whose spheres are only moved.
pub fn balls_of(solid: &Solid) -> Vec<Field> {
    let mut balls = Vec::new();
    let mut pending = vec![(solid.clone(), DVec3::ZERO)];
    while let Some((solid, offset)) = pending.pop() {
        let node = solid.node();
        let offset = match node {
            Node::Transform(Ok(map), _) => offset + map.translation,
            _ => offset,
        };
        if let Node::Primitive(Primitive::Ellipsoid { radii }) = node {
            balls.push(ball(offset, radii.x));
        }
        let operands = node.operands().iter().rev();
        pending.extend(operands.map(|operand| (operand.clone(), offset)));
    }
    balls
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both forms of every scene agree on which points are inside.
    #[test]
    fn fields_and_solids_are_the_same_scenes() {
        for name in ["S1", "S2", "S3", "S4-3", "S5-100", "S6", "S7-1e-1", "S8"] {
            let scene = scene(name).expect("a scene");
            let program = csg::Program::lower(&scene.solid).expect("valid");
            let (mut inside, mut differing, mut seed) = (0, 0, 1_u64);
            for _ in 0..20_000 {
                let p = [(); 3].map(|()| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    ((seed >> 40) as f32 / (1 << 23) as f32 - 1.0) * scene.half as f32
                });
                let mut value = [0.0];
                crate::peers::surface_nets::sample_row(
                    &scene.field,
                    &[p[0]],
                    p[1],
                    p[2],
                    &mut value,
                );
                let point = DVec3::new(p[0].into(), p[1].into(), p[2].into());
                let contained = program.contains(point);
                inside += usize::from(contained);
                // In single precision a point at the very boundary may differ.
                let near = value[0].abs() < 1e-6;
                differing += usize::from(contained != (value[0] < 0.0) && !near);
            }
            assert!(inside > 100, "{name}: {inside} points inside");
            assert_eq!(differing, 0, "{name}");
        }
    }
}
