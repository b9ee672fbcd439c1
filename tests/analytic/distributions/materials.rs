//! What every material must obey: sampling follows its density (χ²), weights are f·|cos|/pdf, no energy is made, light
//! travels both ways alike, lobes add up, photons and camera paths see the same surface.

use crate::chi_square::{assert_directions, numbers};
use crate::scene_text;
use photonfarm::math::{Frame, Rgb, Vec2, Vec3, warp};
use photonfarm::scene::material::{Lobes, Material, MaterialSample, TransportMode, View};

const SAMPLES: u32 = 40_000;
const GGX: &str = "<string name='distribution' value='ggx'/>";

/// A material and what is known about it.
struct Case {
    text: String,
    material: Material,
    /// Index behind over before the surface, where light is refracted.
    relative_index: f32,
    /// The most light that may leave per light that arrives.
    most_energy: f32,
}

fn material(text: &str) -> Material {
    let ahead = "<transform name='to_world'><translate z='5'/></transform>";
    let body = format!(
        "<sensor type='perspective'/><shape type='cube'>{ahead}{text}</shape><shape type='sphere'/><emitter type='point'/>"
    );
    scene_text::prepare(&body, &[]).unwrap_or_else(|error| panic!("{text}: {error}")).materials[0].clone()
}

fn number(name: &str, value: f32) -> String {
    format!("<float name='{name}' value='{value}'/>")
}

fn bsdf(plugin: &str, parameters: &str) -> String {
    format!("<bsdf type='{plugin}'>{parameters}</bsdf>")
}

fn grey(name: &str, value: f32) -> String {
    format!("<rgb name='{name}' value='{value}'/>")
}

fn glass(interior: f32) -> String {
    number("int_ior", interior) + &number("ext_ior", 1.0)
}

/// Materials with lobes of a roughness of at least 0.2, which the bins of the χ² tests resolve.
fn cases() -> Vec<Case> {
    let alpha = |alpha: f32| number("alpha", alpha);
    let stretched = number("alpha_u", 0.2) + &number("alpha_v", 0.6);
    let color = "<rgb name='base_color' value='0.8, 0.4, 0.2'/>";
    let diffuse = bsdf("diffuse", &grey("reflectance", 0.8));
    let cases = [
        (bsdf("roughconductor", &alpha(0.25)), 1.0),
        (bsdf("roughconductor", &format!("{GGX}{}", alpha(0.5))), 1.0),
        (bsdf("roughconductor", &stretched), 1.0),
        (bsdf("roughconductor", &format!("{GGX}{stretched}<string name='material' value='Au'/>")), 1.0),
        (bsdf("roughdielectric", &(alpha(0.25) + &glass(1.5))), 1.5),
        (bsdf("roughdielectric", &format!("{GGX}{stretched}{}", glass(1.8))), 1.8),
        (bsdf("roughdielectric", &format!("{GGX}{}{}", alpha(0.4), glass(0.7))), 0.7),
        (bsdf("plastic", &grey("diffuse_reflectance", 0.9)), 1.0),
        (bsdf("plastic", &(glass(1.9) + "<boolean name='nonlinear' value='true'/>")), 1.0),
        (bsdf("roughplastic", &alpha(0.25)), 1.0),
        (bsdf("roughplastic", &format!("{GGX}{}{}", alpha(0.5), grey("diffuse_reflectance", 0.9))), 1.0),
        (bsdf("thindielectric", ""), 1.0),
        (bsdf("ward", &number("alpha", 0.25)), 1.0),
        (bsdf("ward", &(stretched.clone() + &grey("specular_reflectance", 0.5))), 1.0),
        (bsdf("blendbsdf", &(number("weight", 0.3) + &diffuse + &bsdf("roughconductor", &alpha(0.25)))), 1.0),
        (
            bsdf(
                "blendbsdf",
                &(number("weight", 0.6)
                    + &bsdf("roughdielectric", &(alpha(0.25) + &glass(1.5)))
                    + &bsdf("plastic", "")),
            ),
            1.5,
        ),
        (bsdf("blendbsdf", &(number("weight", 0.5) + &bsdf("null", "") + &bsdf("dielectric", &glass(1.5)))), 1.5),
        (bsdf("mask", &(number("opacity", 0.3) + &diffuse)), 1.0),
        (bsdf("mask", &(number("opacity", 0.7) + &bsdf("roughplastic", &alpha(0.25)))), 1.0),
        (bsdf("null", ""), 1.0),
        (bsdf("difftrans", &grey("transmittance", 0.9)), 1.0),
        (bsdf("twosided", &bsdf("roughplastic", &alpha(0.25))), 1.0),
        (bsdf("principled", color), 1.0),
        (bsdf("principled", &format!("{color}{}{}", number("metallic", 1.0), number("roughness", 0.6))), 1.0),
        (
            bsdf(
                "principled",
                &format!(
                    "{color}{}{}{}",
                    number("metallic", 0.4),
                    number("anisotropic", 0.7),
                    number("roughness", 0.7)
                ),
            ),
            1.0,
        ),
        (
            bsdf(
                "principled",
                &format!("{color}{}{}", number("sheen", 0.5), number("flatness", 0.4) + &number("clearcoat", 1.0)),
            ),
            1.0,
        ),
        (
            bsdf(
                "principled",
                &format!("{color}{}{}{}", number("spec_trans", 0.7), number("eta", 1.5), number("roughness", 0.55)),
            ),
            1.5,
        ),
        (bsdf("principledthin", &format!("{color}{}", number("diff_trans", 0.8))), 1.0),
        (
            bsdf(
                "principledthin",
                &format!(
                    "{color}{}{}{}",
                    number("spec_trans", 0.6),
                    number("diff_trans", 1.4),
                    number("roughness", 0.7)
                ),
            ),
            1.0,
        ),
        (
            bsdf(
                "principledthin",
                &format!(
                    "{color}{}{}",
                    number("spec_trans", 1.0),
                    number("roughness", 0.8) + &number("anisotropic", 0.4)
                ),
            ),
            1.0,
        ),
    ];
    let case = |(text, relative_index): (String, f32)| {
        // Disney's matte part is brighter than light at grazing angles, the more with sheen; see the material's page.
        let most_energy = if text.contains("sheen") { 1.3 } else { 1.0 };
        Case { material: material(&text), text, relative_index, most_energy }
    };
    cases.into_iter().map(case).collect()
}

const RESTRICTIONS: [Lobes; 3] = [Lobes::ALL, Lobes::WIDE, Lobes::FOLLOWED];

fn view(outgoing: Vec3, mode: TransportMode, lobes: Lobes) -> View {
    View::new(Vec2::splat(0.5), outgoing, mode).of(lobes)
}

fn outgoing_directions() -> impl Iterator<Item = Vec3> {
    [0.95f32, 0.6, 0.15].into_iter().enumerate().flat_map(|(index, cosine)| {
        let sine = (1.0 - cosine * cosine).sqrt();
        let azimuth = 0.4 + 2.0 * index as f32;
        [1.0, -1.0].map(|side| Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), side * cosine))
    })
}

fn samples(material: &Material, view: &View, family: u32) -> Vec<Option<MaterialSample>> {
    let sample = |index| numbers(family, index);
    (0..SAMPLES).map(sample).map(|u| material.sample(view, [u[0], u[1], u[2]])).collect()
}

/// Calls `check` with every case, direction and restriction, and a number that is its own.
fn for_all(check: impl Fn(&Case, Vec3, Lobes, u32, &str)) {
    let mut family = 1000;
    for case in cases() {
        for outgoing in outgoing_directions() {
            for lobes in RESTRICTIONS {
                family += 1;
                check(&case, outgoing, lobes, family, &format!("{} from {outgoing}, {lobes:?}", case.text));
            }
        }
    }
}

fn is_near(a: Rgb, b: Rgb, tolerance: f32) -> bool {
    (a - b).abs().max_element() <= tolerance * (a.abs().max_element().max(b.abs().max_element())) + 1e-6
}

#[test]
fn chi_square_sampling_follows_the_density() {
    for_all(|case, outgoing, lobes, family, what| {
        let view = view(outgoing, TransportMode::Radiance, lobes);
        let samples = samples(&case.material, &view, family);
        // A coat is narrower than the bins; `chi_square_narrow_lobes` looks at such.
        if samples.iter().all(Option::is_none) || case.text.contains("clearcoat") {
            return;
        }
        let smooth = samples.iter().map(|sample| sample.filter(|sample| !sample.is_specular()));
        if smooth.clone().all(|sample| sample.is_none()) {
            return;
        }
        let pdf = |direction: Vec3| f64::from(case.material.pdf(&view, direction));
        assert_directions(smooth.map(|sample| sample.map(|sample| sample.direction)), pdf, -1.0, what);
    });
}

#[test]
fn chi_square_narrow_lobes() {
    let mut family = 9000;
    let rough = |plugin: &str, shape: &str, alpha: f32| {
        bsdf(plugin, &format!("{shape}{}{}", number("alpha", alpha), glass(1.5)))
    };
    for alpha in [0.01f32, 0.03] {
        let coat = format!("{}{}", number("clearcoat", 1.0), number("clearcoat_gloss", 1.01 - 10.0 * alpha));
        for text in [
            bsdf("roughconductor", &number("alpha", alpha)),
            bsdf("roughconductor", &format!("{GGX}{}", number("alpha", alpha))),
            rough("roughdielectric", "", alpha),
            rough("roughdielectric", GGX, alpha),
            rough("roughplastic", GGX, alpha),
            bsdf("ward", &number("alpha", alpha)),
            bsdf("principled", &coat),
        ] {
            let material = material(&text);
            for cosine in [0.9f32, 0.4] {
                family += 1;
                let outgoing = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let frame = Frame::from_normal(Vec3::new(-outgoing.x, 0.0, outgoing.z));
                let view = view(outgoing, TransportMode::Radiance, Lobes::FOLLOWED);
                let samples = samples(&material, &view, family);
                assert!(samples.iter().flatten().count() > SAMPLES as usize / 2, "{text} is hardly sampled");
                // A cone of radius 4α round the mirror direction: bins in it resolve the lobe, also where it is foreshortened.
                let least_cosine = 1.0 - 8.0 * f64::from(alpha * alpha);
                let pdf = |direction: Vec3| f64::from(material.pdf(&view, frame.to_world(direction)));
                let directions = samples.iter().map(|sample| sample.map(|sample| frame.to_local(sample.direction)));
                assert_directions(directions, pdf, least_cosine, &format!("{text} from {outgoing}"));
            }
        }
    }
}

#[test]
fn analytic_weights_are_value_times_cosine_over_density() {
    for_all(|case, outgoing, lobes, family, what| {
        for mode in [TransportMode::Radiance, TransportMode::Flux] {
            let view = view(outgoing, mode, lobes);
            for sample in samples(&case.material, &view, family).iter().take(2000).flatten() {
                assert!((sample.direction.length() - 1.0).abs() < 1e-4, "{what}: {}", sample.direction);
                if sample.is_specular() {
                    continue;
                }
                let value = case.material.evaluate(&view, sample.direction);
                let pdf = case.material.pdf(&view, sample.direction);
                assert!((sample.pdf - pdf).abs() <= 1e-3 * pdf, "{what}: density {} against {pdf}", sample.pdf);
                let expected = value * sample.direction.z.abs() / pdf;
                assert!(is_near(sample.weight, expected, 1e-3), "{what}: weight {} against {expected}", sample.weight);
                let crosses = sample.direction.z * outgoing.z < 0.0;
                let index = if outgoing.z > 0.0 { case.relative_index } else { 1.0 / case.relative_index };
                let index = if crosses { index } else { 1.0 };
                assert!((sample.relative_index / index - 1.0).abs() < 1e-5, "{what}: index {}", sample.relative_index);
            }
        }
    });
}

/// The mean weight, and three standard deviations of it.
fn albedo(samples: &[Option<MaterialSample>]) -> (Rgb, f32) {
    let weights = || samples.iter().map(|sample| sample.map_or(Rgb::ZERO, |sample| sample.weight));
    let mean = weights().sum::<Rgb>() / SAMPLES as f32;
    let squares = weights().map(|weight| weight * weight).sum::<Rgb>() / SAMPLES as f32;
    let variance = (squares - mean * mean).max_element().max(0.0) / SAMPLES as f32;
    (mean, 4.0 * variance.sqrt() + 2e-4)
}

#[test]
fn energy_balance_of_materials() {
    let mut family = 20_000;
    for case in cases() {
        for outgoing in outgoing_directions() {
            family += 1;
            let what = format!("{} from {outgoing}", case.text);
            let [all, wide, followed] = RESTRICTIONS
                .map(|lobes| albedo(&samples(&case.material, &view(outgoing, TransportMode::Flux, lobes), family)));
            assert!(all.0.max_element() <= case.most_energy + all.1, "{what}: {} of the light leaves", all.0);
            let error = all.1 + wide.1 + followed.1;
            assert!(
                (all.0 - wide.0 - followed.0).abs().max_element() <= error,
                "{what}: {all:?} {wide:?} {followed:?}"
            );

            let share = case.material.followed_share(&view(outgoing, TransportMode::Flux, Lobes::ALL));
            assert!((0.0..=1.0).contains(&share), "{what}: {share}");
            assert!(share > 0.0 || followed.0 == Rgb::ZERO, "{what}: nothing is followed of {}", followed.0);
            assert!(share < 1.0 || wide.0 == Rgb::ZERO, "{what}: nothing is gathered of {}", wide.0);
            let light = followed.0.element_sum() / all.0.element_sum();
            assert!(!(0.02..=0.98).contains(&light) || (share / light).ln().abs() < 1.6, "{what}: {share} for {light}");
        }
    }
}

#[test]
fn analytic_specular_lobes_are_what_is_sampled() {
    let mut family = 30_000;
    for case in cases() {
        for outgoing in outgoing_directions() {
            family += 1;
            let view = view(outgoing, TransportMode::Flux, Lobes::ALL);
            let mut specular = samples(&case.material, &view, family);
            specular.iter_mut().for_each(|sample| *sample = sample.filter(MaterialSample::is_specular));
            let (mean, error) = albedo(&specular);
            let lobes = case.material.specular_lobes(&view);
            let sum: Rgb = lobes.iter().flatten().map(|lobe| lobe.weight).sum();
            let what = format!("{} from {outgoing}", case.text);
            assert!((mean - sum).abs().max_element() <= error, "{what}: {mean} sampled, {sum} in lobes");
            for sample in specular.iter().flatten().take(100) {
                let found = lobes.iter().flatten().any(|lobe| lobe.direction == sample.direction);
                assert!(found, "{what}: {} is not among the lobes", sample.direction);
            }
        }
    }
}

#[test]
fn analytic_reciprocity() {
    for case in cases() {
        for index in 0..3000 {
            let u = numbers(40_000, index);
            let (a, b) = (warp::sphere([u[0], u[1]]), warp::sphere([u[2], u[3]]));
            if a.z.abs() < 0.05 || b.z.abs() < 0.05 {
                continue;
            }
            let value = |outgoing: Vec3, incident: Vec3, mode| {
                case.material.evaluate(&view(outgoing, mode, Lobes::ALL), incident)
            };
            let index_squared = |direction: Vec3| if direction.z > 0.0 { 1.0 } else { case.relative_index.powi(2) };
            let (there, back) = (value(a, b, TransportMode::Radiance), value(b, a, TransportMode::Radiance));
            let what = format!("{} between {a} and {b}", case.text);
            // Near the angle of total reflection single precision leaves three digits.
            let tolerance = if a.z * b.z < 0.0 { 1e-2 } else { 2e-3 };
            let scaled = [there / index_squared(a), back / index_squared(b)];
            // Clear transmission of thin sheets is not the same both ways; see the material's page.
            let is_reciprocal = a.z * b.z > 0.0 || !case.text.contains("principledthin");
            assert!(!is_reciprocal || is_near(scaled[0], scaled[1], tolerance), "{what}: {there} and {back}");
            // A photon from a to b is what a camera path from b sees.
            let photon = value(a, b, TransportMode::Flux);
            assert!(is_near(photon, back, tolerance), "{what}: {photon} for photons, {back} for radiance");
            // Lobes add up.
            let parts = [Lobes::WIDE, Lobes::FOLLOWED]
                .map(|lobes| case.material.evaluate(&view(a, TransportMode::Radiance, lobes), b));
            assert!(is_near(there, parts[0] + parts[1], 1e-4), "{what}: {parts:?} do not add up to {there}");
            for lobes in RESTRICTIONS {
                if let Some(constant) = case.material.constant_value(&view(a, TransportMode::Radiance, lobes)) {
                    assert!(
                        !case.material.lobes().any(Lobes::TRANSMISSIVE),
                        "{what}: a constant that lets light through"
                    );
                    let value = case.material.evaluate(&view(a, TransportMode::Radiance, lobes), b);
                    assert!(a.z * b.z < 0.0 || is_near(value, constant, 1e-5), "{what}: {value} is not {constant}");
                }
            }
        }
    }
}

#[test]
fn furnace_smooth_and_nearly_smooth_materials_lose_little() {
    let mut family = 50_000;
    let check = |family: &mut u32, text: &str, least: f32, most: f32| {
        let material = material(text);
        for outgoing in outgoing_directions().filter(|outgoing| outgoing.z.abs() > 0.5) {
            *family += 1;
            if outgoing.z < 0.0 && !material.lobes().any(Lobes::TRANSMISSIVE) {
                continue;
            }
            let (mean, error) = albedo(&samples(&material, &view(outgoing, TransportMode::Flux, Lobes::ALL), *family));
            assert!(mean.min_element() > least - error, "{text} from {outgoing}: only {mean} of the light leaves");
            assert!(mean.max_element() < most + error, "{text} from {outgoing}: {mean} of the light leaves");
        }
    };
    for shape in ["", GGX] {
        for alpha in [0.001, 0.1] {
            let rough = format!("{shape}{}", number("alpha", alpha));
            check(&mut family, &bsdf("roughconductor", &rough), 1.0 - 0.3 * alpha, 1.0);
            check(&mut family, &bsdf("roughdielectric", &(rough.clone() + &glass(1.5))), 1.0 - 0.4 * alpha, 1.0);
            check(
                &mut family,
                &bsdf("roughplastic", &(rough + &grey("diffuse_reflectance", 1.0))),
                0.96 - 0.8 * alpha,
                1.0,
            );
        }
    }
    // The fit of the coat's mean reflectance is 0.1 % too high there, see the material's page.
    check(&mut family, &bsdf("plastic", &grey("diffuse_reflectance", 1.0)), 1.0, 1.0015);
    check(&mut family, &bsdf("thindielectric", ""), 1.0, 1.0);
    check(&mut family, &bsdf("difftrans", &grey("transmittance", 1.0)), 1.0, 1.0);
    check(&mut family, &bsdf("mask", &bsdf("dielectric", "")), 1.0, 1.0);
}

#[test]
fn analytic_kinds_of_lobes() {
    let lobes = |text: &str| material(text).lobes();
    let rough = |alpha: f32| bsdf("roughconductor", &number("alpha", alpha));
    assert_eq!(lobes(&rough(0.3)), Lobes::WIDE);
    assert_eq!(lobes(&rough(0.29)), Lobes::NARROW);
    assert_eq!(lobes(&bsdf("roughdielectric", "")), Lobes::NARROW | Lobes::TRANSMISSIVE);
    assert_eq!(lobes(&bsdf("plastic", "")), Lobes::SPECULAR | Lobes::WIDE);
    assert_eq!(lobes(&bsdf("roughplastic", "")), Lobes::SMOOTH);
    assert_eq!(lobes(&bsdf("principled", &number("roughness", 0.8))), Lobes::WIDE);
    assert_eq!(lobes(&bsdf("principled", &(number("metallic", 1.0) + &number("roughness", 0.3)))), Lobes::NARROW);
    let mixed = number("weight", 0.5) + &rough(0.1) + &bsdf("dielectric", "");
    assert_eq!(lobes(&bsdf("blendbsdf", &mixed)), Lobes::FOLLOWED | Lobes::TRANSMISSIVE);
    assert!(std::mem::size_of::<Material>() <= 64, "{} bytes for a material", std::mem::size_of::<Material>());
}
