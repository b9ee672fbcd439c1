//! `linearcurve` and `bsplinecurve` against Mitsuba's pictures of them, and curve files that cannot be read.

use crate::rendered::rendered;
use std::sync::Arc;

use crate::scene_files::prepare;
use photonfarm::math::Vec3;
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;

const CURVES: &str = "-0.8 -0.5 0 0.1\n0 -0.4 0 0.2\n0.3 -0.6 0.2 0.15\n0.8 -0.5 0 0.1\n\n-0.9 0.2 0 0.05\n-0.4 0.8 0.1 0.1\n\
    0.2 0.3 0 0.12\n0.5 0.4 0 0.1\n0.9 0.7 0 0.05\n";

fn scene(plugin: &str, parameters: &str, file: &str) -> Result<Scene, String> {
    let body = format!(
        "<integrator type='path'><integer name='max_depth' value='2'/></integrator>
        <sensor type='orthographic'><transform name='to_world'><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform>
        <film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>
        <emitter type='directional'><vector name='direction' value='0.3, -0.4, -1'/><rgb name='irradiance' value='3'/></emitter>
        <shape type='{plugin}'><string name='filename' value='curves.txt'/>{parameters}
        <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>"
    );
    prepare(&body, &[("curves.txt", file.as_bytes())]).map_err(|error| error.to_string())
}

/// Means of the 16 blocks of 4 × 4 pixels, by rows.
fn blocks(scene: Scene) -> Vec<f32> {
    let scene = Arc::new(scene);
    let parameters = serde_json::Map::from_iter([("max_depth".to_owned(), 2.into())]);
    let picture = rendered(&scene, "path", parameters, 512, 3).radiance;
    let mut sums = vec![0.0; 16];
    for (index, pixel) in picture.iter().enumerate() {
        sums[index / 64 * 4 + index % 16 / 4] += pixel[0] / 16.0;
    }
    sums
}

/// Mitsuba 3.9.1, `scalar_rgb`, 1024 samples.
const PICTURES: [(&str, &str, [f32; 16]); 4] = [
    (
        "linearcurve",
        "",
        [
            0.05967, 0.15683, 0.00944, 0.07076, 0.06574, 0.01997, 0.15808, 0.03114, 0.08673, 0.2065, 0.12433, 0.04577,
            0.0364, 0.03634, 0.12247, 0.0436,
        ],
    ),
    (
        "linearcurve",
        "<transform name='to_world'><scale value='1.2'/></transform>",
        [
            0.12687, 0.16691, 0.04211, 0.10742, 0.03036, 0.00376, 0.12871, 0.02657, 0.04078, 0.14612, 0.06493, 0.0,
            0.13028, 0.10279, 0.20241, 0.13044,
        ],
    ),
    (
        "bsplinecurve",
        "",
        [
            0.0, 0.0978, 0.01417, 0.0, 0.0, 0.01766, 0.13542, 0.0038, 0.0, 0.03977, 0.09531, 0.0, 0.0, 0.01396,
            0.06719, 0.0,
        ],
    ),
    (
        "bsplinecurve",
        "<transform name='to_world'><scale value='1.2'/></transform>",
        [
            0.0, 0.13833, 0.07092, 0.01623, 0.0, 0.00109, 0.08223, 0.01651, 0.0, 0.02519, 0.03978, 0.0, 0.0, 0.03705,
            0.15508, 0.0,
        ],
    ),
];

/// A tube has flat sides, and those of a cone end where the balls of its ends begin.
#[test]
fn agreement_of_curves_with_mitsuba() {
    for (plugin, parameters, expected) in PICTURES {
        let found = blocks(scene(plugin, parameters, CURVES).expect("a good scene"));
        let mean = |blocks: &[f32]| blocks.iter().sum::<f32>() / 16.0;
        let off = mean(&found) / mean(&expected) - 1.0;
        assert!(off.abs() < 0.01, "{plugin}: the mean is {:+.2} % off", 100.0 * off);
        for (block, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() < 0.006, "{plugin} {parameters}, block {block}: {found} for {expected}");
        }
    }
}

/// A tube along x from -1 to 1 (a B-spline) or -2 to 2, of radius 0.5, and where Mitsuba 3.9.1 meets it from outside; from inside,
/// and through an open end, it meets nothing.
#[test]
fn curves_are_met_from_outside_only() {
    const TUBE: &str = "-2 0 0 0.5\n-1 0 0 0.5\n0 0 0 0.5\n1 0 0 0.5\n2 0 0 0.5\n";
    let rays = [
        ("bsplinecurve", [0.0, 0.0, 5.0], [0.0, 0.0, -1.0], Some(4.5)),
        ("bsplinecurve", [-5.0, 0.0, 0.2], [1.0, 0.0, 0.0], None),
        ("bsplinecurve", [-5.0, 0.0, 0.2], [1.0, 0.0, 0.05], None),
        ("bsplinecurve", [0.0, 0.1, 0.2], [0.3, 0.1, 1.0], None),
        ("bsplinecurve", [-3.0, 0.0, 0.0], [1.0, 0.0, 0.2], None),
        ("linearcurve", [0.0, 0.0, 5.0], [0.0, 0.0, -1.0], Some(4.5)),
        ("linearcurve", [-3.0, 0.0, 0.0], [1.0, 0.0, 0.2], Some(0.51054)),
        ("linearcurve", [0.0, 0.1, 0.2], [0.3, 0.1, 1.0], None),
    ];
    for (plugin, origin, direction, expected) in rays {
        let scene = scene(plugin, "", TUBE).expect("a good scene");
        let ray = Ray::new(Vec3::from_array(origin), Vec3::from_array(direction).normalize());
        let found = scene.geometry.intersect(&ray).map(|hit| hit.distance);
        assert_eq!(scene.geometry.is_blocked(&ray), expected.is_some(), "{plugin} {origin:?} {direction:?}");
        match (found, expected) {
            (Some(found), Some(expected)) => assert!((found - expected).abs() < 0.02, "{found} for {expected}"),
            _ => assert_eq!(found, expected, "{plugin} {origin:?} {direction:?}"),
        }
    }
}

/// They have no other outside, and no flat sides: Mitsuba's curves know no such parameters.
#[test]
fn curves_take_no_parameters_of_meshes() {
    for name in ["flip_normals", "face_normals", "flip_tex_coords"] {
        let parameter = format!("<boolean name='{name}' value='true'/>");
        let found = scene("bsplinecurve", &parameter, CURVES).err().unwrap_or_else(|| panic!("{name} is no error"));
        assert!(found.contains(&format!("has no parameter \"{name}\"")), "{found}");
    }
}

#[test]
fn the_approximation_is_told() {
    let scene = scene("linearcurve", "", CURVES).expect("a good scene");
    assert!(
        scene.notices.iter().any(|notice| notice.contains("approximated by tubes with 24 sides")),
        "{:?}",
        scene.notices
    );
}

#[test]
fn curves_that_cannot_be() {
    for (plugin, file, expected) in [
        ("linearcurve", "0 0 0 1\n\n", "curves.txt:1: the curve that ends here has 1 points, and 2 are the fewest"),
        (
            "bsplinecurve",
            "0 0 0 1\n1 0 0 1\n2 0 0 1",
            "curves.txt:3: the curve that ends here has 3 points, and 4 are the fewest",
        ),
        ("linearcurve", "0 0 0 1\n1 0 x 1\n", "curves.txt:2: \"1 0 x 1\" is not a control point"),
        ("linearcurve", "0 0 0 1\n1 0 0\n", "curves.txt:2: \"1 0 0\" is not a control point"),
        ("linearcurve", "0 0 0 1\n1 0 0 -1\n", "curves.txt:2: the control point has 4 numbers and the radius -1"),
        ("linearcurve", "0 0 0 1\n1 0 0 inf\n", "curves.txt:2: \"1 0 0 inf\" is not a control point"),
        ("linearcurve", "\n\n", "the file holds no curves"),
        ("linearcurve", "0 0 0 0\n1 0 0 0\n", "triangles has an area"),
    ] {
        let found = scene(plugin, "", file).err().unwrap_or_else(|| panic!("{file:?} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}

/// Plugins of Mitsuba that are not rendered are called so, with their place and what to take instead.
#[test]
fn plugins_that_are_not_rendered() {
    let sensor = "<sensor type='perspective'/>";
    let light = "<emitter type='point'/>";
    let shape = |inside: &str| format!("{sensor}{light}<shape type='sphere'>{inside}</shape>");
    for (body, expected) in [
        (
            shape("<bsdf type='measured'/>"),
            "(scene/shape[0]/bsdf[0]): bsdf \"measured\" is not supported; use a roughconductor",
        ),
        (shape("<bsdf type='hair'/>"), "bsdf \"hair\" is not supported; use a roughconductor or principled"),
        (shape("<bsdf type='polarizer'/>"), "bsdf \"polarizer\" is not supported; polarization is not rendered"),
        (
            format!("{sensor}{light}<shape type='sdfgrid'/>"),
            "shape \"sdfgrid\" is not supported; export it as a triangle mesh",
        ),
        (
            format!("{light}<shape type='sphere'/><sensor type='batch'/>"),
            "the batch has no sensors; put sensors into it",
        ),
        (
            format!("{light}<shape type='sphere'/><sensor type='distant'/>"),
            "the film of a distant sensor has 768 × 576 pixels; give it one of width 1 and height 1",
        ),
        (
            format!("{light}<shape type='sphere'/><sensor type='radiancemeter'/>"),
            "the film of a radiancemeter has 768 × 576 pixels; give it one of width 1 and height 1",
        ),
        (
            format!("{light}<shape type='sphere'/><sensor type='irradiancemeter'/>"),
            "sensor \"irradiancemeter\" is not supported",
        ),
    ] {
        let found =
            prepare(&body, &[]).err().map(|error| error.to_string()).unwrap_or_else(|| panic!("{body} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
