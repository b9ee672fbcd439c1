//! `emission: metropolis`: photons of chains make the same picture as photons by power.

use photonfarm::method::{MethodChoice, check};

use crate::batches::{ERRORS, assert_same, bits_of_threads, mean_and_error, repository_scene};
use crate::progressive::reference_scene;

/// With the same discs both have the same bias. Rooms, a caustic, a lamp in a closed room beside, and a hat with a hole.
#[test]
fn photons_of_chains_make_the_picture_of_photons_by_power() {
    let scenes = [
        (reference_scene("door-ajar"), 0.05),
        (reference_scene("cornell-glass"), 0.02),
        (repository_scene("sealed-lamp/scene.xml", "32"), 0.05),
        (repository_scene("jack-o-lantern/scene.xml", "32"), 0.05),
    ];
    for (index, (scene, blind)) in scenes.iter().enumerate() {
        let methods: &[&str] = if index == 1 { &["sppm", "ppm"] } else { &["sppm"] };
        for method in methods {
            let parameters = |emission: &str| {
                format!(r#"{{"photons_per_pass": 20000, "initial_radius": 0.05, "emission": "{emission}"}}"#)
            };
            let [chains, power] =
                ["metropolis", "power"].map(|emission| mean_and_error(scene, method, &parameters(emission), 4));
            assert_same(chains, power, 0.0, &format!("{method} in scene {index}, chains and by power"));
            assert!(chains[1] < blind * chains[0], "{method} in scene {index}: the test is blind");
        }
    }
}

/// Nearest photons lie nearer where more of them come, so that the bias differs by a little.
#[test]
fn a_photon_map_of_chains_makes_the_same_picture() {
    for name in ["door-ajar", "cornell-glass"] {
        let scene = reference_scene(name);
        let parameters = |emission: &str| format!(r#"{{"photons_per_pass": 60000, "emission": "{emission}"}}"#);
        let [chains, power] =
            ["metropolis", "power"].map(|emission| mean_and_error(&scene, "photon_map", &parameters(emission), 2));
        assert_same(chains, power, 0.015, &format!("photon_map in {name}, chains and by power"));
        assert!(chains[1] < 0.02 * chains[0], "{name}: the test is blind");
    }
}

/// Weights count the photons of chains, too, so that merging has another share of the bias, which small discs keep small.
#[test]
fn merging_photons_of_chains_makes_the_picture_of_photons_by_power() {
    for name in ["door-ajar", "cornell-glass"] {
        let scene = &reference_scene(name);
        for connect in ["on", "off"] {
            let parameters = |emission: &str| {
                format!(
                    r#"{{"photons_per_pass": 10000, "initial_radius": 0.03, "connect": "{connect}", "emission": "{emission}"}}"#
                )
            };
            let [chains, power] =
                ["metropolis", "power"].map(|emission| mean_and_error(scene, "vcm", &parameters(emission), 2));
            assert_same(chains, power, 0.002, &format!("{name}, connect {connect}, chains and by power"));
            assert!(chains[1] < 0.05 * chains[0], "{name}, connect {connect}: the test is blind");
        }
    }
}

/// All photons come to the picture: chains change nothing, but their weights must still be right.
#[test]
fn a_furnace_of_photon_chains_is_a_furnace() {
    let scene = reference_scene("furnace-closed");
    let parameters = r#"{"initial_radius": 0.01, "photons_per_pass": 16384, "emission": "metropolis"}"#;
    for method in ["sppm", "vcm"] {
        let [found, error, _] = mean_and_error(&scene, method, parameters, 4);
        println!("{method}: {found:.5} ± {error:.5}");
        assert!((found - 1.0).abs() < ERRORS * error + 0.003 && error < 0.0035, "{method}: {found} ± {error}");
    }
}

/// Where a lamp in a closed room takes nearly all power, chains begin where a guide says.
#[test]
fn chains_find_what_few_photons_reach() {
    let scene = repository_scene("sealed-lamp/scene.xml", "32");
    let parameters = |emission: &str| {
        format!(
            r#"{{"direct": "photons", "photons_per_pass": 30000, "initial_radius": 0.2, "emission": "{emission}"}}"#
        )
    };
    let [chains, power] =
        ["metropolis", "power"].map(|emission| mean_and_error(&scene, "sppm", &parameters(emission), 2));
    assert_same(chains, power, 0.0, "direct light by chains and by power");
    assert!(chains[2] < 0.3 * power[2], "noise of chains {}, by power {}", chains[2], power[2]);
}

#[test]
fn photons_of_chains_have_the_same_bits_from_any_number_of_threads() {
    let scene = repository_scene("sealed-lamp/scene.xml", "24");
    for method in ["sppm", "ppm", "vcm", "photon_map"] {
        let parameters = r#"{"photons_per_pass": 10000, "emission": "metropolis"}"#;
        let bits = bits_of_threads(&scene, method, parameters);
        assert!(bits[0] == bits[1] && bits[1] == bits[2], "{method}");
    }
}

/// Chains store what they find; what else chooses among photons is refused, and methods that weigh ways of finding paths have no chains.
#[test]
fn what_chains_cannot_do_is_refused() {
    let refused = [
        (
            "photon_map",
            r#"{"emission": "metropolis", "storage": "importance"}"#,
            "\"storage\" chooses among photons that \"emission\": \"metropolis\" has chosen already; leave one of them out",
        ),
        (
            "photon_map",
            r#"{"emission": "metropolis", "caustic_splitting": 20}"#,
            "\"caustic_splitting\" chooses among photons that \"emission\": \"metropolis\" has chosen already; leave one of them out",
        ),
        ("bdpt", r#"{"emission": "metropolis"}"#, "\"emission\" is \"metropolis\"; allowed: auto, power, guided"),
        (
            "vcm",
            r#"{"emission": "metropolis", "merge": "off"}"#,
            "\"emission\" is \"metropolis\", which makes photons to merge with, and \"merge\" is \"off\"; switch merge on, or give another emission",
        ),
        ("mmlt", r#"{"large_steps": 0}"#, "\"large_steps\" is 0; allowed: 1 to 100"),
    ];
    for (method, parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: method.to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert_eq!(message, format!("method \"{method}\": {expected}"));
    }
}
