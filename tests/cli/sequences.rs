//! Sequences: `render --frames` and `submit --frames`.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use image::AnimationDecoder;
use image::codecs::png::PngDecoder;
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::read_exr;

use crate::command_line::{failure, success, text};

/// A lamp that goes from left to right, in front of two cameras that look towards +z, where +x is to the left.
const SCENE: &str = "<scene version='3.0.0'><integrator type='path'/>
    <sensor type='perspective' id='left'><float name='fov' value='60'/>
        <transform name='to_world'><lookat origin='0.6,0,-4' target='0.6,0,0' up='0,1,0'/></transform>
        <film type='hdrfilm'><integer name='width' value='32'/><integer name='height' value='16'/></film></sensor>
    <sensor type='perspective' id='right'><float name='fov' value='30'/>
        <transform name='to_world'><lookat origin='-0.6,0,-4' target='-0.6,0,0' up='0,1,0'/></transform></sensor>
    <shape type='sphere'><float name='radius' value='0.4'/><emitter type='area'/>
        <animation name='to_world'>
            <transform time='0'><translate x='1.5'/></transform>
            <transform time='2'><translate x='-1.5'/></transform>
        </animation></shape></scene>";
/// The same lamp where it is halfway, and a camera halfway between the two.
const HALFWAY: &str = "<scene version='3.0.0'><integrator type='path'/>
    <sensor type='perspective'><float name='fov' value='45'/>
        <transform name='to_world'><lookat origin='0,0,-4' target='0,0,0' up='0,1,0'/></transform>
        <film type='hdrfilm'><integer name='width' value='32'/><integer name='height' value='16'/></film></sensor>
    <shape type='sphere'><float name='radius' value='0.4'/><emitter type='area'/></shape></scene>";

fn render(folder: &Path, scene: &str, output: &str, options: &[&str]) -> String {
    let [scene, output] = [scene, output].map(|name| folder.join(name));
    let job = ["render", text(&scene), "--passes", "4", "--threads", "1", "-o", text(&output)];
    success(&[job.as_slice(), options].concat())
}

fn picture(file: &Path) -> Picture {
    read_exr(file).unwrap_or_else(|error| panic!("{error}"))
}

/// The column where the light is in the mean.
fn center(picture: &Picture) -> f64 {
    let light = picture.radiance.iter().enumerate().map(|(at, pixel)| (at as u32 % picture.width, f64::from(pixel[1])));
    let (weighted, all) = light.fold((0.0, 0.0), |(weighted, all), (column, value)| {
        (weighted + (f64::from(column) + 0.5) * value, all + value)
    });
    weighted / all
}

#[test]
fn frames_show_what_moves_at_their_moments() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("lamp.xml"), SCENE).expect("writes");
    let preview = folder.join("lamp.png");
    let told = render(folder, "lamp.xml", "all.exr", &["--frames", "1-3", "--preview", text(&preview)]);
    assert!(told.contains("frame 2, 2 of 3") && told.contains("wrote "), "{told}");
    let frame = |name: &str| picture(&folder.join(name));
    let all = ["all.0001.exr", "all.0002.exr", "all.0003.exr"].map(frame);
    let [first, second, third] = all.each_ref().map(center);
    assert!(first + 4.0 < second && second + 4.0 < third, "columns {first}, {second}, {third}");
    assert!(!folder.join("all.exr").exists());
    // A part of a sequence has the bits of the whole one, and so has a single picture of that moment.
    render(folder, "lamp.xml", "part.exr", &["--frames", "2", "--sequence", "1-3"]);
    assert!(frame("part.0002.exr") == all[1]);
    render(folder, "lamp.xml", "one.exr", &["--time", "1", "--seed", "2"]);
    assert!(frame("one.exr") == all[1]);
    // Other moments, and the random numbers of one seed.
    render(folder, "lamp.xml", "still.exr", &["--frames", "1-2", "--times", "1,1", "--frame-seeds", "same"]);
    assert!(frame("still.0001.exr") == frame("still.0002.exr"));
    render(folder, "lamp.xml", "noisy.exr", &["--frames", "1-2", "--times", "1,1"]);
    assert!(frame("noisy.0001.exr") != frame("noisy.0002.exr"));
    // What browsers play.
    let decoder = PngDecoder::new(BufReader::new(File::open(preview).expect("a preview"))).expect("a PNG");
    let frames = decoder.apng().expect("an animation").into_frames().collect_frames().expect("its frames");
    assert_eq!(frames.len(), 3);
    for (shown, expected) in frames.iter().zip(&all) {
        let lit = |at: usize| shown.buffer().as_raw()[4 * at + 1] > 128;
        let is_lit = |at: usize| expected.radiance[at][1] > 0.5;
        let agree = (0..expected.radiance.len()).filter(|at| lit(*at) == is_lit(*at)).count();
        assert!(agree > expected.radiance.len() * 95 / 100, "{agree} pixels agree");
    }
}

#[test]
fn the_camera_goes_from_one_to_the_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("lamp.xml"), SCENE).expect("writes");
    fs::write(folder.join("halfway.xml"), HALFWAY).expect("writes");
    let way = ["--frames", "0-2", "--times", "1,1", "--camera-path", "left,right", "--frame-seeds", "same"];
    render(folder, "lamp.xml", "way.exr", &way);
    render(folder, "halfway.xml", "halfway.exr", &[]);
    let frame = |name: &str| picture(&folder.join(name));
    assert!(frame("way.0001.exr") == frame("halfway.exr"));
    // At its ends it is the cameras themselves; the second has the film of the first only on the way.
    for (number, camera) in [("0000", "left"), ("0002", "1")] {
        let output = format!("{camera}.exr");
        let size = ["--size", "32x16"];
        let time = ["--time", "1", "--camera", camera];
        render(folder, "lamp.xml", &output, &[time.as_slice(), &size].concat());
        let (on_the_way, alone) = (center(&frame(&format!("way.{number}.exr"))), center(&frame(&output)));
        assert!((on_the_way - alone).abs() < 0.3, "{on_the_way} and {alone}");
    }
}

#[test]
fn sequences_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("lamp.xml"), SCENE).expect("writes");
    fs::write(folder.join("halfway.xml"), HALFWAY).expect("writes");
    let refused = |scene: &str, options: &[&str], code| {
        let scene = folder.join(scene);
        failure(&[["render", text(&scene), "-o", text(&folder.join("a.exr"))].as_slice(), options].concat(), code)
    };
    assert!(refused("halfway.xml", &["--frames", "1-3"], 3).contains("nothing in the scene moves"));
    let unknown = refused("lamp.xml", &["--frames", "1-3", "--camera-path", "left,front"], 3);
    assert!(unknown.contains("there is no camera \"front\""), "{unknown}");
    let options: [&[&str]; 8] = [
        &["--frames", "3-1"],
        &["--frames", "1-5", "--sequence", "1-3"],
        &["--frames", "1-3", "--camera-path", "left"],
        &["--frames", "1-3", "--camera-path", "left,right", "--camera", "left"],
        &["--frames", "1-3", "--time", "1"],
        &["--frames", "1-3", "--preview", "a.gif"],
        &["--times", "0,1"],
        &["--frames", "1-3", "--time-shares"],
    ];
    for options in options {
        refused("lamp.xml", options, 2);
    }
    let order = SCENE.replace("time='2'", "time='-2'");
    fs::write(folder.join("order.xml"), order).expect("writes");
    let told = refused("order.xml", &["--frames", "1-3"], 3);
    assert!(told.contains("order.xml:10") && told.contains("the key frame at -2 stands behind that at 0"), "{told}");
    assert_eq!(fs::read_dir(folder).expect("lists").count(), 3, "nothing was written");
}
