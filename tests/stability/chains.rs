//! What Markov chains are known to fail at: they begin somewhere, stay where much light is, and tell how much there is in all by few paths.

use std::sync::Arc;

use photonfarm::scene::Scene;

use crate::pictures::{
    assert_below, assert_close, average, brightest, camera, glow, grays, matte, mean, picture, room, scene, sheet,
    single_pass,
};

/// Methods whose long paths are those of chains.
const CHAINED: [&str; 2] = ["mmlt", "mlt"];

fn view() -> String {
    camera("0, 0, 0.9", "0, 0, -1", "0, 1, 0", 60.0, 16)
}

/// A closed furnace of radiance 1, half of whose light has been reflected more than once.
fn furnace() -> Arc<Scene> {
    scene(&[&view(), &room([1.0; 3], &format!("{}{}", matte(0.7), glow(0.3)))])
}

/// Chains of a single mutation are as right as long ones: none begins where it would not stay.
#[test]
fn chains_have_no_start_up_bias() {
    for method in CHAINED {
        for chains in [1, 16, 256] {
            let seen = picture(&furnace(), method, &format!(r#"{{"chains": {chains}, "large_steps": 1}}"#), 256);
            assert_close(mean(&seen), 1.0, 0.015, &format!("{method}: {chains} chains"));
        }
    }
}

/// All of a pass's light is weighted with what its independent paths tell, so passes differ as a whole.
#[test]
fn passes_of_chains_hardly_flicker() {
    for method in CHAINED {
        let flicker = |parameters: &str| {
            let means: Vec<f64> =
                (1..=48).map(|seed| mean(&single_pass(&furnace(), method, parameters, seed))).collect();
            let middle = average(&means);
            average(&means.iter().map(|mean| (mean / middle - 1.0).powi(2)).collect::<Vec<_>>()).sqrt()
        };
        assert_below(flicker("{}"), 0.09, &format!("{method}: spread of the means of passes of 256 mutations"));
        println!("{method}, with 1 % of large steps: {:.3}", flicker(r#"{"large_steps": 1}"#));
    }
}

/// A ball of glass under a small lamp: of all ways that light goes few bring very much, and chains stay there.
#[test]
fn stuck_chains_leave_no_bright_pixels() {
    let lamp = sheet("0, 0.99, 0", "0, 0, 0", "0, 0, 1", [0.05, 0.05], &format!("{}{}", matte(0.0), glow(100.0)));
    let ball = "<shape type='sphere'><point name='center' x='0.3' y='-0.6' z='-0.3'/><float name='radius' value='0.3'/>\
        <bsdf type='dielectric'/></shape>";
    let scene = scene(&[&view(), &room([1.0; 3], &matte(0.7)), &lamp, ball]);
    let expected = picture(&scene, "bdpt", "{}", 256);
    for method in CHAINED {
        let peak = |parameters: &str| {
            let seen = picture(&scene, method, parameters, 64);
            let over = grays(&seen).into_iter().zip(grays(&expected)).map(|(seen, expected)| seen / expected);
            over.fold(0.0, f64::max)
        };
        // Whole paths stay longer.
        let bound = if method == "mlt" { 16.0 } else { 6.0 };
        assert_below(peak("{}"), bound, &format!("{method}: brightest pixel over what is right"));
        println!("{method}, one chain with 1 % of large steps: {:.2}", peak(r#"{"chains": 1, "large_steps": 1}"#));
    }
}

/// A small mirror shows a bright spot on the wall behind the camera: half of the picture's light is in one pixel.
#[test]
fn one_bright_pixel_does_not_starve_the_others() {
    let spot = "<emitter type='spot'><transform name='to_world'><lookat origin='0.616, 0.41, 0.5' \
        target='0.616, 0.41, 1' up='0, 1, 0'/></transform><rgb name='intensity' value='1000, 1000, 1000'/>\
        <float name='cutoff_angle' value='10'/></emitter>";
    let walls = room([1.0; 3], &matte(0.7));
    let mirror = sheet(
        "0.3, 0.2, -0.95",
        "0.3, 0.2, 1",
        "0, 1, 0",
        [0.06, 0.06],
        "<bsdf type='conductor'><string name='material' value='none'/></bsdf>",
    );
    let [with, without] = [mirror.as_str(), ""].map(|mirror| scene(&[&view(), &walls, spot, mirror]));
    let share = |scene: &Arc<Scene>| {
        let seen = picture(scene, "bdpt", "{}", 64);
        brightest(&seen) / (256.0 * mean(&seen))
    };
    println!("share of the brightest pixel: {:.2}, {:.2} without the mirror", share(&with), share(&without));
    assert!(share(&with) > 0.25, "the scene provokes nothing");
    for method in CHAINED {
        // Pixels apart from the mirror and the lamp's cone.
        let noise = |scene: &Arc<Scene>| {
            let expected = grays(&picture(scene, "bdpt", "{}", 1024));
            let usual = 3.0 * average(&expected[..16]);
            let seen = grays(&picture(scene, method, "{}", 64));
            let others = seen.iter().zip(&expected).filter(|(_, expected)| **expected < usual);
            average(&others.map(|(seen, expected)| (seen / expected - 1.0).powi(2)).collect::<Vec<_>>()).sqrt()
        };
        let [with, without] = [&with, &without].map(noise);
        assert_below(
            with / without,
            2.5,
            &format!("{method}: noise of the others, over {without:.3} without the mirror"),
        );
    }
}
