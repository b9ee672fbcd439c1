//! What the program says of the pictures that it writes, and that it does not replace better ones.

use std::path::Path;

use crate::command_line::{ended, program, run};
use photonfarm::estimate::picture_files::{PictureOrigin, decode_exr, read_channels, read_origin};

const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";

/// Standard error of a command that must succeed in `folder`.
fn told(folder: &Path, arguments: &[&str]) -> String {
    ended(&program(arguments).current_dir(folder).output().expect("it starts"), 0)
}

fn passes(file: &Path) -> Option<u32> {
    read_origin(file).map(|PictureOrigin { passes, .. }| passes)
}

#[test]
fn pictures_of_more_passes_stay_and_the_user_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let scene = std::path::absolute(SCENE).expect("a path");
    let scene = scene.to_str().expect("UTF-8");
    let render = |passes: &str, more: &[&str]| {
        let options = ["--size", "16", "--method", "path", "--passes", passes, "-o", "a.exr", "-o", "a.png"];
        told(folder, &[["render", scene].as_slice(), &options, more].concat())
    };
    let [exr, png, beside] = ["a.exr", "a.png", "a.2-passes.exr"].map(|name| folder.join(name));
    let first = render("4", &[]);
    assert!(first.contains("wrote a.exr\n") && first.contains("wrote a.png\n"), "{first}");
    assert_eq!(passes(&exr), Some(4));
    let better = std::fs::read(&png).expect("a picture");
    // Fewer passes of the same scene go beside, as PNG too.
    let fewer = render("2", &[]);
    assert!(
        fewer.contains("wrote a.2-passes.exr; a.exr has 4 passes of this scene and stays (--overwrite replaces it)"),
        "{fewer}"
    );
    assert!(fewer.contains("wrote a.2-passes.png; a.png has 4 passes"), "{fewer}");
    assert_eq!([passes(&exr), passes(&beside)], [Some(4), Some(2)]);
    assert!(std::fs::read(&png).expect("a picture") == better);
    // More passes replace, and so do fewer that are told to.
    assert!(render("6", &[]).contains("wrote a.exr\n"));
    assert_eq!(passes(&exr), Some(6));
    assert!(render("1", &["--overwrite"]).contains("wrote a.exr\n"));
    assert_eq!(passes(&exr), Some(1));
    // Another scene is another picture.
    render("6", &[]);
    let other = ["render", scene, "--size", "8", "--method", "path", "--passes", "1", "-o", "a.exr"];
    assert!(told(folder, &other).contains("wrote a.exr\n"));
    assert_eq!(passes(&exr), Some(1));
}

#[test]
fn pictures_have_the_format_that_their_names_ask_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = std::path::absolute(SCENE).expect("a path");
    let outputs = ["-o", "a.exr", "-o", "a.png", "-o", "a.jpeg", "-o", "a.webp"];
    let options = ["--size", "16", "--method", "path", "--passes", "2", "--tone", "agx", "--exposure", "auto"];
    let formats = ["--half", "--bits", "16", "--quality", "95"];
    let scene = ["render", scene.to_str().expect("UTF-8")];
    told(folder.path(), &[scene.as_slice(), &options, &outputs, &formats].concat());
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a picture");
    let decoded = |name: &str| image::load_from_memory(&read(name)).expect("decodes");
    assert_eq!(decoded("a.png").color(), image::ColorType::Rgb16);
    let [png, jpeg, webp] = ["a.png", "a.jpeg", "a.webp"].map(|name| decoded(name).to_rgb8());
    assert!(webp.iter().zip(png.iter()).all(|(a, b)| a.abs_diff(*b) <= 1));
    assert!(jpeg.dimensions() == (16, 16) && read("a.jpeg").starts_with(&[0xff, 0xd8]));
    // Half floats have bits only above the lowest 13 of 32.
    let exr = decode_exr(&read("a.exr")).expect("decodes");
    assert!(exr.radiance.iter().flatten().all(|value| value.to_bits() & 0x1fff == 0));
}

/// Whoever asks for light groups finds them in the EXR file, without naming a layer.
#[test]
fn light_groups_are_written_into_exr_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let lamp = "<emitter type='point'><point name='position' value='0, 0.3, 0'/>\
        <string name='light_group' value='bulb'/></emitter></scene>";
    let scene = std::fs::read_to_string(SCENE).expect("a reference").replace("</scene>", lamp);
    std::fs::write(folder.path().join("lamps.xml"), scene).expect("writes");
    let render = ["render", "lamps.xml", "--size", "16", "--method", "path", "--passes", "2", "--light-groups"];
    told(folder.path(), &[render.as_slice(), &["-o", "a.exr", "-o", "a.png"]].concat());
    let channels = read_channels(&folder.path().join("a.exr")).expect("reads");
    assert_eq!(channels.layer_names(), ["luminance", "light_group.bulb", "light_group.others"]);
    let check = program(&["scene", "check", "lamps.xml"]).current_dir(folder.path()).output().expect("it starts");
    let check = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(check.contains("groups     bulb, others\n"), "{check}");
    let refused = program(&[render.as_slice(), &["-o", "a.png"]].concat()).current_dir(folder.path()).output();
    let refused = ended(&refused.expect("it starts"), 2);
    assert!(refused.contains("--light-groups goes into EXR files, and none is written"), "{refused}");
}

#[test]
fn methods_without_photons_tell_samples_and_one_is_no_plural() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = std::path::absolute(SCENE).expect("a path");
    let scene = scene.to_str().expect("UTF-8");
    let render = |method: &str| {
        let options = ["--size", "16", "--method", method, "--passes", "1", "--threads", "1", "-o", "a.exr"];
        told(folder.path(), &[["render", scene].as_slice(), &options].concat())
    };
    let path = render("path");
    assert!(path.contains("1 pass, ") && path.contains("million samples/s") && path.contains("1 thread"), "{path}");
    assert!(!path.contains("photons") && !path.contains("1 passes") && !path.contains("1 threads"), "{path}");
    assert!(render("sppm").contains("million photons/s"));
    // Chains tell how they walk.
    let chains = render("mmlt");
    assert!(chains.contains("% of small step accepted, ") && chains.contains("% of large step accepted"), "{chains}");
}

/// What others call a method leads to its name here, in every command that takes one.
#[test]
fn names_that_others_use_lead_to_methods() {
    for (name, method) in [
        ("pt", "path"),
        ("PathTracer", "path"),
        ("bidir", "bdpt"),
        ("photon-mapping", "photon_map"),
        ("pssmlt", "mmlt"),
    ] {
        for command in [["render", SCENE, "--method", name].as_slice(), &["methods", name]] {
            let told = ended(&run(command), 3);
            let expected =
                format!("there is no method \"{name}\"; it is called \"{method}\" here; methods: sppm, ppm, ");
            assert!(told.contains(&expected), "{told}");
        }
    }
    let told = ended(&run(&["methods", "spppm"]), 3);
    assert!(told.contains("did you mean \"sppm\"? Methods: sppm, ppm, "), "{told}");
    let told = ended(&run(&["methods", "arnold"]), 3);
    assert!(told.contains("there is no method \"arnold\"; methods: sppm, ppm, "), "{told}");
}
