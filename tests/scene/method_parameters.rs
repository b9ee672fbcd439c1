//! Every parameter of every method: what its help says of range and default is so, and checked methods are stored and read again.

use photonfarm::method::{CheckedMethod, METHODS, MethodChoice, MethodError, ParameterHelp, check, entry};
use serde_json::{Map, Value, json};

const PIXELS: u64 = 100_000;

fn checked(method: &str, parameters: Map<String, Value>) -> Result<CheckedMethod, MethodError> {
    check(&MethodChoice { name: method.to_owned(), parameters }, PIXELS)
}

fn with(method: &str, name: &str, value: Value) -> Result<CheckedMethod, MethodError> {
    checked(method, Map::from_iter([(name.to_owned(), value)]))
}

/// Some parameters are refused where another one leaves them nothing to say.
fn with_what_it_needs(method: &str, name: &str, value: Value) -> Result<CheckedMethod, MethodError> {
    let needed = match (name, value.as_str()) {
        ("cache_rays", _) => json!({ "cache_error": 0.2 }),
        ("direct_neighbors", _) => json!({ "direct": "photons" }),
        ("direct_reuse", _) => json!({ "direct": "photon_direct" }),
        ("splitting", _) => json!({ "caustic_splitting": 2 }),
        ("coarsest_samples", _) => json!({ "hierarchy": 8, "finest_samples": 1 }),
        ("finest_samples", _) => json!({ "hierarchy": 8, "coarsest_samples": 256 }),
        ("localization", _) => json!({ "hierarchy": 8 }),
        ("show", Some("localized")) => json!({ "hierarchy": 8, "localization": 25 }),
        _ => json!({}),
    };
    let mut parameters = needed.as_object().expect("an object").clone();
    parameters.insert(name.to_owned(), value);
    checked(method, parameters)
}

fn every_parameter() -> impl Iterator<Item = (&'static str, &'static ParameterHelp)> {
    METHODS.iter().flat_map(|entry| entry.parameters.iter().map(|parameter| (entry.name, parameter)))
}

/// A number where it is one, else a word.
fn value(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| text.into())
}

#[test]
fn defaults_are_what_help_says() {
    for (method, parameter) in every_parameter() {
        let shown = parameter.default.split(':').next().expect("split yields at least one part");
        let defaults = checked(method, Map::new()).expect("defaults are good");
        let alone = Map::from_iter([(parameter.name.to_owned(), value(shown))]);
        let given = checked(method, alone).expect("the default is in range");
        if parameter.name == "alpha" {
            let alpha = defaults.choice.parameters["alpha"].as_f64().expect("a number");
            assert!((alpha - shown.parse::<f64>().expect("a number")).abs() < 5e-5, "{method}: {alpha}");
        } else {
            assert_eq!(given, defaults, "{method}: {} = {shown}", parameter.name);
        }
    }
}

/// What is in a range and what is just outside, by the words of its help.
fn probes(range: &str) -> (Vec<Value>, Vec<Value>) {
    let (mut within, mut outside) = (Vec::new(), vec![json!("nonsense"), json!([1]), json!(null), json!(true)]);
    if range.starts_with("a list") {
        return probes_of_paths();
    }
    for part in range.split(", ") {
        let part = part.split(" for ").next().expect("split yields at least one part");
        if let Some((low, high)) = part.split_once(" to ") {
            outside.extend([json!(low.to_string()), json!(1e300), json!(u64::MAX), json!(i64::MIN)]);
            let [Ok(low), Ok(high)] = [low, high].map(str::parse::<i64>) else {
                let [low, high] = [low, high].map(|number| number.parse::<f64>().expect("a number"));
                within.extend([json!(low), json!(high), json!(1)]);
                outside.push(json!(high * 1.1));
                outside.extend(if low == 0.0 {
                    vec![json!(-0.125)]
                } else {
                    vec![json!(low * 0.9), json!(0), json!(-low)]
                });
                continue;
            };
            // 1e3 is a whole number as well as 1000.
            within.extend([json!(low), json!(high), json!(low as f64), json!(high as f64)]);
            outside.extend([json!(high + 1), json!((high + 1) as f64), json!(high as f64 + 0.5)]);
            // Zero and −1 may have a meaning of their own.
            outside.extend((!range.contains(&format!("{}", low - 1)) && low != 2).then(|| json!(low - 1)));
        } else if let Some(low) = part.strip_prefix("above ") {
            let low = low.parse::<f64>().expect("a number");
            within.push(json!(low + 0.125));
            outside.extend([json!(low), json!(low - 0.125)]);
        } else if let Some(high) = part.strip_prefix("below ") {
            outside.push(json!(high.parse::<f64>().expect("a number")));
        } else if range.starts_with("s,t") {
            within.extend([json!("2,3"), json!("all")]);
            outside.extend([json!("2"), json!("2,3,4"), json!("-1,3")]);
        } else {
            within.push(value(part));
            outside.push(json!(format!("{part}s")));
        }
    }
    (within, outside)
}

/// Paths with as few and as many points and cones as may be, and with one too few or too many.
fn probes_of_paths() -> (Vec<Value>, Vec<Value>) {
    let path = |points: usize, cones: &[f32]| {
        let points = vec![[0.5, 0.25, -1.5]; points];
        if cones.is_empty() { json!([{"points": points}]) } else { json!([{"points": points, "cones": cones}]) }
    };
    let many = |count: usize| Value::Array(vec![path(2, &[])[0].clone(); count]);
    let within = [json!([]), many(1000), path(2, &[]), path(32, &[0.5]), path(3, &[90.0, 0.125])];
    let outside = [
        many(1001),
        path(1, &[]),
        path(33, &[]),
        path(4, &[1.0, 2.0]),
        path(2, &[0.0]),
        path(2, &[90.5]),
        json!([{"points": [[0.5, 0.25], [1.0, 1.0, 1.0]]}]),
        json!([{"points": [[0.5, 0.25, 1e39], [1.0, 1.0, 1.0]]}]),
        json!([{"cones": [1.0]}]),
        json!([{"points": [[0.5, 0.25, 1.0], [1.0, 1.0, 1.0]], "cone": 5}]),
    ];
    (within.into(), outside.into())
}

/// A picture of no paths would be black without a word.
#[test]
fn lengths_and_strategies_that_leave_nothing() {
    let refused = |method: &str, parameters: Value, expected: &str| {
        let given = parameters.as_object().expect("an object").clone();
        let error = checked(method, given).err().unwrap_or_else(|| panic!("{method} {parameters} is taken"));
        assert_eq!(error.to_string(), format!("method \"{method}\": {expected}"));
    };
    for method in ["path", "light_tracing", "bdpt", "bdpm", "pbdpm", "vcm"] {
        let longer = "\"length\" is 5, and \"max_depth\" allows 3 segments; give a length of at most 3";
        refused(method, json!({"length": 5, "max_depth": 3}), longer);
        for taken in [json!({"length": 3, "max_depth": 3}), json!({"length": 1})] {
            let given = taken.as_object().expect("an object").clone();
            assert!(checked(method, given).is_ok(), "{method} {taken}");
        }
    }
    let off = json!({"length": 3, "light_sampling": "off", "material_sampling": "off"});
    refused("path", off, "no paths of 3 segments are found; switch a way of finding them on");
    let of = |strategy: &str, remedy: &str| format!("no path is found with the strategy {strategy}; those of {remedy}");
    refused("bdpt", json!({"strategy": "0,0"}), &of("0,0", "2 segments are 0,3 1,2 2,1"));
    refused("bdpt", json!({"strategy": "4,0"}), &of("4,0", "3 segments are 0,4 1,3 2,2 3,1"));
    refused("bdpt", json!({"strategy": "1,1"}), &of("1,1", "2 segments are 0,3 1,2 2,1"));
    refused("bdpt", json!({"strategy": "3,3", "max_depth": 2}), &of("3,3", "2 segments are 0,3 1,2 2,1"));
    refused("bdpt", json!({"strategy": "40000,40000"}), &of("40000,40000", "5 segments are 0,6 1,5 2,4 3,3 4,2 5,1"));
    refused(
        "bdpt",
        json!({"strategy": "4294967295,4294967295"}),
        &of("4294967295,4294967295", "5 segments are 0,6 1,5 2,4 3,3 4,2 5,1"),
    );
    let hits = json!({"strategy": "1,2", "connect": "off", "merge": "off"});
    refused("vcm", hits, &of("1,2", "2 segments are 0,3"));
    let longer = json!({"strategy": "3,1", "connect": "off", "max_depth": 3});
    refused("vcm", longer, &of("3,1", "3 segments are 0,4 1,2 2,1"));
    let other_length = "no path of 3 segments is found with the strategy 2,1; those of 3 segments are 0,4 1,3 2,2 3,1";
    refused("bdpt", json!({"strategy": "2,1", "length": 3}), other_length);
    for (method, strategy) in [("bdpt", "0,2"), ("bdpt", "1,2"), ("bdpm", "1,1"), ("pbdpm", "2,3"), ("vcm", "2,1")] {
        assert!(with(method, "strategy", json!(strategy)).is_ok(), "{method} {strategy}");
    }
}

/// What would be taken and do nothing is refused.
#[test]
fn irradiance_caches_that_contradict_other_parameters() {
    let refused = |parameters: Value, expected: &str| {
        let given = parameters.as_object().expect("an object").clone();
        let error = checked("photon_map", given).expect_err("refused").to_string();
        assert_eq!(error, format!("method \"photon_map\": {expected}"));
    };
    let no_cache = "\"cache_rays\" is 64, and without \"cache_error\" there is no irradiance cache; \
        give \"cache_error\" too, for example 0.2";
    refused(json!({"cache_rays": 64}), no_cache);
    refused(json!({"cache_rays": 64, "cache_error": "off"}), no_cache);
    let no_gathering = "\"cache_error\" is 0.3, and with \"final_gather\" 0 no rays gather what it keeps; \
        give \"final_gather\" at least 1";
    refused(json!({"cache_error": 0.3, "final_gather": 0}), no_gathering);
    for taken in [json!({"cache_error": 0.3}), json!({"cache_error": 0.3, "cache_rays": 64, "final_gather": 1})] {
        assert!(checked("photon_map", taken.as_object().expect("an object").clone()).is_ok(), "{taken}");
    }
}

#[test]
fn ranges_are_what_help_says() {
    let mut seen = 0;
    for (method, parameter) in every_parameter() {
        let (within, outside) = probes(parameter.range);
        assert!(!within.is_empty(), "{method}.{} allows nothing", parameter.name);
        for value in within {
            let found = with_what_it_needs(method, parameter.name, value.clone());
            let found = found.unwrap_or_else(|error| panic!("{method}.{} = {value}: {error}", parameter.name));
            let written = &found.choice.parameters[parameter.name];
            // How many photons `auto` is follows from the picture's size alone, so it is written out as a number.
            let expected = if value == "auto" && parameter.name == "photons_per_pass" { json!(PIXELS) } else { value };
            let same = *written == expected || (written.is_number() && written.as_f64() == expected.as_f64());
            assert!(same, "{method} writes {written} for {expected}");
            seen += 1;
        }
        for value in outside {
            let error = with(method, parameter.name, value.clone()).err();
            let error = error.unwrap_or_else(|| panic!("{method}.{} = {value} is taken", parameter.name)).to_string();
            let expected =
                format!("method \"{method}\": \"{}\" is {value}; allowed: {}", parameter.name, parameter.range);
            assert_eq!(error, expected);
        }
    }
    assert!(seen > 100, "only {seen} values were tried");
}

#[test]
fn a_written_out_choice_means_the_same_for_another_size() {
    for entry in METHODS {
        let first = checked(entry.name, Map::new()).expect("defaults are good");
        let names: Vec<&String> = first.choice.parameters.keys().collect();
        let known: Vec<&str> = entry.parameters.iter().map(|parameter| parameter.name).collect();
        assert_eq!(names, known, "{}", entry.name);
        let again = check(&first.choice, 5).expect("it was checked");
        assert_eq!(again.choice, first.choice);
    }
}

/// As jobs were stored and sent before parameters were types.
#[test]
fn checked_methods_are_stored_as_ever() {
    let records = [
        (
            "photon_map",
            r#"{"choice":{"name":"photon_map","parameters":{"photons_per_pass":65536,"neighbors":20,"caustic_neighbors":10,
            "largest_radius":0.25,"kernel":"cone","final_gather":4,"max_depth":-1,"rr_depth":1,"passes":256}},
            "radius_rule":"schedule","alpha":0.6666666666666666,"photons_per_pass":65536,"passes":256}"#,
        ),
        (
            "vcm",
            r#"{"choice":{"name":"vcm","parameters":{"connect":"on","merge":"off","alpha":0.6666666666666666,
            "radius_rule":"statistics","photons_per_pass":4096,"initial_radius":"auto","heuristic":"power","strategy":"2,3",
            "show":"unweighted","max_depth":12,"rr_depth":3,"length":5,"passes":64}},"radius_rule":"schedule","alpha":1.0,
            "photons_per_pass":4096,"passes":64}"#,
        ),
        (
            "path",
            r#"{"choice":{"name":"path","parameters":{"light_sampling":"on","material_sampling":"off","heuristic":"balance",
            "max_depth":-1,"rr_depth":3,"length":"all","passes":256}},"radius_rule":"schedule","alpha":1.0,
            "photons_per_pass":4096,"passes":256}"#,
        ),
        (
            "sppm",
            r#"{"choice":{"name":"sppm","parameters":{"alpha":0.8,"radius_rule":"schedule","photons_per_pass":500000,
            "initial_radius":0.02,"max_depth":-1,"rr_depth":1,"direct":"sample","passes":256}},"radius_rule":"schedule",
            "alpha":0.8,"photons_per_pass":500000,"passes":256}"#,
        ),
    ];
    for (name, text) in records {
        let record: Value = serde_json::from_str(text).expect("the test's JSON is good");
        let read: CheckedMethod = serde_json::from_str(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut written = serde_json::to_value(&read).expect("it has a JSON form");
        if name == "photon_map" {
            // What gathers nothing in discs has no α; this method used to name one.
            written["alpha"] = record["alpha"].clone();
        }
        // New since then; a job that was stored goes on as it began, whatever is the default now.
        let parameters = written["choice"]["parameters"].as_object_mut().expect("an object");
        let has_photons = name != "path";
        assert_eq!(parameters.remove("emission"), has_photons.then(|| json!("power")), "{name}");
        assert_eq!(parameters.remove("occlusion"), has_photons.then(|| json!("off")), "{name}");
        assert_eq!(parameters.remove("light_picks"), Some(json!("importance")), "{name}");
        let known = entry(name).expect("a method of the table").parameters;
        let then = record["choice"]["parameters"].as_object().expect("an object");
        for later in known.iter().filter(|known| !then.contains_key(known.name)) {
            let shown = later.default.split(':').next().expect("split yields at least one part");
            let Some(written) = parameters.remove(later.name) else { continue };
            let same = written == value(shown) || written.as_f64().is_some_and(|it| value(shown).as_f64() == Some(it));
            assert!(same, "{name}: {} is {written}, and its default {shown}", later.name);
        }
        assert_eq!(written, record, "{name}");
        let mut other = record.clone();
        other["passes"] = json!(7);
        let refused = serde_json::from_value::<CheckedMethod>(other).expect_err("it contradicts itself").to_string();
        assert!(refused.contains("7 passes"), "{refused}");
    }
}
