//! Rules of the house that a machine can check: which layer may know which, where a crate may be named, what has a file
//! or a row of its own, and how long files may get.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use photonfarm::method::METHODS;

mod documents;

/// Layers from the lowest to the highest, each with those that it may import.
const LAYERS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("scene", &["math"]),
    ("import", &["math", "scene"]),
    ("transport", &["math", "scene"]),
    ("estimate", &["math"]),
    ("method", &["math", "scene", "transport", "estimate"]),
    ("render", &["math", "scene", "transport", "estimate", "method"]),
    ("evaluation", &["math", "scene", "import", "estimate", "method", "render"]),
    // Below `render` the farm reads only what travels or is checked: it adds numbers and never traces a ray.
    ("farm", &["math", "scene", "import", "estimate", "method", "render", "evaluation"]),
    // `scene` and `method` for their errors, which become problem documents.
    ("api", &["farm", "estimate", "evaluation", "scene", "method"]),
    ("cli", &["math", "scene", "import", "transport", "estimate", "method", "evaluation", "render", "farm", "api"]),
];

/// Crates that belong to some places only: files and folders below `src`.
const CRATES: &[(&str, &[&str])] = &[
    ("obvhs", &["scene/geometry/accelerator.rs"]),
    ("base64", &["import/gltf", "evaluation/chart", "farm/webhooks/signature.rs"]),
    ("roxmltree", &["import", "cli/scene_file.rs"]),
    ("flate2", &["scene/geometry/serialized.rs", "import/gzip.rs"]),
    ("zip", &["scene", "import", "cli/scene_file.rs", "farm/store/maintenance.rs"]),
    ("sqlx", &["farm/store"]),
    ("object_store", &["farm/store"]),
    ("exr", &["estimate/picture_files", "scene/texture", "import/pbrt/infinite.rs"]),
    ("image", &["estimate/picture_files", "scene/texture"]),
    ("png", &["estimate/picture_files/animated_png.rs"]),
    ("plotters", &["evaluation/chart/canvas.rs"]),
    (
        "rayon",
        &[
            "transport",
            "method",
            "render",
            "estimate/denoise",
            "evaluation/run.rs",
            "evaluation/stopwatch.rs",
            "farm/worker",
        ],
    ),
    ("tokio", &["farm", "api", "cli", "main.rs"]),
    ("axum", &["farm", "api", "cli/farm_options.rs"]),
    ("utoipa", &["farm", "api"]),
    ("utoipa_axum", &["api"]),
    ("reqwest", &["cli"]),
    ("openidconnect", &["farm/login"]),
    ("headers", &["api/ranges.rs"]),
    ("hyper", &["farm/http/server.rs"]),
    (
        "hyper_util",
        &["farm/worker", "farm/dial.rs", "farm/http/server.rs", "farm/webhooks/sender.rs", "farm/login/requests.rs"],
    ),
    ("tower_service", &["farm/dial.rs"]),
    ("rustls", &["farm/tls"]),
    ("rustls_platform_verifier", &["farm/tls"]),
    ("rcgen", &["farm/tls"]),
    ("ring", &["farm/tls", "farm/webhooks/signature.rs"]),
    ("tokio_rustls", &["farm/dial.rs", "farm/http/server.rs"]),
    ("getrandom", &["farm/access/secret.rs"]),
    ("prometheus_client", &["farm/coordinator/counters.rs", "farm/coordinator/metrics.rs"]),
    ("time", &["farm/coordinator/announcing.rs", "cli/terminal.rs", "estimate/picture_files/exr_attributes.rs"]),
    ("prost", &["farm"]),
    ("lz4_flex", &["farm/wire"]),
    ("clap", &["cli", "main.rs"]),
    ("indicatif", &["cli"]),
    ("console", &["cli/top.rs", "cli/progress.rs"]),
    ("tracing_subscriber", &["cli", "main.rs"]),
];

/// The farm's rules: a state machine that is given the time and knows neither clocks nor the network.
const STATE_MACHINE: &str = "farm/rules/";

const MOST_LINES: usize = 400;

struct SourceFile {
    /// Below `src`, with `/` separators.
    path: String,
    text: String,
    /// Without comments and without inline tests.
    code: String,
}

impl SourceFile {
    fn layer(&self) -> &str {
        self.path.split(['/', '.']).next().unwrap_or_default()
    }

    /// Whether the code names the crate `name` as the start of a path.
    fn names_crate(&self, name: &str) -> bool {
        words_before_colons(&self.code).any(|(before, word)| word == name && !before.ends_with(':'))
            || self.code.contains(&format!("use {name};"))
    }
}

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources() -> Vec<SourceFile> {
    let root = crate_folder().join("src");
    let mut paths = Vec::new();
    collect(&root, &mut paths);
    paths.sort();
    let read = |path: &PathBuf| {
        let text = fs::read_to_string(path).expect("sources are text");
        let product = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let code = product.lines().map(|line| line.split("//").next().unwrap_or_default());
        let code = code.collect::<Vec<_>>().join("\n");
        let relative = path.strip_prefix(&root).expect("below src");
        let parts: Vec<_> = relative.iter().map(|part| part.to_string_lossy()).collect();
        SourceFile { path: parts.join("/"), text, code }
    };
    paths.iter().map(read).collect()
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder can be read") {
        let path = entry.expect("an entry can be read").path();
        if path.is_dir() {
            collect(&path, paths);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            paths.push(path);
        }
    }
}

/// Every `word::` with the text before it.
fn words_before_colons(code: &str) -> impl Iterator<Item = (&str, &str)> {
    code.match_indices("::").map(|(at, _)| {
        let before = &code[..at];
        let start = before.rfind(|c: char| !(c.is_alphanumeric() || c == '_')).map_or(0, |index| index + 1);
        (&code[..start], &code[start..at])
    })
}

/// First names of paths that start at the crate's root: `crate::a::b`, `crate::{a, b}`, and `super::super::a` where that
/// many steps lead there.
fn imported_layers(file: &SourceFile) -> BTreeSet<String> {
    let depth = file.path.split('/').filter(|part| *part != "mod.rs").count();
    let root = format!("\u{0}{}", "super::".repeat(depth));
    let mut code = file.code.replace("crate::", "\u{0}");
    if !["lib.rs", "main.rs"].contains(&file.path.as_str()) {
        code = code.replace(&root[1..], "\u{0}");
    }
    code.split('\u{0}').skip(1).flat_map(first_names).collect()
}

fn first_names(path: &str) -> Vec<String> {
    let name = |text: &str| text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let Some(group) = path.strip_prefix('{') else { return vec![name(path)] };
    let (mut names, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' | ',' if depth == 0 => {
                names.push(name(&group[start..at]));
                start = at + 1;
                if letter == '}' {
                    break;
                }
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

fn assert_none(violations: &[String], rule: &str) {
    assert!(violations.is_empty(), "{rule}:\n{}", violations.join("\n"));
}

#[test]
fn structure_the_table_of_layers_is_complete() {
    let table = fs::read_to_string(crate_folder().join("src/lib.rs")).expect("lib.rs is there");
    let documented: BTreeSet<&str> =
        table.lines().filter_map(|line| line.strip_prefix("//! | [`")?.split('`').next()).collect();
    let known: BTreeSet<&str> = LAYERS.iter().map(|(layer, _)| *layer).collect();
    assert_eq!(documented, known, "the table in src/lib.rs and the one in this test differ");
    let entries = fs::read_dir(crate_folder().join("src")).expect("src is there");
    let folders: BTreeSet<String> = entries
        .map(|entry| entry.expect("an entry can be read"))
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(folders, known.iter().map(|layer| (*layer).to_owned()).collect());
}

#[test]
fn structure_layers_import_only_what_is_below() {
    let mut violations = Vec::new();
    let mut seen = 0;
    for file in sources() {
        let Some((layer, allowed)) = LAYERS.iter().find(|(layer, _)| *layer == file.layer()) else { continue };
        for name in imported_layers(&file) {
            seen += 1;
            let known = LAYERS.iter().any(|(other, _)| *other == name);
            if known && name != *layer && !allowed.contains(&name.as_str()) {
                violations.push(format!("{} imports {name}", file.path));
            }
        }
    }
    assert!(seen > 100, "only {seen} imports were found: the parser is broken");
    assert_none(&violations, "a layer imports only those below it");
}

#[test]
fn structure_crates_are_named_where_they_belong() {
    let mut violations = Vec::new();
    let sources = sources();
    for (name, places) in CRATES {
        let users: Vec<&SourceFile> = sources.iter().filter(|file| file.names_crate(name)).collect();
        assert!(!users.is_empty(), "nothing uses {name}: the table of crates is out of date");
        let belongs = |file: &SourceFile| {
            places.iter().any(|place| file.path == *place || file.path.starts_with(&format!("{place}/")))
        };
        violations.extend(users.iter().filter(|file| !belongs(file)).map(|file| format!("{} names {name}", file.path)));
    }
    assert_none(&violations, "a crate is named only where it belongs");
}

#[test]
fn structure_rendering_knows_no_clock_environment_or_thread() {
    const FORBIDDEN: &[&str] = &[
        "Instant",
        "SystemTime",
        "std::env",
        "env::var",
        "std::thread",
        "thread::current",
        "current_thread_index",
        "current_num_threads",
        "ThreadId",
        "RandomState",
        "std::process",
        "std::net",
    ];
    const BELOW_FARM: &[&str] = &["math", "scene", "transport", "estimate", "method", "evaluation", "render"];
    let mut violations = Vec::new();
    for file in sources() {
        if !BELOW_FARM.contains(&file.layer()) {
            continue;
        }
        for word in FORBIDDEN.iter().filter(|word| file.code.contains(**word)) {
            // A process id names a temporary file beside a picture; no number depends on it. Evaluations take the time of what they
            // render, and say on which machine.
            let allowed = file.path.starts_with("estimate/picture_files/") && *word == "std::process"
                || ["evaluation/stopwatch.rs", "evaluation/machine.rs"].contains(&file.path.as_str());
            if !allowed {
                violations.push(format!("{} names {word}", file.path));
            }
        }
    }
    assert_none(&violations, "a pass is a pure function of its scene, parameters, seed and index");
}

/// Functions of the system's mathematical library differ between systems, and so would pictures; the crate `libm` is the same everywhere.
#[test]
fn structure_pictures_do_not_hang_on_the_systems_mathematics() {
    const FUNCTIONS: &[&str] = &[
        "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2",
        "exp_m1", "ln", "ln_1p", "log", "log2", "log10", "powf", "hypot", "cbrt",
    ];
    const LAYERS_OF_PICTURES: &[&str] = &["math", "scene", "transport", "estimate", "method", "render"];
    let mut violations = Vec::new();
    for file in sources().iter().filter(|file| LAYERS_OF_PICTURES.contains(&file.layer())) {
        for function in FUNCTIONS {
            let called = [format!(".{function}("), format!("f32::{function}"), format!("f64::{function}")];
            let names = |call: &String| {
                file.code.match_indices(call.as_str()).any(|(at, _)| {
                    !file.code[at + call.len()..].starts_with(|next: char| next.is_alphanumeric() || next == '_')
                        || call.ends_with('(')
                })
            };
            if called.iter().any(names) {
                violations.push(format!("{} calls {function}", file.path));
            }
        }
    }
    assert_none(&violations, "the crate libm is used, so that every system gives the same bits");
}

#[test]
fn structure_scheduling_is_synchronous() {
    let mut violations = Vec::new();
    let sources = sources();
    let rules: Vec<&SourceFile> = sources.iter().filter(|file| file.path.starts_with(STATE_MACHINE)).collect();
    assert!(rules.len() > 5, "the rules are elsewhere");
    for file in rules {
        let crates = ["tokio", "axum", "reqwest", "prost", "rayon", "futures_util", "tracing", "sqlx", "object_store"];
        let named = crates.iter().filter(|name| file.names_crate(name));
        violations.extend(named.map(|name| format!("{} names {name}", file.path)));
        for word in ["async ", ".await", "Renderer", "Mutex", "::now()", "SystemTime", "std::env", "evaluation::"] {
            if file.code.contains(word) {
                violations.push(format!("{} contains {word}", file.path));
            }
        }
    }
    assert_none(&violations, "scheduling is a synchronous state machine");
}

/// Places of the farm that may reach what traces: those that run in workers.
const TRACERS: &[&str] = &["farm/worker/", "farm/method_choice.rs", "farm/local_farm.rs"];

/// What the coordinator's side may use of the layers that trace: data, names and checks, none of which can trace a ray.
const HARMLESS: &[&str] = &[
    "render::Guides",
    "render::Pilot",
    "render::first_surface::FirstSurface",
    "evaluation::DEFAULT_ERROR",
    "farm::method_choice::AUTO",
    "farm::method_choice::DEFAULT_METHOD",
    "farm::method_choice::choice",
    "farm::method_choice::without_passed_over",
    "farm::method_choice::check_trials",
    "farm::prepared_scenes",
];

/// A path with groups as paths without: `a::{b, c::{d, e}}` is `a::b`, `a::c::d` and `a::c::e`.
fn without_groups(path: &str) -> Vec<String> {
    let Some(open) = path.find('{') else { return vec![path.trim().to_owned()] };
    let inside = path[open + 1..].trim_end().trim_end_matches('}');
    let (mut items, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, letter) in inside.char_indices().chain([(inside.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inside[start..at].trim().is_empty() {
                    items.extend(without_groups(&format!("{}{}", &path[..open], inside[start..at].trim())));
                }
                start = at + 1;
            }
            _ => {}
        }
    }
    items
}

/// Every item that a file imports from the crate or names by its whole path, as paths without groups.
fn imported_items(file: &SourceFile) -> Vec<String> {
    let imports = file.code.split("use crate::").skip(1);
    let mut items: Vec<String> =
        imports.flat_map(|import| without_groups(import.split(';').next().unwrap_or_default())).collect();
    for (at, _) in file.code.match_indices("crate::").filter(|(at, _)| !file.code[..*at].ends_with("use ")) {
        let path = &file.code[at + "crate::".len()..];
        let end = path.find(|letter: char| !(letter.is_alphanumeric() || letter == '_' || letter == ':'));
        items.push(path[..end.unwrap_or(path.len())].to_owned());
    }
    items
}

/// The module that a file is: `farm::http` for `farm/http/mod.rs`.
fn module(file: &SourceFile) -> String {
    file.path.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::")
}

/// The modules whose items a file imports with `use`, out of those that are known.
fn imported_modules(file: &SourceFile, known: &BTreeSet<String>) -> BTreeSet<String> {
    let own = module(file);
    let statements = file.code.split("use ").skip(1).filter_map(|rest| rest.split_once(';')).map(|(path, _)| path);
    let absolute = |item: String| {
        let ups = item.matches("super::").count();
        let place: Vec<&str> = own.split("::").collect();
        match item.strip_prefix("crate::") {
            Some(path) => path.to_owned(),
            None if ups > 0 => {
                [&place[..place.len().saturating_sub(ups)].join("::"), &item[ups * "super::".len()..]].join("::")
            }
            None => format!("{own}::{item}"),
        }
    };
    let found = statements.flat_map(without_groups).map(absolute).filter_map(|path| {
        let ends = path.match_indices("::").map(|(at, _)| at).chain([path.len()]);
        ends.map(|end| path[..end].to_owned()).filter(|module| known.contains(module)).last()
    });
    found.filter(|module| *module != own).collect()
}

/// Files of a folder that has no circles can be read one after the other, each after those that it imports.
#[test]
fn structure_files_of_the_farm_import_each_other_in_one_direction() {
    let files: Vec<SourceFile> = sources().into_iter().filter(|file| file.layer() == "farm").collect();
    let known: BTreeSet<String> = files.iter().map(module).collect();
    let mut left: BTreeMap<String, BTreeSet<String>> =
        files.iter().map(|file| (module(file), imported_modules(file, &known))).collect();
    assert!(left.values().map(BTreeSet::len).sum::<usize>() > 200, "the parser is broken");
    loop {
        let read: BTreeSet<String> = left.keys().filter(|file| left[*file].is_empty()).cloned().collect();
        if read.is_empty() {
            break;
        }
        left.retain(|file, _| !read.contains(file));
        left.values_mut().for_each(|imports| imports.retain(|import| !read.contains(import)));
    }
    let violations: Vec<String> = left.iter().map(|(file, imports)| format!("{file} waits for {imports:?}")).collect();
    assert_none(&violations, "files that import each other, and what imports those");
}

#[test]
fn structure_the_coordinator_reaches_nothing_that_traces() {
    let mut violations = Vec::new();
    let mut seen = 0;
    for file in sources() {
        let traces = TRACERS.iter().any(|place| file.path.starts_with(place));
        if file.layer() != "farm" || traces {
            continue;
        }
        for item in imported_items(&file) {
            let suspicious = ["render::", "transport::", "evaluation::", "farm::worker", "farm::method_choice"];
            if suspicious.iter().any(|layer| item.starts_with(layer)) {
                seen += 1;
                if !HARMLESS.iter().any(|known| item == *known || item.ends_with("::self")) {
                    violations.push(format!("{} reaches {item}", file.path));
                }
            }
        }
        for word in ["super::worker", "Renderer", "first_surface_layers", "try_methods"] {
            if file.code.contains(word) {
                violations.push(format!("{} names {word}", file.path));
            }
        }
    }
    assert!(seen > 5, "only {seen} imports were found: the parser is broken");
    assert_none(&violations, "the coordinator's side never traces a path");
}

#[test]
fn structure_methods_never_import_each_other() {
    let mut violations = Vec::new();
    let sources = sources();
    for method in METHODS {
        // A method that is another one but for a part stands beside that one's parts.
        let end = format!("/{}.rs", method.name);
        let is_its_own = |file: &&SourceFile| file.path.starts_with("method/") && file.path.ends_with(&end);
        let file = sources.iter().find(is_its_own).unwrap_or_else(|| panic!("{} has no file", method.name));
        let path = &file.path;
        for other in METHODS.iter().filter(|other| other.name != method.name) {
            // The photon map itself is a module of transport.
            let paths = words_before_colons(&file.code)
                .any(|(before, word)| word == other.name && !before.ends_with("transport::"));
            let imports = ["super", "method"].iter().any(|from| file.code.contains(&format!("{from}::{}", other.name)));
            if paths || imports {
                violations.push(format!("{path} names {}", other.name));
            }
        }
    }
    assert_none(&violations, "what two methods share moves down to transport");
}

#[test]
fn structure_methods_have_complete_rows() {
    let names: BTreeSet<&str> = METHODS.iter().map(|method| method.name).collect();
    assert_eq!(names.len(), METHODS.len(), "two methods have one name");
    for method in METHODS {
        let texts = [method.summary, method.cannot_sample, method.reference];
        assert!(texts.iter().all(|text| text.len() > 3), "{} does not say what it is", method.name);
        let parameters: BTreeSet<&str> = method.parameters.iter().map(|parameter| parameter.name).collect();
        assert_eq!(parameters.len(), method.parameters.len(), "{} has a parameter twice", method.name);
        for parameter in method.parameters {
            let texts = [parameter.meaning, parameter.range, parameter.default];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}.{}", method.name, parameter.name);
        }
    }
}

#[test]
fn structure_files_are_short_and_named_for_what_they_hold() {
    const BANNED: &[&str] = &["util", "utils", "common", "helper", "helpers", "misc", "manager"];
    let mut violations = Vec::new();
    for file in sources() {
        let lines = file.text.lines().count();
        if lines > MOST_LINES {
            violations.push(format!("{} has {lines} lines", file.path));
        }
        if file.path.split(['/', '.']).any(|part| BANNED.contains(&part)) {
            violations.push(format!("{} says nothing about what it holds", file.path));
        }
        if !file.text.starts_with("//!") {
            violations.push(format!("{} does not say what it is for", file.path));
        }
    }
    assert_none(&violations, "files are short and say what they hold");
}
