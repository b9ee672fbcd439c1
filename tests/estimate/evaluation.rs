//! Error over time: runs that stop at budgets, curves and rates, changes beyond noise, other programs' curves, and charts.

use std::path::Path;

use crate::result_records::{record, with_errors};
use photonfarm::evaluation::chart::{ChartData, ChartKind, report, to_png, to_svg};
use photonfarm::evaluation::{
    ChangeRule, Measure, Reached, Record, Reference, Run, Sample, Spent, Stopwatch, StopwatchError, Verdict, changes,
    curves, follow, read_peers, read_results, reference_folders,
};
use photonfarm::method::{self, CheckedMethod, MethodChoice};

fn checked(name: &str, parameters: serde_json::Value) -> CheckedMethod {
    let parameters = parameters.as_object().cloned().expect("an object");
    method::check(&MethodChoice { name: name.to_owned(), parameters }, 4096).expect("good parameters")
}

#[test]
fn all_references_load() {
    let folders = reference_folders(Path::new("tests/references")).expect("lists");
    assert!(folders.len() >= 11);
    for folder in folders {
        let reference = Reference::load(&folder).expect("loads");
        let exact = reference.name.starts_with("furnace");
        assert_eq!(reference.standard_error.is_none(), exact, "{}", reference.name);
        assert_eq!(reference.picture.radiance.iter().flatten().all(|value| *value == 1.0), exact);
    }
}

/// A second goes by between any two looks.
struct Metronome(f64);

impl Stopwatch for Metronome {
    fn spent(&mut self) -> Result<Spent, StopwatchError> {
        self.0 += 1.0;
        Ok(Spent { processor: self.0, wall: 2.0 * self.0 })
    }
}

#[test]
fn one_run_gives_the_picture_at_every_budget() {
    let reference = Reference::load(Path::new("tests/references/furnace-env")).expect("loads");
    let method = checked("sppm", serde_json::json!({"photons_per_pass": 1024}));
    let mut told = Vec::new();
    let snapshots =
        follow(&reference.scene, &method, 7, &[5.0, 1.5, 2.0], &mut Metronome(0.0), &mut |spent| told.push(spent));
    let snapshots = snapshots.expect("renders");
    let found: Vec<(f64, u32)> = snapshots.iter().map(|snapshot| (snapshot.budget, snapshot.passes)).collect();
    assert_eq!(found, [(1.5, 2), (2.0, 2), (5.0, 5)]);
    assert_eq!((told.len(), snapshots[2].spent.wall), (5, 10.0));
    let mut run = Run::start(&reference.scene, &method, 7).expect("starts");
    (0..5).for_each(|_| run.pass().expect("renders"));
    assert_eq!(snapshots[2].picture, run.picture(), "looking at a run changes nothing");
}

#[test]
fn theory_has_a_rate_for_every_method() {
    let rate = |name: &str, parameters| method::theory_rate(&checked(name, parameters));
    let default = |name: &str| rate(name, serde_json::json!({}));
    for name in ["sppm", "ppm", "pbdpm"] {
        assert!((default(name) + 2.0 / 3.0).abs() < 1e-4, "{name}: {}", default(name));
    }
    for name in ["path", "bdpt", "light_tracing", "vcm"] {
        assert_eq!(default(name), -1.0, "{name}");
    }
    assert_eq!([default("photon_map"), default("bdpm")], [0.0, 0.0]);
    assert!((rate("sppm", serde_json::json!({"alpha": 0.9})) + 0.2).abs() < 1e-9);
    assert_eq!(rate("vcm", serde_json::json!({"merge": "off"})), -1.0);
    assert!((rate("vcm", serde_json::json!({"connect": "off"})) + 2.0 / 3.0).abs() < 1e-4);
}

#[test]
fn a_power_law_has_its_power() {
    let samples: Vec<Sample> = [1.0, 3.0, 10.0, 30.0]
        .into_iter()
        .flat_map(|seconds: f64| {
            // Three seeds around the law, and a reference with noise of 0.001.
            [0.5, 1.0, 2.0].map(|factor| (seconds, factor * 0.3 * seconds.powf(-2.0 / 3.0) + 0.001))
        })
        .zip([1, 2, 3].into_iter().cycle())
        .map(|((seconds, error), seed)| {
            Sample::of(&record("box", "sppm", seed, seconds, error, 0.001), Measure::Relmse)
        })
        .collect();
    let [curve] = curves(&samples, Measure::Relmse).try_into().expect("one curve");
    let slope = curve.slope.expect("four points");
    assert!((slope.median + 2.0 / 3.0).abs() < 1e-9 && slope.count == 3, "{slope:?}");
    let point = &curve.points[0];
    assert!((point.error.median - 0.3).abs() < 1e-12 && (point.error.high - 0.6).abs() < 1e-12);
    // 0.3·t^(−2/3) = 0.1 where t = 3^1.5.
    let Some(Reached::At(seconds)) = curve.reaches(0.1) else { panic!("{:?}", curve.reaches(0.1)) };
    assert!((seconds - 3f64.powf(1.5)).abs() < 1e-9, "{seconds}");
    assert_eq!(curve.reaches(0.4), Some(Reached::Before(1.0)));
    assert_eq!(curve.reaches(0.001), Some(Reached::NotBy(30.0)));
}

/// Twenty cells of three seeds, whose log errors have a standard deviation of 5 %.
fn noisy(random: &mut impl FnMut() -> f64, factor: impl Fn(&str, f64) -> f64) -> Vec<Record> {
    let mut records = Vec::new();
    for label in ["sppm", "ppm", "path", "bdpt", "vcm"] {
        for budget in [1.0, 3.0, 10.0, 30.0] {
            for seed in 1..=3 {
                // The sum of twelve uniform numbers is nearly normal.
                let normal: f64 = (0..12).map(|_| random()).sum::<f64>() - 6.0;
                let error = factor(label, budget) * 0.1 / budget * (0.05 * normal).exp();
                records.push(record("box", label, seed, budget, error, 0.0));
            }
        }
    }
    records
}

/// Knuth's linear congruential generator, from 0 to 1.
fn generator(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn a_change_beyond_noise_is_found() {
    let mut random = generator(1);
    let old = noisy(&mut random, |_, _| 1.0);
    let new = noisy(&mut random, |label, budget| match (label, budget) {
        ("path", 10.0) => 1.4,
        ("vcm", _) => 0.6,
        _ => 1.0,
    });
    let found = changes(&old, &new, ChangeRule::default());
    assert_eq!(found.len(), 20);
    for change in found {
        let expected = match (change.label.as_str(), change.budget) {
            ("path", 10.0) => Verdict::Worse,
            ("vcm", _) => Verdict::Better,
            _ => Verdict::Same,
        };
        assert_eq!(change.verdict, expected, "{change:?}");
    }
}

#[test]
fn noise_is_no_change() {
    // At a level of 1 %, two alarms are expected in 200 comparisons of twenty cells; nine or more have probability 2·10⁻⁴.
    let mut random = generator(2);
    let rule = ChangeRule { tolerance: 0.0, ..ChangeRule::default() };
    let alarms = (0..200)
        .filter(|_| {
            let (old, new) = (noisy(&mut random, |_, _| 1.0), noisy(&mut random, |_, _| 1.0));
            changes(&old, &new, rule).iter().any(|change| change.verdict != Verdict::Same)
        })
        .count();
    assert!(alarms <= 8, "{alarms} false alarms");
}

#[test]
fn a_sure_but_small_change_is_tolerated() {
    let (old, new) = (with_errors("box", &[0.1, 0.1001, 0.0999]), with_errors("box", &[0.103, 0.1031, 0.1029]));
    let verdict = |tolerance| changes(&old, &new, ChangeRule { tolerance, ..ChangeRule::default() })[0].verdict;
    assert_eq!([verdict(0.05), verdict(0.0)], [Verdict::Same, Verdict::Worse]);
}

#[test]
fn what_cannot_be_compared_is_told() {
    let one_seed = with_errors("box", &[0.1]);
    assert_eq!(changes(&one_seed, &with_errors("box", &[0.5]), ChangeRule::default())[0].verdict, Verdict::Unknown);
    let mut other = with_errors("box", &[0.1, 0.11]);
    other.iter_mut().for_each(|record| record.scene_hash = "changed".to_owned());
    let found = changes(&with_errors("box", &[0.1, 0.11]), &other, ChangeRule::default());
    assert_eq!(found[0].verdict, Verdict::OtherScene);
    assert!(changes(&one_seed, &with_errors("room", &[0.1]), ChangeRule::default()).is_empty());
}

fn write(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writes");
    path
}

const CSV: &str = "name,scene,seed,budget,cpu_seconds,relmse,noise_relmse\n\
    Other 2.0,box,1,1,1.05,0.2,0.01\nOther 2.0,box,1,3,3.1,0.07,0.01\n\n";

#[test]
fn other_programs_curves_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = read_peers(&write(folder.path(), "a.csv", CSV)).expect("reads");
    let sample = points[1].sample(Measure::Relmse).expect("has relMSE");
    assert!(sample.peer && (sample.left(Measure::Relmse) - 0.06).abs() < 1e-12, "{sample:?}");
    assert!(points[1].sample(Measure::Rmse).is_none(), "it has no RMSE");
    let json = serde_json::to_string(&points).expect("JSON");
    assert_eq!(read_peers(&write(folder.path(), "a.json", &json)).expect("reads"), points);
    for (text, part) in [
        ("", "empty"),
        ("name,scene\nOther", "a.csv:2: 1 values under 2 names"),
        ("name,scene,seed,budget,cpu_seconds,relmsq\nOther,box,1,1,1,0.1", "relmsq"),
        ("name,scene,seed,budget,cpu_seconds\nOther,box,1,1,0", "above 0"),
        ("[{\"name\": 3}]", "line 1"),
    ] {
        let error = read_peers(&write(folder.path(), "a.csv", text)).expect_err(text).to_string();
        assert!(error.contains(part) && error.contains("EVALUATION.md"), "{error}");
    }
}

#[test]
fn results_with_a_bad_line_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = serde_json::to_string(&record("box", "sppm", 1, 1.0, 0.1, 0.0)).expect("JSON");
    let error = read_results(&write(folder.path(), "a.jsonl", &format!("{good}\n{{}}\n"))).expect_err("bad line");
    assert!(error.to_string().contains("a.jsonl:2"), "{error}");
    let again = record("box", "sppm", 1, 1.0, 0.2, 0.0);
    let text = format!("{good}\n{}\n{{\"cut off", serde_json::to_string(&again).expect("JSON"));
    let read = read_results(&write(folder.path(), "b.jsonl", &text)).expect("reads");
    assert_eq!(read, [again], "the last of two lines for a cell counts, a line without an end does not");
}

/// Two scenes, three methods of which one is blind on one scene, and a peer.
fn chart_data() -> (Vec<Record>, ChartData) {
    let mut records = Vec::new();
    for (scene, factor) in [("box", 1.0), ("room <1>", 3.0)] {
        for (label, power) in [("sppm", -0.66), ("path", -1.0), ("bdpt:heuristic=power", -0.9)] {
            for seed in 1..=3u32 {
                for budget in [1.0, 3.0, 10.0f64] {
                    let error = factor * (1.0 + 0.1 * f64::from(seed)) * 0.05 * budget.powf(power) + 0.001;
                    let mut record = record(scene, label, u64::from(seed), budget, error, 0.001);
                    record.blind = (label == "path" && scene == "box").then(|| "caustics".to_owned());
                    records.push(record);
                }
            }
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let peers = read_peers(&write(folder.path(), "a.csv", CSV)).expect("reads");
    let data = ChartData::new(&records, &peers, Measure::Relmse, 0.02);
    (records, data)
}

#[test]
fn charts_show_every_scene_and_method() {
    let (_, data) = chart_data();
    for kind in ChartKind::ALL {
        let svg = to_svg(&data.draw(kind)).expect("draws");
        let document = roxmltree::Document::parse(&svg).expect("well-formed");
        let texts: Vec<String> = document.descendants().filter_map(|node| node.text()).map(str::to_owned).collect();
        for name in ["box", "room <1>", "sppm", "path"] {
            assert!(texts.iter().any(|text| text.contains(name)), "{name} is missing in the chart {}", kind.name());
        }
        let broken = texts.concat().replace(char::is_whitespace, "");
        for name in ["bdpt:heuristic=power", "Other2.0"] {
            assert!(broken.contains(name), "{name} is missing in the chart {}", kind.name());
        }
    }
}

#[test]
fn pngs_have_two_pixels_for_one() {
    let (_, data) = chart_data();
    let drawing = data.draw(ChartKind::Best);
    let svg = to_svg(&drawing).expect("draws");
    let document = roxmltree::Document::parse(&svg).expect("well-formed");
    let size = |name| document.root_element().attribute(name).and_then(|text| text.parse::<u32>().ok()).expect("size");
    let picture = image::load_from_memory(&to_png(&drawing).expect("draws")).expect("a PNG").into_rgb8();
    assert_eq!(picture.dimensions(), (2 * size("width"), 2 * size("height")));
    let dark = picture.pixels().filter(|pixel| pixel.0.iter().all(|value| *value < 100)).count();
    assert!(dark > 500, "only {dark} dark pixels: no words were drawn");
}

#[test]
fn the_report_stands_alone() {
    let (mut records, data) = chart_data();
    let folder = tempfile::tempdir().expect("a folder");
    records[0].picture = Some("p/ours.png".to_owned());
    records[0].reference_picture = Some("p/reference.png".to_owned());
    let error = report(&data, &records, folder.path()).expect_err("the pictures are missing").to_string();
    assert!(error.contains("reference.png") && error.contains("beside the results"), "{error}");
    std::fs::create_dir(folder.path().join("p")).expect("creates");
    write(&folder.path().join("p"), "ours.png", "ours");
    write(&folder.path().join("p"), "reference.png", "reference");
    let html = report(&data, &records, folder.path()).expect("reports");
    assert_eq!(html.matches("<svg").count(), 3);
    assert!(html.contains("b3Vycw==") && html.contains("cmVmZXJlbmNl"), "the pictures are not embedded");
    assert!(
        html.contains("<td>room &lt;1&gt;</td>") && !html.contains("{{"),
        "names are text, and nothing is left open"
    );
    assert!(!html.replace("http://www.w3.org/2000/svg", "").contains("://"), "it refers to something outside");
}
