//! `directionalarea` against its closed form in every method, and `merge`, whose shapes stay what they are.

use crate::rendered::rendered;
use std::f32::consts::PI;
use std::sync::Arc;

use crate::scene_files::prepare;
use photonfarm::scene::Scene;

/// Looks straight down on [-1, 1]² from below the lamps; 8 × 8 pixels.
const SENSOR: &str = "<sensor type='orthographic'><transform name='to_world'>\
    <lookat origin='0,0,1' target='0,0,0' up='0,1,0'/></transform><film type='hdrfilm'><integer name='width' value='8'/>\
    <integer name='height' value='8'/><rfilter type='box'/></film></sensor>";
const FLOOR: &str = "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform>\
    <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>";

/// A lamp at z = 2 above the right half of the picture, which shines down.
fn lamp(shape: &str, emitter: &str) -> String {
    format!(
        "<shape type='{shape}'><transform name='to_world'><rotate x='1' angle='180'/><translate value='1, 0, 2'/></transform>\
        <emitter type='directionalarea'>{emitter}</emitter></shape>"
    )
}

fn render(scene: Scene, name: &str, passes: u32) -> Vec<[f32; 3]> {
    rendered(&Arc::new(scene), name, serde_json::Map::new(), passes, 3).radiance
}

fn scene(body: &str) -> Scene {
    prepare(&format!("{SENSOR}{body}"), &[]).unwrap_or_else(|error| panic!("{body}: {error}"))
}

fn error(body: &str) -> String {
    prepare(&format!("{SENSOR}{body}"), &[]).err().unwrap_or_else(|| panic!("{body} is no error")).to_string()
}

/// The floor below the lamp gets its number as irradiance, at every distance; beside it there is nothing.
#[test]
fn analytic_a_beam_has_a_sharp_edge_in_every_method() {
    let body = format!("{FLOOR}{}", lamp("rectangle", "<rgb name='radiance' value='3, 2, 1'/>"));
    for (method, passes, bound) in [
        ("path", 2, 1e-5),
        ("bdpt", 256, 0.01),
        ("sppm", 8, 0.03),
        ("ppm", 8, 0.03),
        ("vcm", 8, 0.03),
        ("photon_map", 8, 0.05),
    ] {
        let picture = render(scene(&body), method, passes);
        // Discs of photons reach over the edge, hence not the columns beside it.
        for (columns, factor) in [(0..3, 0.0), (5..8, 0.5 / PI)] {
            let pixels: Vec<[f32; 3]> =
                (0..64).filter(|index| columns.contains(&(index % 8))).map(|index| picture[index]).collect();
            for (channel, radiance) in [3.0, 2.0, 1.0].into_iter().enumerate() {
                let mean = pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32;
                let off = (mean - factor * radiance).abs() / (0.5 / PI * radiance);
                assert!(off < bound, "{method}, columns {columns:?}: {mean} for {}", factor * radiance);
            }
        }
    }
}

/// Photons of all of the beam make its whole flux: a mirror above the floor sends it sideways onto a wall.
#[test]
fn analytic_beams_by_mirrors_are_caustics() {
    let wall = "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>";
    // The lamp shines along +x at x = -4; the mirror in the plane x = z turns it down.
    let lamp = "<shape type='disk'><transform name='to_world'><scale value='2'/><rotate y='1' angle='90'/><translate value='-4, 0, 3'/>\
        </transform><emitter type='directionalarea'><rgb name='radiance' value='2'/></emitter></shape>";
    let mirror = "<shape type='rectangle'><transform name='to_world'><scale x='2' y='2'/><rotate y='1' angle='-135'/>\
        <translate value='0, 0, 3'/></transform><bsdf type='twosided'><bsdf type='conductor'/></bsdf></shape>";
    let picture = render(scene(&format!("{wall}{lamp}{mirror}")), "sppm", 16);
    let mean = picture.iter().map(|pixel| pixel[0]).sum::<f32>() / 64.0;
    let expected = 0.5 / PI * 2.0;
    assert!((mean / expected - 1.0).abs() < 0.03, "{mean} for {expected}");
}

#[test]
fn analytic_the_lamp_itself_is_black() {
    let lamp =
        "<shape type='rectangle'><emitter type='directionalarea'><rgb name='radiance' value='3'/></emitter></shape>";
    let picture = render(scene(lamp), "path", 2);
    assert!(picture.iter().all(|pixel| *pixel == [0.0; 3]), "{:?}", picture[0]);
}

#[test]
fn analytic_textures_color_the_beam() {
    let checkers = "<texture name='radiance' type='checkerboard'><rgb name='color0' value='1'/><rgb name='color1' value='2'/></texture>";
    // Above all of the picture, unlike the others: a field of the checkerboard for each quarter of it.
    let lamp = lamp("rectangle", checkers).replace("1, 0, 2", "0, 0, 2");
    let picture = render(scene(&format!("{FLOOR}{lamp}")), "path", 1);
    let mut found: Vec<f32> = [0, 7, 56, 63].map(|pixel: usize| picture[pixel][0] * PI / 0.5).to_vec();
    assert!((found[0] - found[3]).abs() < 1e-5 && (found[1] - found[2]).abs() < 1e-5, "{found:?}");
    found.sort_by(f32::total_cmp);
    assert!((found[0] - 1.0).abs() < 1e-5 && (found[3] - 2.0).abs() < 1e-5, "{found:?}");
}

#[test]
fn curved_shapes_cannot_make_a_beam() {
    for shape in ["sphere", "cube"] {
        let found = error(&format!("{FLOOR}{}", lamp(shape, "")));
        assert!(found.contains("is not flat; use flat shapes that face one way"), "{found}");
    }
    let found = error("<emitter type='directionalarea'/><shape type='sphere'/>");
    assert!(found.contains("directionalarea"), "{found}");
}

/// The shapes of a `merge` are those of the scene, to the last bit, in a group and out of it.
#[test]
fn merged_shapes_are_as_they_were() {
    let parts = "<shape type='cube'><transform name='to_world'><scale value='0.3'/></transform></shape>\
        <shape type='sphere'><point name='center' x='0.5' y='0.5' z='0.2'/><float name='radius' value='0.3'/></shape>";
    let sun = "<emitter type='directional'><vector name='direction' x='0.3' y='0.2' z='-1'/></emitter>";
    let merged = format!("<shape type='merge'>{parts}</shape>");
    let group = |inside: &str| {
        format!("<shape type='shapegroup' id='g'>{inside}</shape><shape type='instance'><ref id='g'/></shape>")
    };
    for (one, other) in [(parts.to_owned(), merged.clone()), (group(parts), group(&merged))] {
        let [one, other] = [one, other].map(|shapes| render(scene(&format!("{FLOOR}{shapes}{sun}")), "path", 4));
        assert_eq!(one, other);
    }
    let found = error("<shape type='merge'><boolean name='flip_normals' value='true'/><shape type='cube'/></shape>");
    assert!(found.contains("shape \"merge\" has no parameter \"flip_normals\""), "{found}");
}
