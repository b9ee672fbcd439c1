//! χ² tests of lights from images, environment maps and textured area lights, and their power against integrals.
//!
//! With the other tests of sampling they fail by chance with probability 10⁻³ (Šidák's correction); seeds are fixed.

use std::f64::consts::{PI, TAU};

use crate::chi_square::{assert_directions, numbers};
use crate::scene_files::{exr_file, prepare};
use photonfarm::math::{Rgb, Vec3};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;

const SAMPLES: u32 = 100_000;

/// Eight columns and five rows, one of them black, one texel a thousand times as bright as the others.
fn sky(column: usize, row: usize) -> [f32; 3] {
    let u = numbers(200, (8 * row + column) as u32);
    match (column, row) {
        (5, 1) => [900.0, 700.0, 400.0],
        (_, 3) => [0.0; 3],
        _ => [u[0], u[1], u[2]],
    }
}

const TURNED: &str = "<transform name='to_world'><rotate x='1' y='-2' z='0.5' angle='65'/></transform>";

fn environment(file: &[u8], parameters: &str) -> Scene {
    let body = format!(
        "<sensor type='perspective'/><shape type='cube'/><emitter type='envmap'>\
        <string name='filename' value='sky.exr'/>{parameters}</emitter>"
    );
    prepare(&body, &[("sky.exr", file)]).expect("the scene is good")
}

fn arriving(scene: &Scene, direction: Vec3) -> (Rgb, f64) {
    let (radiance, pdf) = scene.lights.environment(&Vec3::ONE.into(), direction).expect("there is an environment");
    (radiance, f64::from(pdf))
}

// ---- Environment maps. --------------------------------------------------------------------------------------------

#[test]
fn chi_square_direct_light_of_an_environment_map() {
    for (family, size, parameters) in [(201, [8, 5], ""), (202, [8, 5], TURNED), (203, [2, 2], ""), (204, [33, 3], "")]
    {
        let file = exr_file(size[0], size[1], |x, y| sky(x % 8, y % 5));
        let scene = environment(&file, parameters);
        let samples = (0..SAMPLES).map(|sample| {
            let u = numbers(family, sample);
            let sample = scene.lights.sample_direct(&scene.geometry, &Vec3::ONE.into(), [u[2], u[0], u[1]])?;
            let (radiance, pdf) = arriving(&scene, sample.direction);
            // Rounding may move a direction over the edge of its cell, where the density is another.
            if (pdf / f64::from(sample.pdf_solid_angle) - 1.0).abs() < 1e-3 {
                let weighted = radiance / sample.pdf_solid_angle;
                let off = (weighted - sample.weighted_radiance).length() / weighted.length();
                assert!(off < 1e-2, "{weighted} is not {}", sample.weighted_radiance);
            }
            Some(sample.direction)
        });
        assert_directions(samples, |direction| arriving(&scene, direction).1, -1.0, &format!("map {family}"));
    }
}

#[test]
fn chi_square_densities_of_an_environment_map_agree() {
    let scene = environment(&exr_file(8, 5, sky), TURNED);
    let differ = (0..SAMPLES).filter(|sample| {
        let u = numbers(205, *sample);
        let sample =
            scene.lights.sample_direct(&scene.geometry, &Vec3::ONE.into(), [u[2], u[0], u[1]]).expect("light comes");
        (arriving(&scene, sample.direction).1 / f64::from(sample.pdf_solid_angle) - 1.0).abs() > 1e-3
    });
    let differ = differ.count();
    assert!(differ < 20, "{differ} samples found another density");
}

/// ∫ L dω by the midpoint rule.
fn fluence(scene: &Scene) -> [f64; 3] {
    const FINE: u32 = 700;
    let mut sum = [0.0; 3];
    for i in 0..FINE {
        for j in 0..2 * FINE {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(FINE);
            let angle = TAU * (f64::from(j) + 0.5) / f64::from(2 * FINE);
            let sine = (1.0 - z * z).sqrt();
            let direction = Vec3::new((sine * angle.cos()) as f32, (sine * angle.sin()) as f32, z as f32);
            let (radiance, _) = arriving(scene, direction);
            (0..3).for_each(|channel| sum[channel] += f64::from(radiance[channel]));
        }
    }
    sum.map(|sum| sum * 4.0 * PI / f64::from(2 * FINE * FINE))
}

#[test]
fn chi_square_light_of_an_environment_map_is_its_integral() {
    let scene = environment(&exr_file(8, 5, sky), TURNED);
    let [light] = scene.lights.lights() else { panic!("one light is expected") };
    let mut sum = glam::DVec3::ZERO;
    for u in (0..SAMPLES).map(|sample| numbers(206, sample)) {
        let direct = light.sample_direct(&scene.geometry, Vec3::ONE, [u[0], u[1]]).expect("light comes");
        sum += direct.weighted_radiance.as_dvec3();
    }
    for (channel, expected) in fluence(&scene).into_iter().enumerate() {
        let found = sum[channel] / f64::from(SAMPLES);
        assert!((found / expected - 1.0).abs() < 0.01, "{found} is not {expected}");
    }
}

#[test]
fn chi_square_a_constant_map_is_a_constant_light() {
    let map = environment(&exr_file(6, 4, |_, _| [3.0, 2.0, 1.0]), "<float name='scale' value='2'/>");
    let body = "<sensor type='perspective'/><shape type='cube'/><emitter type='constant'>\
        <rgb name='radiance' value='6, 4, 2'/></emitter>";
    let constant = prepare(body, &[]).expect("the scene is good");
    let powers = [&map, &constant].map(|scene| scene.lights.lights()[0].power());
    assert!((powers[0] / powers[1] - 1.0).abs().max_element() < 1e-3, "{} is not {}", powers[0], powers[1]);
    for u in (0..1000).map(|sample| numbers(208, sample)) {
        let direction = photonfarm::math::warp::sphere([u[0], u[1]]);
        let (radiance, pdf) = arriving(&map, direction);
        assert!(radiance.distance(Rgb::new(6.0, 4.0, 2.0)) < 1e-5);
        assert!((pdf * 4.0 * PI - 1.0).abs() < 1e-4, "the density is {pdf}");
    }
}

/// Row i of h lies at the polar angle π·i/(h - 1) from +y, column j of w at the turn (j + ½)/w from -z towards +x.
#[test]
fn chi_square_texels_of_an_environment_map_lie_where_they_belong() {
    let (width, height) = (7, 6);
    let color = |column: usize, row: usize| [1.0 + column as f32, 1.0 + row as f32, 1.0];
    let scene = environment(&exr_file(width, height, color), "");
    for row in 1..height - 1 {
        for column in 0..width {
            let polar = PI * row as f64 / (height - 1) as f64;
            let angle = TAU * (column as f64 + 0.5) / width as f64;
            let direction = [polar.sin() * angle.sin(), polar.cos(), -polar.sin() * angle.cos()];
            let (radiance, _) = arriving(&scene, Vec3::from_array(direction.map(|x| x as f32)));
            let expected = Rgb::from_array(color(column, row));
            assert!(radiance.distance(expected) < 1e-3, "({column}, {row}): {radiance} is not {expected}");
        }
    }
    for (direction, row) in [(Vec3::Y, 0), (Vec3::NEG_Y, height - 1)] {
        let (radiance, _) = arriving(&scene, direction);
        assert!((radiance.y - 1.0 - row as f32).abs() < 1e-4, "{direction}: {radiance}");
    }
}

// ---- Textured area lights. ----------------------------------------------------------------------------------------

/// A lamp of some shape with a black half, and bright in a small part.
fn lamp(shape: &str) -> Scene {
    let file =
        exr_file(16, 16, |x, y| if (x, y) == (9, 4) { [800.0; 3] } else { [x as f32 / 8.0, 0.0, (y % 2) as f32] });
    let body = format!(
        "<sensor type='perspective'/><shape type='{shape}'><emitter type='area'><texture type='bitmap' name='radiance'>\
        <string name='filename' value='a.exr'/></texture></emitter></shape>"
    );
    prepare(&body, &[("a.exr", &file)]).expect("the scene is good")
}

#[test]
fn chi_square_direct_light_of_textured_lamps() {
    for (family, shape, point) in [
        (210, "rectangle", Vec3::new(0.3, 0.2, 1.5)),
        (211, "cube", Vec3::new(2.5, 3.0, 1.9)),
        (212, "sphere", Vec3::new(0.3, 2.2, 1.0)),
    ] {
        let scene = lamp(shape);
        let mut sum = Rgb::ZERO;
        for u in (0..SAMPLES).map(|sample| numbers(family, sample)) {
            let Some(sample) = scene.lights.sample_direct(&scene.geometry, &point.into(), [u[2], u[0], u[1]]) else {
                continue;
            };
            sum += sample.weighted_radiance / SAMPLES as f32;
            let Some(hit) = scene.geometry.intersect(&Ray::new(point, sample.direction)) else { continue };
            let Some((radiance, pdf)) = scene.lights.emitted(&scene.geometry, &point.into(), &hit, true) else {
                continue;
            };
            // Of a cube, light from a hidden face is sampled too.
            if (hit.distance / sample.distance - 1.0).abs() < 1e-3 {
                assert!((pdf / sample.pdf_solid_angle - 1.0).abs() < 1e-2, "{shape}: {pdf}");
                let weighted = radiance / pdf;
                assert!(weighted.distance(sample.weighted_radiance) < 0.02 * weighted.length() + 0.02, "{shape}");
            }
        }
        // The same by directions all around.
        let mut expected = Rgb::ZERO;
        for u in (0..4 * SAMPLES).map(|sample| numbers(family + 10, sample)) {
            let direction = photonfarm::math::warp::sphere([u[0], u[1]]);
            let Some(hit) = scene.geometry.intersect(&Ray::new(point, direction)) else { continue };
            let Some((radiance, _)) = scene.lights.emitted(&scene.geometry, &point.into(), &hit, true) else {
                continue;
            };
            expected += radiance * (4.0 * PI) as f32 / (4 * SAMPLES) as f32;
        }
        if shape != "cube" {
            assert!((sum / expected - 1.0).abs().max_element() < 0.1, "{shape}: {sum} is not {expected}");
        }
    }
}

#[test]
fn chi_square_photons_of_textured_lamps() {
    for (family, shape) in [(213, "rectangle"), (214, "cube"), (215, "sphere")] {
        let scene = lamp(shape);
        let [light] = scene.lights.lights() else { panic!("one light is expected") };
        let mut sum = Rgb::ZERO;
        for u in (0..SAMPLES).map(|sample| numbers(family, sample)) {
            let photon = light.emit(&scene.geometry, [u[0], u[1]], [u[2], u[3]]).expect("light comes");
            sum += photon.flux / SAMPLES as f32;
        }
        let power = light.power();
        assert!((sum / power - 1.0).abs().max_element() < 0.06, "{shape}: photons carry {sum} of {power}");
    }
}
