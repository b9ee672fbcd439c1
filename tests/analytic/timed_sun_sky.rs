//! `timed_sunsky` against averages of Mitsuba's own `sunsky`, and how it is read.
//!
//! Mitsuba 3.9.1 has the plugin, but its scalar modes show the sun's radiance from all directions, and its other modes refuse it. So
//! the truth is the mean of `emitter.eval` of `sunsky` in `scalar_rgb` over 1200 to 8009 even instants of the span, and of
//! the irradiance of a floor by its sun over the same instants.

use crate::scene_files::prepare;
use photonfarm::math::Vec3;
use photonfarm::scene::Scene;

/// What Mitsuba shows of a span.
struct Span {
    parameters: &'static str,
    /// Directions with the mean radiance of the sky from there.
    sky: [[f32; 6]; 4],
    /// The mean irradiance of a floor by the sun.
    sun: [f64; 3],
}

const SPANS: &[Span] = &[
    Span {
        parameters: "<integer name='start_month' value='6'/><integer name='end_year' value='2025'/><integer name='end_day' value='2'/>",
        sky: [
            [-0.5114078, -0.8446128, 0.1584024, 0.101767, 0.151334, 0.214415],
            [-0.4539768, -0.6446671, 0.6150686, 0.0380683, 0.0643793, 0.114103],
            [0.7913045, 0.1320007, 0.5970034, 0.0375408, 0.0648221, 0.116715],
            [-0.5107896, 0.8528827, 0.1080978, 0.177624, 0.21456, 0.249742],
        ],
        sun: [0.980_562_67, 0.808_882_29, 0.605_606_28],
    },
    Span {
        parameters: "<float name='turbidity' value='5.5'/><float name='latitude' value='50'/><float name='longitude' value='10'/>
        <float name='timezone' value='1'/>",
        sky: [
            [-0.5114078, -0.8446128, 0.1584024, 0.0944467, 0.118031, 0.143693],
            [-0.4539768, -0.6446671, 0.6150686, 0.036337, 0.0535709, 0.0813252],
            [0.7913045, 0.1320007, 0.5970034, 0.102553, 0.115317, 0.131085],
            [-0.5107896, 0.8528827, 0.1080978, 0.134351, 0.148036, 0.155964],
        ],
        sun: [0.498_204_93, 0.391_455_17, 0.272_946_28],
    },
    Span {
        parameters: "<integer name='start_year' value='2024'/><integer name='start_month' value='2'/><integer name='start_day' value='20'/>
        <integer name='end_year' value='2024'/><integer name='end_month' value='3'/><integer name='end_day' value='11'/>
        <float name='window_start_time' value='0'/><float name='window_end_time' value='24'/><rgb name='albedo' value='0.1, 0.5, 0.9'/>",
        sky: [
            [-0.5114078, -0.8446128, 0.1584024, 0.0378884, 0.0691662, 0.109346],
            [-0.4539768, -0.6446671, 0.6150686, 0.0117764, 0.0257511, 0.0531079],
            [0.7913045, 0.1320007, 0.5970034, 0.0280628, 0.0440327, 0.0703533],
            [-0.5107896, 0.8528827, 0.1080978, 0.0458319, 0.0800164, 0.118381],
        ],
        sun: [0.304_016_16, 0.241_275_07, 0.166_296_39],
    },
];

/// A ball under an emitter, for a sensor whose shutter is open between two times.
fn scene(emitter: &str, shutter: [f64; 2]) -> Result<Scene, String> {
    let [open, close] = shutter;
    let body = format!(
        "<sensor type='perspective'><transform name='to_world'><translate z='-6'/></transform>
        <float name='shutter_open' value='{open}'/><float name='shutter_close' value='{close}'/></sensor>
        <shape type='sphere'/>{emitter}"
    );
    prepare(&body, &[]).map_err(|error| error.to_string())
}

fn timed(parameters: &str, shutter: [f64; 2]) -> Result<Scene, String> {
    scene(&format!("<emitter type='timed_sunsky'>{parameters}</emitter>"), shutter)
}

fn radiance(scene: &Scene, direction: Vec3) -> Vec3 {
    scene.lights.lights()[0].environment(direction).expect("it is an environment").0
}

#[test]
fn agreement_of_average_skies_with_mitsuba() {
    for Span { parameters, sky, .. } in SPANS {
        let scene =
            timed(&format!("{parameters}<float name='sun_scale' value='0'/>"), [0.0, 1.0]).expect("a good scene");
        for numbers in sky {
            let (found, expected) =
                (radiance(&scene, Vec3::from_slice(&numbers[..3])), Vec3::from_slice(&numbers[3..]));
            let off = ((found - expected) / expected).abs().max_element();
            assert!(off < 4e-3, "{parameters}: {found} for {expected}, {off}");
        }
    }
}

/// The sun is 5° wide, which changes its irradiance by less than 0.1 %, and makes this sum of even numbers exact to about as much.
#[test]
fn agreement_of_average_suns_with_mitsuba() {
    const SAMPLES: u32 = 1 << 16;
    for Span { parameters, sun, .. } in SPANS {
        let more = "<float name='sky_scale' value='0'/><float name='sun_aperture' value='5'/>";
        let scene = timed(&format!("{parameters}{more}"), [0.0, 1.0]).expect("a good scene");
        let arriving = |sample: u32| {
            let u = [(f64::from(sample) + 0.5) / f64::from(SAMPLES), f64::from(sample.reverse_bits()) / 2f64.powi(32)];
            let sample = scene.lights.lights()[0].sample_direct(&scene.geometry, Vec3::ZERO, u.map(|u| u as f32));
            sample.map_or(Vec3::ZERO, |sample| sample.weighted_radiance * sample.direction.z.max(0.0)).as_dvec3()
        };
        let irradiance =
            (0..SAMPLES).map(arriving).reduce(|sum, light| sum + light).expect("numbers") / f64::from(SAMPLES);
        for (found, expected) in irradiance.to_array().into_iter().zip(sun) {
            assert!((found / expected - 1.0).abs() < 5e-3, "{parameters}: {found} for {expected}");
        }
    }
}

/// Half of the thirty-first day of a span of sixty: 13:00 on the 31st of May.
#[test]
fn one_instant_is_a_sunsky() {
    let span = "<integer name='start_month' value='5'/><integer name='end_year' value='2025'/><integer name='end_month' value='6'/>
        <integer name='end_day' value='30'/>";
    let part = 30.5 / 60.0;
    let found = timed(span, [part; 2]).expect("a good scene");
    // An emitter's own shutter moves and stretches the same span.
    let shutter = "<float name='shutter_open' value='2'/><float name='shutter_close' value='6'/>";
    let stretched = timed(&format!("{span}{shutter}"), [2.0 + 4.0 * part; 2]).expect("a good scene");
    let expected = scene(
        "<emitter type='sunsky'><integer name='year' value='2025'/><integer name='month' value='5'/><integer name='day' value='31'/>
        <float name='hour' value='13'/></emitter>",
        [0.0, 0.0],
    )
    .expect("a good scene");
    for direction in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.48, 0.64, 0.6), Vec3::new(0.0, -0.8, 0.6)] {
        for found in [&found, &stretched] {
            let [found, expected] = [found, &expected].map(|scene| radiance(scene, direction));
            assert!((found - expected).abs().max_element() < 1e-5 * expected.max_element(), "{found} for {expected}");
        }
    }
}

#[test]
fn spans_that_cannot_be() {
    let none = [0.0, 0.0];
    for (parameters, shutter, expected) in [
        ("<integer name='end_year' value='2024'/>", none, "the last day comes before the end of the first one"),
        ("<integer name='end_year' value='2025'/>", none, "let it end at least a day after it starts"),
        (
            "<integer name='start_month' value='2'/><integer name='start_day' value='31'/>",
            none,
            "month 2 of 2025 has 28 days",
        ),
        (
            "<float name='window_end_time' value='6'/>",
            none,
            "\"window_end_time\" is 6, before \"window_start_time\", 7",
        ),
        ("<float name='window_start_time' value='25'/>", none, "give a number from 0 to 24"),
        ("<float name='shutter_close' value='0'/>", none, "let it close after it opens"),
        ("", [0.0, 2.0], "the sensor's shutter is open at 2 of the span, outside of it"),
        ("", [1.0, 0.5], "\"shutter_close\" is 0.5, and \"shutter_open\" 1"),
        ("<boolean name='complex_sun' value='true'/>", none, "\"complex_sun\" is not supported"),
        ("<vector name='sun_direction' value='0, 0, 1'/>", none, "has no parameter \"sun_direction\""),
        (
            "<float name='window_start_time' value='0'/><float name='window_end_time' value='3'/>",
            [0.0, 1.0],
            "the sun of the timed_sunsky stands below the horizon all the time",
        ),
    ] {
        let found = timed(parameters, shutter).err().unwrap_or_else(|| panic!("{parameters} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
