//! χ² tests of every sampling routine against its density, and of lights against their power.
//!
//! All of them together fail by chance with probability 10⁻³ (Šidák's correction); seeds are fixed.

use std::f64::consts::{PI, TAU};

use crate::chi_square::{Histogram, assert_directions, assert_uniform, numbers, turn};
use crate::scene_text::prepare;
use photonfarm::math::discrete::Discrete;
use photonfarm::math::{Frame, Rgb, Vec2, Vec3, warp};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::material::{Material, TransportMode, View};

const SAMPLES: u32 = 100_000;

fn pairs(family: u32) -> impl Iterator<Item = [f32; 2]> {
    (0..SAMPLES).map(move |sample| {
        let u = numbers(family, sample);
        [u[0], u[1]]
    })
}

fn scene(body: &str) -> Scene {
    prepare(&format!("<sensor type='perspective'/>{body}"), &[]).expect("the scene is good")
}

// ---- Numbers and warps. -------------------------------------------------------------------------------------------

#[test]
fn chi_square_numbers_are_uniform_in_pairs() {
    for (first, second) in [(0, 1), (1, 2), (2, 3), (0, 3)] {
        let points = (0..SAMPLES).map(|sample| {
            let u = numbers(1, sample);
            [f64::from(u[first]), f64::from(u[second])]
        });
        assert_uniform(points, &format!("numbers {first} and {second} of a block"));
    }
    let points = (0..SAMPLES).map(|sample| [numbers(2, sample)[0], numbers(2, sample + 1)[0]].map(f64::from));
    assert_uniform(points, "numbers of neighbouring paths");
    let points = (0..SAMPLES).map(|sample| [numbers(sample, 3)[0], numbers(sample + 1, 3)[0]].map(f64::from));
    assert_uniform(points, "numbers of successive passes");
}

#[test]
fn chi_square_warps() {
    let disc = pairs(10).map(warp::disc).map(|point| [f64::from(point.length_squared()), turn(point.x, point.y)]);
    assert_uniform(disc, "disc");
    let triangle = pairs(11).map(warp::triangle).map(|point| {
        let sum = f64::from(point.x + point.y);
        [sum * sum, f64::from(point.y) / sum.max(1e-12)]
    });
    assert_uniform(triangle, "triangle");
    let hemisphere = pairs(12).map(|u| Some(warp::cosine_hemisphere(u)));
    assert_directions(hemisphere, |w| f64::from(warp::cosine_hemisphere_pdf(w.z)), -1.0, "cosine hemisphere");
    assert_directions(pairs(13).map(|u| Some(warp::sphere(u))), |_| f64::from(warp::SPHERE_PDF), -1.0, "sphere");
    for (family, one_minus_cosine) in [(14, 2e-6f32), (15, 0.1), (16, 1.0), (17, 2.0)] {
        // The z coordinate of a narrow cone has no digits left: look at the distance from the axis.
        let cone = pairs(family).map(|u| warp::cone(one_minus_cosine, u)).map(|w| {
            let sine_squared = f64::from(w.x).powi(2) + f64::from(w.y).powi(2);
            let below = match w.z >= 0.0 {
                true => sine_squared / (1.0 + (1.0 - sine_squared).max(0.0).sqrt()),
                false => 1.0 - f64::from(w.z),
            };
            [below / f64::from(one_minus_cosine), turn(w.x, w.y)]
        });
        assert_uniform(cone, &format!("cone of 1 - cos = {one_minus_cosine}"));
        let solid_angle = TAU * f64::from(one_minus_cosine);
        assert!((f64::from(warp::cone_pdf(one_minus_cosine)) * solid_angle - 1.0).abs() < 1e-6);
    }
}

#[test]
fn chi_square_discrete() {
    let weights = [0.0, 3.0, 0.25, 0.0, 1.0, 0.001, 5.0, 0.0];
    let discrete = Discrete::new(&weights).expect("the weights are good");
    let mut histogram = Histogram::new(weights.len());
    let mut rest = Vec::new();
    for u in (0..SAMPLES).map(|sample| numbers(20, sample)) {
        let (index, rescaled) = discrete.pick(u[0]);
        assert!(weights[index] > 0.0, "something impossible was picked with {}", u[0]);
        assert!((0.0..1.0).contains(&rescaled));
        histogram.add(index);
        if index == 6 {
            rest.push([f64::from(rescaled), f64::from(u[1])]);
        }
    }
    let total: f64 = weights.iter().sum();
    let shares = weights.map(|weight| weight / total);
    histogram.assert_shares(&shares, "discrete");
    assert_uniform(rest.into_iter(), "the number that a pick gives back");
    for (index, share) in shares.iter().enumerate() {
        assert!((f64::from(discrete.probability(index)) - share).abs() < 1e-6);
    }
    for u in [0.0, 1.0 - f32::EPSILON / 2.0] {
        assert!(weights[discrete.pick(u).0] > 0.0, "the end {u} picks something impossible");
    }
    for bad in [&[][..], &[0.0, 0.0], &[f64::NAN], &[f64::INFINITY, 1.0]] {
        assert!(Discrete::new(bad).is_none(), "{bad:?}");
    }
}

/// The guide only shortens the search: what is picked is the first thing whose cumulative probability is above the number.
#[test]
fn discrete_picks_as_a_plain_search_does() {
    for count in [1, 2, 3, 5, 64, 513, 1000] {
        let weights: Vec<f64> = (0..count).map(|index| f64::from(numbers(22, index)[0]).powi(6)).collect();
        let discrete = Discrete::new(&weights).expect("the weights are good");
        let cumulative: Vec<f32> = (0..count).map(|index| discrete.share_below(index as f32 + 1.0)).collect();
        let plain = |u: f32| cumulative.iter().position(|sum| *sum > u).expect("the last sum is 1");
        let borders = cumulative.iter().flat_map(|sum| [*sum, sum.next_down(), sum.next_up()]);
        for u in (0..10_000).map(|sample| numbers(23, sample)[1]).chain(borders).filter(|u| (0.0..1.0).contains(u)) {
            assert_eq!(discrete.pick(u).0, plain(u), "{count} things, number {u}");
        }
    }
}

#[test]
fn analytic_frames_are_orthonormal() {
    let random = pairs(21).take(20_000).map(warp::sphere);
    let special = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.0, 0.0, -0.999_999_94)];
    let near_pole = (1..30).map(|power| Vec3::new(0.5f32.powi(power), 0.0, -1.0).normalize());
    for normal in random.chain(special).chain(near_pole) {
        let Frame { tangent, bitangent, normal: z } = Frame::from_normal(normal);
        for (a, b, expected) in [
            (tangent, tangent, 1.0),
            (bitangent, bitangent, 1.0),
            (tangent, bitangent, 0.0),
            (tangent, z, 0.0),
            (bitangent, z, 0.0),
        ] {
            assert!((a.dot(b) - expected).abs() < 2e-6, "frame around {normal}: {} is not {expected}", a.dot(b));
        }
        assert!(tangent.cross(bitangent).distance(z) < 2e-6, "frame around {normal} is left-handed");
        let frame = Frame::from_normal(normal);
        let back = frame.to_local(frame.to_world(Vec3::new(0.2, -0.5, 0.7)));
        assert!(back.distance(Vec3::new(0.2, -0.5, 0.7)) < 2e-6);
    }
}

// ---- Materials. ---------------------------------------------------------------------------------------------------

fn material(text: &str) -> Material {
    let ahead = "<transform name='to_world'><translate z='5'/></transform>";
    scene(&format!("<shape type='cube'>{ahead}{text}</shape><emitter type='point'/>")).materials[0].clone()
}

fn view(outgoing: Vec3, mode: TransportMode) -> View {
    View::new(Vec2::ZERO, outgoing, mode)
}

#[test]
fn chi_square_materials() {
    let diffuse = |rgb: &str| format!("<bsdf type='diffuse'><rgb name='reflectance' value='{rgb}'/></bsdf>");
    let (front, back) = (diffuse("0.8, 0.4, 0.2"), diffuse("0.1, 0.3, 0.9"));
    let two_sided = format!("<bsdf type='twosided'>{front}{back}</bsdf>");
    let mut family = 30;
    for (name, text, sides) in [
        ("diffuse", front.as_str(), &[1.0f32][..]),
        ("twosided", two_sided.as_str(), &[1.0, -1.0]),
        ("default", "", &[1.0, -1.0]),
    ] {
        let material = material(text);
        for side in sides {
            for tilt in [0.05f32, 0.7, 1.0] {
                family += 1;
                let outgoing = Vec3::new((1.0 - tilt * tilt).sqrt(), 0.0, side * tilt);
                let what = format!("{name} seen from {outgoing}");
                let sample =
                    |u: [f32; 4]| material.sample(&view(outgoing, TransportMode::Radiance), [u[0], u[1], u[2]]);
                let samples: Vec<_> = (0..SAMPLES).map(|index| sample(numbers(family, index))).collect();
                for sample in samples.iter().flatten() {
                    let value = material.evaluate(&view(outgoing, TransportMode::Radiance), sample.direction);
                    let expected = value * sample.direction.z.abs() / sample.pdf;
                    assert!(sample.weight.distance(expected) < 1e-5, "{what}: weight {}", sample.weight);
                    assert!(
                        (sample.pdf / material.pdf(&view(outgoing, TransportMode::Radiance), sample.direction) - 1.0)
                            .abs()
                            < 1e-5,
                        "{what}"
                    );
                }
                let pdf = |w: Vec3| f64::from(material.pdf(&view(outgoing, TransportMode::Radiance), w));
                assert_directions(samples.iter().map(|s| s.map(|s| s.direction)), pdf, -1.0, &what);
            }
        }
    }
}

#[test]
fn analytic_one_sided_materials_are_black_from_behind() {
    let behind = Vec3::new(0.6, 0.0, -0.8);
    for text in ["<bsdf type='diffuse'/>", "<bsdf type='conductor'/>"] {
        let material = material(text);
        assert!(material.sample(&view(behind, TransportMode::Radiance), [0.5; 3]).is_none(), "{text}");
        assert_eq!(material.evaluate(&view(behind, TransportMode::Radiance), behind), Rgb::ZERO);
        assert_eq!(material.evaluate(&view(-behind, TransportMode::Radiance), behind), Rgb::ZERO);
    }
}

fn glass(interior: f64) -> Material {
    material(&format!(
        "<bsdf type='dielectric'><float name='int_ior' value='{interior}'/><float name='ext_ior' value='1'/></bsdf>"
    ))
}

/// Fresnel's equations in double precision, by the angle form. `index` is that behind over that before.
fn fresnel(cosine: f64, index: f64) -> f64 {
    let incident = cosine.acos();
    let sine = incident.sin() / index;
    if sine >= 1.0 {
        return 1.0;
    }
    let refracted = sine.asin();
    if incident < 1e-6 {
        return ((index - 1.0) / (index + 1.0)).powi(2);
    }
    let perpendicular = (incident - refracted).sin() / (incident + refracted).sin();
    let parallel = (incident - refracted).tan() / (incident + refracted).tan();
    0.5 * (perpendicular.powi(2) + parallel.powi(2))
}

#[test]
fn analytic_dielectric_lobes() {
    for interior in [1.01, 1.33, 1.5, 2.4, 0.7] {
        let material = glass(interior);
        for step in 1..=200 {
            for side in [1.0f32, -1.0] {
                let cosine = step as f32 / 200.0;
                let outgoing = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, side * cosine);
                let index = if side > 0.0 { interior } else { 1.0 / interior };
                let expected = fresnel(f64::from(cosine), index);
                let [reflected, refracted, ..] = material.specular_lobes(&view(outgoing, TransportMode::Flux));
                let shares = [reflected, refracted].map(|lobe| lobe.map_or(0.0, |lobe| f64::from(lobe.weight.x)));
                let what = format!("index {index} at cosine {cosine}");
                assert!((shares[0] - expected).abs() < 3e-5, "{what}: {} of {expected} is reflected", shares[0]);
                assert!((shares[0] + shares[1] - 1.0).abs() < 1e-6, "{what}: {shares:?} is not all");

                let radiance = material.specular_lobes(&view(outgoing, TransportMode::Radiance));
                let [_, Some(refracted), ..] = radiance else { continue };
                // Snell's law, the other side, and radiance that scales with the squared index.
                let sine = f64::from(outgoing.x) / index;
                assert!((f64::from(-refracted.direction.x) - sine).abs() < 1e-6, "{what}: {}", refracted.direction);
                assert!(refracted.direction.z * side <= 0.0, "{what}: refraction stays on its side");
                assert!((refracted.direction.length() - 1.0).abs() < 1e-5, "{what}");
                let scaled = f64::from(refracted.weight.x) * index * index;
                assert!((scaled - shares[1]).abs() < 1e-5, "{what}: radiance {scaled}, flux {}", shares[1]);
                assert!((f64::from(refracted.relative_index) - index).abs() < 1e-6 * index, "{what}");
                // The way back has the same share.
                let back = material.specular_lobes(&view(refracted.direction, TransportMode::Flux))[1]
                    .expect("light comes back");
                assert!((f64::from(back.weight.x) - shares[1]).abs() < 1e-3, "{what}: {} comes back", back.weight.x);
            }
        }
    }
}

#[test]
fn analytic_total_reflection_starts_at_the_critical_angle() {
    for interior in [1.1, 1.33, 1.5, 2.4f64] {
        let material = glass(interior);
        let critical = (1.0 / interior).asin();
        for (angle, passes) in [(critical - 1e-3, true), (critical + 1e-3, false)] {
            let outgoing = Vec3::new(angle.sin() as f32, 0.0, -angle.cos() as f32);
            let lobes = material.specular_lobes(&view(outgoing, TransportMode::Flux));
            assert_eq!(lobes[1].is_some(), passes, "index {interior} at {angle} rad");
            let frequency = (0..1000).filter(|index| {
                let u = numbers(40, *index);
                material.sample(&view(outgoing, TransportMode::Flux), [u[0], u[1], u[2]]).unwrap().relative_index != 1.0
            });
            assert_eq!(frequency.count() > 0, passes);
        }
    }
}

#[test]
fn chi_square_dielectric_choice() {
    for (family, outgoing) in
        [(41, Vec3::new(0.0, 0.6, 0.8)), (42, Vec3::new(0.99, 0.0, 0.141_067)), (43, Vec3::new(0.5, 0.0, -0.866_025))]
    {
        let material = glass(1.5);
        let index = if outgoing.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let share = fresnel(f64::from(outgoing.z.abs()), index);
        let mut histogram = Histogram::new(2);
        for u in (0..SAMPLES).map(|sample| numbers(family, sample)) {
            let sample =
                material.sample(&view(outgoing, TransportMode::Flux), [u[0], u[1], u[2]]).expect("glass never absorbs");
            assert!(sample.is_specular());
            assert!((sample.weight.x - 1.0).abs() < 1e-6, "the choice is not by the share: {}", sample.weight);
            histogram.add(usize::from(sample.direction.z * outgoing.z < 0.0));
        }
        histogram.assert_shares(&[share, 1.0 - share], &format!("glass seen from {outgoing}"));
    }
}

#[test]
fn analytic_conductor_at_normal_and_grazing_incidence() {
    let text =
        "<bsdf type='conductor'><rgb name='eta' value='0.2, 0.9, 1.5'/><rgb name='k' value='3.9, 2.4, 1.9'/></bsdf>";
    let material = material(text);
    let reflected = |cosine: f32| {
        let outgoing = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        material.sample(&view(outgoing, TransportMode::Radiance), [0.5; 3]).expect("metal reflects").weight
    };
    for (channel, (eta, k)) in [(0.2f32, 3.9f32), (0.9, 2.4), (1.5, 1.9)].into_iter().enumerate() {
        let normal = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        assert!((reflected(1.0)[channel] - normal).abs() < 1e-5);
        assert!(reflected(1e-4)[channel] > 0.998);
    }
}

// ---- Light towards a point. ---------------------------------------------------------------------------------------

const AREA: &str = "<emitter type='area'><rgb name='radiance' value='3, 2, 1'/></emitter>";

/// Tests a scene's only light from `point` in the cone round the direction to `target` whose cosine is `least_cosine`.
fn check_direct(family: u32, body: &str, point: Vec3, target: Vec3, least_cosine: f64) {
    let scene = scene(body);
    let frame = Frame::from_normal((target - point).normalize());
    let what = format!("{body} from {point}");
    let samples = (0..SAMPLES).map(|sample| {
        let u = numbers(family, sample);
        let found = scene.lights.sample_direct(&scene.geometry, &point.into(), [u[2], u[0], u[1]])?;
        let value = found.weighted_radiance * found.pdf_solid_angle;
        assert!(value.distance(Rgb::new(3.0, 2.0, 1.0)) < 1e-4, "{what}: radiance {value}");
        Some(frame.to_local(found.direction))
    });
    // Where the light is hidden by another part of itself, sampling still goes through it: the density of the part that
    // is seen is not all. Test convex lights only.
    let pdf = |local: Vec3| {
        let ray = Ray::new(point, frame.to_world(local).normalize());
        let Some(hit) = scene.geometry.intersect(&ray) else { return 0.0 };
        scene.lights.emitted(&scene.geometry, &point.into(), &hit, true).map_or(0.0, |(_, pdf)| f64::from(pdf))
    };
    assert_directions(samples, pdf, least_cosine, &what);
}

#[test]
fn chi_square_direct_light_of_flat_shapes() {
    let oblique = "<transform name='to_world'><scale x='1.5' y='0.5'/><rotate x='1' y='2' angle='40'/></transform>";
    let rectangle = format!("<shape type='rectangle'>{oblique}{AREA}</shape>");
    check_direct(50, &rectangle, Vec3::new(0.5, 0.2, 2.0), Vec3::ZERO, 0.5);
    let sheared = "<transform name='to_world'><matrix value='1 0.7 0 0  0 1 0 0  0 0 1 0  0 0 0 1'/></transform>";
    let rectangle = format!("<shape type='rectangle'>{sheared}{AREA}</shape>");
    check_direct(51, &rectangle, Vec3::new(0.0, 0.0, 1.5), Vec3::ZERO, 0.2);
    let even = "<transform name='to_world'><scale value='1.5'/><rotate x='1' y='2' angle='40'/></transform>";
    let disk = format!("<shape type='disk'>{even}{AREA}</shape>");
    check_direct(52, &disk, Vec3::new(0.5, 0.2, 2.0), Vec3::ZERO, 0.5);
}

#[test]
fn chi_square_direct_light_of_spheres() {
    let sphere = format!("<shape type='sphere'><point name='center' value='1, 2, 3'/>{AREA}</shape>");
    check_direct(53, &sphere, Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 2.0, 3.0), 0.9);
    // Close to the surface, and so far away that the cone is narrow.
    check_direct(54, &sphere, Vec3::new(1.0, 2.0, 4.02), Vec3::new(1.0, 2.0, 3.0), 0.1);
    check_direct(55, &sphere, Vec3::new(1.0, 2.0, 53.0), Vec3::new(1.0, 2.0, 3.0), 0.9997);
    // From inside, by area.
    let shell = format!("<shape type='sphere'><boolean name='flip_normals' value='true'/>{AREA}</shape>");
    check_direct(56, &shell, Vec3::new(0.3, -0.2, 0.4), Vec3::new(0.3, -0.2, 3.0), -1.0);
}

#[test]
fn chi_square_direct_light_of_a_cube() {
    let turned = "<transform name='to_world'><scale x='0.5' y='0.4' z='0.8'/><rotate y='1' angle='30'/></transform>";
    let cube = format!("<shape type='cube'>{turned}{AREA}</shape>");
    check_direct(58, &cube, Vec3::new(1.0, 1.5, 2.5), Vec3::ZERO, 0.8);
}

/// The density of a cylinder's light is infinite at its outline: look at the points that samples meet instead.
#[test]
fn chi_square_direct_light_of_a_cylinder() {
    let scene = scene(&format!("<shape type='cylinder'><float name='radius' value='0.4'/>{AREA}</shape>"));
    // Level with the middle; the visible part lies within `outline` to either side.
    let point = Vec3::new(2.0, 0.5, 0.5);
    let outline = f64::from(0.4 / point.truncate().length()).acos();
    let mut seen = Histogram::new(2);
    let mut points = Vec::new();
    for u in (0..SAMPLES).map(|sample| numbers(57, sample)) {
        let sample = scene.lights.sample_direct(&scene.geometry, &point.into(), [u[2], u[0], u[1]]);
        seen.add(usize::from(sample.is_some()));
        let Some(sample) = sample else { continue };
        let target = point + sample.direction * sample.distance;
        let angle = (turn(target.x, target.y) - turn(point.x, point.y) + 0.5).rem_euclid(1.0) - 0.5;
        points.push([f64::from(target.z).clamp(0.0, 1.0), 0.5 + 0.5 * angle * TAU / outline]);
        // Near the outline the cosine has few digits.
        let Some(hit) = scene.geometry.intersect(&Ray::new(point, sample.direction)) else { continue };
        if hit.geometric_normal.dot(hit.outgoing) > 0.1 {
            let (_, pdf) = scene.lights.emitted(&scene.geometry, &point.into(), &hit, true).expect("it was sampled");
            assert!((pdf / sample.pdf_solid_angle - 1.0).abs() < 1e-3, "{pdf} is not {}", sample.pdf_solid_angle);
            let area = 0.8 * PI;
            let cosine = f64::from(hit.geometric_normal.dot(hit.outgoing));
            let expected = f64::from(hit.distance).powi(2) / (cosine * area);
            assert!((f64::from(pdf) / expected - 1.0).abs() < 1e-4, "{pdf} is not {expected}");
        }
    }
    seen.assert_shares(&[1.0 - outline / PI, outline / PI], "cylinder: the side that is seen");
    assert_uniform(points.into_iter(), "cylinder: points");
}

#[test]
fn chi_square_direct_light_of_an_environment() {
    let body = "<shape type='cube'/><emitter type='constant'><rgb name='radiance' value='3, 2, 1'/></emitter>";
    let scene = scene(body);
    let (radiance, pdf) = scene.lights.environment(&Vec3::ONE.into(), Vec3::Y).expect("there is an environment");
    assert_eq!(radiance, Rgb::new(3.0, 2.0, 1.0));
    let samples = (0..SAMPLES).map(|sample| {
        let u = numbers(59, sample);
        Some(scene.lights.sample_direct(&scene.geometry, &Vec3::ONE.into(), [u[2], u[0], u[1]])?.direction)
    });
    assert_directions(samples, |_| f64::from(pdf), -1.0, "constant");
}

#[test]
fn chi_square_lights_are_picked_by_power_and_by_place() {
    // Powers 4π·I: 3 to 1 in luminance. Squared distances to the place: 25 and 106 m².
    let body = "<shape type='cube'/><emitter type='point'><rgb name='intensity' value='3, 3, 3'/></emitter>\
        <emitter type='point'><point name='position' value='9, 0, 0'/></emitter>";
    let scene = scene(body);
    let (mut picked, mut from) = (Histogram::new(2), Histogram::new(2));
    for u in (0..SAMPLES).map(|sample| numbers(60, sample)) {
        let direct =
            scene.lights.sample_direct(&scene.geometry, &Vec3::new(0.0, 5.0, 0.0).into(), [u[0], u[1], u[2]]).unwrap();
        picked.add(usize::from(direct.direction.x > 0.1));
        let photon = scene.lights.emit(&scene.geometry, [u[0], u[1], u[2]], [u[2], u[3]]).unwrap();
        from.add(usize::from(photon.origin.x > 0.1));
        assert!((photon.flux.x / (16.0 * PI) as f32 - 1.0).abs() < 1e-5, "photons carry {}", photon.flux.x);
    }
    let [near, far] = [3.0 / 25.0, 1.0 / 106.0];
    picked.assert_shares(&[near / (near + far), far / (near + far)], "direct light's choice");
    from.assert_shares(&[0.75, 0.25], "emission's choice");
}

// ---- Photons. -----------------------------------------------------------------------------------------------------

struct Emission {
    origin: Vec3,
    direction: Vec3,
    flux: Rgb,
}

/// Photons of a scene's only light, after a test of their mean flux against its power and against `power`.
fn emissions(family: u32, scene: &Scene, power: f64) -> Vec<Emission> {
    let [light] = scene.lights.lights() else { panic!("one light is expected") };
    let emit = |sample: u32| {
        let u = numbers(family, sample);
        let photon = light.emit(&scene.geometry, [u[0], u[1]], [u[2], u[3]]).expect("lights emit");
        assert!((photon.direction.length() - 1.0).abs() < 1e-5);
        Emission { origin: photon.origin, direction: photon.direction, flux: photon.flux }
    };
    let photons: Vec<Emission> = (0..SAMPLES).map(emit).collect();
    let flux = photons.iter().map(|photon| f64::from(photon.flux.x));
    let (sum, squares) = flux.fold((0.0, 0.0), |(sum, squares), flux| (sum + flux, squares + flux * flux));
    let count = f64::from(SAMPLES);
    let mean = sum / count;
    let error = ((squares / count - mean * mean).max(0.0) / count).sqrt();
    assert!((mean - power).abs() < 4.0 * error + 1e-5 * power, "photons carry {mean} ± {error} W of {power} W");
    let own = f64::from(light.power().x);
    assert!((own / power - 1.0).abs() < 1e-5, "the light says that it has {own} W of {power} W");
    photons
}

/// Tests that directions follow the cosine law around `normal`.
fn assert_cosine_law<'a>(photons: impl Iterator<Item = (&'a Emission, Vec3)>, what: &str) {
    let points = photons.map(|(photon, normal)| {
        let local = Frame::from_normal(normal).to_local(photon.direction);
        assert!(local.z >= -1e-6, "{what}: a photon leaves backwards");
        [f64::from(local.z).powi(2), turn(local.x, local.y)]
    });
    assert_uniform(points, &format!("{what}: directions"));
}

#[test]
fn chi_square_photons_of_flat_lights() {
    let place = "<transform name='to_world'><scale x='2' y='0.5'/><rotate x='1' angle='90'/><translate value='1, 2, 3'/></transform>";
    let lit = scene(&format!("<shape type='rectangle'>{place}{AREA}</shape>"));
    let photons = emissions(70, &lit, PI * 4.0 * 3.0);
    let (center, normal) = (Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Y);
    let points = photons.iter().map(|photon| {
        let local = photon.origin - center;
        assert!(local.y.abs() < 1e-4);
        [0.5 + f64::from(local.x) / 4.0, 0.5 + f64::from(local.z)]
    });
    assert_uniform(points, "rectangle: positions");
    assert_cosine_law(photons.iter().map(|photon| (photon, normal)), "rectangle");

    let place = "<transform name='to_world'><scale value='2'/><rotate x='1' angle='90'/><translate value='1, 2, 3'/></transform>";
    let lit = scene(&format!("<shape type='disk'>{place}{AREA}</shape>"));
    let photons = emissions(71, &lit, PI * PI * 4.0 * 3.0);
    let points = photons.iter().map(|photon| {
        let local = (photon.origin - center) * 0.5;
        [f64::from(local.length_squared()), turn(local.x, local.z)]
    });
    assert_uniform(points, "disk: positions");
    assert_cosine_law(photons.iter().map(|photon| (photon, normal)), "disk");
}

/// Both sides emit: seen from behind, from inside of a sphere, and as photons, half of which leave from each side.
#[test]
fn chi_square_two_sided_lights() {
    let both = AREA.replace("'area'>", "'area'><boolean name='two_sided' value='true'/>");
    let oblique = "<transform name='to_world'><scale x='1.5' y='0.5'/><rotate x='1' y='2' angle='40'/></transform>";
    let rectangle = format!("<shape type='rectangle'>{oblique}{both}</shape>");
    for point in [Vec3::new(0.5, 0.2, 2.0), Vec3::new(0.5, 0.2, -2.0)] {
        check_direct(150, &rectangle, point, Vec3::ZERO, 0.5);
    }
    let sphere = format!("<shape type='sphere'>{both}</shape>");
    check_direct(151, &sphere, Vec3::new(0.3, -0.2, 0.4), Vec3::new(0.3, -0.2, 3.0), -1.0);
    check_direct(152, &sphere, Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.9);

    let lit = scene(&format!("<shape type='rectangle'>{both}</shape>"));
    let photons = emissions(153, &lit, 2.0 * PI * 4.0 * 3.0);
    assert_cosine_law(photons.iter().map(|photon| (photon, Vec3::Z * photon.origin.z.signum())), "both sides");
    let mut sides = Histogram::new(2);
    photons.iter().for_each(|photon| sides.add(usize::from(photon.direction.z > 0.0)));
    sides.assert_shares(&[0.5, 0.5], "sides");
}

#[test]
fn chi_square_photons_of_round_lights() {
    let lit = scene(&format!("<shape type='sphere'><float name='radius' value='0.5'/>{AREA}</shape>"));
    let photons = emissions(72, &lit, PI * PI * 3.0);
    let points = photons.iter().map(|p| [0.5 + f64::from(p.origin.z), turn(p.origin.x, p.origin.y)]);
    assert_uniform(points, "sphere: positions");
    assert_cosine_law(photons.iter().map(|p| (p, p.origin.normalize())), "sphere");

    let lit = scene(&format!("<shape type='cylinder'><float name='radius' value='0.5'/>{AREA}</shape>"));
    let photons = emissions(73, &lit, PI * PI * 3.0);
    let points = photons.iter().map(|p| [f64::from(p.origin.z), turn(p.origin.x, p.origin.y)]);
    assert_uniform(points, "cylinder: positions");
    let outward = |p: &Emission| Vec3::new(p.origin.x, p.origin.y, 0.0).normalize();
    assert_cosine_law(photons.iter().map(|p| (p, outward(p))), "cylinder");
}

#[test]
fn chi_square_photons_of_a_mesh() {
    let place = "<transform name='to_world'><scale x='1' y='2' z='3'/></transform>";
    let lit = scene(&format!("<shape type='cube'>{place}{AREA}</shape>"));
    let half = Vec3::new(1.0, 2.0, 3.0);
    let photons = emissions(74, &lit, PI * 88.0 * 3.0);
    // Each face in 8 × 8 parts.
    let (mut histogram, mut shares) = (Histogram::new(6 * 64), Vec::new());
    for axis in 0..3 {
        let area = 4.0 * f64::from(half[(axis + 1) % 3] * half[(axis + 2) % 3]);
        shares.extend([area / 88.0 / 64.0; 128]);
    }
    let face = |p: &Emission| {
        let scaled = p.origin / half;
        let axis = (0..3).max_by(|a, b| scaled[*a].abs().total_cmp(&scaled[*b].abs())).expect("three axes");
        (axis, scaled)
    };
    for photon in &photons {
        let (axis, scaled) = face(photon);
        let part = |other: usize| ((scaled[(axis + other) % 3] + 1.0) * 4.0).clamp(0.0, 7.0) as usize;
        histogram.add(axis * 128 + usize::from(scaled[axis] > 0.0) * 64 + part(1) * 8 + part(2));
    }
    histogram.assert_shares(&shares, "cube: positions");
    let normal = |p: &Emission| {
        let (axis, scaled) = face(p);
        Vec3::AXES[axis] * scaled[axis].signum()
    };
    assert_cosine_law(photons.iter().map(|p| (p, normal(p))), "cube");
}

#[test]
fn chi_square_photons_of_points_and_spots() {
    let cube = "<shape type='cube'/>";
    let lit = scene(&format!("{cube}<emitter type='point'><point name='position' value='1, 2, 3'/></emitter>"));
    let photons = emissions(75, &lit, 4.0 * PI);
    assert!(photons.iter().all(|p| p.origin == Vec3::new(1.0, 2.0, 3.0)));
    let sphere = photons.iter().map(|p| Some(p.direction));
    assert_directions(sphere, |_| f64::from(warp::SPHERE_PDF), -1.0, "point");

    for (family, cutoff, beam) in [(76, 30.0f64, 20.0f64), (77, 30.0, 30.0), (78, 80.0, 0.0), (79, 150.0, 100.0)] {
        let aim = "<transform name='to_world'><lookat origin='1, 2, 3' target='0, 0, 0' up='0, 1, 0'/></transform>";
        let spot = format!(
            "{cube}<emitter type='spot'>{aim}<float name='cutoff_angle' value='{cutoff}'/><float name='beam_width' value='{beam}'/></emitter>"
        );
        let (cutoff, beam) = (cutoff.to_radians(), beam.to_radians());
        // ∫ falloff dω by the midpoint rule.
        let falloff = |angle: f64| if angle <= beam { 1.0 } else { (cutoff - angle) / (cutoff - beam) };
        let steps = 100_000;
        let width = cutoff / f64::from(steps);
        let angles = (0..steps).map(|step| (f64::from(step) + 0.5) * width);
        let power: f64 = angles.map(|angle| TAU * falloff(angle) * angle.sin() * width).sum();
        let photons = emissions(family, &scene(&spot), power);
        let frame = Frame::from_normal(-Vec3::new(1.0, 2.0, 3.0).normalize());
        let points = photons.iter().map(|p| {
            let local = frame.to_local(p.direction);
            [(1.0 - f64::from(local.z)) / (1.0 - cutoff.cos()), turn(local.x, local.y)]
        });
        assert_uniform(points, &format!("{spot}: directions"));
        let density = 1.0 / (TAU * (1.0 - cutoff.cos()));
        for photon in &photons {
            let angle = f64::from(frame.to_local(photon.direction).z).clamp(-1.0, 1.0).acos();
            let expected = falloff(angle.min(cutoff)) / density;
            assert!((f64::from(photon.flux.x) - expected).abs() < 2e-3 / density, "{spot} at {angle} rad");
        }
    }
}

// ---- Cameras. -----------------------------------------------------------------------------------------------------

#[test]
fn chi_square_lens() {
    let look = "<transform name='to_world'><lookat origin='1, 2, 3' target='4, 0, 1' up='0, 1, 0'/></transform>";
    let sensor = format!(
        "<sensor type='thinlens'>{look}<float name='aperture_radius' value='0.3'/><float name='focus_distance' value='5'/>\
        <float name='fov' value='40'/><film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film></sensor>"
    );
    let scene =
        prepare(&format!("{sensor}<shape type='cube'/><emitter type='point'/>"), &[]).expect("the scene is good");
    let forward = Vec3::new(3.0, -2.0, -2.0).normalize();
    let frame = Frame::from_normal(forward);
    let position = scene.camera.position();
    for (family, picture) in [(90, Vec2::new(0.5, 0.5)), (91, Vec2::new(0.1, 0.9))] {
        let middle = scene.camera.ray(picture, [0.0, 0.0]);
        let sharp = middle.at((5.0 - (middle.origin - position).dot(forward)) / middle.direction.dot(forward));
        let points = pairs(family).map(|u| {
            let ray = scene.camera.ray(picture, u);
            let depth = |point: Vec3| (point - position).dot(forward);
            let at_depth = |wanted: f32| ray.at((wanted - depth(ray.origin)) / ray.direction.dot(forward));
            assert!(at_depth(5.0).distance(sharp) < 1e-4, "the ray misses the point in focus");
            assert!((depth(ray.origin) - 0.01).abs() < 1e-5, "the near clip is a depth");
            let lens = frame.to_local(at_depth(0.0) - position) / 0.3;
            [f64::from(lens.truncate().length_squared()).min(0.999_999), turn(lens.x, lens.y)]
        });
        assert_uniform(points, "lens");
    }
}
