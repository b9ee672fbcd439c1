//! Small scenes, one for each plugin, default and main parameter of Mitsuba 3, look as Mitsuba 3.9.1 shows them (`tests/mitsuba_scenes`).
//!
//! `docs/measured/MITSUBA-SCENES.md` has the same comparison with more passes.

use crate::mitsuba_scenes::{Judged, KNOWN, folder, judge, names};
use rayon::prelude::*;

const GROUPS: [&str; 9] = ["bsdf", "emitter", "film", "integrator", "medium", "sensor", "shape", "spectrum", "texture"];
/// Few passes suffice, since noise is known.
const PASSES: u32 = 64;

/// Renders a group of scenes and says which differ.
fn check(group: &str) {
    let check_one = |name: &String| {
        let judged = judge(name, PASSES).unwrap_or_else(|error| panic!("{name}: {error}"));
        let Judged { reference, mean, mean_noise, worst, place, noise, notices } = &judged;
        let text = format!(
            "{name}: mean {:+.2} ± {:.2} %, worst block {place:?} {:+.1} % beyond noise of at most {:.1} %, beside {} samples \
             of Mitsuba {} {} {notices:?} {}",
            100.0 * mean,
            100.0 * mean_noise,
            100.0 * worst,
            100.0 * noise,
            reference.samples,
            reference.mitsuba,
            reference.variant,
            Judged::reason(name)
        );
        (judged.holds(name), text)
    };
    let judged: Vec<(bool, String)> = names(&format!("{group}-")).par_iter().map(check_one).collect();
    judged.iter().for_each(|(_, text)| println!("{text}"));
    let differing: Vec<&str> = judged.iter().filter(|(holds, _)| !holds).map(|(_, text)| text.as_str()).collect();
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

#[test]
fn agreement_mitsuba_bsdfs() {
    check("bsdf");
}

#[test]
fn agreement_mitsuba_emitters() {
    check("emitter");
}

#[test]
fn agreement_mitsuba_films() {
    check("film");
}

#[test]
fn agreement_mitsuba_integrators() {
    check("integrator");
}

#[test]
fn agreement_mitsuba_media() {
    check("medium");
}

#[test]
fn agreement_mitsuba_sensors() {
    check("sensor");
}

#[test]
fn agreement_mitsuba_shapes() {
    check("shape");
}

#[test]
fn agreement_mitsuba_spectra() {
    check("spectrum");
}

#[test]
fn agreement_mitsuba_textures() {
    check("texture");
}

#[test]
fn every_small_scene_is_checked_and_has_its_reference() {
    let all = names("");
    assert!(all.len() > 60, "only {} scenes", all.len());
    for name in &all {
        assert!(GROUPS.iter().any(|group| name.starts_with(&format!("{group}-"))), "no test renders {name}");
        assert!(folder().join(format!("{name}.json")).is_file(), "{name} has no reference");
    }
    for (name, ..) in KNOWN {
        assert!(all.iter().any(|scene| scene == name), "there is no scene {name}");
    }
}
