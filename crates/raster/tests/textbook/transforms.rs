//! Transforms: matrices, their order, shears, rotations, normals.

use super::{close, rows};
use glam::{DMat3, DMat4, DVec3, DVec4};
use raster::Camera;
use raster::transform::{self, EulerOrder, GimbalLock, Shear};

#[test]
fn row_vectors_take_transposes() {
    let (sin, cos) = 0.7f64.sin_cos();
    let t = DVec3::new(4.0, 3.0, -2.0);
    let printed = [
        (
            transform::translation(t),
            rows([
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [4.0, 3.0, -2.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::Z, 0.7),
            rows([
                [cos, sin, 0.0, 0.0],
                [-sin, cos, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::X, 0.7),
            rows([
                [1.0, 0.0, 0.0, 0.0],
                [0.0, cos, sin, 0.0],
                [0.0, -sin, cos, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::Y, 0.7),
            rows([
                [cos, 0.0, -sin, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [sin, 0.0, cos, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
    ];
    let row_times = |v: DVec4, m: DMat4| {
        let columns = [m.x_axis, m.y_axis, m.z_axis, m.w_axis];
        DVec4::from_array(columns.map(|column| v.dot(column)))
    };
    let v = DVec4::new(1.0, 2.0, 3.0, 1.0);
    let (mut by_columns, mut by_rows) = (v, v);
    for (columns, printed) in printed {
        assert!(close(transform::for_row_vectors(columns), printed));
        by_columns = columns * by_columns;
        by_rows = row_times(by_rows, printed);
    }
    assert!(by_columns.abs_diff_eq(by_rows, 1e-12));
    // With w in front: [1 x y z] times A.
    let moved = transform::for_row_vectors_w_first(transform::translation(t));
    let printed = rows([
        [1.0, 4.0, 3.0, -2.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert_eq!(moved, printed);
    let turned = transform::for_row_vectors_w_first(transform::rotation(DVec3::Z, 0.7));
    let found = row_times(DVec4::new(1.0, 2.0, 3.0, 4.0), turned);
    let wanted = DVec4::new(1.0, 2.0 * cos - 3.0 * sin, 2.0 * sin + 3.0 * cos, 4.0);
    assert!(found.abs_diff_eq(wanted, 1e-12));
}

/// x' = a_xx x + a_yx y + a_zx z + b_x and so on: a linear map and a translation
/// are one matrix, whose rows are multiplied as scalar products.
#[test]
fn affine_maps_are_matrices() {
    let a = DMat3::from_cols(
        DVec3::new(1.0, 2.0, 0.5),
        DVec3::new(0.0, 1.0, 3.0),
        DVec3::new(2.0, 0.1, 1.0),
    );
    let (b, p) = (DVec3::new(4.0, 3.0, -2.0), DVec3::new(0.3, -0.2, 0.7));
    let m = transform::from_frame(a, b);
    let by_rows = |row: usize| {
        let linear = a.x_axis[row] * p.x + a.y_axis[row] * p.y + a.z_axis[row] * p.z;
        let product = m.row(row).dot(transform::point(p));
        assert!((product - (linear + b[row])).abs() < 1e-12);
        product
    };
    let moved = DVec3::new(by_rows(0), by_rows(1), by_rows(2));
    assert!(m.transform_point3(p).abs_diff_eq(moved, 1e-12));
    assert_eq!(m.row(3), DVec4::W);
}

/// T(-t), S(1/s), the transpose, H(-s); of a rigid motion the transpose and
/// -R^T t; of scaling about a point and a turn about one, theirs.
#[test]
fn inverses_need_no_division() {
    let (t, s) = (DVec3::new(4.0, 3.0, -2.0), DVec3::new(2.0, 0.5, 4.0));
    let r = transform::rotation(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8);
    let turn = DMat3::from_mat4(r);
    let back = -(turn.transpose() * t);
    let rigid = transform::translation(t) * r;
    let [c0, c1, c2] = [turn.x_axis, turn.y_axis, turn.z_axis];
    let printed = rows([
        [c0.x, c0.y, c0.z, back.x],
        [c1.x, c1.y, c1.z, back.y],
        [c2.x, c2.y, c2.z, back.z],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(transform::rigid_inverse(rigid), printed));
    for (m, inverse) in [
        (rigid, printed),
        (transform::translation(t), transform::translation(-t)),
        (
            transform::scaling(s),
            transform::scaling(DVec3::new(0.5, 2.0, 0.25)),
        ),
        (r, r.transpose()),
        (
            transform::scaling_about(t, s),
            transform::scaling_about(t, s.recip()),
        ),
    ] {
        assert!(close(m * inverse, DMat4::IDENTITY));
        assert!(close(m.inverse(), inverse));
    }
}

#[test]
fn homogeneous_coordinates() {
    let (p, q) = (
        DVec4::new(2.0, 4.0, 6.0, 2.0),
        DVec4::new(9.0, 3.0, 0.0, 3.0),
    );
    for factor in [1.0, -2.0, 0.1] {
        let same = transform::cartesian(p * factor).unwrap();
        assert!(same.abs_diff_eq(DVec3::new(1.0, 2.0, 3.0), 1e-12));
    }
    assert_eq!(transform::cartesian(DVec4::new(1.0, 2.0, 3.0, 0.0)), None);
    // w0 P1 - w1 P0 = w0 w1 (p1 - p0), a direction.
    let difference = transform::homogeneous_difference(q, p);
    assert_eq!(difference, DVec4::new(12.0, -6.0, -18.0, 0.0));
    // Scaling by a is dividing w by a.
    let (a, v) = (4.0, DVec4::new(1.0, 2.0, 3.0, 1.0));
    let scaled = transform::cartesian(transform::scaling(DVec3::splat(a)) * v);
    assert_eq!(
        scaled,
        transform::cartesian(DVec4::new(1.0, 2.0, 3.0, 1.0 / a))
    );
    // T(0,3,0) T(4,0,0) = T(4,3,0); positions move, directions do not.
    let t = transform::translation(DVec3::Y * 3.0) * transform::translation(DVec3::X * 4.0);
    assert_eq!(t, transform::translation(DVec3::new(4.0, 3.0, 0.0)));
    assert_eq!(
        t * transform::point(DVec3::ONE),
        DVec4::new(5.0, 4.0, 1.0, 1.0)
    );
    assert_eq!(
        t * transform::direction(DVec3::ONE),
        DVec4::new(1.0, 1.0, 1.0, 0.0)
    );
}

#[test]
fn shears_and_their_inverses() {
    let s = 0.3;
    let printed = |row: usize, column: usize| {
        let mut m = DMat4::IDENTITY.to_cols_array_2d();
        m[column][row] = s;
        DMat4::from_cols_array_2d(&m)
    };
    for (shear, row, column) in [
        (Shear::XByY, 0, 1),
        (Shear::YByX, 1, 0),
        (Shear::XByZ, 0, 2),
        (Shear::ZByX, 2, 0),
        (Shear::YByZ, 1, 2),
        (Shear::ZByY, 2, 1),
    ] {
        assert_eq!(transform::shear(shear, s), printed(row, column));
        let both = transform::shear(shear, s) * transform::shear(shear, -s);
        assert_eq!(both, DMat4::IDENTITY);
    }
}

#[test]
fn rotation_about_l_m_n() {
    let (axis, angle) = (DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8f64);
    let DVec3 { x: l, y: m, z: n } = axis;
    let (sin, cos) = angle.sin_cos();
    let v = 1.0 - cos;
    let printed = rows([
        [
            l * l + (1.0 - l * l) * cos,
            l * m * v - n * sin,
            l * n * v + m * sin,
            0.0,
        ],
        [
            l * m * v + n * sin,
            m * m + (1.0 - m * m) * cos,
            m * n * v - l * sin,
            0.0,
        ],
        [
            l * n * v - m * sin,
            m * n * v + l * sin,
            n * n + (1.0 - n * n) * cos,
            0.0,
        ],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let found = transform::rotation(axis, angle);
    assert!(close(found, printed));
    assert!(close(found.transpose(), transform::rotation(axis, -angle)));
    // About any point: T(p) R T(-p).
    let p = DVec3::new(1.0, 2.0, 3.0);
    let about = transform::translation(p) * found * transform::translation(-p);
    assert!(about.transform_point3(p).abs_diff_eq(p, 1e-12));
}

/// M = M_v M_u^T with the frames (u n l) and (v n m).
#[test]
fn rotation_from_u_to_v_and_changes_of_basis() {
    let (u, v) = (
        DVec3::new(1.0, 2.0, -1.0).normalize(),
        DVec3::new(0.3, -0.5, 0.9).normalize(),
    );
    let n = u.cross(v).normalize();
    let frame = |a: DVec3| DMat3::from_cols(a, n, a.cross(u.cross(v)).normalize());
    let m = frame(v) * frame(u).transpose();
    let found = transform::rotation_between(u, v);
    assert!(close(found, DMat4::from_mat3(m)));
    // Scalar products of the axes of two frames.
    let (from, to) = (frame(u), frame(v));
    let change = transform::change_of_basis(from, to);
    for row in 0..3 {
        for column in 0..3 {
            let product = to.col(row).dot(from.col(column));
            assert!((change.col(column)[row] - product).abs() < 1e-12);
        }
    }
    let p = DVec3::new(0.5, -2.0, 1.0);
    assert!((to * (change * p)).abs_diff_eq(from * p, 1e-12));
    // F S F^T scales along the axes of a frame.
    let factors = DVec3::new(2.0, 0.5, 3.0);
    let scaling = transform::scaling_in_frame(from, factors);
    for k in 0..3 {
        let scaled = scaling.transform_vector3(from.col(k));
        assert!(scaled.abs_diff_eq(from.col(k) * factors[k], 1e-12));
    }
}

#[test]
fn euler_transform_has_the_printed_elements() {
    let (h, p, r) = (0.4f64, -0.7f64, 1.9f64);
    let ((sh, ch), (sp, cp), (sr, cr)) = (h.sin_cos(), p.sin_cos(), r.sin_cos());
    let printed = rows([
        [sh * sp * sr + ch * cr, sh * sp * cr - ch * sr, sh * cp, 0.0],
        [cp * sr, cp * cr, -sp, 0.0],
        [ch * sp * sr - sh * cr, ch * sp * cr + sh * sr, ch * cp, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let e = transform::Euler {
        heading: h,
        pitch: p,
        roll: r,
    };
    assert!(close(DMat4::from_mat3(e.to_matrix()), printed));
    assert!(close(
        DMat4::from_mat3(e.to_matrix().transpose()) * printed,
        DMat4::IDENTITY
    ));
    // At p = pi/2 only h - r is left.
    let half = std::f64::consts::FRAC_PI_2;
    let locked = EulerOrder::Yxz.to_matrix([h, half, r]);
    let (s, c) = (h - r).sin_cos();
    let wanted = rows([
        [c, s, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [-s, c, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(DMat4::from_mat3(locked), wanted));
    let first = EulerOrder::Yxz.from_matrix(locked, GimbalLock::FirstIsZero);
    assert!(
        first[0] == 0.0 && (first[2] - (r - h)).abs() < 1e-7,
        "{first:?}"
    );
    let last = EulerOrder::Yxz.from_matrix(locked, GimbalLock::LastIsZero);
    assert!(
        last[2] == 0.0 && (last[0] - (h - r)).abs() < 1e-7,
        "{last:?}"
    );
}

/// Every order gives its rotation back, locked or not, with either convention.
#[test]
fn euler_angles_in_every_order() {
    let steps = [-3.0, -1.2, 0.0, 0.5, 2.9f64];
    let half = std::f64::consts::FRAC_PI_2;
    for order in EulerOrder::ALL {
        for a in steps {
            for c in steps {
                for b in [-half, -1.0, 0.0, 0.3, 1.5, half, 2.0 * half] {
                    let m = order.to_matrix([a, b, c]);
                    for lock in [GimbalLock::LastIsZero, GimbalLock::FirstIsZero] {
                        let angles = order.from_matrix(m, lock);
                        let again = order.to_matrix(angles);
                        assert!(m.abs_diff_eq(again, 1e-8), "{order:?} {a} {b} {c} {lock:?}");
                    }
                }
            }
        }
    }
}

/// y' rotated by r, then moved by d: the array of the exercise.
#[test]
fn opengl_takes_columns() {
    let (r, d) = (0.6f64, 2.5);
    let (s, c) = r.sin_cos();
    let m = transform::translation(DVec3::Y * d) * transform::rotation(DVec3::Y, r);
    let wanted = [
        c, 0.0, -s, 0.0, //
        0.0, 1.0, 0.0, 0.0, //
        s, 0.0, c, 0.0, //
        0.0, d, 0.0, 1.0,
    ];
    for (found, wanted) in transform::opengl_array(m).into_iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-12);
    }
}

/// Halved along x, a slanted face's normal is not halved with it.
#[test]
fn normals_take_the_adjugate() {
    let m = DMat3::from_diagonal(DVec3::new(0.5, 1.0, 1.0));
    let (along, normal) = (DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
    assert!((m * along).dot(m * normal).abs() > 0.5);
    let g = transform::normal_matrix(m);
    assert_eq!((m * along).dot(g * normal), 0.0);
    // The adjugate transposed is the inverse transposed times the determinant.
    let m = DMat3::from_cols(
        DVec3::new(1.0, 2.0, 0.5),
        DVec3::new(0.0, 1.0, 3.0),
        DVec3::new(2.0, 0.1, 1.0),
    );
    let wanted = m.inverse().transpose() * m.determinant();
    assert!(transform::normal_matrix(m).abs_diff_eq(wanted, 1e-12));
    // Minors with their signs, row by row: adj(M) = |M| times the inverse.
    let minor = |row: usize, column: usize| {
        let [r, s] = [(row + 1) % 3, (row + 2) % 3];
        let [c, d] = [(column + 1) % 3, (column + 2) % 3];
        m.col(c)[r] * m.col(d)[s] - m.col(d)[r] * m.col(c)[s]
    };
    for row in 0..3 {
        for column in 0..3 {
            let found = transform::normal_matrix(m).col(column)[row];
            assert!((found - minor(row, column)).abs() < 1e-12);
        }
    }
    // That of a rotation is itself.
    let turn = DMat3::from_mat4(transform::rotation(DVec3::Y, 0.7));
    assert!(transform::normal_matrix(turn).abs_diff_eq(turn, 1e-12));
}

/// M_c = M_p M_v M_m puts local points where the three do one after another.
#[test]
fn matrices_compose() {
    let model = transform::translation(DVec3::X) * transform::rotation(DVec3::Z, 0.3);
    let camera = Camera::looking_at(DVec3::new(3.0, -5.0, 2.0), DVec3::ZERO).depths(1.0, 20.0);
    let view = camera.view(400, 320).unwrap();
    let p = DVec4::new(0.2, 0.4, -0.3, 1.0);
    let at_once = (view.eye_to_clip() * view.world_to_eye() * model) * p;
    let one_by_one = view.eye_to_clip() * (view.world_to_eye() * (model * p));
    assert!(at_once.abs_diff_eq(one_by_one, 1e-12));
}
