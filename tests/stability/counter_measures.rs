//! The table of counter-measures that tools/switch_off.py switches off: whether it still fits the code, the tests and the document.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn text<'a>(entry: &'a Value, field: &str) -> &'a str {
    entry[field].as_str().unwrap_or_else(|| panic!("no text \"{field}\" in {entry}"))
}

/// The entries of a list of the table.
fn entries(list: &str) -> Vec<Value> {
    let table: Value = serde_json::from_str(&read("tests/stability/counter_measures.json")).expect("the table is JSON");
    table[list].as_array().unwrap_or_else(|| panic!("no list \"{list}\"")).clone()
}

/// Names of rows in docs/measured/STABILITY.md: what is bold at the start of a line of a table.
fn rows() -> Vec<String> {
    let name = |line: &str| line.strip_prefix("| **")?.split_once("**").map(|(name, _)| name.to_owned());
    read("docs/measured/STABILITY.md").lines().filter_map(name).collect()
}

#[test]
fn what_switches_counter_measures_off_fits_the_code() {
    for entry in entries("measures") {
        let changes = entry["changes"].as_array().cloned().unwrap_or_else(|| vec![entry.clone()]);
        for change in &changes {
            let (file, old) = (text(change, "file"), text(change, "old"));
            assert!(text(change, "new") != old, "{old} is replaced by itself");
            assert_eq!(read(file).matches(old).count(), 1, "{file} should have this once: {old}");
        }
        let (module, function) = text(&entry, "test").split_once("::").expect("module::test");
        let test = format!("#[test]\nfn {function}()");
        assert!(read(&format!("tests/stability/{module}.rs")).contains(&test), "there is no test {module}::{function}");
    }
}

#[test]
fn every_row_has_a_counter_measure_or_a_reason() {
    let rows = rows();
    let known: BTreeSet<&str> = rows.iter().map(String::as_str).collect();
    assert!(rows.len() > 30 && known.len() == rows.len(), "{} rows, {} of them different", rows.len(), known.len());
    let (measures, without) = (entries("measures"), entries("without"));
    let names = |list: &'_ [Value]| list.iter().map(|entry| text(entry, "row").to_owned()).collect::<BTreeSet<_>>();
    let (switched_off, excused) = (names(&measures), names(&without));
    for entry in &without {
        assert!(text(entry, "reason").len() > 10, "no reason: {entry}");
    }
    assert!(switched_off.is_disjoint(&excused), "rows both in the table and excused");
    let told: BTreeSet<&str> = switched_off.union(&excused).map(String::as_str).collect();
    assert_eq!(told, known, "the rows of the table and of docs/measured/STABILITY.md differ");
}
