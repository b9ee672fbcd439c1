//! `mlt`: chains of whole paths against closed forms and references, their balance for each kind of change, and paths that users give.

use crate::methods::{ERRORS, mean_and_error};
use crate::progressive::{reference_folder, reference_scene};
use photonfarm::estimate::picture_files;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use photonfarm::transport::Counters;
use photonfarm::transport::metropolis::chains::{Lengths, Space, acceptance};
use photonfarm::transport::metropolis::mutation::Source;
use photonfarm::transport::metropolis::path_space::proposals::{Proposal, Shares};
use photonfarm::transport::metropolis::path_space::user_path::{GivenPath, UserPath};
use photonfarm::transport::metropolis::path_space::window::FilmWindow;
use photonfarm::transport::metropolis::path_space::{PathSpace, PathState};
use rayon::prelude::*;

/// A closed furnace has radiance 1, whichever paths its chains keep to; with mirrors and glass, too.
#[test]
fn furnaces_of_whole_paths_have_radiance_one() {
    for name in ["furnace-closed", "furnace-specular"] {
        let (found, error) = mean_and_error(&reference_scene(name), "mlt", "{}", 16, 4);
        println!("{name}: {found:.5} ± {error:.5}");
        assert!((found - 1.0).abs() < ERRORS * error, "{name}: {found} ± {error}");
        assert!(error < 0.015, "{name}: the test is blind");
    }
}

/// Means of references: of lamps of every kind, a lens, glossy surfaces, glass and an environment.
#[test]
fn means_of_whole_paths_are_those_of_references() {
    for (name, blind) in [
        ("cornell-diffuse", 0.02),
        ("dof", 0.02),
        ("glossy-blocks-a010", 0.03),
        ("textured-env", 0.02),
        ("spot-mirror", 0.05),
        ("door-ajar", 0.06),
    ] {
        let reference = picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("it can be read");
        let sum: f64 = reference.radiance.iter().flatten().map(|value| f64::from(*value)).sum();
        let expected = sum / (3 * reference.radiance.len()) as f64;
        let (found, error) = mean_and_error(&reference_scene(name), "mlt", "{}", 16, 4);
        println!("{name}: {found:.5} ± {error:.5} of {expected:.5}");
        assert!((found - expected).abs() < ERRORS * error, "{name}: {found} ± {error}, {expected}");
        assert!(error < blind * expected, "{name}: the test is blind: {error}");
    }
}

/// The space of paths of three segments and more, of which all changes are of one kind; those that follow given paths go back by others.
fn space<'a>(scene: &'a Scene, kind: Proposal, user_paths: &'a [UserPath]) -> PathSpace<'a> {
    let is_used = |other: Proposal| other == kind || (kind == Proposal::User && other == Proposal::Bidirectional);
    PathSpace {
        scene,
        lengths: Lengths { shortest: 3, longest: None },
        window: FilmWindow::new(scene),
        shares: Shares::new(std::array::from_fn(|index| f32::from(u8::from(is_used(Proposal::ALL[index]))))),
        user_paths,
        least_importance: 0.0,
        pixels: 0..scene.pixel_count() as u32,
    }
}

/// Where a path ends on the film and how long it is: one of 12 parts of the space.
fn part(state: &PathState) -> usize {
    let film = state.terms.film;
    let quarter = usize::from(film.x >= 0.5) + 2 * usize::from(film.y >= 0.5);
    quarter + 4 * (state.path.segments() - 3).min(2)
}

/// The largest |z| over all pairs of parts of flows there against flows back, from states that are distributed as f*; and how many of them moved.
fn imbalance(space: &PathSpace<'_>, acceptance: impl Fn(f32, f32, f32) -> f32) -> (f64, u32) {
    const PARTS: usize = 12;
    let (mut flows, mut squares) = ([[0.0f64; PARTS]; PARTS], [[0.0f64; PARTS]; PARTS]);
    let (mut from, mut to, mut counters) = (PathState::default(), PathState::default(), Counters::default());
    let mut moved = 0;
    for path in 0..1_200_000 {
        let mut source = Source::new(PathRandom::new(7, Stream::Chain, 0, path));
        space.renew(&mut from, &mut source, &mut counters);
        let target = space.target(&from);
        if target == 0.0 {
            continue;
        }
        let change = space.change(&from, &mut to, &mut source, &mut counters);
        if change.acceptance == 0.0 {
            continue;
        }
        let flow = f64::from(target * acceptance(change.acceptance, target, space.target(&to)));
        moved += 1;
        let (here, there) = (part(&from), part(&to));
        flows[here][there] += flow;
        squares[here][there] += flow * flow;
    }
    let z = |here: usize, there: usize| {
        let variance = squares[here][there] + squares[there][here];
        if variance > 0.0 { (flows[here][there] - flows[there][here]).abs() / variance.sqrt() } else { 0.0 }
    };
    let pairs = (0..PARTS).flat_map(|here| (0..here).map(move |there| (here, there)));
    (pairs.map(|(here, there)| z(here, there)).fold(0.0, f64::max), moved)
}

/// Each kind of change keeps the distribution of paths by itself: as much flows from each part of the space to each other one as back. Of 66 pairs one is
/// beyond 4.5 standard errors once in 2,000 runs. A transition probability that is deliberately wrong, that of independent paths, is found out.
#[test]
fn changes_of_each_kind_are_in_balance() {
    let scene = reference_scene("cornell-glass");
    let to_floor = [[0.0, 0.99, 0.01], [0.7, -1.0, -0.6]];
    let by_wall = [[0.0, 0.99, 0.01], [-1.0, 0.3, 0.6], [0.7, -1.0, -0.6]];
    let check = |points: &[[f32; 3]]| {
        let cones = vec![0.3; points.len() - 1];
        UserPath::check(&scene, &GivenPath { points, cones }).expect("nothing is in its way")
    };
    let user_paths = [check(&to_floor), check(&by_wall)];
    let of_kind = |kind: &Proposal| {
        let space = space(&scene, *kind, if *kind == Proposal::User { &user_paths } else { &[] });
        let (right, moved) = imbalance(&space, |acceptance, _, _| acceptance);
        let (wrong, _) = imbalance(&space, |_, before, after| (after / before).min(1.0));
        println!("{kind:?}: {moved} moved, |z| {right:.2}, of wrong probabilities {wrong:.2}");
        (*kind, moved, right, wrong)
    };
    let found: Vec<_> = Proposal::ALL.par_iter().map(of_kind).collect();
    for (kind, moved, right, wrong) in found {
        assert!(moved > 300, "{kind:?}: the test is blind: {moved} moved");
        assert!(right < 4.5, "{kind:?}: |z| {right}");
        // Those of caustics differ too little from the right ones for these parts of the space.
        assert!(
            wrong > 5.5 || kind == Proposal::Caustic,
            "{kind:?}: wrong probabilities are not found out, |z| {wrong}"
        );
    }
}

/// Checks `user_paths` of a job on a scene.
fn refusal(scene: &str, paths: &str) -> Option<String> {
    let scene = reference_scene(scene);
    let parameters = serde_json::from_str(&format!(r#"{{"user_paths": {paths}}}"#)).expect("it is JSON");
    let choice = MethodChoice { name: "mlt".to_owned(), parameters };
    let checked = match method::check(&choice, scene.pixel_count() as u64) {
        Ok(checked) => checked,
        Err(problem) => return Some(problem.to_string()),
    };
    method::check_in_scene(&checked, &scene).err().map(|problem| problem.to_string())
}

/// A path that cannot be is refused, and the answer says which segment is wrong, and why.
#[test]
fn impossible_user_paths_are_refused() {
    let glass = |points: &str| refusal("cornell-glass", &format!(r#"[{{"points": {points}}}]"#)).unwrap_or_default();
    for (points, why) in [
        ("[[0, 0.99, 0], [0.7, -1, -0.6]]", ""),
        ("[[0.8, 0.99, 0.8], [0.7, -1, -0.6]]", "path 1 of user_paths: it starts at no lamp; the nearest is at"),
        ("[[0, 0.99, 0], [0.42, -1, 0.32]]", "segment 1 passes a surface at"),
        ("[[0, 0.99, 0], [0.7, -0.5, -0.6]]", "segment 1 hits nothing at its end; the surface in its direction is at"),
        ("[[0, 0.99, 0], [-0.8, -1, 0.8], [-0.9, 0.9, 5]]", "segment 2 hits nothing at its end"),
        ("[[0, 0.99, 0], [-0.33, -0.26, -0.24]]", "it ends at a mirror or glass"),
        ("[[0, 0.99, 0]]", r#""user_paths" is"#),
    ] {
        let found = glass(points);
        println!("{points}: {found}");
        assert!(if why.is_empty() { found.is_empty() } else { found.contains(why) }, "{points}: {found}");
    }
    let no_place = refusal("textured-env", r#"[{"points": [[0, 1, 0], [0, 0, 0]]}]"#).unwrap_or_default();
    assert!(no_place.contains("no lamp of the scene has a place"), "{no_place}");
    let cone = refusal("cornell-glass", r#"[{"points": [[0, 0.99, 0], [0.7, -1, -0.6]], "cones": [0]}]"#);
    assert!(cone.is_some_and(|problem| problem.contains("cones above 0 to 90")));
}

/// Hints never bias, however absurd: many for one dark corner, and wide ones.
#[test]
fn user_paths_do_not_bias() {
    let scene = reference_scene("cornell-glass");
    let (expected, expected_error) = mean_and_error(&scene, "mlt", "{}", 16, 4);
    let corner = r#"{"points": [[0, 0.99, 0], [1, -0.2, -0.9], [0.7, -1, -0.9]], "cones": [1, 1]}"#;
    let wide = r#"{"points": [[0.1, 0.99, 0.1], [-1, 0.9, 0.5], [0.9, -1, 0.9]], "cones": [90]}"#;
    let parameters = format!(r#"{{"user_path": 300, "user_paths": [{corner}, {corner}, {wide}]}}"#);
    let (found, error) = mean_and_error(&scene, "mlt", &parameters, 16, 4);
    let together = error.hypot(expected_error);
    println!("{found:.5} ± {error:.5}, {expected:.5} ± {expected_error:.5} without");
    assert!((found - expected).abs() < ERRORS * together, "{found} ± {error}, {expected} without");
    assert!(together < 0.06 * expected, "the test is blind");
}

/// A chain never goes to a path that brings nothing, also not from one whose target is too small for a number.
#[test]
fn paths_that_bring_nothing_are_never_taken() {
    for (proposed, current, expected) in
        [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0), (1.0, 2.0, 0.5), (2.0, 1.0, 1.0), (1.0, 0.0, 1.0)]
    {
        let found = acceptance(proposed, current);
        assert!(found == expected, "from {current} to {proposed}: {found}");
    }
}
