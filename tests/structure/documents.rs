//! Documents name what there is, and their links lead somewhere.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use photonfarm::estimate::picture_files;
use photonfarm::method::METHODS;

use crate::{assert_none, crate_folder};

/// Folders with documents, besides the root.
const FOLDERS: &[&str] = &["clients", "deploy", "docs", "scenes", "tests", "tools"];

fn read(path: impl AsRef<Path>) -> String {
    let path = crate_folder().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    entries.map(|entry| entry.expect("an entry can be read").path()).collect()
}

fn is_document(path: &Path) -> bool {
    path.is_file() && path.extension().is_some_and(|extension| extension == "md")
}

fn collect_documents(folder: &Path, documents: &mut Vec<PathBuf>) {
    for path in entries(folder) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // What package managers install is not ours.
        if path.is_dir() && !name.starts_with('.') && !["node_modules", "venv"].contains(&name.as_str()) {
            collect_documents(&path, documents);
        } else if is_document(&path) {
            documents.push(path);
        }
    }
}

fn documents() -> Vec<PathBuf> {
    let mut documents: Vec<PathBuf> = entries(crate_folder()).into_iter().filter(|path| is_document(path)).collect();
    FOLDERS.iter().for_each(|folder| collect_documents(&crate_folder().join(folder), &mut documents));
    documents
}

/// The text without fenced, indented and inline code.
fn without_code(text: &str) -> String {
    let mut prose = String::new();
    let mut is_fenced = false;
    for line in text.lines() {
        is_fenced ^= line.trim_start().starts_with("```");
        if !is_fenced && !line.starts_with("    ") {
            prose.extend(line.split('`').step_by(2));
        }
        prose.push('\n');
    }
    prose
}

/// Targets of links and pictures, without titles.
fn links(text: &str) -> Vec<String> {
    let target = |rest: &str| rest.split([')', ' ']).next().unwrap_or_default().to_owned();
    without_code(text).split("](").skip(1).map(target).collect()
}

/// The name by which a link reaches a heading.
fn anchor(heading: &str) -> String {
    let kept = |letter: &char| letter.is_alphanumeric() || [' ', '-', '_'].contains(letter);
    heading.trim().to_lowercase().chars().filter(kept).map(|letter| if letter == ' ' { '-' } else { letter }).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// What is wrong with a link of `document`.
fn fault(document: &Path, link: &str) -> Option<String> {
    let (path, fragment) = link.split_once('#').map_or((link, None), |(path, fragment)| (path, Some(fragment)));
    let target = if path.is_empty() { document.to_owned() } else { document.parent()?.join(path) };
    let place = document.strip_prefix(crate_folder()).unwrap_or(document).display();
    if !target.exists() {
        return Some(format!("{place}: nothing is at {link}"));
    }
    let fragment = fragment.filter(|_| is_document(&target))?;
    let is_known = anchors(&fs::read_to_string(&target).expect("documents are text")).contains(fragment);
    (!is_known).then(|| format!("{place}: no heading is {link}"))
}

#[test]
fn documents_link_to_what_is_there() {
    let (mut violations, mut seen) = (Vec::new(), 0);
    for document in documents() {
        let text = fs::read_to_string(&document).expect("documents are text");
        for link in links(&text).iter().filter(|link| !link.contains(':')) {
            seen += 1;
            violations.extend(fault(&document, link));
        }
    }
    assert!(seen > 200, "only {seen} links were found: the parser is broken");
    assert_none(&violations, "links lead to files and headings");
}

/// A measurement is worth what is known of how it was made.
#[test]
fn documents_of_measurements_say_how_they_were_made() {
    let folder = crate_folder().join("docs/measured");
    let list = read("docs/measured/README.md");
    let mut violations = Vec::new();
    for path in entries(&folder).into_iter().filter(|path| is_document(path) && !path.ends_with("README.md")) {
        let name = path.file_name().expect("files have names").to_string_lossy().into_owned();
        if !list.contains(&format!("]({name})")) {
            violations.push(format!("docs/measured/README.md does not list {name}"));
        }
        let head = read(&path).lines().take(16).collect::<Vec<_>>().join("\n").to_lowercase();
        for word in ["commit", "2026", "processor"] {
            if !head.contains(word) {
                violations.push(format!("the first lines of {name} lack the word {word}"));
            }
        }
    }
    assert_none(&violations, "measurements name their commit, date and machine");
}

#[test]
fn structure_the_manual_names_every_method_and_parameter() {
    let manual = read("docs/METHODS.md");
    for method in METHODS {
        assert!(manual.contains(&format!("`{}`", method.name)), "docs/METHODS.md lacks {}", method.name);
        for parameter in method.parameters {
            let name = format!("`{}`", parameter.name);
            assert!(manual.contains(&name), "docs/METHODS.md lacks {}.{}", method.name, parameter.name);
        }
    }
}

#[test]
fn structure_references_are_complete() {
    let folder = crate_folder().join("tests/references");
    let readme = fs::read_to_string(folder.join("README.md")).expect("the references have a README");
    let mut scenes = 0;
    for entry in fs::read_dir(&folder).expect("the references are there") {
        let path = entry.expect("an entry can be read").path();
        if !path.is_dir() {
            continue;
        }
        scenes += 1;
        let name = path.file_name().expect("folders have names").to_string_lossy().into_owned();
        for file in ["scene.xml", "ref.exr", "stderr.exr", "meta.json"] {
            assert!(path.join(file).is_file(), "{name} has no {file}");
        }
        assert!(readme.contains(&format!("`{name}`")), "{name} is missing in the README of the references");
    }
    assert!(scenes >= 7, "only {scenes} references");
}

#[test]
fn structure_layers_of_pictures_are_described() {
    let document = read("docs/REST.md");
    for row in picture_files::LAYERS {
        let line = format!("| `{}` | `{}`", row.name, row.channels[0]);
        assert!(document.contains(&line), "docs/REST.md has no row {line}");
    }
}

#[test]
fn structure_scenes_are_described() {
    let folder = crate_folder().join("scenes");
    let readme = fs::read_to_string(folder.join("README.md")).expect("the scenes have a README");
    let mut scenes = 0;
    for entry in fs::read_dir(&folder).expect("the scenes are there") {
        let path = entry.expect("an entry can be read").path();
        if path.is_dir() {
            scenes += 1;
            let name = path.file_name().expect("folders have names").to_string_lossy().into_owned();
            assert!(path.join("scene.xml").is_file(), "{name} has no scene.xml");
            assert!(readme.contains(&name), "{name} is missing in the README of the scenes");
        }
    }
    assert!(scenes >= 6, "only {scenes} scenes");
}
