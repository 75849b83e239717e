//! The class `Solid`: Boolean operators, names, colours, questions.

use csg::{Meshed, Node, Profile, Program, Solid};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};
use rayon::prelude::*;

use crate::arguments::{AnyColor, Corners, Place};
use crate::arrays;
use crate::check::{Measured, PyMeasure};
use crate::errors::{invalid, of_model};
use crate::mesh::PyMesh;
use crate::meshing::MeshOptions;
use crate::profile::PyProfile;
use crate::waiting::{Follow, wait, wait_out};

/// A solid: an immutable tree of shapes, combined by `|` (or `+`), `&` and `-`; `~` is all
/// that is outside. Functions such as `sphere` and `cube` make it; nothing is computed
/// before a mesh, a measure or a picture is asked for.
///
/// >>> import stereotomy as st
/// >>> bore = st.infinite_cylinder(radius=0.5)
/// >>> blank = st.cube(1.5) & st.sphere(1)
/// >>> drilled = blank - bore
/// >>> drilled
/// <Solid difference(intersection(cuboid, sphere), infinite_cylinder)>
/// >>> drilled = drilled - bore.rotate_x(90) - bore.rotate_y(90)
/// >>> drilled.contains([0.6, 0.6, 0.4])
/// True
/// >>> round(drilled.measure(tolerance=1e-4).volume, 3)
/// 0.989
#[pyclass(frozen, from_py_object, name = "Solid", module = "stereotomy")]
#[derive(Clone)]
pub(crate) struct PySolid(pub(crate) Solid);

/// The solid, unless its root is at fault: `call` is how the message shows what was
/// called. What lies below was looked at when it was made.
pub(crate) fn checked(solid: Solid, call: impl FnOnce() -> String) -> PyResult<PySolid> {
    match fault_of_root(&solid) {
        None => Ok(PySolid(solid)),
        Some(fault) => Err(invalid(format!("{}: {fault}", call()))),
    }
}

/// The solid, unless any of its nodes is at fault: for what a function makes whole.
pub(crate) fn checked_whole(solid: Solid, call: impl FnOnce() -> String) -> PyResult<PySolid> {
    match fault_of_whole(&solid) {
        None => Ok(PySolid(solid)),
        Some(fault) => Err(invalid(format!("{}: {fault}", call()))),
    }
}

fn fault_of_root(solid: &Solid) -> Option<String> {
    match solid.node() {
        Node::Primitive(_) => fault_of_whole(solid),
        Node::Transform(Err(fault), _) => Some(fault.to_string()),
        // Whether a map is singular does not depend on what it moves.
        Node::Transform(Ok(map), _) => fault_of_whole(&Solid::cube(1.0).affine(*map)),
        Node::Made(made) => match &made.solid {
            Err(fault) => Some(fault.to_string()),
            Ok(inner) if matches!(inner.node(), Node::Made(_)) => fault_of_root(inner),
            Ok(_) => None,
        },
        _ => None,
    }
}

fn fault_of_whole(solid: &Solid) -> Option<String> {
    match Program::lower(solid) {
        Ok(_) => None,
        Err(csg::Error::InvalidNode { fault, .. }) => Some(fault.to_string()),
        Err(error) => Some(error.to_string()),
    }
}

pub(crate) fn lower(solid: &Solid) -> PyResult<Program> {
    Program::lower(solid).map_err(of_model)
}

#[pymethods]
impl PySolid {
    fn __or__(&self, other: &Self) -> Self {
        Self(&self.0 | &other.0)
    }

    fn __add__(&self, other: &Self) -> Self {
        Self(&self.0 | &other.0)
    }

    fn __and__(&self, other: &Self) -> Self {
        Self(&self.0 & &other.0)
    }

    fn __sub__(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0)
    }

    fn __invert__(&self) -> Self {
        Self(!&self.0)
    }

    fn __repr__(&self) -> String {
        format!("<Solid {}>", outline(&self.0, 3))
    }

    /// The same solid under a name, which its faces carry unless a name further in
    /// overrides it.
    ///
    /// >>> import stereotomy as st
    /// >>> ball = st.sphere(1).named("ball")
    /// >>> {surface.name for surface in ball.mesh().surfaces}
    /// {'ball'}
    fn named(&self, name: String) -> Self {
        Self(self.0.named(name))
    }

    /// The same solid in a colour, which its faces carry unless a colour further in
    /// overrides it: "#rrggbb", "#rrggbbaa", or three or four numbers from 0 to 1 (sRGB).
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(1).colored("#c8482c").mesh().surfaces[0].color
    /// (0.784, 0.282, 0.173, 1.0)
    fn colored(&self, color: AnyColor) -> Self {
        Self(self.0.colored(color.0))
    }

    /// A triangle mesh of the boundary: to a tolerance of a thousandth of the longest
    /// side, unless another one is given, or cells.
    ///
    /// tolerance: the largest distance between mesh and solid, both ways.
    /// angle: with a tolerance, the largest angle in degrees that a surface turns along
    ///     an edge of the mesh, too.
    /// cells, cell_size: a uniform lattice of so many cells along the longest side, or of
    ///     cells of that side length, in place of a tolerance.
    /// smallest_feature: look for features down to this size.
    /// draft: plain surface nets: bevelled, perhaps not manifold.
    /// bounds: (least corner, greatest corner) of a box known to contain the solid.
    /// unit: of the model's lengths: "um", "mm", "cm", "m", "in" or "ft".
    /// normals: exact normals at triangles' corners (36 bytes a triangle).
    /// feature_edges: fill the mesh's feature_edges with edges of more than this angle in
    ///     degrees.
    /// check: check and measure what was made.
    /// max_cells, max_triangles, max_memory (bytes), max_seconds: limits; beyond them
    ///     LimitReached is raised, or with partial the mesh is what fits.
    /// progress: called with the share of the work that is done, from 0 to 1. (To a tolerance
    ///     that is the share of finding the boundary: refining it comes after, and is not told.)
    ///
    /// Other threads go on meanwhile; Ctrl-C stops the work.
    ///
    /// >>> import stereotomy as st
    /// >>> mesh = st.sphere(1).mesh(tolerance=1e-3)
    /// >>> mesh.vertices.shape[1], mesh.vertices.dtype, mesh.triangles.dtype
    /// (3, dtype('float64'), dtype('uint32'))
    /// >>> mesh.report.deviation <= 1e-3 and mesh.report.is_proven
    /// True
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, tolerance=None, angle=None, cells=None, cell_size=None, smallest_feature=None, draft=False, bounds=None, unit='mm', normals=True, feature_edges=None, check=True, max_cells=None, max_triangles=None, max_memory=None, max_seconds=None, partial=False, progress=None)"
    )]
    pub(crate) fn mesh(
        &self,
        py: Python<'_>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyMesh> {
        let MeshOptions { mesher, follow } = MeshOptions::of("mesh", options)?;
        let solid = self.0.clone();
        let meshed = wait(py, &follow, move || {
            Program::lower(&solid).and_then(|program| mesher.mesh(&program))
        })?;
        meshed.map(PyMesh::of).map_err(of_model)
    }

    /// Whether points are in the solid: one point, or an array of shape (n, 3), for which
    /// the answer is an array of n. On the boundary itself either answer may come.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).contains([0, 0, 0.9])
    /// True
    /// >>> st.sphere(1).contains([[0, 0, 0.9], [1, 1, 1]]).tolist()
    /// [True, False]
    fn contains<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let program = lower(&self.0)?;
        if let Ok(point) = points.extract::<[f64; 3]>() {
            let inside = program.contains(point).into_pyobject(py)?;
            return Ok(inside.to_owned().into_any());
        }
        let points: Vec<[f64; 3]> = arrays::rows("points", points)?;
        let inside: Vec<bool> = wait_out(py, || {
            let points = points.par_iter().with_min_len(256);
            points.map(|&point| program.contains(point)).collect()
        })?;
        Ok(numpy::PyArray1::from_vec(py, inside).into_any())
    }

    /// A box around the solid as (least corner, greatest corner), on each side at most
    /// about 1/256 of its size too large; None if the solid is proven empty. (The bounds
    /// of a mesh are tight.)
    ///
    /// >>> import stereotomy as st
    /// >>> low, high = st.sphere(1).bounds()
    /// >>> all(-1.02 <= x <= -1 for x in low)
    /// True
    fn bounds(&self, py: Python<'_>) -> PyResult<Corners<Place>> {
        let solid = self.0.clone();
        let bounds = wait_out(py, move || Program::lower(&solid)?.bounds())?;
        let bounds = bounds.map_err(of_model)?;
        Ok(bounds.map(|bounds| (bounds.min.into(), bounds.max.into())))
    }

    /// How far a part of the solid strays at most from what was asked for, as far as it stands for
    /// something curved that there are no surfaces for (circles turned beside an axis, twists);
    /// None if all is what was asked for. Measures are of the solid as it is.
    ///
    /// >>> import stereotomy as st
    /// >>> ring = st.circle(1).translate([3, 0]).revolve()
    /// >>> 0 < ring.strays() < 1e-3, st.sphere(1).strays()
    /// (True, None)
    fn strays(&self) -> Option<f64> {
        self.0.strays()
    }

    /// The section with a plane as a profile, in coordinates of the plane: at a height z,
    /// with x and y as they are, or through `point` across `normal`, with y as near to the
    /// model's z as the plane allows (else to its y). Of a solid of flat faces it is exact;
    /// of curved ones it strays at most `tolerance`.
    ///
    /// >>> import stereotomy as st
    /// >>> tube = st.cuboid([3, 3, 5]) - st.cuboid([1, 1, 9])
    /// >>> round(tube.section(z=1).area(), 9)
    /// 8.0
    /// >>> round(tube.section(normal=[0, 1, 0]).area(), 9)
    /// 10.0
    #[pyo3(signature = (z=None, *, normal=None, point=[0.0; 3], tolerance=1e-3), text_signature = "($self, z=None, *, normal=None, point=(0.0, 0.0, 0.0), tolerance=0.001)")]
    fn section(
        &self,
        py: Python<'_>,
        z: Option<f64>,
        normal: Option<[f64; 3]>,
        point: [f64; 3],
        tolerance: f64,
    ) -> PyResult<PyProfile> {
        let point: DVec3 = point.into();
        let frame = match (z, normal) {
            (Some(z), None) if z.is_finite() => DAffine3::from_translation(DVec3::Z * z),
            (None, Some(normal)) if point.is_finite() => frame_across(normal.into(), point)
                .ok_or_else(|| {
                    invalid("section: normal is zero or not finite: give a direction")
                })?,
            _ => {
                return Err(PyValueError::new_err(
                    "section: give either z, a height, or normal (and point), finite numbers",
                ));
            }
        };
        let follow = Follow::default();
        let mesher = csg::Mesher::new()
            .tolerance(tolerance)
            .cancel_token(follow.cancel.clone());
        let options = csg::BoundaryOptions::new().cancel_token(follow.cancel.clone());
        let solid = self.0.clone();
        let section = wait(py, &follow, move || {
            solid.chorded_section(frame, tolerance, &options)
        })?;
        if let Some(section) = section.map_err(of_model)? {
            return Ok(PyProfile(section));
        }
        let solid = self.0.clone();
        let parts = wait(py, &follow, move || {
            let parts = solid.cut_at(frame)?.into_iter();
            let mesh = |part: Solid| mesher.mesh(&Program::lower(&part)?);
            parts.map(mesh).collect::<Result<Vec<_>, _>>()
        })?;
        let parts = parts.map_err(of_model)?;
        let faces: Result<Vec<Profile>, _> = parts.iter().map(Meshed::faces_in_plane).collect();
        Ok(PyProfile(Profile::union(faces.map_err(of_model)?)))
    }

    /// Volume, area, centroid and moments of the solid from its exact boundary, with bounds
    /// on their errors. With options of `mesh`, and where it cannot be told how surfaces meet,
    /// they are those of a mesh.
    ///
    /// >>> import math, stereotomy as st
    /// >>> ball = st.sphere(2).measure()
    /// >>> abs(ball.volume - 32 / 3 * math.pi) <= ball.volume_error < 1e-10
    /// True
    /// >>> st.sphere(2).measure(tolerance=0.1).volume_error is None
    /// True
    #[pyo3(signature = (**options))]
    fn measure(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyMeasure> {
        if options.is_none_or(PyDictMethods::is_empty) {
            let follow = Follow::default();
            let options = csg::BoundaryOptions::new().cancel_token(follow.cancel.clone());
            let solid = self.0.clone();
            let measure = wait(py, &follow, move || {
                Ok(Program::lower(&solid)?.boundary(&options)?.measure())
            })?;
            match measure {
                Ok(measure) => return Ok(PyMeasure(Measured::Solid(measure))),
                // A mesh is better than nothing.
                Err(csg::Error::Undecided(_)) => {}
                Err(error) => return Err(of_model(error)),
            }
        }
        self.mesh(py, options)?.measure(py)
    }

    /// The report of the mesh that the options of `mesh` give: what was proven, and what
    /// had to be settled for.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(1).report().is_proven
    /// True
    #[pyo3(signature = (**options))]
    fn report(
        &self,
        py: Python<'_>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<crate::report::PyReport> {
        let mesh = self.mesh(py, options)?;
        mesh.report
            .ok_or_else(|| invalid("a mesh without a report"))
    }
}

/// The tree in the words of the functions, down to some levels.
fn outline(solid: &Solid, levels: usize) -> String {
    const MOST: usize = 6;
    let node = solid.node();
    let operands = node.operands();
    let kind = match node {
        // What a function made of other shapes is its own affair.
        Node::Primitive(_) | Node::Made(_) => return node.kind().to_owned(),
        Node::Named(name, _) => format!("named {name:?}"),
        _ => node.kind().to_owned(),
    };
    if levels == 0 {
        return format!("{kind}(...)");
    }
    let shown = operands.iter().take(MOST);
    let mut shown: Vec<String> = shown.map(|operand| outline(operand, levels - 1)).collect();
    if operands.len() > MOST {
        shown.push(format!("{} more", operands.len() - MOST));
    }
    format!("{kind}({})", shown.join(", "))
}

/// A frame whose z axis is along the normal.
fn frame_across(normal: DVec3, point: DVec3) -> Option<DAffine3> {
    let z = (normal / normal.abs().max_element()).try_normalize()?;
    // Seen from the front a section is upright.
    let up = if z.truncate() == DVec2::ZERO {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let x = up.cross(z).try_normalize()?;
    Some(DAffine3 {
        matrix3: DMat3::from_cols(x, z.cross(x), z),
        translation: point,
    })
}
