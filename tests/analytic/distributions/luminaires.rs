//! Luminaires with measured intensities: photons follow the file's distribution, direct light its values.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::chi_square::{Histogram, assert_directions, assert_uniform, numbers, turn};
use photonfarm::import::load_bytes;
use photonfarm::math::Vec3;
use photonfarm::scene::bundle::Bundle;
use photonfarm::scene::{Scene, SceneError};

const SAMPLES: u32 = 100_000;
/// Lumens per watt.
const EFFICACY: f64 = 179.0;
const VERTICAL: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0];
const ALONG: [f64; 10] = [900.0, 880.0, 860.0, 700.0, 500.0, 450.0, 0.0, 0.0, 100.0, 50.0];

fn file(header: &str, horizontal: &[f64], vertical: &[f64], candelas: impl Fn(usize, usize) -> f64) -> String {
    let mut text = format!("{header}TILT=NONE\n1 2900 1.0 {} {} 1 2 0.1 0.2 0.1\n", vertical.len(), horizontal.len());
    text += "1.0 1.0 63.7\n";
    for angles in [vertical, horizontal] {
        writeln!(text, "{}", angles.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")).unwrap();
    }
    for column in 0..horizontal.len() {
        let row: Vec<String> = (0..vertical.len()).map(|row| candelas(column, row).to_string()).collect();
        writeln!(text, "{}", row.join(" ")).unwrap();
    }
    text
}

fn scene(file: &str, parameters: &str) -> Result<Scene, SceneError> {
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/>\
         <emitter type='ies'><string name='filename' value='lamp.ies'/>{parameters}</emitter></scene>"
    );
    let mut description = load_bytes("test.xml", text.as_bytes(), &[])?;
    let files = BTreeMap::from([("lamp.ies".to_owned(), Arc::from(file.as_bytes()))]);
    description.bundle = Bundle::Archive(Arc::new(files));
    Scene::prepare(&description)
}

/// Linear between `values` at `places`; 0 elsewhere.
fn linear(places: &[f64], values: &[f64], at: f64) -> f64 {
    let pair = places.windows(2).zip(values.windows(2)).find(|(places, _)| (places[0]..=places[1]).contains(&at));
    pair.map_or(0.0, |(p, v)| v[0] + (v[1] - v[0]) * (at - p[0]) / (p[1] - p[0]))
}

/// ∫ f over 0..1 by the midpoint rule.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    (0..200).map(|step| f((f64::from(step) + 0.5) / 200.0) / 200.0).sum()
}

/// Photons of the only light: direction and flux over power, after a test of their mean against `power`.
fn photons(family: u32, scene: &Scene, power: f64) -> Vec<(Vec3, f64)> {
    let [light] = scene.lights.lights() else { panic!("one light is expected") };
    assert!((f64::from(light.power().x) / power - 1.0).abs() < 1e-4, "{} W is not {power} W", light.power().x);
    let photons: Vec<(Vec3, f64)> = (0..SAMPLES)
        .map(|sample| {
            let u = numbers(family, sample);
            let photon = light.emit(&scene.geometry, [u[0], u[3]], [u[1], u[2]]).expect("luminaires emit");
            assert!((photon.direction.length() - 1.0).abs() < 1e-5);
            (photon.direction, f64::from(photon.flux.x) / power)
        })
        .collect();
    let count = f64::from(SAMPLES);
    let mean = photons.iter().map(|(_, flux)| flux).sum::<f64>() / count;
    let square = photons.iter().map(|(_, flux)| flux * flux).sum::<f64>() / count;
    let error = ((square - mean * mean).max(0.0) / count).sqrt();
    assert!((mean - 1.0).abs() < 4.0 * error + 1e-5, "photons carry {mean} ± {error} of the power");
    photons
}

#[test]
fn chi_square_photons_of_an_even_luminaire() {
    let lit = scene(&file("", &[0.0], &[0.0, 90.0, 180.0], |_, _| EFFICACY), "").expect("the scene is good");
    let photons = photons(1, &lit, 4.0 * PI);
    assert!(photons.iter().all(|(_, flux)| (flux - 1.0).abs() < 1e-3));
    assert_directions(photons.iter().map(|(w, _)| Some(*w)), |_| 0.25 / PI, -1.0, "even luminaire");
}

/// The intensity is a product of a function of the vertical and one of the horizontal angle, so that the shares of the
/// cells of 2.5° are products, too.
fn check_symmetry(family: u32, horizontal: &[f64], factors: &[f64], fold: impl Fn(f64) -> f64) {
    const WIDTH: f64 = 2.5;
    let text = file("IESNA:LM-63-1995\n[TEST] 1\n", horizontal, &VERTICAL, |column, row| factors[column] * ALONG[row]);
    let lit = scene(&text, "").expect("the scene is good");
    let vertical = |degrees: f64| linear(&VERTICAL, &ALONG, degrees);
    let around = |degrees: f64| linear(horizontal, factors, fold(degrees));
    let angle = |cell: usize, part: f64| WIDTH * (cell as f64 + part);
    let along = |cell| mean(|x| vertical(angle(cell, x)) * angle(cell, x).to_radians().sin()) * WIDTH.to_radians();
    let rows: Vec<f64> = (0..36).map(along).collect();
    let columns: Vec<f64> = (0..144).map(|cell| around(angle(cell, 0.5)) * WIDTH.to_radians()).collect();
    let total = rows.iter().sum::<f64>() * columns.iter().sum::<f64>();
    let photons = photons(family, &lit, total / EFFICACY);

    // Rows by sectors of nine columns, and the place inside of the cell.
    let (mut histogram, mut inside) = (Histogram::new(36 * 16), Vec::new());
    for (w, flux) in &photons {
        let theta = f64::from(w.z).acos().to_degrees() / WIDTH;
        // Horizontal angles run clockwise round +z.
        let phi = turn(w.x, -w.y) * 144.0;
        let (row, column) = ((theta as usize).min(35), (phi as usize).min(143));
        histogram.add(row * 16 + column / 9);
        let cosines = [0, 1].map(|side| angle(row + side, 0.0).to_radians().cos());
        let height = cosines[0] - cosines[1];
        inside.push([((cosines[0] - f64::from(w.z)) / height).clamp(0.0, 0.999_999), phi.fract()]);
        let pdf = rows[row] * columns[column] / total / (height * WIDTH.to_radians());
        let expected = vertical(theta * WIDTH) * around(phi * WIDTH) / total / pdf;
        // Beside the border of a cell, rounding may decide which it is.
        let at_border = [theta, phi].iter().any(|cells| (cells.round() - cells).abs() < 1e-3);
        assert!(at_border || (flux - expected).abs() < 2e-3 * (1.0 + expected), "{flux} is not {expected} at {w}");
    }
    let share = |bin: usize| rows[bin / 16] * columns[bin % 16 * 9..][..9].iter().sum::<f64>() / total;
    let shares: Vec<f64> = (0..36 * 16).map(share).collect();
    histogram.assert_shares(&shares, &format!("luminaire over {horizontal:?}"));
    assert_uniform(inside.into_iter(), &format!("luminaire over {horizontal:?}: inside of cells"));
}

#[test]
fn chi_square_photons_of_luminaires_with_symmetries() {
    let quarter = |phi: f64| if phi % 180.0 > 90.0 { 180.0 - phi % 180.0 } else { phi % 180.0 };
    check_symmetry(2, &[0.0, 22.5, 45.0, 90.0], &[1.0, 0.5, 2.0, 0.1], quarter);
    let half = |phi: f64| if phi > 180.0 { 360.0 - phi } else { phi };
    check_symmetry(3, &[0.0, 45.0, 90.0, 180.0], &[1.0, 0.5, 2.0, 0.1], half);
    check_symmetry(4, &[0.0, 90.0, 225.0, 360.0], &[1.0, 0.5, 2.0, 1.0], |phi| phi);
    let other_half = |phi: f64| match phi {
        phi if phi < 90.0 => 180.0 - phi,
        phi if phi > 270.0 => 540.0 - phi,
        phi => phi,
    };
    check_symmetry(5, &[90.0, 135.0, 270.0], &[1.0, 0.5, 2.0], other_half);
}

#[test]
fn analytic_direct_light_of_a_luminaire() {
    let text = file("IESNA91\n", &[0.0, 90.0, 180.0, 270.0, 360.0], &[0.0, 90.0, 180.0], |column, row| match row {
        0 => 1790.0,
        1 => 179.0 * [2.0, 3.0, 4.0, 5.0, 2.0][column],
        _ => 179.0 * 6.0,
    });
    let place = "<transform name='to_world'><scale value='3'/><translate value='1, 2, 3'/></transform>\
        <rgb name='intensity' value='1, 0.5, 0'/>";
    let lit = scene(&text, place).expect("the scene is good");
    let origin = Vec3::new(1.0, 2.0, 3.0);
    let cases = [
        (Vec3::Z, 10.0),
        (Vec3::NEG_Z, 6.0),
        (Vec3::X, 2.0),
        (Vec3::NEG_Y, 3.0),
        (Vec3::NEG_X, 4.0),
        (Vec3::Y, 5.0),
        (Vec3::new(1.0, -1.0, 0.0).normalize(), 2.5),
        (Vec3::new(1.0, 0.0, 1.0).normalize(), 6.0),
    ];
    for (direction, expected) in cases {
        let point = origin + direction * 2.0;
        let found = lit.lights.sample_direct(&lit.geometry, &point.into(), [0.5; 3]).expect("it shines everywhere");
        assert!((found.weighted_radiance.x * 4.0 - expected).abs() < 1e-4 * expected, "{direction}: {found:?}");
        assert!((found.weighted_radiance.y * 8.0 - expected).abs() < 1e-4 * expected);
        assert!(found.direction.distance(-direction) < 1e-5 && found.pdf_solid_angle == 0.0);
    }
}

#[test]
fn luminaires_that_cannot_be() {
    let good = file("IESNA:LM-63-2002\n[TEST] A\n", &[0.0, 90.0], &[0.0, 45.0, 90.0], |_, row| row as f64);
    assert!(scene(&good, "").is_ok());
    let tilted = good.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1.0 0.9 0.8");
    assert!(scene(&tilted, "").is_ok());
    let replaced = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    };
    let cases = [
        ("no tilt", replaced("TILT=NONE\n", "")),
        ("tilt in a file", replaced("TILT=NONE", "TILT=lamp.tlt")),
        ("cut off", good[..good.len() - 8].to_owned()),
        ("cut off before the angles", replaced("1 2900", "\u{1a}")),
        ("type B", replaced(" 3 2 1 2 ", " 3 2 2 2 ")),
        ("type A", replaced(" 3 2 1 2 ", " 3 2 3 2 ")),
        ("one vertical angle", replaced(" 3 2 1 2 ", " 1 2 1 2 ")),
        ("many angles", replaced(" 3 2 1 2 ", " 999999 999999 1 2 ")),
        ("no angles", replaced(" 3 2 1 2 ", " 3 0 1 2 ")),
        ("half an angle", replaced(" 3 2 1 2 ", " 3 1.5 1 2 ")),
        ("angles in disorder", replaced("0 45 90", "0 95 90")),
        ("vertical angles of 200°", replaced("0 45 90", "0 45 200")),
        ("a third of the circle", replaced("\n0 90\n", "\n0 120\n")),
        ("negative intensity", replaced("0 1 2", "0 -1 2")),
        ("intensity that is not a number", replaced("0 1 2", "0 nan 2")),
        ("infinite intensity", replaced("0 1 2", "0 1e999 2")),
        ("no light", good.replace("0 1 2", "0 0 0")),
        ("multiplier of 0", replaced("1 2900 1.0", "1 2900 0")),
        ("huge multiplier", replaced("1 2900 1.0", "1 2900 1e300")),
    ];
    let mut report = String::new();
    for (what, text) in &cases {
        match scene(text, "") {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    let stretched = "<transform name='to_world'><scale x='2'/></transform>";
    for parameters in [stretched, "<float name='intensty' value='1'/>", "<rgb name='intensity' value='-1, 0, 0'/>"] {
        writeln!(report, "{parameters}\n    {}", scene(&good, parameters).err().expect("an error")).unwrap();
    }
    insta::assert_snapshot!(report);
}

/// No cut and no changed byte of a file makes reading it panic.
#[test]
fn mutated_luminaires_are_read_or_refused() {
    let good = file("IESNA:LM-63-2002\n", &[0.0, 90.0], &[0.0, 45.0, 90.0], |_, row| row as f64);
    for length in 0..good.len() {
        let _ = scene(&good[..length], "");
    }
    for index in 0..3000 {
        let u = numbers(50, index);
        let mut bytes = good.clone().into_bytes();
        let at = (u[0] * bytes.len() as f32) as usize;
        bytes[at] = b"0123456789.-e \nTX"[(u[1] * 17.0) as usize];
        let _ = scene(&String::from_utf8(bytes).expect("ASCII"), "");
    }
}
