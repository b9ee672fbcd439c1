//! The weights of techniques that find the same path: against densities that are multiplied out, and as identities between
//! methods.

use std::f32::consts::PI;
use std::sync::Arc;

use crate::progressive::{Job, reference_scene};
use photonfarm::math::Vec3;
use photonfarm::math::random::{PassRandom, PathRandom, Stream, dimension};
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Interaction;
use photonfarm::scene::light::SeenPoint;
use photonfarm::scene::material::{TransportMode, View};
use photonfarm::transport::bidirectional::{
    CameraWalk, Heuristic, LightWalk, Measure, Selection, Techniques, Vertex, Weighting,
};
use photonfarm::transport::{Counters, Limits};
use serde_json::json;

const LIGHT_PATHS: f32 = 5000.0;
const RADIUS_SQUARED: f32 = 4e-4;

/// A path from the light (first) to the camera, with the camera itself left out.
struct WholePath<'a> {
    scene: &'a Scene,
    hits: Vec<Interaction>,
    camera: Vec3,
}

impl WholePath<'_> {
    fn direction(&self, from: usize, to: usize) -> Vec3 {
        let end = |index: usize| self.hits.get(index).map_or(self.camera, |hit| hit.position);
        (end(to) - end(from)).normalize()
    }

    fn distance_squared(&self, from: usize, to: usize) -> f64 {
        let end = |index: usize| self.hits.get(index).map_or(self.camera, |hit| hit.position);
        f64::from((end(to) - end(from)).length_squared())
    }

    /// From a density by solid angle at `from` to one by area at `to`.
    fn by_area(&self, pdf: f32, from: usize, to: usize) -> f64 {
        let cosine = self.direction(from, to).dot(self.hits[to].geometric_normal).abs();
        f64::from(pdf) * f64::from(cosine) / self.distance_squared(from, to)
    }

    /// The density by area of going from `before` over `at` to `after`.
    fn scattered(&self, before: usize, at: usize, after: usize, mode: TransportMode) -> f64 {
        let hit = &self.hits[at];
        let local = |to| hit.frame.to_local(self.direction(at, to));
        let view = View::new(hit.uv, local(before), mode);
        self.by_area(self.scene.material(hit.shape).pdf(&view, local(after)), at, after)
    }

    /// The density of light vertices 0 to `last`, by area.
    fn light_density(&self, last: usize) -> f64 {
        let cosine = self.direction(0, 1).dot(self.hits[0].geometric_normal);
        let seen = SeenPoint { primitive: self.hits[0].primitive, position: self.hits[0].position, cosine };
        let emitted = self.scene.lights.lights()[0].emission_pdf(&self.scene.geometry, &seen);
        let first = self.by_area(emitted, 0, 1);
        (2..=last).map(|to| self.scattered(to - 2, to - 1, to, TransportMode::Flux)).product::<f64>() * first
    }

    /// The density of camera vertices from the one next to the camera to `last`, by area and per pixel.
    fn camera_density(&self, last: usize) -> f64 {
        let count = self.hits.len();
        let pixels = self.scene.film.whole_pixel_count();
        let pdf = self.scene.camera.pdf(self.direction(count, count - 1)) * pixels;
        let first = self.by_area(pdf, count, count - 1);
        (last..count - 1).map(|to| self.scattered(to + 2, to + 1, to, TransportMode::Radiance)).product::<f64>() * first
    }

    /// Densities of all techniques: (light vertices, camera vertices but for the camera, merged), density.
    fn densities(&self, techniques: Techniques) -> Vec<((usize, usize, bool), f64)> {
        let count = self.hits.len();
        let mut all = Vec::new();
        let mut add = |technique, key, density: f64| {
            if techniques.any(technique) {
                all.push((key, density));
            }
        };
        add(Techniques::HIT, (0, count, false), self.camera_density(0));
        let toward = self.direction(1, 0);
        let cosine = -toward.dot(self.hits[0].geometric_normal);
        let seen = SeenPoint { primitive: self.hits[0].primitive, position: self.hits[0].position, cosine };
        let direct = self.scene.lights.lights()[0].direct_pdf(&self.scene.geometry, self.hits[1].position, &seen);
        add(Techniques::DIRECT, (1, count - 1, false), self.by_area(direct, 1, 0) * self.camera_density(1));
        for light in 2..count {
            let density = self.light_density(light - 1) * self.camera_density(light);
            add(Techniques::CONNECT, (light, count - light, false), density);
        }
        add(Techniques::CAMERA, (count, 0, false), self.light_density(count - 1) * f64::from(LIGHT_PATHS));
        for at in 1..count {
            let near = f64::from(PI * RADIUS_SQUARED * LIGHT_PATHS);
            add(Techniques::MERGE, (at, count - at, true), self.light_density(at) * self.camera_density(at) * near);
        }
        all
    }

    fn weight(&self, weighting: &Weighting, key: (usize, usize, bool)) -> f64 {
        let power = |density: f64| if weighting.heuristic == Heuristic::Power { density * density } else { density };
        let all = self.densities(weighting.techniques);
        let own = all.iter().find(|(found, _)| *found == key).expect("the technique takes part").1;
        power(own) / all.iter().map(|(_, density)| power(*density)).sum::<f64>()
    }
}

/// Subpaths of one index, and the light's own point.
fn subpaths(scene: &Scene, weighting: Weighting, index: u32) -> (Vec<Vertex>, Vec<Vertex>) {
    let limits = Limits { max_depth: Some(6), rr_depth: 100 };
    let random = PassRandom::independent(3, Stream::Photon, 0);
    let light_walk = LightWalk { scene, limits, weighting, random: &random };
    let selection = Selection::default();
    let random = PassRandom::of_pixels(3, Stream::Camera, 0);
    let camera_walk = CameraWalk { scene, limits, weighting, selection, random: &random };
    let (mut light, mut camera, mut counters) = (Vec::new(), Vec::new(), Counters::default());
    light_walk.trace(index, &mut counters, |vertex, _, _| light.push(*vertex));
    camera_walk.trace(index, weighting.acceptance(RADIUS_SQUARED, LIGHT_PATHS), &mut counters, |vertex, _, _| {
        camera.push(*vertex);
        Vec3::ZERO
    });
    (light, camera)
}

fn light_point(scene: &Scene, first: &Vertex) -> Option<Interaction> {
    scene.intersect(&first.hit.ray_to(first.hit.outgoing)).filter(|hit| hit.shape.light == 0)
}

/// The path that a joint of `light` and `camera` vertices makes; a merge keeps the camera's vertex.
fn joined<'a>(scene: &'a Scene, light: &[Vertex], camera: &[Vertex]) -> Option<WholePath<'a>> {
    let origin = light_point(scene, light.first()?)?;
    let hits = light.iter().map(|vertex| vertex.hit).chain(camera.iter().rev().map(|vertex| vertex.hit));
    Some(WholePath { scene, hits: std::iter::once(origin).chain(hits).collect(), camera: scene.camera.position() })
}

fn assert_near(found: f32, expected: f64, what: &str) -> bool {
    let error = (f64::from(found) - expected).abs();
    assert!(error < 2e-3 * expected.max(0.05), "{what}: weight {found} where densities give {expected}");
    true
}

/// Compares the weights of all joints of many subpath pairs; returns how many there were of each kind.
fn check_weights(scene: &Arc<Scene>, weighting: Weighting) -> [u32; 3] {
    let acceptance = weighting.acceptance(RADIUS_SQUARED, LIGHT_PATHS);
    let mut checked = [0; 3];
    for index in 0..400 {
        let (light, camera) = subpaths(scene, weighting, index);
        for i in 1..=camera.len().min(3) {
            let at = &camera[i - 1];
            // Light sampling.
            let u = PathRandom::new(3, Stream::Camera, 0, index).block(dimension::light(i as u32));
            let sample = scene.lights.sample_direct(&scene.geometry, &at.hit.position.into(), [u[0], u[1], u[2]]);
            if let Some(sample) = sample
                && let Some(reflected) = at.reflect(scene, TransportMode::Radiance, sample.direction)
                && let Some(point) =
                    scene.intersect(&at.hit.ray_to(sample.direction)).filter(|hit| hit.shape.light == 0)
            {
                let hits = std::iter::once(point).chain(camera[..i].iter().rev().map(|vertex| vertex.hit)).collect();
                let path = WholePath { scene, hits, camera: scene.camera.position() };
                let found =
                    weighting.direct(&at.sums, at.pdf(scene, &reflected), reflected.cosine, &sample, acceptance);
                assert_near(found, path.weight(&weighting, (1, i, false)), "light sampling");
                checked[0] += 1;
            }
            for j in 1..=light.len().min(3) {
                let to = &light[j - 1];
                let between = to.hit.position - at.hit.position;
                let direction = between.normalize();
                let Some(path) = joined(scene, &light[..j], &camera[..i]) else { continue };
                if weighting.techniques.any(Techniques::CONNECT)
                    && let Some(here) = at.reflect(scene, TransportMode::Radiance, direction)
                    && let Some(there) = to.reflect(scene, TransportMode::Flux, -direction)
                {
                    let found = weighting.connection(
                        [&at.sums, &to.sums],
                        [at.pdf(scene, &here), to.pdf(scene, &there)],
                        [here.cosine, there.cosine],
                        between.length_squared(),
                        acceptance,
                    );
                    assert_near(found, path.weight(&weighting, (j + 1, i, false)), "connection");
                    checked[1] += 1;
                }
                // A merge of the light subpath with itself: a camera subpath that ends in the same vertex.
                if weighting.techniques.any(Techniques::MERGE)
                    && j >= 2
                    && let Some(merged) = merge_at(scene, weighting, &light[..j], &camera[..i], acceptance)
                {
                    assert_near(merged.0, merged.1, "merge");
                    checked[2] += 1;
                }
            }
        }
    }
    checked
}

/// Found and expected weight where a camera subpath, prolonged to the last vertex of a light subpath, merges there.
fn merge_at(
    scene: &Scene,
    weighting: Weighting,
    light: &[Vertex],
    camera: &[Vertex],
    acceptance: f32,
) -> Option<(f32, f64)> {
    let (at, to) = (camera.last()?, light.last()?);
    let direction = (to.hit.position - at.hit.position).normalize();
    let here = at.reflect(scene, TransportMode::Radiance, direction)?;
    let mut end = *to;
    end.hit.outgoing = -direction;
    let towards_light = to.hit.outgoing;
    let there = end.reflect(scene, TransportMode::Radiance, towards_light)?;
    let scattered = weighting.scatter(&at.sums, at.pdf(scene, &here), here.cosine);
    let cosine = direction.dot(to.hit.geometric_normal).abs();
    let sums = weighting.arrive(&scattered, at.hit.position.distance_squared(to.hit.position), cosine);
    let found = weighting.merged([&sums, &to.sums], end.pdf(scene, &there), acceptance);
    let path = joined(scene, light, camera)?;
    Some((found, path.weight(&weighting, (light.len(), camera.len() + 1, true))))
}

#[test]
fn weights_are_those_of_densities_multiplied_out() {
    let every = Techniques::ALL_CONNECTIONS.with(Techniques::MERGE, true);
    let sets =
        [every, Techniques::ALL_CONNECTIONS, every.with(Techniques::CAMERA, false), every.with(Techniques::HIT, false)];
    for name in ["cornell-diffuse", "glossy-blocks-a010"] {
        let scene = reference_scene(name);
        for techniques in sets {
            for heuristic in [Heuristic::Balance, Heuristic::Power] {
                let weighting = Weighting { techniques, heuristic, measure: Measure::Area, light_paths: LIGHT_PATHS };
                let checked = check_weights(&scene, weighting);
                assert!(checked[0] > 50 && checked[1] > 100, "few joints were checked: {checked:?}");
                assert!(checked[2] > 100 || !techniques.any(Techniques::MERGE), "few merges were checked: {checked:?}");
            }
        }
    }
}

/// Light sampling alone and hits alone share a path as two densities do.
#[test]
fn weights_of_path_tracing_are_those_of_two_techniques() {
    let scene = reference_scene("glossy-blocks-a010");
    let techniques = Techniques::HIT.with(Techniques::DIRECT, true);
    for heuristic in [Heuristic::Balance, Heuristic::Power] {
        let weighting = Weighting { techniques, heuristic, measure: Measure::Area, light_paths: LIGHT_PATHS };
        let checked = check_weights(&scene, weighting);
        assert!(checked[0] > 50, "few joints were checked: {checked:?}");
    }
}

fn pixels(scene: &Arc<Scene>, method: &str, parameters: &str) -> Vec<[f32; 3]> {
    Job::new(scene, method, parameters).run(2, 1).picture().radiance
}

#[test]
fn vcm_without_merging_is_bdpt() {
    let scene = reference_scene("cornell-glass");
    assert_eq!(pixels(&scene, "vcm", r#"{"merge": "off"}"#), pixels(&scene, "bdpt", "{}"));
}

#[test]
fn vcm_without_connections_is_pbdpm() {
    let scene = reference_scene("cornell-glass");
    let vcm = pixels(&scene, "vcm", r#"{"connect": "off", "photons_per_pass": 65536}"#);
    assert_eq!(vcm, pixels(&scene, "pbdpm", r#"{"camera_hits": "off", "photons_per_pass": 65536}"#));
}

#[test]
fn strategies_of_a_length_add_up() {
    let scene = reference_scene("cornell-glass");
    let whole = pixels(&scene, "bdpt", r#"{"length": 3}"#);
    let mut sum = vec![[0.0; 3]; whole.len()];
    for strategy in ["0,4", "1,3", "2,2", "3,1"] {
        let part = pixels(&scene, "bdpt", &format!(r#"{{"length": 3, "strategy": "{strategy}"}}"#));
        assert!(part.iter().flatten().any(|value| *value > 0.0), "strategy {strategy} found nothing");
        sum.iter_mut().flatten().zip(part.iter().flatten()).for_each(|(sum, part)| *sum += part);
    }
    for (sum, whole) in sum.iter().flatten().zip(whole.iter().flatten()) {
        assert!((sum - whole).abs() <= 1e-5 * whole.abs().max(1.0), "{sum} and {whole}");
    }
}

#[test]
fn strategies_are_those_of_the_techniques() {
    let strategies = |name: &str, parameters: serde_json::Value| {
        let parameters = parameters.as_object().cloned().unwrap_or_default();
        let found = method::strategies(&MethodChoice { name: name.to_owned(), parameters }, 3);
        found.map(|found| {
            found.iter().map(|way| (way.segments, way.light, way.camera, way.merges())).collect::<Vec<_>>()
        })
    };
    let [hit, direct, seen] = [(2, 0, 3, false), (2, 1, 2, false), (2, 2, 1, false)];
    let longer = [(3, 0, 4, false), (3, 1, 3, false), (3, 2, 2, false), (3, 3, 1, false)];
    assert_eq!(strategies("bdpt", json!({})), Ok([[hit, direct, seen].as_slice(), &longer].concat()));
    let merged = [(3, 1, 2, true), (3, 2, 1, true)];
    assert_eq!(strategies("vcm", json!({"length": 3})), Ok([longer.as_slice(), &merged].concat()));
    let photons = json!({"camera_hits": "off", "max_depth": 2});
    assert_eq!(strategies("pbdpm", photons), Ok(vec![hit, (2, 1, 1, true)]));
    assert_eq!(strategies("bdpt", json!({"strategy": "1,2"})), Ok(vec![direct]));
    assert_eq!(strategies("bdpt", json!({"max_depth": 1})), Ok(vec![]));
    let refused = strategies("sppm", json!({})).expect_err("one way only").to_string();
    assert!(refused.ends_with("bdpt, bdpm, pbdpm, vcm do"), "{refused}");
}
