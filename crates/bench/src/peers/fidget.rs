//! fidget: manifold dual contouring on an octree, with an interpreter and a
//! JIT compiler to evaluate the field.

use csg::Mesh;
use fidget::context::Tree;
use fidget::eval::{Function, MathFunction};
use fidget::jit::JitFunction;
use fidget::mesh::{Octree, Settings};
use fidget::render::{RenderHints, ThreadPool};
use fidget::shape::{BoundShape, Shape};
use fidget::shapes::types::Vec3;
use fidget::shapes::{Difference, Intersection, Sphere, Union};
use fidget::vm::VmFunction;
use glam::DVec3;

use crate::field::Field;

/// How the field is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evaluator {
    /// Compiled to machine code.
    Jit,
    /// Interpreted.
    Vm,
}

impl Evaluator {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Jit, Self::Vm];

    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jit => "JIT",
            Self::Vm => "VM",
        }
    }
}

/// What a run is asked for.
#[derive(Clone, Copy)]
pub struct Run {
    /// Which evaluator.
    pub evaluator: Evaluator,
    /// Levels of the octree: 2^depth cells a side.
    pub depth: u8,
    /// The cube goes from -half to half.
    pub half: f64,
    /// One thread runs in the calling one, more in a pool.
    pub threads: usize,
}

/// Hands `work` a closure that makes one mesh; making the shape comes before
/// it and is not part of the time.
pub fn with_mesher<T>(field: &Field, run: Run, work: impl FnOnce(&dyn Fn() -> Raw) -> T) -> T {
    let tree = tree(field);
    match run.evaluator {
        Evaluator::Jit => with_function::<JitFunction, T>(tree, run, work),
        Evaluator::Vm => with_function::<VmFunction, T>(tree, run, work),
    }
}

/// A mesh as fidget gives it.
pub struct Raw(fidget::mesh::Mesh);

impl Raw {
    /// As a mesh of ours. Fidget's triangles are oriented alike.
    pub fn into_mesh(self) -> Mesh {
        let positions = self.0.vertices.iter();
        let positions = positions.map(|v| DVec3::new(v.x.into(), v.y.into(), v.z.into()));
        let triangles = self.0.triangles.iter();
        let triangles = triangles.map(|t| [t.x as u32, t.y as u32, t.z as u32]);
        Mesh::new(positions.collect(), triangles.collect())
    }
}

fn with_function<F: Function + MathFunction + RenderHints + Clone, T>(
    tree: Tree,
    run: Run,
    work: impl FnOnce(&dyn Fn() -> Raw) -> T,
) -> T {
    let shape: BoundShape<F, f32> = Shape::<F>::from(tree)
        .try_into()
        .expect("only x, y and z are free");
    let pool = (run.threads > 1).then(|| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(run.threads);
        ThreadPool::Custom(pool.build().expect("the system starts threads"))
    });
    work(&|| {
        let settings = Settings {
            depth: run.depth,
            world_to_model: nalgebra::Matrix4::new_scaling(run.half as f32),
            threads: pool.as_ref(),
            ..Settings::default()
        };
        let octree = Octree::build(&shape, &settings).expect("nobody cancels");
        Raw(octree.walk_dual())
    })
}

/// The field with fidget's own shapes where it has them.
fn tree(field: &Field) -> Tree {
    let (x, y, z) = Tree::axes();
    let axes = [x, y, z];
    match field {
        Field::Ball { center, radius } => Sphere {
            center: Vec3::new(center[0] as f32, center[1] as f32, center[2] as f32),
            radius: *radius as f32,
        }
        .into(),
        Field::Rod {
            axis,
            center,
            radius,
        } => {
            let squared = |across: usize| {
                let k = (axis + across) % 3;
                (axes[k].clone() - center[k] as f32).square()
            };
            (squared(1) + squared(2)).sqrt() - *radius as f32
        }
        Field::Block { low, high } => {
            let mut sides = Vec::new();
            for k in 0..3 {
                if low[k].is_finite() {
                    sides.push(low[k] as f32 - axes[k].clone());
                }
                if high[k].is_finite() {
                    sides.push(axes[k].clone() - high[k] as f32);
                }
            }
            Intersection { input: sides }.into()
        }
        Field::HalfSpace { normal, offset } => {
            let [nx, ny, nz] = normal.map(|n| n as f32);
            let [x, y, z] = axes;
            x * nx + y * ny + z * nz - *offset as f32
        }
        Field::Union(of) => Union {
            input: of.iter().map(tree).collect(),
        }
        .into(),
        Field::Intersection(of) => Intersection {
            input: of.iter().map(tree).collect(),
        }
        .into(),
        Field::Difference(from, taken) => Difference {
            shape: tree(from),
            cutout: tree(taken),
        }
        .into(),
    }
}
