//! What users read when a scene cannot be imported: every error has its place and a remedy.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use photonfarm::import::load_bytes;
use photonfarm::scene::error::{Location, SceneError};
use photonfarm::scene::geometry::{obj, ply};

/// The errors of malformed inputs, one below the other.
fn report<'a, T>(cases: &[(&'a str, &'a str)], read: impl Fn(&'a str) -> Result<T, SceneError>) -> String {
    let mut report = String::new();
    for (what, input) in cases {
        let error = read(input).err().unwrap_or_else(|| panic!("{what} is no error"));
        writeln!(report, "{what}\n    {error}").unwrap();
    }
    report
}

#[test]
fn malformed_xml() {
    let cases = [
        ("unclosed tag", "<shape type='cube'>\n</scene>"),
        ("unknown tag", "\n<shpe type='cube'/>"),
        ("animation without key frames", "<animation name='to_world'/>"),
        ("transform step outside of a transform", "<translate value='1, 2, 3'/>"),
        ("unknown attribute", "<shape typ='cube'/>"),
        ("missing attribute", "<shape id='a'/>"),
        ("text between tags", "<shape type='cube'>red</shape>"),
        ("value with contents", "<float name='a' value='1'><float name='b' value='2'/></float>"),
        ("not a number", "<shape type='sphere'>\n<float name='radius' value='one'/></shape>"),
        ("not an integer", "<integer name='width' value='2.5'/>"),
        ("not a boolean", "<boolean name='raw' value='yes'/>"),
        ("not a color", "<rgb name='reflectance' value='#12345'/>"),
        ("two numbers for a vector", "<point name='center' value='1, 2'/>"),
        ("a vector in two ways", "<point name='center' value='1, 2, 3' x='1'/>"),
        ("a spectrum", "<spectrum name='eta' value='700:1.5, 400:1.6'/>"),
        ("unknown step", "<transform name='to_world'><lookAt origin='0,0,0'/></transform>"),
        ("short matrix", "<transform name='to_world'><matrix value='1 0 0 1'/></transform>"),
        ("rotation about nothing", "<transform name='to_world'><rotate angle='3' x='0'/></transform>"),
        ("view along up", "<transform name='to_world'><lookat origin='0,1,0' target='0,0,0' up='0,1,0'/></transform>"),
        ("unknown id", "<bsdf type='diffuse' id='white'/><shape type='cube'><ref id='whit'/></shape>"),
        ("no ids at all", "<shape type='cube'><ref id='white'/></shape>"),
        ("id given twice", "<bsdf type='diffuse' id='a'/>\n<bsdf type='diffuse' id='a'/>"),
        (
            "references in a circle",
            "<bsdf type='twosided' id='a'><ref id='b'/></bsdf><bsdf type='twosided' id='b'><ref id='a'/></bsdf>",
        ),
        ("unknown parameter", "<default name='samples' value='4'/><integer name='a' value='$sample'/>"),
        ("missing include", "<include filename='materials.xml'/>"),
        ("include that leads out", "<include filename='../materials.xml'/>"),
    ];
    let report = report(&cases, |body| {
        load_bytes("room.xml", format!("<scene version='3.0.0'>{body}\n</scene>").as_bytes(), &[])
    });
    insta::assert_snapshot!(report);
}

#[test]
fn malformed_scene_files() {
    let cases = [
        ("empty", " \n"),
        ("another format", "#usda 1.0"),
        ("a damaged archive", "PK\u{3}\u{4}nothing"),
        ("a document type", "<!DOCTYPE scene [<!ENTITY a 'b'>]>\n<scene version='3.0.0'/>"),
        ("another outermost tag", "<shape type='cube'/>"),
        ("no version", "<scene/>"),
        ("not a version", "<scene version='new'/>"),
    ];
    insta::assert_snapshot!(report(&cases, |text| load_bytes("room", text.as_bytes(), &[])));
}

#[test]
fn malformed_json() {
    let cases = [
        ("syntax", "{\"type\": \"scene\",\n\"a\": }"),
        ("another outermost type", "{\"type\": \"sphere\"}"),
        ("no type", "{\"type\": \"scene\", \"ball\": {\"radius\": 1}}"),
        ("unknown type", "{\"type\": \"scene\", \"ball\": {\"type\": \"spere\"}}"),
        ("key given twice", "{\"type\": \"scene\",\n\"a\": {\"type\": \"cube\"},\n\"a\": {\"type\": \"cube\"}}"),
        ("two numbers", "{\"type\": \"scene\", \"ball\": {\"type\": \"sphere\", \"center\": [1, 2]}}"),
        ("null", "{\"type\": \"scene\", \"ball\": {\"type\": \"sphere\", \"radius\": null}}"),
        (
            "a color of two",
            "{\"type\": \"scene\", \"m\": {\"type\": \"diffuse\", \"reflectance\": {\"type\": \"rgb\", \"value\": [1, 2]}}}",
        ),
        (
            "unknown id",
            "{\"type\": \"scene\", \"red\": {\"type\": \"diffuse\"}, \"s\": {\"type\": \"cube\", \"bsdf\": {\"type\": \"ref\", \"id\": \"rad\"}}}",
        ),
        ("unknown step", "{\"type\": \"scene\", \"s\": {\"type\": \"cube\", \"to_world\": [{\"rotat\": {}}]}}"),
        (
            "unknown argument",
            "{\"type\": \"scene\", \"s\": {\"type\": \"cube\", \"to_world\": [{\"rotate\": {\"axis\": [0, 1, 0], \"angel\": 3}}]}}",
        ),
        (
            "two steps in one",
            "{\"type\": \"scene\", \"s\": {\"type\": \"cube\", \"to_world\": [{\"scale\": 2, \"translate\": [1, 2, 3]}]}}",
        ),
    ];
    insta::assert_snapshot!(report(&cases, |text| load_bytes("room.json", text.as_bytes(), &[])));
}

#[test]
fn malformed_old_xml() {
    let cases = [
        ("misspelled tag", "\n<shpae type='cube'/>"),
        ("unknown plugin", "<bsdf type='diffus'/>"),
        ("plugin of Mitsuba 3", "<bsdf type='roughconducter'/>"),
        ("neither color nor spectrum", "<bsdf type='diffuse'><rgb name='reflectance' value='red'/></bsdf>"),
        ("spectrum that goes back", "<bsdf type='diffuse'><spectrum name='reflectance' value='700:1, 400:2'/></bsdf>"),
        ("spectrum in a missing file", "<bsdf type='diffuse'><spectrum name='reflectance' filename='a.spd'/></bsdf>"),
        ("black body without heat", "<emitter type='constant'><blackbody name='radiance' temperature='0K'/></emitter>"),
        ("weights that do not match", "<bsdf type='mixturebsdf'><string name='weights' value='1'/></bsdf>"),
        ("coating of nothing", "<bsdf type='coating'/>"),
        ("step outside of a transform", "<lookat origin='0,0,1' target='0,0,0'/>"),
        (
            "view of nothing",
            "<sensor type='perspective'><transform name='toWorld'><lookAt origin='0,0,1' target='0,0,1'/></transform></sensor>",
        ),
        (
            "references in a circle",
            "<bsdf type='twosided' id='a'><ref id='b'/></bsdf><bsdf type='coating' id='b'><ref id='a'/></bsdf>",
        ),
        (
            "coatings in a circle",
            "<bsdf type='coating' id='a'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>",
        ),
    ];
    let report = report(&cases, |body| {
        load_bytes("room.xml", format!("<scene version='0.5.0'>{body}\n</scene>").as_bytes(), &[])
    });
    insta::assert_snapshot!(report);
}

fn place(file: &str) -> Location {
    Location { file: file.to_owned(), line: 0, path: "scene/shape[0]/filename".to_owned() }
}

#[test]
fn malformed_obj() {
    let cases = [
        ("empty", ""),
        ("no faces", "v 0 0 0\n"),
        ("index out of range", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
        ("index zero", "v 0 0 0\nf 0 1 1\n"),
        ("two corners", "v 0 0 0\nf 1 1\n"),
        ("not finite", "v 0 0 0\nv 0 nan 0\n"),
        ("not a number", "v 0 0 zero\n"),
        ("missing number", "v 0 0\n"),
        ("no polygons", "v 0 0 0\ncurv2 1 2 3\n"),
    ];
    insta::assert_snapshot!(
        report(&cases, |text| obj::read(text.as_bytes(), None, &place("roof.obj")).map(|read| read.mesh))
    );
}

#[test]
fn malformed_ply() {
    const VERTICES: &str = "property float x\nproperty float y\nproperty float z\n";
    const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let ascii =
        |count: &str, body: &str| format!("ply\nformat ascii 1.0\nelement vertex {count}\n{VERTICES}{FACES}{body}");
    let cases = [
        ("another format", "solid roof\n".to_owned()),
        ("header without end", "ply\nformat ascii 1.0\n".to_owned()),
        ("unknown line", "ply\nformat ascii 1.0\nelement vertex many\n".to_owned()),
        ("more vertices promised than there can be", ascii("4000000000", "0 0 0\n")),
        ("cut short", ascii("2", "0 0 0\n0 0 1\n3 0 1")),
        ("index out of range", ascii("2", "0 0 0\n0 0 1\n3 0 1 2")),
        ("not finite", ascii("2", "0 0 0\n0 inf 1\n3 0 1 1")),
        ("not a number", ascii("2", "0 0 0\n0 x 1\n3 0 1 1")),
        ("two corners", ascii("1", "0 0 0\n2 0 0\n")),
        ("long list", ascii("1", "0 0 0\n250 0 0\n")),
        (
            "binary cut short",
            format!("ply\nformat binary_little_endian 1.0\nelement vertex 1\n{VERTICES}{FACES}0123456789ab\x03abc"),
        ),
    ];
    let borrowed: Vec<(&str, &str)> = cases.iter().map(|(what, text)| (*what, text.as_str())).collect();
    insta::assert_snapshot!(report(&borrowed, |text| ply::read(text.as_bytes(), &place("roof.ply"))));
}

/// A zip archive of files with a name and a content each.
fn archive(files: &[(&str, &str)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(content.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn malformed_archives() {
    const EMPTY: &str = "<scene version='3.0.0'/>";
    const SELF: &str = "<scene version='3.0.0'>\n<include filename='scene.xml'/></scene>";
    const INCLUDER: &str = "<scene version='3.0.0'><include filename='parts/lamp.xml'/></scene>";
    const CHAIN: &str = "<scene version='3.0.0'><include filename='0.xml'/></scene>";
    let chain: Vec<(String, String)> =
        (0..20).map(|i| (format!("{i}.xml"), CHAIN.replace("0.xml", &format!("{}.xml", i + 1)))).collect();
    let chain: Vec<(&str, &str)> = chain.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let cases: [(&str, Vec<(&str, &str)>); 8] = [
        ("no scene file", vec![("readme.txt", "hello"), ("parts/scene.xml", EMPTY)]),
        ("several scene files", vec![("a.xml", EMPTY), ("b.json", "{}")]),
        ("both standard names", vec![("scene.xml", EMPTY), ("scene.json", "{}")]),
        ("a name that leads out", vec![("scene.xml", EMPTY), ("../lamp.ply", "")]),
        ("a file that includes itself", vec![("scene.xml", SELF)]),
        ("a chain of includes", [&[("scene.xml", CHAIN)], &chain[..]].concat()),
        ("a missing include", vec![("scene.xml", INCLUDER), ("parts/lamps.xml", EMPTY)]),
        (
            "an error in an included file",
            vec![("scene.xml", INCLUDER), ("parts/lamp.xml", "<scene version='3.0.0'>\n<shap/></scene>")],
        ),
    ];
    let mut texts = String::new();
    for (what, files) in cases {
        let error = load_bytes("room.zip", &archive(&files), &[]).expect_err(what);
        writeln!(texts, "{what}\n    {error}").unwrap();
    }
    insta::assert_snapshot!(texts);
}

#[test]
fn unused_defines() {
    let defines = [("samples".to_owned(), "4".to_owned())];
    let cases = [
        ("another name", "<scene version='3.0.0'><default name='sample' value='1'/></scene>"),
        ("no parameters", "<scene version='3.0.0'/>"),
        ("json", "{\"type\": \"scene\"}"),
    ];
    insta::assert_snapshot!(report(&cases, |text| load_bytes("room", text.as_bytes(), &defines)));
}
