//! Materials against the values that Mitsuba 3 computes for them, and `ward` against its formulas.
//!
//! `material_values/make_values.py` wrote the values, in single precision as Mitsuba computes, hence the tolerance.

use crate::scene_text;
use photonfarm::math::{Rgb, Vec2, Vec3};
use photonfarm::scene::material::{Material, TransportMode, View};

const VALUES: &str = include_str!("../material_values/values.txt");
const TOLERANCE: f32 = 1e-4;
/// The coat of `roughplastic` is integrated numerically, with other nodes than Mitsuba's.
const TOLERANCE_OF_INTEGRALS: f32 = 1e-3;
/// Differences below do not count: the far tails of lobes, where Mitsuba cuts off.
const LEAST: f32 = 1e-7;

fn material(text: &str) -> Material {
    let ahead = "<transform name='to_world'><translate z='5'/></transform>";
    let body = format!(
        "<sensor type='perspective'/><shape type='cube'>{ahead}{text}</shape><shape type='sphere'/><emitter type='point'/>"
    );
    scene_text::prepare(&body, &[]).unwrap_or_else(|error| panic!("{text}: {error}")).materials[0].clone()
}

#[test]
fn agreement_with_values_of_mitsuba() {
    let mut current = None;
    let (mut compared, mut wrong) = (0, Vec::new());
    for line in VALUES.lines().filter(|line| !line.starts_with('#')) {
        if line.starts_with('<') {
            current = Some((line, material(line)));
            continue;
        }
        let (text, material) = current.as_ref().expect("a material comes before its values");
        let numbers: Vec<f32> = line.split(' ').map(|number| number.parse().expect("a number")).collect();
        let vector = |index: usize| Vec3::from_slice(&numbers[3 * index..3 * index + 3]);
        let (came, goes) = (vector(0), vector(1));
        let last = numbers.len() / 3 - 1;
        for (mode, expected) in [(TransportMode::Radiance, vector(2)), (TransportMode::Flux, vector(last))] {
            // Thin sheets of Mitsuba are not the same both ways, and photons there see them as radiance does; here photons see
            // what radiance sees from the other end, as `analytic_reciprocity` checks.
            if text.contains("principledthin") && mode == TransportMode::Flux {
                continue;
            }
            let view = View::new(Vec2::splat(0.5), came, mode);
            let tolerance = if text.contains("roughplastic") { TOLERANCE_OF_INTEGRALS } else { TOLERANCE };
            let value: Rgb = material.evaluate(&view, goes) * goes.z.abs();
            compared += 1;
            if ((value - expected).abs() - expected.abs() * tolerance).max_element() > LEAST {
                wrong.push(format!("{text} {mode:?} from {came} to {goes}: {value}, not {expected}"));
            }
        }
    }
    assert!(compared > 1000, "only {compared} values");
    assert!(wrong.is_empty(), "{} of {compared} values differ:\n{}", wrong.len(), wrong.join("\n"));
}
