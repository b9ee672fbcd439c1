//! `sunsky` against Mitsuba's own values, and how it is sampled.
//!
//! The values are of Mitsuba 3.9.1, `scalar_rgb`: `emitter.eval` in a direction, and 0.5/π times the irradiance of a floor as its
//! `path` renders it. Its sun is 0.2 % too bright at the usual aperture, where it rounds the cosine of 0.27° to single precision.

use crate::rendered::rendered;
use std::sync::Arc;

use crate::chi_square::{assert_directions, numbers};
use crate::scene_files::prepare;
use photonfarm::math::Vec3;
use photonfarm::scene::Scene;

/// The parameters of a `sunsky`; then directions with the radiance from there, the last towards the sun.
const VALUES: &[(&str, &[[f32; 6]])] = &[
    (
        "",
        &[
            [-0.5103561, -0.8428335, 0.1707876, 0.09338258, 0.1489674, 0.2265891],
            [0.3451146, 0.9325024, 0.1064671, 0.1849799, 0.249753, 0.3203198],
            [-0.4494005, -0.6381658, 0.6251269, 0.02849712, 0.05516627, 0.1103867],
            [0.7867402, 0.1312701, 0.603165, 0.03873879, 0.06788377, 0.1262854],
            [-0.510177, 0.8518444, 0.1186618, 0.1515391, 0.2132389, 0.2872496],
            [0.05138545, 0.691748, 0.7203085, 21418.74, 17626.25, 13041.79],
        ],
    ),
    (
        "<vector name='sun_direction' value='0, 0.6, 0.8'/>",
        &[
            [-0.8250769, -0.03986745, 0.5636122, 0.03757076, 0.06885666, 0.1325364],
            [-0.5813048, -0.4507953, 0.6773981, 0.02806301, 0.05447771, 0.1114938],
            [0.670275, -0.07641235, 0.7381684, 0.03014581, 0.0555444, 0.1114146],
            [0.2152382, 0.4360352, 0.8738111, 0.07890973, 0.1038727, 0.1547872],
            [-0.2487624, -0.9503095, 0.1871606, 0.08850097, 0.1431244, 0.2270233],
            [0.0, 0.6, 0.8, 21689.51, 18034.7, 13663.47],
        ],
    ),
    (
        "<vector name='sun_direction' value='-1, 0.2, 0.15'/><float name='turbidity' value='6.4'/><rgb name='albedo' value='0.1, 0.5, 0.9'/><float name='sky_scale' value='2'/><float name='sun_scale' value='0.5'/>",
        &[
            [-0.9988655, 0.01602809, 0.04484196, 2.123343, 1.328115, 0.462101],
            [-0.2605859, -0.8972757, 0.3563584, 0.08411103, 0.1132008, 0.1299989],
            [-0.6210856, -0.7712622, 0.1393099, 0.1706035, 0.1809349, 0.1585456],
            [-0.6257623, 0.6601408, 0.4154945, 0.1959856, 0.1917861, 0.1679894],
            [-0.8658726, 0.1179432, 0.4861626, 0.3741593, 0.3111778, 0.2104584],
            [-0.9701425, 0.1940285, 0.1455214, 3697.977, 1990.952, 613.6493],
        ],
    ),
    (
        "<vector name='sun_direction' value='0.3, -0.9, 0.2'/><float name='sun_aperture' value='20'/><transform name='to_world'><rotate x='1' angle='90'/></transform>",
        &[
            [0.01645312, -0.9996288, 0.02171632, 0.05795103, 0.07924017, 0.1300097],
            [-0.2241713, -0.9430811, -0.2456524, 0.02939751, 0.05065713, 0.1027684],
            [-0.6612114, -0.6262471, 0.4130543, 0.03486603, 0.06538527, 0.128464],
            [-0.1921271, -0.8517683, -0.4874196, 0.02761005, 0.05104724, 0.1054144],
            [0.2199417, -0.2562121, 0.9412656, 0.08425111, 0.1371522, 0.2263393],
            [0.3094264, -0.9282792, 0.2062843, 15.97383, 13.50711, 10.60807],
        ],
    ),
    (
        "<float name='latitude' value='60'/><float name='longitude' value='10'/><float name='timezone' value='1'/><integer name='month' value='3'/><integer name='day' value='20'/><float name='hour' value='12'/><float name='turbidity' value='9.5'/>",
        &[
            [0.6274887, 0.6242881, 0.4653195, 0.1803338, 0.1808003, 0.1796104],
            [-0.04949324, 0.9543995, 0.294401, 0.08350691, 0.09459455, 0.1119738],
            [0.2872463, -0.03229013, 0.9573123, 0.09128441, 0.09819105, 0.1100039],
            [-0.7689252, -0.3210526, 0.5528826, 0.04823766, 0.06267056, 0.08842836],
            [0.08151191, -0.6843665, 0.7245677, 0.07383943, 0.08324103, 0.1043797],
            [0.8606142, -0.1197336, 0.4949819, 10702.61, 7883.549, 5418.799],
        ],
    ),
];

/// A white matte floor from above, under a day.
fn scene(parameters: &str) -> Result<Scene, String> {
    let body = format!(
        "<sensor type='orthographic'><transform name='to_world'><lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform>
        <film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/><rfilter type='box'/></film></sensor>
        <shape type='rectangle'><bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>
        <emitter type='sunsky'>{parameters}</emitter>"
    );
    prepare(&body, &[]).map_err(|error| error.to_string())
}

fn radiance(scene: &Scene, direction: Vec3) -> Vec3 {
    scene.lights.lights()[0].environment(direction).expect("it is an environment").0
}

#[test]
fn agreement_of_radiances_with_mitsuba() {
    for (parameters, values) in VALUES {
        let scene = scene(parameters).expect("a good scene");
        for (index, numbers) in values.iter().enumerate() {
            let found = radiance(&scene, Vec3::from_slice(&numbers[..3]));
            let expected = Vec3::from_slice(&numbers[3..]);
            let is_sun = index + 1 == values.len();
            // Of place and time Mitsuba's sun stands up to 0.015° elsewhere.
            let bound = if is_sun {
                5e-3
            } else if parameters.contains("latitude") {
                3e-3
            } else {
                1e-4
            };
            let off = ((found - expected) / expected).abs().max_element();
            assert!(off < bound, "{parameters} {index}: {found} for {expected}, {off}");
        }
    }
}

/// The sun of its usual place and time, drawn a tenth as wide: the direction is Mitsuba's to 0.03°.
#[test]
fn agreement_of_the_sun_s_place() {
    for (parameters, values) in VALUES.iter().filter(|(parameters, _)| !parameters.contains("sun_direction")) {
        let scene = scene(&format!("{parameters}<float name='sun_aperture' value='0.06'/>")).expect("a good scene");
        let sun = values.last().expect("the sun is the last");
        assert!(radiance(&scene, Vec3::from_slice(&sun[..3]))[0] > 1e5, "{parameters}");
    }
}

fn floor(parameters: &str, name: &str, passes: u32) -> [f32; 3] {
    let scene = Arc::new(scene(parameters).expect("a good scene"));
    let pixels = rendered(&scene, name, serde_json::Map::new(), passes, 3).radiance;
    [0, 1, 2].map(|channel| pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32)
}

/// Mitsuba's own pictures of the floor are noisy by 0.13 %.
#[test]
fn agreement_of_irradiances_with_mitsuba() {
    for (day, expected) in [(1, [0.215_713, 0.199_001, 0.190_694]), (2, [0.051_556, 0.054_158, 0.054_576])] {
        for (method, passes, bound) in [("path", 256, 0.008), ("sppm", 8, 0.02), ("bdpt", 64, 0.02)] {
            let found = floor(VALUES[day].0, method, passes);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0_f32).abs() < bound, "{method}, day {day}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn chi_square_directions_of_days() {
    for (family, parameters) in [
        (700, "<float name='sun_aperture' value='40'/>"),
        (701, "<float name='sun_aperture' value='60'/><float name='sky_scale' value='0'/>"),
        (702, "<float name='sun_scale' value='0'/><vector name='sun_direction' value='1, 0.2, 0.1'/>"),
    ] {
        let scene = scene(parameters).expect("a good scene");
        let light = &scene.lights.lights()[0];
        let sample = |index| {
            let u = numbers(family, index);
            let sample = light.sample_direct(&scene.geometry, Vec3::ZERO, [u[0], u[1]]).expect("light comes");
            let (radiance, pdf) = light.environment(sample.direction).expect("it is an environment");
            assert!(
                (sample.pdf_solid_angle / pdf - 1.0).abs() < 1e-4,
                "{parameters}: {} for {pdf}",
                sample.pdf_solid_angle
            );
            let off = sample.weighted_radiance.distance(radiance / pdf);
            assert!(
                off <= 1e-4 * (radiance / pdf).length(),
                "{parameters}: {} for {}",
                sample.weighted_radiance,
                radiance / pdf
            );
            Some(sample.direction)
        };
        let pdf = |direction: Vec3| f64::from(light.environment(direction).expect("it is an environment").1);
        assert_directions((0..100_000).map(sample), pdf, -1.0, parameters);
    }
}

#[test]
fn days_that_cannot_be() {
    for (parameters, expected) in [
        ("<float name='turbidity' value='0.5'/>", "\"turbidity\" is 0.5; give a number from 1 to 10"),
        ("<rgb name='albedo' value='0.1, 2, 0.1'/>", "\"albedo\" is above 1"),
        ("<float name='sun_aperture' value='90'/>", "\"sun_aperture\" is 90 degrees"),
        ("<boolean name='complex_sun' value='true'/>", "\"complex_sun\" is not supported"),
        ("<float name='sun_scale' value='-1'/>", "\"sun_scale\" is -1"),
        ("<integer name='month' value='13'/>", "\"month\" is 13; give a number from 1 to 12"),
        (
            "<float name='hour' value='3'/><vector name='sun_direction' value='0, 0, 1'/>",
            "\"sun_direction\" and \"hour\" are given",
        ),
        ("<vector name='sun_direction' value='0, 0, 0'/>", "\"sun_direction\" has no length"),
        (
            "<integer name='month' value='2'/><integer name='day' value='31'/>",
            "\"day\" is 31, and month 2 of 2010 has 28 days",
        ),
        ("<float name='day' value='2.5'/>", "\"day\" is 2.5; give a whole number"),
        ("<float name='sky_scale' value='1e40'/>", "\"sky_scale\" is 1e40; give a number from 0 to 1e20"),
        // At night everything is black.
        (
            "<vector name='sun_direction' value='0, 1, -0.1'/>",
            "the sun of the sunsky stands 5.7° below the horizon, and nothing else",
        ),
    ] {
        let found = scene(parameters).err().unwrap_or_else(|| panic!("{parameters} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
