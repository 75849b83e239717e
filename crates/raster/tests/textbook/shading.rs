//! Light and materials.

use glam::Vec3;
use raster::shade::{Finish, Incident, Material, phong};

/// I = Ka Iamb + Kd Iin (L N) + Ks Iin (R V)^n with the pictures' numbers.
#[test]
fn phong_with_the_printed_coefficients() {
    let color = csg::Color::from_linear([150.0 / 255.0, 1.0, 100.0 / 255.0]);
    let theta = 0.5f32;
    let normal = Vec3::Z;
    let towards = Vec3::new(theta.sin(), 0.0, theta.cos());
    for (ka, kd, ks, n) in [(0.5, 0.5, 0.8, 4.0), (0.5, 0.5, 0.6, 10.0)] {
        let material = Material::new(color, Finish::new(ka, kd, ks, n));
        for alpha in [0.0f32, 0.3, 1.0] {
            let viewer = Vec3::new(-(theta + alpha).sin(), 0.0, (theta + alpha).cos());
            let lights = [
                Incident {
                    towards: Vec3::ZERO,
                    intensity: Vec3::splat(0.4),
                },
                Incident {
                    towards,
                    intensity: Vec3::splat(0.9),
                },
            ];
            let found = phong(&material, &lights, normal, viewer);
            for k in 0..3 {
                let diffuse = color.rgb[k] * (ka * 0.4 + kd * 0.9 * theta.cos());
                let wanted = diffuse + ks * 0.9 * alpha.cos().powf(n);
                assert!((found[k] - wanted).abs() < 1e-5, "{found} {wanted}");
            }
        }
    }
}
