//! The light `goniometric`: an image of a point light's intensity into all directions, as an IES file in memory.

use std::f64::consts::PI;
use std::fmt::Write;

use glam::{DMat4, DVec2, DVec3, Vec2};

use super::super::draft::Draft;
use super::super::values::shown;
use super::light::{emission, with_power};
use super::output::Output;
use super::parameters::Parameters;
use super::spectrum::luminance;
use super::texture::{self, in_memory, mean_color};
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::texture::Texture;

/// Degrees between the intensities that are taken from the image.
const STEP: usize = 2;
/// What the `ies` emitter divides candelas by, lm·W⁻¹.
const EFFICACY: f64 = 179.0;

/// Reads the light.
///
/// # Errors
/// On an image that cannot be read, or is black.
pub(super) fn read(parameters: &Parameters, to_world: DMat4, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let intensity = emission(parameters, "I", output)?;
    let Some(name) = parameters.text("filename")? else {
        let position = to_world.transform_point3(DVec3::ZERO);
        let light = Draft::new(PluginClass::Emitter, "point", &parameters.place).with_point("position", position);
        return Ok(light.with_rgb("intensity", with_power(intensity, 4.0 * PI, parameters)?));
    };
    let image = texture::plain_image(name, parameters, output)?.with_text("wrap_mode", "clamp");
    let mean = luminance(mean_color(&image, output)?);
    let intensity = with_power(intensity, 4.0 * PI * mean, parameters)?;
    let texture = in_memory(&image, output)?;
    let file = format!("goniometric-{}.ies", output.made.files.len());
    output.made.files.insert(file.clone(), table(&texture).into_bytes().into());
    let instead = format!("its intensities every {STEP} degrees, and linear ones in between, take its place");
    output.approximated(&parameters.place, format!("the image {} of a goniometric light", shown(name)), instead);
    let light = Draft::new(PluginClass::Emitter, "ies", &parameters.place).with_text("filename", &file);
    Ok(light.with_rgb("intensity", intensity).with_transform("to_world", to_world))
}

/// An IES file of the image's intensities.
fn table(image: &Texture) -> String {
    let (vertical, horizontal) = (180 / STEP + 1, 360 / STEP + 1);
    let mut text = format!("IESNA:LM-63-2002\nTILT=NONE\n1 -1 {EFFICACY} {vertical} {horizontal} 1 2 0 0 0\n1 1 0\n");
    let angles = |count: usize| (0..count).map(|index| format!("{} ", index * STEP)).collect::<String>();
    text.push_str(&(angles(vertical) + "\n" + &angles(horizontal)));
    for column in 0..horizontal {
        text.push('\n');
        for row in 0..vertical {
            let [polar, azimuth] = [row, column].map(|index| ((index * STEP) as f64).to_radians());
            let ((sine, z), (y, x)) = (libm::sincos(polar), libm::sincos(azimuth));
            // Horizontal angles of the emitter turn from +x to -y; pbrt's image has y and z exchanged.
            let direction = DVec3::new(sine * x, z, -sine * y);
            let uv = equal_area_square(direction).as_vec2();
            let color = image.color(&Vec2::new(uv.x, uv.y).into());
            // Writing to a String cannot fail.
            let _ = write!(text, "{} ", (color.x + color.y + color.z) / 3.0);
        }
    }
    text.push('\n');
    text
}

/// Where a unit vector stands in the unit square, which keeps areas [Clarberg 2008, "Fast equal-area mapping of the
/// (hemi)sphere using SIMD"].
pub(super) fn equal_area_square(direction: DVec3) -> DVec2 {
    let [x, y, z] = direction.abs().to_array();
    let radius = (1.0 - z).max(0.0).sqrt();
    let (most, least) = (x.max(y), x.min(y));
    let angle = if most == 0.0 { 0.0 } else { libm::atan2(least, most) * 2.0 / PI };
    let angle = if x < y { 1.0 - angle } else { angle };
    let mut v = angle * radius;
    let mut u = radius - v;
    if direction.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    DVec2::new(0.5 * (u.copysign(direction.x) + 1.0), 0.5 * (v.copysign(direction.y) + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_has_its_poles_in_the_middle_and_at_the_corners() {
        assert_eq!(equal_area_square(DVec3::Z), DVec2::splat(0.5));
        assert_eq!(equal_area_square(DVec3::NEG_Z).x.fract(), 0.0);
        assert!(equal_area_square(DVec3::X).distance(DVec2::new(1.0, 0.5)) < 1e-12);
        assert!(equal_area_square(DVec3::NEG_Y).distance(DVec2::new(0.5, 0.0)) < 1e-12);
        // Half of the hemisphere lies above a height of 1/2, and half of the diamond within a radius of 1/√2.
        let ring = DVec3::new(0.75_f64.sqrt(), 0.0, 0.5);
        assert!((equal_area_square(ring).x - (0.5 + 0.5 * 0.5_f64.sqrt())).abs() < 1e-12);
    }
}
